#include "capture/track/board_detect.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/aruco.hpp>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace tendril {
namespace {

using Points = std::vector<cv::Point2f>;

double Distance(const cv::Point2f& a, const cv::Point2f& b) { return std::hypot(a.x - b.x, a.y - b.y); }

// Moves each point to the saddle of the brightness within `reach` px of it; those whose window is small, at
// the rim, or that move farther than the window are told by `kept`.
void RefineSaddles(const cv::Mat& gray, Points& points, const std::vector<double>& reach,
                   std::vector<bool>& kept) {
  const cv::TermCriteria until(cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-3);
  kept.assign(points.size(), false);
  for (size_t i = 0; i < points.size(); ++i) {
    const int half = std::clamp(static_cast<int>(std::floor(reach[i])), 2, 15);
    const auto inside = [&](const cv::Point2f& p) {
      return p.x >= 2 && p.y >= 2 && p.x <= static_cast<float>(gray.cols - 3) &&
             p.y <= static_cast<float>(gray.rows - 3);
    };
    if (!inside(points[i])) continue;
    Points one{points[i]};
    cv::cornerSubPix(gray, one, {half, half}, {-1, -1}, until);
    if (!inside(one[0]) || Distance(one[0], points[i]) > half) continue;
    points[i] = one[0];
    kept[i] = true;
  }
}

// Distance from each corner of a full grid to its nearest neighbour along rows and columns.
std::vector<double> NearestInGrid(const Points& corners, int across, int down) {
  std::vector<double> nearest(corners.size(), std::numeric_limits<double>::infinity());
  const auto pair = [&](size_t a, size_t b) {
    const double d = Distance(corners[a], corners[b]);
    nearest[a] = std::min(nearest[a], d);
    nearest[b] = std::min(nearest[b], d);
  };
  for (int r = 0; r < down; ++r) {
    for (int c = 0; c < across; ++c) {
      const auto i = static_cast<size_t>(r * across + c);
      if (c + 1 < across) pair(i, i + 1);
      if (r + 1 < down) pair(i, i + static_cast<size_t>(across));
    }
  }
  return nearest;
}

double MeanAround(const cv::Mat& gray, const cv::Point2f& at) {
  const int x = std::clamp(static_cast<int>(std::lround(at.x)), 1, gray.cols - 2);
  const int y = std::clamp(static_cast<int>(std::lround(at.y)), 1, gray.rows - 2);
  return cv::mean(gray(cv::Rect(x - 1, y - 1, 3, 3)))[0];
}

cv::Point2f CenterOfSquare(const Points& corners, int across, int r, int c) {
  const auto i = static_cast<size_t>(r * across + c);
  const auto below = i + static_cast<size_t>(across);
  return 0.25F * (corners[i] + corners[i + 1] + corners[below] + corners[below + 1]);
}

// Puts the corners in the board's order whatever order the detector chose: rows to the right and down as
// seen from the front, and the first corner where the board says.
void OrderChessboard(const cv::Mat& gray, const Board& board, Points& corners) {
  const int across = board.columns;
  const int down = board.rows;
  const cv::Point2f right = corners[static_cast<size_t>(across - 1)] - corners[0];
  const cv::Point2f below = corners[static_cast<size_t>(across * (down - 1))] - corners[0];
  if (right.x * below.y - right.y * below.x < 0) {  // mirrored
    for (int r = 0; r < down; ++r) {
      std::reverse(corners.begin() + r * across, corners.begin() + (r + 1) * across);
    }
  }
  bool turn = false;
  if (LooksSameTurned(board)) {
    turn = corners.front().x + corners.front().y > corners.back().x + corners.back().y;
  } else {
    // Squares of one colour minus those of the other, all over the board: light may be uneven.
    double even_less_odd = 0;
    for (int r = 0; r + 1 < down; ++r) {
      for (int c = 0; c + 1 < across; ++c) {
        const double level = MeanAround(gray, CenterOfSquare(corners, across, r, c));
        even_less_odd += (r + c) % 2 == 0 ? level : -level;
      }
    }
    turn = even_less_odd > 0;  // half a turn exchanges the colours
  }
  if (turn) std::reverse(corners.begin(), corners.end());
}

BoardCorners DetectChessboard(const cv::Mat& gray, const Board& board) {
  const cv::Size size(board.columns, board.rows);
  Points corners;
  constexpr int kFlags = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE;
  // In large pictures noise makes thousands of quads, over which this search takes minutes: half the size
  // does.
  constexpr int kLarge = 1000;
  bool found = false;
  if (std::max(gray.cols, gray.rows) < kLarge) {
    found = cv::findChessboardCorners(gray, size, corners, kFlags);
  } else {
    cv::Mat half;
    cv::resize(gray, half, {}, 0.5, 0.5, cv::INTER_AREA);
    found = cv::findChessboardCorners(half, size, corners, kFlags);
    for (cv::Point2f& c : corners) c = 2 * c + cv::Point2f(0.5F, 0.5F);
  }
  // The sector-based search is slower, and finds boards that are blurred or large and near.
  if (!found) found = cv::findChessboardCornersSB(gray, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE);
  BoardCorners seen;
  if (!found || corners.size() != static_cast<size_t>(size.area())) return seen;

  std::vector<double> reach = NearestInGrid(corners, board.columns, board.rows);
  for (double& r : reach) r *= 0.3;
  std::vector<bool> kept;
  // Twice: the detector's first guess may be a few pixels off, and the windows follow the distances.
  for (int round = 0; round < 2; ++round) RefineSaddles(gray, corners, reach, kept);
  if (std::count(kept.begin(), kept.end(), false) > 0) return seen;
  OrderChessboard(gray, board, corners);
  seen.pixels.resize(2, static_cast<Eigen::Index>(corners.size()));
  for (size_t i = 0; i < corners.size(); ++i) {
    seen.ids.push_back(static_cast<int>(i));
    seen.pixels.col(static_cast<Eigen::Index>(i)) << corners[i].x, corners[i].y;
  }
  return seen;
}

struct Marker {
  int id = 0;
  std::array<cv::Point2f, 4> corners;  // as the board counts them
};

void Keep(const std::map<int, cv::Point2f>& corners, BoardCorners& seen) {
  seen.pixels.resize(2, static_cast<Eigen::Index>(corners.size()));
  for (const auto& [id, p] : corners) {
    seen.pixels.col(static_cast<Eigen::Index>(seen.ids.size())) << p.x, p.y;
    seen.ids.push_back(id);
  }
}

// Markers that a picture shows once, by id.
std::vector<Marker> FindMarkers(const cv::Mat& gray, int dictionary, int border_bits) {
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->markerBorderBits = border_bits;
  std::vector<Points> corners;
  std::vector<int> ids;
  cv::aruco::detectMarkers(gray, cv::aruco::getPredefinedDictionary(dictionary), corners, ids, parameters);
  std::vector<Marker> markers;
  for (size_t i = 0; i < ids.size(); ++i) {
    if (std::count(ids.begin(), ids.end(), ids[i]) > 1 || corners[i].size() != 4) continue;
    markers.push_back({ids[i], {corners[i][0], corners[i][1], corners[i][2], corners[i][3]}});
  }
  return markers;
}

BoardCorners DetectCharuco(const cv::Mat& gray, const Board& board) {
  const auto known = DictionaryOf(board.family);
  const auto dictionary = cv::aruco::getPredefinedDictionary(known ? known->number : 0);
  const auto drawn =
      cv::aruco::CharucoBoard::create(board.columns, board.rows, static_cast<float>(board.square),
                                      static_cast<float>(board.marker), dictionary);
  std::vector<Points> markers;
  std::vector<int> marker_ids;
  cv::aruco::detectMarkers(gray, dictionary, markers, marker_ids);
  BoardCorners seen;
  if (marker_ids.empty()) return seen;
  Points corners;
  std::vector<int> ids;
  cv::aruco::interpolateCornersCharuco(markers, marker_ids, gray, drawn, corners, ids);
  // A corner is farther from the nearest marker's corner than half the squares' rim; stay clear of it.
  const double rim = 0.5 * (1 - board.marker / board.square);
  std::vector<double> reach(corners.size());
  for (size_t i = 0; i < corners.size(); ++i) {
    double square_px = std::numeric_limits<double>::infinity();
    double nearest = std::numeric_limits<double>::infinity();
    for (const Points& marker : markers) {
      for (size_t k = 0; k < 4; ++k) {
        const double d = Distance(marker[k], corners[i]);
        if (d > nearest) continue;
        nearest = d;
        square_px =
            board.square / board.marker *
            std::min(Distance(marker[k], marker[(k + 1) % 4]), Distance(marker[k], marker[(k + 3) % 4]));
      }
    }
    reach[i] = std::isfinite(square_px) ? rim * square_px : 2;
  }
  std::vector<bool> kept;
  RefineSaddles(gray, corners, reach, kept);
  std::map<int, cv::Point2f> found;
  for (size_t i = 0; i < corners.size(); ++i) {
    if (kept[i]) found[ids[i]] = corners[i];
  }
  Keep(found, seen);
  return seen;
}

Result<std::vector<Marker>> FindGridTags(const cv::Mat& gray, const Board& board) {
  std::vector<Marker> markers;
  if (board.border_bits == 1) {
    auto detector = TagDetector::Create({.family = board.family});
    if (!detector.ok()) return detector.error();
    const auto tags = detector.value().Detect({gray.data, gray.cols, gray.rows, static_cast<int>(gray.step)});
    if (!tags.ok()) return tags.error();
    std::map<int, int> times;
    for (const TagDetection& tag : tags.value()) ++times[tag.id];
    for (const TagDetection& tag : tags.value()) {
      if (times[tag.id] > 1) continue;
      Marker marker{tag.id, {}};
      for (int k = 0; k < 4; ++k) {
        marker.corners[static_cast<size_t>(k)] =
            cv::Point2f(static_cast<float>(tag.corners_px(0, k)), static_cast<float>(tag.corners_px(1, k)));
      }
      markers.push_back(marker);
    }
    return markers;
  }
  for (Marker m : FindMarkers(gray, cv::aruco::DICT_APRILTAG_36h11, board.border_bits)) {
    // OpenCV has these tags upside down, and counts their corners clockwise from the top left.
    const auto c = m.corners;
    m.corners = {c[1], c[0], c[3], c[2]};
    markers.push_back(m);
  }
  return markers;
}

Result<BoardCorners> DetectAprilGrid(const cv::Mat& gray, const Board& board) {
  const auto markers = FindGridTags(gray, board);
  if (!markers.ok()) return markers.error();
  BoardCorners seen;
  std::map<int, cv::Point2f> found;
  for (const Marker& marker : markers.value()) {
    if (marker.id >= board.columns * board.rows) continue;
    Points corners(marker.corners.begin(), marker.corners.end());
    double side = std::numeric_limits<double>::infinity();
    for (size_t k = 0; k < 4; ++k) side = std::min(side, Distance(corners[k], corners[(k + 1) % 4]));
    std::vector<bool> kept(4, true);
    // Where black squares fill the gaps (Kalibr's), each corner is a saddle; libapriltag's corners are fitted
    // to the edges already.
    const double free = std::min(board.spacing, 0.2 * board.border_bits);
    if (board.border_bits == 2) RefineSaddles(gray, corners, std::vector<double>(4, 0.6 * free * side), kept);
    for (size_t k = 0; k < 4; ++k) {
      if (kept[k]) found[4 * marker.id + static_cast<int>(k)] = corners[k];
    }
  }
  Keep(found, seen);
  return seen;
}

}  // namespace

