#include "model/geometry/rotation.h"

#include <cmath>

namespace tendril {
namespace {

// sin(x) / x.
double Sinc(double x) { return std::abs(x) < 1e-4 ? 1 - x * x / 6 : std::sin(x) / x; }

}  // namespace

Eigen::Matrix3d ExpSo3(const Eigen::Vector3d& v) {
  const double angle = v.stableNorm();
  const double half_sinc = Sinc(0.5 * angle);
  const double first = Sinc(angle);                   // sin(angle) / angle
  const double second = 0.5 * half_sinc * half_sinc;  // (1 - cos(angle)) / angle^2, without the cancellation
  Eigen::Matrix3d cross;
  cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return Eigen::Matrix3d::Identity() + first * cross + second * (cross * cross);
}

Eigen::Quaterniond ExpSo3Quaternion(const Eigen::Vector3d& v) {
  const double half = 0.5 * v.stableNorm();
  const Eigen::Vector3d vec = 0.5 * Sinc(half) * v;
  return {std::cos(half), vec.x(), vec.y(), vec.z()};
}

Eigen::Vector3d LogSo3(const Eigen::Quaterniond& rotation) {
  const double sign = rotation.w() < 0 ? -1 : 1;
  const double w = std::abs(rotation.w());
  const Eigen::Vector3d vec = sign * rotation.vec();
  const double square = vec.squaredNorm();
  if (square < 1e-8 && w > 0) {  // 2 atan(t) / |vec| with t = |vec| / w, as a series: square may underflow
    const double t2 = square / (w * w);
    return (2 / w) * (1 - t2 * (1.0 / 3 - t2 / 5)) * vec;
  }
  const double length = std::sqrt(square);
  const double half = w >= length ? std::atan(length / w) : std::atan2(length, w);  // atan is the faster
  return (2 * half / length) * vec;
}

Eigen::Vector3d LogSo3(const Eigen::Matrix3d& rotation) { return LogSo3(Eigen::Quaterniond(rotation)); }

}  // namespace tendril
