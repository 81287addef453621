#pragma once
// Pictures of calibration boards with known corners, for tests of detectors and of whole calibrations: each
// pixel's rays meet the board's plane and take its print. Shares nothing with the detectors but the boards'
// layout and the tags' printed patterns.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "capture/rig/camera_model.h"
#include "capture/rig/tag_family.h"
#include "capture/track/board.h"
#include "tests/support/render_tag.h"

namespace tendril::testing_support {

// Brightness of the board's print at a place on it: 1 white, 0 black; negative beside the board.
class BoardPrint {
 public:
  explicit BoardPrint(const Board& board) : board_(board) {
    if (board.kind != BoardKind::kAprilGrid) return;
    for (int i = 0; i < board.columns * board.rows; ++i) tags_.push_back(PatternOf("tag36h11", i).value());
  }

  // Whether the print is surely one colour within (dx, dy) of a place.
  bool IsPlain(double x, double y, double dx, double dy) const {
    if (board_.kind != BoardKind::kChessboard) return false;
    const double s = board_.square;
    return std::abs(x / s - std::round(x / s)) * s > dx && std::abs(y / s - std::round(y / s)) * s > dy;
  }

  double At(double x, double y) const {
    if (board_.kind == BoardKind::kChessboard) {
      const double s = board_.square;
      if (x < -2 * s || y < -2 * s || x > s * (board_.columns + 1) || y > s * (board_.rows + 1)) return -1;
      const int c = static_cast<int>(std::floor(x / s)) + 1;
      const int r = static_cast<int>(std::floor(y / s)) + 1;
      if (c < 0 || r < 0 || c > board_.columns || r > board_.rows) return 1;  // the white rim
      return (r + c) % 2 == 0 ? 0 : 1;
    }
    return Grid(x, -y);
  }

 private:
  // An AprilGrid as Kalibr prints it, y up: tags, and black squares where four gaps meet.
  double Grid(double x, double y) const {
    const double gap = board_.spacing * board_.square;
    const double pitch = board_.square + gap;
    const double width = pitch * board_.columns - gap;
    const double height = pitch * board_.rows - gap;
    if (x < -2 * gap || y < -2 * gap || x > width + 2 * gap || y > height + 2 * gap) return -1;
    const int c = static_cast<int>(std::floor((x + gap) / pitch));
    const int r = static_cast<int>(std::floor((y + gap) / pitch));
    const double u = x - c * pitch;  // from the tag's bottom left; -gap .. side
    const double v = y - r * pitch;
    if (u < 0 && v < 0 && board_.border_bits == 2) return 0;
    if (u < 0 || v < 0 || c < 0 || r < 0 || c >= board_.columns || r >= board_.rows) return 1;
    const TagPattern& tag = tags_[static_cast<size_t>(r * board_.columns + c)];
    const int ring = 1;  // the pattern's white ring and its border of one bit
    const int bits = static_cast<int>(tag.rows()) - 2 * ring - 2;
    const int modules = bits + 2 * board_.border_bits;
    const int column = static_cast<int>(u / board_.square * modules) - board_.border_bits;
    const int row = modules - 1 - static_cast<int>(v / board_.square * modules) - board_.border_bits;
    if (column < 0 || row < 0 || column >= bits || row >= bits) return 0;
    return tag(row + ring + 1, column + ring + 1) > 127 ? 1 : 0;
  }

  Board board_;
  std::vector<TagPattern> tags_;
};

// The rays of a camera's pixels, for many pictures of one camera; NaN where there is none.
struct RayTable {
  int width = 0;
  Eigen::Matrix3Xd rays;  // row by row

