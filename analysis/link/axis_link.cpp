// The link with an infinite axis as a winding angle, and the twist of normals: link.h.
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "analysis/link/link.h"
#include "model/check.h"

namespace tendril {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kUlp = std::numeric_limits<double>::epsilon();

Eigen::Vector3d Eigen3(const Vec3<double>& v) { return {v.x, v.y, v.z}; }

// Unit tangents of the segments; a segment without length takes the mean direction of its neighbours that
// have one.
Eigen::Matrix3Xd SegmentTangents(const Eigen::Matrix3Xd& points, bool closed) {
  const Eigen::Index n = points.cols() - 1;
  Eigen::Matrix3Xd tangents = Eigen::Matrix3Xd::Zero(3, n);
  std::vector<bool> known(static_cast<size_t>(n));
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d edge = points.col(i + 1) - points.col(i);
    const double length = edge.stableNorm();
    known[static_cast<size_t>(i)] = length > 0;
    if (length > 0) tangents.col(i) = edge / length;
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    if (known[static_cast<size_t>(i)]) continue;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Eigen::Index step : {-1, 1}) {
      for (Eigen::Index k = 1; k < n; ++k) {
        Eigen::Index at = i + step * k;
        if (closed) at = (at + n * 2) % n;
        if (at < 0 || at >= n) break;
        if (!known[static_cast<size_t>(at)]) continue;
        mean += tangents.col(at);
        break;
      }
    }
    const double length = mean.norm();
    tangents.col(i) = length > 0 ? Eigen::Vector3d(mean / length) : Eigen::Vector3d::UnitX();
  }
  return tangents;
}

// The mean of the unit tangents on both sides of a node; where the curve turns straight back, the one before.
Eigen::Vector3d NodeTangent(const Eigen::Matrix3Xd& tangents, Eigen::Index node, bool closed) {
  const Eigen::Index n = tangents.cols();
  const bool end = node == 0 || node == n;
  if (end && !closed) return tangents.col(node == 0 ? 0 : n - 1);
  const Eigen::Vector3d before = tangents.col(end ? n - 1 : node - 1);
  const Eigen::Vector3d mean = before + tangents.col(end ? 0 : node);
  const double length = mean.norm();
  return length > 1e-12 ? Eigen::Vector3d(mean / length) : before;
}

// v turned by the smallest rotation that takes the unit vector `from` to `to`.
Eigen::Vector3d Carry(const Eigen::Vector3d& v, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d axis = from.cross(to);
  const double cosine = from.dot(to);
  if (cosine < -1 + 1e-15) return -v;  // straight back: no smallest rotation; never for half a turn of a node
  return cosine * v + axis.cross(v) + axis * (axis.dot(v) / (1 + cosine));
}

// The angle from q to r about the axis, and whether the segment q -> r meets the axis.
struct Winding {
  double angle = 0;
  double error = 0;
  bool on_axis = false;
};

// q and along = r - q, both across the axis: q x along keeps its digits where q x r would cancel.
Winding AngleAbout(const Eigen::Vector3d& axis, const Eigen::Vector3d& q, const Eigen::Vector3d& r,
                   const Eigen::Vector3d& along, double noise) {
  const bool from_q = q.squaredNorm() <= r.squaredNorm();
  const double sine = axis.dot((from_q ? q : r).cross(along));
  const double cosine = q.dot(r);
  const double size = q.norm() * r.norm();
  const double doubt = (kCoplanar * std::min(q.norm(), r.norm()) + noise) * along.norm();
  if (std::abs(sine) <= doubt) return {0, cosine <= kCoplanar * size ? kPi : 0, cosine <= kCoplanar * size};
  return {std::atan2(sine, cosine), 16 * kUlp * size / std::hypot(sine, cosine) + 4 * kUlp, false};
}

}  // namespace

