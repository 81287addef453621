#include "model/geometry/net_curvature.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "model/check.h"

namespace tendril {
namespace {

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

struct Bend {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();  // rad
  double length = 0;                               // m
};

Bend BendOf(const Eigen::Matrix3Xd& points) {
  Bend sum;
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  double before_length = 0;
  for (Eigen::Index i = 0; i + 1 < points.cols(); ++i) {
    const Eigen::Vector3d along = points.col(i + 1) - points.col(i);
    const double length = along.norm();
    const Eigen::Vector3d tangent = along / length;  // NaN of two nodes in one place
    if (i > 0) {
      sum.length += 0.5 * (before_length + length);
      const Eigen::Vector3d axis = before.cross(tangent);
      const double sine = axis.norm();
      if (!(sine <= 0)) sum.turn += axis / sine * std::atan2(sine, before.dot(tangent));
    }
    before = tangent;
    before_length = length;
  }
  return sum;
}

double CurvatureAbout(const Eigen::Vector3d& axis, const Eigen::Matrix3Xd& points) {
  const Bend bend = BendOf(points);
  return bend.length > 0 ? bend.turn.dot(axis) / bend.length : kNotKnown;
}

double SigmaAbout(const Eigen::Vector3d& axis, const Eigen::Matrix3Xd& points,
                  const Eigen::Ref<const Eigen::MatrixXd>& factor) {
  // Far below the error that a column stands for, far above rounding.
  constexpr double kStep = 1e-3;
  double variance = 0;
  for (Eigen::Index c = 0; c < factor.cols(); ++c) {
    if (factor.col(c).isZero(0)) continue;
    const Eigen::VectorXd step = kStep * factor.col(c);
    const Eigen::Map<const Eigen::Matrix3Xd> moved(step.data(), 3, points.cols());
    const double slope =
        (CurvatureAbout(axis, points + moved) - CurvatureAbout(axis, points - moved)) / (2 * kStep);
    variance += slope * slope;
  }
  return std::sqrt(variance);
}

}  // namespace

NetCurvature NetCurvatureOf(const CurveSeries& series, Eigen::Index first, Eigen::Index last) {
  const auto frames = static_cast<Eigen::Index>(series.curves.size());
  NetCurvature net{Eigen::VectorXd::Constant(frames, kNotKnown),
                   Eigen::VectorXd::Constant(frames, kNotKnown)};
  if (frames == 0) return net;
  const Eigen::Index nodes = series.curves.front().points.cols();
  if (last < 0) last = nodes - 1;
  TENDRIL_CHECK(first >= 0 && last < nodes);
  const Eigen::Index count = std::max<Eigen::Index>(0, last - first + 1);
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  for (const FramedCurve& curve : series.curves) {
    const Bend bend = BendOf(curve.points.middleCols(first, count));
    if (bend.turn.norm() > axis.norm()) axis = bend.turn;
  }
  if (axis.norm() > 0) axis.normalize();
  for (Eigen::Index f = 0; f < frames; ++f) {
    const auto frame = static_cast<std::size_t>(f);
    const Eigen::Matrix3Xd points = series.curves[frame].points.middleCols(first, count);
    net.value[f] = CurvatureAbout(axis, points);
    if (series.covariance_factor.empty() || !std::isfinite(net.value[f]) || axis.isZero(0)) continue;
    net.sigma[f] = SigmaAbout(axis, points, series.covariance_factor[frame].middleRows(3 * first, 3 * count));
  }
  return net;
}

}  // namespace tendril