  explicit RayTable(const Camera& camera)
      : width(camera.width_px), rays(3, static_cast<Eigen::Index>(camera.width_px) * camera.height_px) {
    for (Eigen::Index i = 0; i < rays.cols(); ++i) {
      const auto ray =
          RayOfPixel(camera, Eigen::Vector2d(static_cast<double>(i % width), static_cast<double>(i / width)));
      rays.col(i) = ray ? *ray : Eigen::Vector3d::Constant(NAN);
    }
  }
};

// What the camera sees of the board, from samples x samples rays per pixel; then blur (px) and noise
// (levels).
//   table  of this camera; it saves time
inline Picture RenderBoard(const Camera& camera, const Eigen::Isometry3d& lab_from_board, const Board& board,
                           double blur_px, double noise, std::mt19937& random, int samples = 5,
                           const RayTable* table = nullptr) {
  const BoardPrint print(board);
  const Eigen::Isometry3d board_from_camera = (camera.camera_from_lab * lab_from_board).inverse();
  Picture picture(camera.width_px, camera.height_px, 90);
  // Only where the board can be: about the print with its rim, three squares wide.
  const Eigen::Matrix3Xd corners = BoardPoints(board);
  const Eigen::Vector3d rim(3 * board.square, 3 * board.square, 0);
  const Eigen::Vector3d low = corners.rowwise().minCoeff() - rim;
  const Eigen::Vector3d high = corners.rowwise().maxCoeff() + rim;
  Eigen::Array2d first(camera.width_px, camera.height_px);
  Eigen::Array2d last(0, 0);
  for (int i = 0; i < 64; ++i) {
    const double t = (i % 16) / 15.0;
    const Eigen::Vector3d at(i < 32   ? low.x() + t * (high.x() - low.x())
                             : i < 48 ? low.x()
                                      : high.x(),
                             i >= 32  ? low.y() + t * (high.y() - low.y())
                             : i < 16 ? low.y()
                                      : high.y(),
                             0);
    const auto pixel = Project(camera, lab_from_board * at);
    if (!pixel) {
      first.setZero();
      last = Eigen::Array2d(camera.width_px - 1, camera.height_px - 1);
      break;
    }
    first = first.min(pixel->array());
    last = last.max(pixel->array());
  }
  first = first.max(0);
  last = last.min(Eigen::Array2d(camera.width_px - 1, camera.height_px - 1));
  const int left = static_cast<int>(first.x());
  const int top = static_cast<int>(first.y());
  const int across = std::max(0, static_cast<int>(last.x()) - left + 1);
  const int down = std::max(0, static_cast<int>(last.y()) - top + 1);
  Eigen::Matrix2Xd places(2, static_cast<Eigen::Index>(across) * down);  // on the board, of pixels' middles
  for (Eigen::Index i = 0; i < places.cols(); ++i) {
    const auto u = left + i % across;
    const auto v = top + i / across;
    Eigen::Vector3d ray = Eigen::Vector3d::Constant(NAN);
    if (table != nullptr) {
      ray = table->rays.col(v * table->width + u);
    } else if (const auto found =
                   RayOfPixel(camera, Eigen::Vector2d(static_cast<double>(u), static_cast<double>(v)))) {
      ray = *found;
    }
    const Eigen::Vector3d along = board_from_camera.linear() * ray;
    const double t = -board_from_camera.translation().z() / along.z();
    places.col(i) = (board_from_camera.translation() + (t > 0 ? t : NAN) * along).head<2>();
  }
  const auto place = [&](int u, int v) {
    return Eigen::Vector2d(places.col(static_cast<Eigen::Index>(v) * across + u));
  };
  for (int v = 0; v < down; ++v) {
    for (int u = 0; u < across; ++u) {
      const Eigen::Vector2d middle = place(u, v);
      // The middle ray decides whether the board is near; the lens bends little within one pixel.
      if (!middle.allFinite() || print.At(middle.x(), middle.y()) < 0) continue;
      const int u0 = std::max(0, u - 1);
      const int u1 = std::min(across - 1, u + 1);
      const int v0 = std::max(0, v - 1);
      const int v1 = std::min(down - 1, v + 1);
      const Eigen::Vector2d du = (place(u1, v) - place(u0, v)) / std::max(1, u1 - u0);
      const Eigen::Vector2d dv = (place(u, v1) - place(u, v0)) / std::max(1, v1 - v0);
      if (!du.allFinite() || !dv.allFinite()) continue;
      const Eigen::Vector2d reach = 0.5 * (du.cwiseAbs() + dv.cwiseAbs());
      if (print.IsPlain(middle.x(), middle.y(), reach.x(), reach.y())) {
        picture.At(left + u, top + v) = 40 + 170 * print.At(middle.x(), middle.y());
        continue;
      }
      double sum = 0;
      for (int i = 0; i < samples * samples; ++i) {
        const double a = (i % samples + 0.5) / samples - 0.5;
        const double b = (i / samples + 0.5) / samples - 0.5;
        const Eigen::Vector2d at = middle + a * du + b * dv;
        const double white = print.At(at.x(), at.y());
        sum += white < 0 ? 90 : 40 + 170 * white;
      }
      picture.At(left + u, top + v) = sum / (samples * samples);
    }
  }
  if (blur_px > 0 && across > 0 && down > 0)
    Blur(picture, blur_px, left, top, left + across - 1, top + down - 1);
  if (noise > 0) AddNoise(picture, noise, random);
  return picture;
}

}  // namespace tendril::testing_support