LinkValue AxisLink(const Strand& strand, const Axis& axis) {
  const double length = axis.direction.stableNorm();
  TENDRIL_CHECK(length > 0);
  const Eigen::Vector3d along = axis.direction / length;
  const auto across = [&](const Eigen::Vector3d& v) { return Eigen::Vector3d(v - v.dot(along) * along); };
  LinkValue link;
  double angle = 0, error = 0;
  Eigen::Vector3d from = Eigen3(strand.node(0)) - axis.point;
  double far = from.norm();
  for (size_t i = 1; i < strand.nodes(); ++i) {
    const Eigen::Vector3d to = Eigen3(strand.node(i)) - axis.point;
    // Far along the axis the parts across it carry the rounding of the whole.
    const double noise = 2 * kUlp * std::max(far, to.norm());
    const Eigen::Vector3d edge = Eigen3(strand.node(i)) - Eigen3(strand.node(i - 1));
    const Winding one = AngleAbout(along, across(from), across(to), across(edge), noise);
    angle += one.angle;
    error += one.error;
    if (one.on_axis) link.flags |= kTouchesAxis;
    from = to;
    far = to.norm();
  }
  const auto add_ray = [&](const std::optional<Ray>& ray, size_t node, double sign) {
    if (!ray) return;
    const Eigen::Vector3d start = Eigen3(strand.node(node)) - axis.point;
    const Eigen::Vector3d q = across(start);
    const Eigen::Vector3d out = across(Eigen3(ray->direction));
    if (out.norm() <= 1e-12 + ray->error) {
      link.flags |= kRayAlongAxis;
      return;
    }
    // From where it stands to where it points, as seen along the axis; less than half a turn.
    const double sine = along.dot(q.cross(out));
    const double cosine = q.dot(out);
    const double size = q.norm() * out.norm();
    const double doubt = (1e-12 + ray->error / out.norm()) * size + 2 * kUlp * start.norm() * out.norm();
    const bool meets = cosine <= 1e-12 * size;
    if (meets && std::abs(sine) <= 1e-6 * size + doubt) link.flags |= kRayMeetsAxis;
    if (std::abs(sine) <= doubt) {
      error += meets ? kPi : doubt / std::max(size, 1e-300);
      return;
    }
    angle += sign * std::atan2(sine, cosine);
    error += (doubt + 8 * kUlp * size) / std::hypot(sine, cosine);
  };
  add_ray(strand.base_ray, 0, -1);
  add_ray(strand.tip_ray, strand.nodes() - 1, 1);
  link.value = angle / (2 * kPi);
  link.error = error / (2 * kPi);
  return link;
}

Result<Eigen::Matrix3Xd> PerpendicularNormals(const FramedCurve& curve, bool closed) {
  const Eigen::Index n = curve.points.cols();
  if (curve.normals.cols() != n || n < 2) {
    return Error{ErrorKind::kBadInput, "a self-link needs one normal per node and two nodes or more"};
  }
  const Eigen::Matrix3Xd tangents = SegmentTangents(curve.points, closed);
  Eigen::Matrix3Xd normals(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d tangent = NodeTangent(tangents, i, closed);
    const Eigen::Vector3d given = curve.normals.col(i);
    const Eigen::Vector3d normal = given - given.dot(tangent) * tangent;
    const double length = normal.norm();
    if (!(length > 1e-6 * given.norm()) || !std::isfinite(length)) {
      return Error{ErrorKind::kBadInput,
                   "the normal of node " + std::to_string(i) +
                       " is not finite, zero or along the curve, expected one across it"};
    }
    normals.col(i) = normal / length;
  }
  return normals;
}

double Twist(const Eigen::Matrix3Xd& points, const Eigen::Matrix3Xd& normals, bool closed) {
  TENDRIL_CHECK(points.cols() == normals.cols() && points.cols() >= 2);
  const Eigen::Matrix3Xd tangents = SegmentTangents(points, closed);
  double angle = 0;
  for (Eigen::Index i = 0; i < tangents.cols(); ++i) {
    const Eigen::Vector3d tangent = tangents.col(i);
    const Eigen::Vector3d here = Carry(normals.col(i), NodeTangent(tangents, i, closed), tangent);
    const Eigen::Vector3d there = Carry(normals.col(i + 1), NodeTangent(tangents, i + 1, closed), tangent);
    angle += std::atan2(tangent.dot(here.cross(there)), here.dot(there));
  }
  return angle / (2 * kPi);
}

}  // namespace tendril