Result<BoardCorners> DetectBoard(const GrayImage& image, const Board& board) {
  if (auto s = CheckBoard(board); !s.ok()) return s.error();
  if (image.pixels == nullptr || image.width < 1 || image.height < 1 || image.stride < image.width) {
    return Error{ErrorKind::kBadInput, fmt::format("a picture of {} x {} px with {} bytes a row; expected "
                                                   "pixels, and at least as many bytes a row as pixels",
                                                   image.width, image.height, image.stride)};
  }
  if (image.width < 32 || image.height < 32) return BoardCorners{};  // no room for a board
  // OpenCV only reads it, but takes it as writable.
  const cv::Mat gray(image.height, image.width, CV_8UC1, const_cast<unsigned char*>(image.pixels),
                     static_cast<size_t>(image.stride));
  try {
    switch (board.kind) {
      case BoardKind::kChessboard:
        return DetectChessboard(gray, board);
      case BoardKind::kCharuco:
        return DetectCharuco(gray, board);
      case BoardKind::kAprilGrid:
        return DetectAprilGrid(gray, board);
    }
  } catch (const cv::Exception& error) {
    return Error{ErrorKind::kBadInput, "the board's detector refused the picture: " + error.err};
  }
  return BoardCorners{};
}

}  // namespace tendril
