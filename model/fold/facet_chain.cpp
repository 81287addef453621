#include "model/fold/facet_chain.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/check.h"
#include "model/geometry/rotation.h"

namespace tendril {
namespace {

// A unit quaternion in four scalars. Eigen's product loads pairs that were stored one by one a moment before,
// which stalls (profile: a third of FoldChain waited there).
struct Turn {
  double w = 1, x = 0, y = 0, z = 0;

  Turn Inverse() const { return {w, -x, -y, -z}; }
  Eigen::Quaterniond Quaternion() const { return {w, x, y, z}; }
};

Turn operator*(const Turn& a, const Turn& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

// One Newton step back to unit length: the drift of a product is rounding, never more.
Turn Renormalised(const Turn& q) {
  const double scale = 0.5 * (3 - (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z));
  return {scale * q.w, scale * q.x, scale * q.y, scale * q.z};
}

// Everything about a crease is told from its mean frame: the sheet's axes half-way (by phi) between facet i
// and facet i+1. Quaternions throughout, so that angles of 1e-150 keep their digits, second-order ones too.
struct Hinge {
  Turn half;             // facet_from_mean: by phi about the crease
  Turn mean_from_chord;  // the tendon segment's directors in the mean frame
  double chord = 0;      // hole to hole, m
};

// sin and cos of the crease angles; they come in turn (alpha, beta), so two are remembered.
class CreaseDirections {
 public:
  struct Direction {
    double angle = -1;
    double sine = 0;
    double cosine = 0;
  };

  const Direction& At(double angle, Eigen::Index crease) {
    Direction& direction = last_[crease % 2];
    if (direction.angle != angle) {
      direction = {angle, std::sin(angle), std::cos(angle)};
      if (std::abs(direction.cosine) < 1e-15) direction.cosine = 0;  // pi / 2 stands for a right angle
    }
    return direction;
  }

 private:
  Direction last_[2];
};

// The rotation about x or y whose angle, in [-pi/2, pi/2], has this sine and (relative) this cosine.
void HalfAngle(double sine, double cosine, double& half_sine, double& half_cosine) {
  half_cosine = std::sqrt(0.5 * (1 + cosine));
  half_sine = 0.5 * sine / half_cosine;
}

Hinge HingeAt(const TentacleLayout& layout, Eigen::Index i, double phi,
              const CreaseDirections::Direction& direction) {
  const auto& [angle, sine_a, cosine_a] = direction;
  const double sign = i % 2 == 0 ? -1 : 1;  // mountain, valley, ... seen from +x
  const double s = std::sin(0.5 * phi);
  const double c = std::cos(0.5 * phi);
  const double cosine = phi == std::numbers::pi / 2 ? 0 : (c - s) * (c + s);  // closed: exactly
  const double sine = 2 * s * c;

  Hinge hinge;
  hinge.half = {c, 0, sign * s * sine_a, sign * s * cosine_a};

  // Chord in the mean frame: hole i lies `before` below the crease, hole i+1 `after` above it, each turned
  // back by phi. Where the two are equal the chord has no x component and d1 is the mean normal itself.
  const double before = layout.crease_z[i] - layout.hole_z[i];
  const double after = layout.hole_z[i + 1] - layout.crease_z[i];
  const double sum = before + after;
  double uneven = after - before;
  if (std::abs(uneven) < 1e-12 * sum) uneven = 0;
  const double x = uneven * sign * sine * sine_a;
  const double y = sum * 2 * s * s * cosine_a * sine_a;
  const double z = sum * (cosine + 2 * s * s * cosine_a * cosine_a);
  const double in_sheet = std::sqrt(y * y + z * z);
  hinge.chord = x == 0 ? in_sheet : std::sqrt(y * y + z * z + x * x);
  double half_sine_x = 0;
  double half_cosine_x = 1;
  if (y != 0 && in_sheet > 0) HalfAngle(-y / in_sheet, z / in_sheet, half_sine_x, half_cosine_x);
  hinge.mean_from_chord = {half_cosine_x, half_sine_x, 0, 0};
  if (x != 0 && hinge.chord > 0) {
    double half_sine_y = 0;
    double half_cosine_y = 1;
    HalfAngle(x / hinge.chord, in_sheet / hinge.chord, half_sine_y, half_cosine_y);
    hinge.mean_from_chord = hinge.mean_from_chord * Turn{half_cosine_y, 0, half_sine_y, 0};
  }
  return hinge;
}

}  // namespace

FacetChain FoldChain(const TentacleLayout& layout, const Eigen::Ref<const Eigen::VectorXd>& angle) {
  FacetChain chain;
  FoldChain(layout, angle, chain);
  return chain;
}

void FoldChain(const TentacleLayout& layout, const Eigen::Ref<const Eigen::VectorXd>& angle,
               FacetChain& chain) {
  const Eigen::Index creases = layout.crease_z.size();
  TENDRIL_CHECK(creases > 0 && angle.size() == creases && layout.hole_z.size() == creases + 1);
  chain.tentacle_from_sheet.resize(creases + 1);

  CreaseDirections directions;
  Turn turned;  // tentacle_from_facet
  Eigen::Matrix3d rotation;
  Eigen::Vector3d crease;  // the crease's centre in the tentacle's frame, reached from hole 0 facet by facet
  for (Eigen::Index i = 0; i <= creases; ++i) {
    double known_z = 0;  // the point of facet i, on its centerline, whose place is known
    if (i == 0) {
      const Hinge hinge = HingeAt(layout, 0, angle[0], directions.At(layout.crease_angle[0], 0));
      turned = (hinge.half * hinge.mean_from_chord).Inverse();
      crease.setZero();
      known_z = layout.hole_z[0];
    } else {
      known_z = layout.crease_z[i - 1];
    }
    rotation = turned.Quaternion().toRotationMatrix();
    Eigen::Isometry3d& pose = chain.tentacle_from_sheet[i];
    pose.setIdentity();
    pose.linear() = rotation;
    pose.translation() = crease - known_z * rotation.col(2);
    if (i == creases) break;
    crease += (layout.crease_z[i] - known_z) * rotation.col(2);
    const auto& direction = directions.At(layout.crease_angle[i], i);
    const double sign = i % 2 == 0 ? -1 : 1;
    const double sine = sign * std::sin(angle[i]);
    turned = turned * Turn{std::cos(angle[i]), 0, sine * direction.sine, sine * direction.cosine};
    if (i % 16 == 15) turned = Renormalised(turned);
  }
}

TendonCurve TendonCurveOf(const TentacleLayout& layout, const FacetChain& chain,
                          const Eigen::Ref<const Eigen::VectorXd>& angle) {
  TendonCurve curve;
  TendonCurveOf(layout, chain, angle, curve);
  return curve;
}

void TendonCurveOf(const TentacleLayout& layout, const FacetChain& chain,
                   const Eigen::Ref<const Eigen::VectorXd>& angle, TendonCurve& curve) {
  const Eigen::Index creases = layout.crease_z.size();
  TENDRIL_CHECK(creases > 0 && angle.size() == creases && layout.hole_z.size() == creases + 1);
  TENDRIL_CHECK(static_cast<Eigen::Index>(chain.tentacle_from_sheet.size()) == creases + 1);
  curve.holes.resize(3, creases + 1);
  curve.frames.resize(creases);
  curve.segment_length.resize(creases);
  curve.turning.resize(3, creases - 1);

  CreaseDirections directions;
  Turn arrived;  // directors of segment i-1 from facet i
  for (Eigen::Index i = 0; i <= creases; ++i) {
    const Eigen::Isometry3d& pose = chain.tentacle_from_sheet[i];
    curve.holes.col(i) = pose.translation() + layout.hole_z[i] * pose.linear().col(2);
    if (i == creases) break;
    const Hinge hinge = HingeAt(layout, i, angle[i], directions.At(layout.crease_angle[i], i));
    const Turn leaving = hinge.half * hinge.mean_from_chord;  // facet i from directors
    curve.frames[i].noalias() = (pose.linear() * leaving.Quaternion().toRotationMatrix()).transpose();
    curve.segment_length[i] = hinge.chord;
    // R_i^T R_{i+1} of the two segments' directors, told from the facet between them.
    if (i > 0) curve.turning.col(i - 1) = LogSo3((arrived * leaving).Quaternion());
    arrived = hinge.mean_from_chord.Inverse() * hinge.half;
  }
}

FramedCurve NodesAtHoles(const TendonCurve& curve) {
  const Eigen::Index nodes = curve.holes.cols();
  FramedCurve framed;
  framed.points = curve.holes;
  framed.normals.resize(3, nodes);
  for (Eigen::Index i = 0; i < nodes; ++i) {
    const Eigen::Matrix3d& before = curve.frames[std::max<Eigen::Index>(i - 1, 0)];
    const Eigen::Matrix3d& after = curve.frames[std::min(i, nodes - 2)];
    const Eigen::Vector3d tangent = (before.row(2) + after.row(2)).transpose();
    Eigen::Vector3d normal = (before.row(0) + after.row(0)).transpose();
    const auto made_perpendicular = [&](const Eigen::Vector3d& v) -> Eigen::Vector3d {
      const double square = tangent.squaredNorm();
      return square > 1e-14 ? Eigen::Vector3d(v - (v.dot(tangent) / square) * tangent) : v;
    };
    normal = made_perpendicular(normal);
    if (normal.norm() < 1e-7) {
      // The segments turn by pi: the mean vanishes, or lies along the tangent, but half the turning does not.
      const Eigen::Matrix3d half_way = before.transpose() * ExpSo3(0.5 * curve.turning.col(i - 1));
      normal = made_perpendicular(half_way.col(0));
      if (normal.norm() < 1e-7) normal = made_perpendicular(half_way.col(1));
    }
    framed.normals.col(i) = normal.normalized();
  }
  return framed;
}

double KinematicPull(const TentacleLayout& layout, const TendonCurve& curve) {
  // Summed as differences: near the flat state the lengths themselves keep no digit of the pull.
  double taken = 0;
  for (Eigen::Index i = 0; i < curve.segment_length.size(); ++i) {
    taken += (layout.hole_z[i + 1] - layout.hole_z[i]) - curve.segment_length[i];
  }
  return taken / (layout.hole_z[layout.hole_z.size() - 1] - layout.hole_z[0]);
}

}  // namespace tendril
