#pragma once
// Pictures of calibration boards with known corners, for tests of detectors and of whole calibrations: each
// pixel's rays meet the board's plane and take its print. Shares nothing with the detectors but the boards'
// layout and the tags' printed patterns.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
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

// What the camera sees of the board, from samples x samples rays per pixel; then blur (px) and noise
// (levels).
inline Picture RenderBoard(const Camera& camera, const Eigen::Isometry3d& lab_from_board, const Board& board,
                           double blur_px, double noise, std::mt19937& random, int samples = 5) {
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
  for (int v = static_cast<int>(first.y()); v <= last.y(); ++v) {
    for (int u = static_cast<int>(first.x()); u <= last.x(); ++u) {
      // The middle ray decides whether the board is near; the lens bends little within one pixel.
      double sum = 0;
      const auto place = [&](double x, double y) -> std::optional<Eigen::Vector2d> {
        const auto ray = RayOfPixel(camera, Eigen::Vector2d(x, y));
        if (!ray) return std::nullopt;
        const Eigen::Vector3d along = board_from_camera.linear() * *ray;
        const double t = -board_from_camera.translation().z() / along.z();
        if (!(t > 0)) return std::nullopt;
        return Eigen::Vector2d((board_from_camera.translation() + t * along).head<2>());
      };
      const auto middle = place(u, v);
      if (!middle || print.At(middle->x(), middle->y()) < 0) continue;
      const auto beside = place(u + 0.5, v);
      const auto below = place(u, v + 0.5);
      if (!beside || !below) continue;
      const Eigen::Vector2d du = 2 * (*beside - *middle);
      const Eigen::Vector2d dv = 2 * (*below - *middle);
      for (int i = 0; i < samples * samples; ++i) {
        const double a = (i % samples + 0.5) / samples - 0.5;
        const double b = (i / samples + 0.5) / samples - 0.5;
        const Eigen::Vector2d at = *middle + a * du + b * dv;
        const double white = print.At(at.x(), at.y());
        sum += white < 0 ? 90 : 40 + 170 * white;
      }
      picture.At(u, v) = sum / (samples * samples);
    }
  }
  if (blur_px > 0) Blur(picture, blur_px);
  if (noise > 0) AddNoise(picture, noise, random);
  return picture;
}

}  // namespace tendril::testing_support
