#include "capture/track/planar_chain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "model/check.h"
#include "model/median.h"

namespace tendril {
namespace {

constexpr double kNotSeen = std::numeric_limits<double>::quiet_NaN();

// Centres by frame and tag.
std::map<std::int64_t, std::map<int, Eigen::Vector2d>> CentersByFrame(
    std::span<const DetectionRow> detections) {
  std::map<std::int64_t, std::map<int, const DetectionRow*>> best;
  for (const DetectionRow& row : detections) {
    const DetectionRow*& kept = best[row.frame][row.tag];
    if (kept == nullptr || row.margin > kept->margin) kept = &row;
  }
  std::map<std::int64_t, std::map<int, Eigen::Vector2d>> centers;
  for (const auto& [frame, tags] : best) {
    for (const auto& [tag, row] : tags) centers[frame][tag] = TagCenter(row->corners_px);
  }
  return centers;
}

// Turning and arc length of a polyline in the plane, between the middles of its first and last segment.
void Bend(const Eigen::Matrix2Xd& points, double* turning, double* length) {
  *turning = 0;
  *length = 0;
  for (Eigen::Index i = 1; i + 1 < points.cols(); ++i) {
    const Eigen::Vector2d before = points.col(i) - points.col(i - 1);
    const Eigen::Vector2d after = points.col(i + 1) - points.col(i);
    *turning += std::atan2(before.x() * after.y() - before.y() * after.x(), before.dot(after));
    *length += 0.5 * (before.norm() + after.norm());
  }
}

}  // namespace

Eigen::Vector2d TagCenter(const Eigen::Matrix<double, 2, 4>& corners_px) {
  Eigen::Vector2d mean = corners_px.rowwise().mean();
  const Eigen::Vector2d first = corners_px.col(2) - corners_px.col(0);
  const Eigen::Vector2d second = corners_px.col(3) - corners_px.col(1);
  const double sine = first.x() * second.y() - first.y() * second.x();
  if (!(std::abs(sine) > 1e-9 * first.norm() * second.norm()) || first.norm() == 0) return mean;
  const Eigen::Vector2d between = corners_px.col(1) - corners_px.col(0);
  return corners_px.col(0) + first * ((between.x() * second.y() - between.y() * second.x()) / sine);
}

double MedianSpacingPx(std::span<const DetectionRow> detections, std::span<const int> chain) {
  std::vector<double> spacing;
  for (const auto& [frame, tags] : CentersByFrame(detections)) {
    for (size_t i = 0; i + 1 < chain.size(); ++i) {
      const auto a = tags.find(chain[i]);
      const auto b = tags.find(chain[i + 1]);
      if (a != tags.end() && b != tags.end()) spacing.push_back((a->second - b->second).norm());
    }
  }
  return Median(std::move(spacing));
}

Result<PlanarChain> FollowPlanarChain(std::span<const DetectionRow> detections, const Eigen::VectorXd& time,
                                      const PlanarChainOptions& options) {
  TENDRIL_CHECK(options.plane_of_pixel != nullptr);
  const auto nodes = static_cast<Eigen::Index>(options.chain.size());
  if (nodes < 2 || std::set<int>(options.chain.begin(), options.chain.end()).size() != options.chain.size()) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("a chain of {} tags, each once, is needed; expected two or more "
                             "different ids",
                             nodes)};
  }
  const auto centers = CentersByFrame(detections);
  if (!centers.empty() && (centers.rbegin()->first >= time.size() || centers.begin()->first < 0)) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("detections of frames {} to {}, but times of {} frames; expected a "
                             "time for each",
                             centers.begin()->first, centers.rbegin()->first, time.size())};
  }
  PlanarChain all;
  all.curve.name = "limb";
  all.curve.time = time;
  all.tip_angle = Eigen::VectorXd::Constant(time.size(), kNotSeen);
  all.mean_curvature = all.tip_angle;
  double sum2 = 0;
  Eigen::Index seen_count = 0;
  for (Eigen::Index frame = 0; frame < time.size(); ++frame) {
    FramedCurve curve;
    curve.points = Eigen::Matrix3Xd::Constant(3, nodes, kNotSeen);
    curve.normals = Eigen::Vector3d(0, -1, 0).replicate(1, nodes);  // the tags face the camera
    Eigen::VectorXd sigma = Eigen::VectorXd::Constant(nodes, kNotSeen);
    Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(3 * nodes, 2 * nodes);
    Eigen::Matrix2Xd plane(2, nodes);
    Eigen::Index seen = 0;
    if (const auto found = centers.find(frame); found != centers.end()) {
      for (Eigen::Index i = 0; i < nodes; ++i) {
        const auto at = found->second.find(options.chain[static_cast<size_t>(i)]);
        if (at == found->second.end()) continue;
        const auto point = options.plane_of_pixel(at->second);
        const auto right = options.plane_of_pixel(at->second + Eigen::Vector2d(1, 0));
        const auto down = options.plane_of_pixel(at->second + Eigen::Vector2d(0, 1));
        if (!point || !right || !down) continue;
        plane.col(i) = *point;
        curve.points.col(i) = Eigen::Vector3d(point->x(), 0, point->y());
        sigma[i] = options.sigma_px * (*right - *point).norm();
        for (const auto& [column, moved] : {std::pair{2 * i, *right}, std::pair{2 * i + 1, *down}}) {
          factor(3 * i, column) = options.sigma_px * (moved.x() - point->x());
          factor(3 * i + 2, column) = options.sigma_px * (moved.y() - point->y());
        }
        sum2 += sigma[i] * sigma[i];
        ++seen;
      }
    }
    seen_count += seen;
    if (seen == nodes) {
      ++all.complete_frames;
      double turning = 0;
      double length = 0;
      Bend(plane, &turning, &length);
      all.tip_angle[frame] = turning;
      all.mean_curvature[frame] = nodes > 2 && length > 0 ? turning / length : kNotSeen;
    }
    all.curve.curves.push_back(std::move(curve));
    all.curve.sigma.push_back(std::move(sigma));
    all.curve.covariance_factor.push_back(std::move(factor));
  }
  const auto total = static_cast<double>(nodes * time.size());
  all.seen_fraction = total > 0 ? static_cast<double>(seen_count) / total : 0;
  all.rms_sigma = seen_count > 0 ? std::sqrt(sum2 / static_cast<double>(seen_count)) : kNotSeen;
  return all;
}

}  // namespace tendril
