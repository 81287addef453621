#include "capture/rig/strip_chain.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "model/check.h"
#include "model/geometry/rotation.h"

namespace tendril {
namespace {

constexpr double kGravity = 9.80665;  // m/s^2
constexpr double kPetDensity = 1390;  // kg/m^3
constexpr int kStripsPerFacet = 3;

using Isometry = Eigen::Isometry3d;
using Vector3 = Eigen::Vector3d;

// The part of a convex polygon with sign * (z - at) >= 0.
Eigen::Matrix3Xd Clip(const Eigen::Matrix3Xd& polygon, double at, double sign) {
  std::vector<Vector3> kept;
  for (Eigen::Index i = 0; i < polygon.cols(); ++i) {
    const Vector3 a = polygon.col(i);
    const Vector3 b = polygon.col((i + 1) % polygon.cols());
    const double side_a = sign * (a.z() - at);
    const double side_b = sign * (b.z() - at);
    if (side_a >= 0) kept.push_back(a);
    if ((side_a > 0 && side_b < 0) || (side_a < 0 && side_b > 0)) {
      kept.push_back(a + (b - a) * (side_a / (side_a - side_b)));
    }
  }
  Eigen::Matrix3Xd result(3, static_cast<Eigen::Index>(kept.size()));
  for (std::size_t i = 0; i < kept.size(); ++i) result.col(static_cast<Eigen::Index>(i)) = kept[i];
  return result;
}

// Where a facet's strips join: two lines along y, at thirds of its length on the centerline.
std::array<double, 2> JointsOfFacet(const TentacleLayout& layout, Eigen::Index facet) {
  const Eigen::Index creases = layout.crease_z.size();
  const double from = facet == 0 ? layout.base_z : layout.crease_z[facet - 1];
  const double to = facet == creases ? layout.tip_z : layout.crease_z[facet];
  return {from + (to - from) / 3, from + (to - from) * 2 / 3};
}

// A line of the sheet about which all that follows turns.
struct Hinge {
  Vector3 at;
  Vector3 direction;
  double turn = 0;
  int crease = -1;                 // -1: a bend within a facet
  Vector3 give = Vector3::Zero();  // turning about any axis through `at`, made first
};

Isometry TurnAbout(const Hinge& hinge) {
  Isometry turn(Eigen::Translation3d(hinge.at) * Eigen::AngleAxisd(hinge.turn, hinge.direction) *
                Eigen::Translation3d(-hinge.at));
  if (hinge.give.isZero(0)) return turn;
  const Isometry give(Eigen::Translation3d(hinge.at) * ExpSo3Quaternion(hinge.give) *
                      Eigen::Translation3d(-hinge.at));
  return give * turn;
}

// Hinges between the strips, in order. The law's angle is that between the facets' middle strips, so a
// facet's bend is taken off again at the creases beside it: bent facets do not make the whole tentacle
// wander.
std::vector<Hinge> Hinges(const TentacleTruth& truth, const Eigen::VectorXd& angle,
                          const Eigen::Matrix3Xd& bends) {
  std::vector<Hinge> hinges;
  Vector3 carried = Vector3::Zero();  // the second half of what the crease before could not fold
  for (Eigen::Index facet = 0; facet < truth.facet_bend.size(); ++facet) {
    const double bend = truth.facet_bend[facet];
    for (const double z : JointsOfFacet(truth.layout, facet)) {
      hinges.push_back({{0, 0, z}, Vector3::UnitY(), 0.5 * bend});
    }
    hinges[hinges.size() - 2].give = carried;
    if (facet >= angle.size()) continue;
    const double mountain = facet % 2 == 0 ? -1 : 1;  // a mountain turns the next facet toward -x
    hinges.push_back({{0, 0, truth.layout.crease_z[facet]},
                      DirectionOfCrease(truth.layout.crease_angle[facet]),
                      2 * mountain * angle[facet] - 0.5 * (bend + truth.facet_bend[facet + 1]),
                      static_cast<int>(facet)});
    if (bends.cols() == 0) continue;
    const Vector3 half = 0.5 * bends.col(facet);
    const Hinge& crease = hinges.back();
    hinges[hinges.size() - 2].give = half;
    carried = Eigen::AngleAxisd(-crease.turn, crease.direction) * half;
  }
  return hinges;
}

std::vector<Isometry> PosesOfStrips(const std::vector<Hinge>& hinges, const Isometry& first) {
  std::vector<Isometry> poses{first};
  for (const Hinge& hinge : hinges) poses.push_back(poses.back() * TurnAbout(hinge));
  return poses;
}

double AreaOf(const Eigen::Matrix3Xd& polygon) {
  Vector3 twice = Vector3::Zero();
  for (Eigen::Index i = 2; i < polygon.cols(); ++i) {
    twice += Vector3(polygon.col(i - 1) - polygon.col(0)).cross(Vector3(polygon.col(i) - polygon.col(0)));
  }
  return 0.5 * twice.norm();
}

// Each crease gives way to the weight of what hangs beyond it.
void AddSag(const TentacleTruth& truth, double thickness, const std::vector<TrueStrip>& strips,
            const std::vector<Isometry>& lab_from_sheet, std::vector<Hinge>& hinges) {
  double mass = 0;
  Vector3 mass_times_position = Vector3::Zero();
  for (std::size_t i = hinges.size(); i-- > 0;) {
    const Eigen::Matrix3Xd& polygon = strips[i + 1].corners_in_sheet;
    if (polygon.cols() >= 3) {
      const double m = AreaOf(polygon) * thickness * kPetDensity;
      mass += m;
      mass_times_position += m * (lab_from_sheet[i + 1] * Vector3(polygon.rowwise().mean()));
    }
    if (hinges[i].crease < 0) continue;
    const Vector3 at = lab_from_sheet[i] * hinges[i].at;
    const Vector3 axis = lab_from_sheet[i].linear() * hinges[i].direction;
    const Vector3 moment = (mass_times_position - mass * at).cross(Vector3(0, 0, -kGravity));
    hinges[i].turn += truth.sag_compliance * moment.dot(axis);
  }
}

// Index of the strip that a point of the sheet at this z belongs to, within its facet.
std::size_t StripAt(const TentacleLayout& layout, int facet, double z) {
  const std::array<double, 2> joints = JointsOfFacet(layout, facet);
  const std::size_t within = z < joints[0] ? 0 : z < joints[1] ? 1 : 2;
  return static_cast<std::size_t>(facet) * kStripsPerFacet + within;
}

// d1 of the tendon segment across crease i: either facet's normal, turned half of the crease's way.
Vector3 SegmentNormal(const std::vector<Isometry>& poses, const TentacleLayout& layout, Eigen::Index i,
                      double angle, const Vector3& d3) {
  const std::size_t before = static_cast<std::size_t>(i) * kStripsPerFacet + 2;
  const Vector3 axis = poses[before].linear() * DirectionOfCrease(layout.crease_angle[i]);
  const double half = (i % 2 == 0 ? -1 : 1) * angle;
  const Vector3 from_base = Eigen::AngleAxisd(half, axis) * Vector3(poses[before - 1].linear().col(0));
  const Vector3 from_tip = Eigen::AngleAxisd(-half, axis) * Vector3(poses[before + 2].linear().col(0));
  const Vector3 mean = from_base + from_tip;
  return (mean - mean.dot(d3) * d3).normalized();
}

FramedCurve CenterlineOf(const TentacleTruth& truth, const std::vector<Isometry>& poses,
                         const Eigen::VectorXd& angle) {
  const TentacleLayout& layout = truth.layout;
  const Eigen::Index holes = layout.hole_z.size();
  FramedCurve curve;
  curve.points.resize(3, holes);
  for (Eigen::Index i = 0; i < holes; ++i) {
    const std::size_t strip = StripAt(layout, static_cast<int>(i), layout.hole_z[i]);
    curve.points.col(i) = poses[strip] * Vector3(0, truth.hole_y[i], layout.hole_z[i]);
  }
  Eigen::Matrix3Xd tangent(3, holes - 1);
  Eigen::Matrix3Xd normal(3, holes - 1);
  for (Eigen::Index i = 0; i + 1 < holes; ++i) {
    tangent.col(i) = (curve.points.col(i + 1) - curve.points.col(i)).normalized();
    normal.col(i) = SegmentNormal(poses, layout, i, angle[i], tangent.col(i));
  }
  curve.normals.resize(3, holes);
  for (Eigen::Index i = 0; i < holes; ++i) {
    const Eigen::Index before = std::max<Eigen::Index>(i - 1, 0);
    const Eigen::Index after = std::min<Eigen::Index>(i, holes - 2);
    const Vector3 t = (tangent.col(before) + tangent.col(after)).normalized();
    const Vector3 n = normal.col(before) + normal.col(after);
    curve.normals.col(i) = (n - n.dot(t) * t).normalized();
  }
  return curve;
}

// Moves the chain so that hole 0 is the origin, the first tendon segment runs along +z and its d1 is +x.
Isometry TentacleFromChain(const FramedCurve& chain, const Vector3& d1) {
  const Vector3 d3 = (chain.points.col(1) - chain.points.col(0)).normalized();
  Eigen::Matrix3d rows;
  rows.row(0) = d1.transpose();
  rows.row(1) = d3.cross(d1).transpose();
  rows.row(2) = d3.transpose();
  Isometry pose = Isometry::Identity();
  pose.linear() = rows;
  pose.translation() = -rows * chain.points.col(0);
  return pose;
}

}  // namespace

Eigen::Vector3d DirectionOfCrease(double angle) { return {0, std::sin(angle), std::cos(angle)}; }

TrueTentacle ShapeOfStrips(const TentacleTruth& truth, const TentacleDesign& design,
                           const Eigen::VectorXd& rest_angle, const BeyondFold& beyond) {
  const TentacleLayout& layout = truth.layout;
  TENDRIL_CHECK(beyond.fold.size() == 0 || beyond.fold.size() == rest_angle.size());
  TENDRIL_CHECK(beyond.bend.cols() == 0 || beyond.bend.cols() == rest_angle.size());
  TrueTentacle shape;
  shape.fold_angle = rest_angle;
  if (beyond.fold.size() > 0) shape.fold_angle += beyond.fold;
  for (Eigen::Index facet = 0; facet < layout.hole_z.size(); ++facet) {
    const std::array<double, 2> joints = JointsOfFacet(layout, facet);
    const Eigen::Matrix3Xd& polygon = layout.facets[static_cast<std::size_t>(facet)];
    const int number = static_cast<int>(facet);
    const auto add = [&](double from, double to, Eigen::Matrix3Xd corners) {
      shape.strips.push_back({number,
                              from,
                              to,
                              std::move(corners),
                              {truth.hole_y[facet], layout.hole_z[facet]},
                              Isometry::Identity()});
    };
    add(layout.base_z, joints[0], Clip(polygon, joints[0], -1));
    add(joints[0], joints[1], Clip(Clip(polygon, joints[0], 1), joints[1], -1));
    add(joints[1], layout.tip_z, Clip(polygon, joints[1], 1));
  }

  const std::vector<Isometry> loose = PosesOfStrips(Hinges(truth, rest_angle, {}), Isometry::Identity());
  const FramedCurve chain = CenterlineOf(truth, loose, rest_angle);
  const Vector3 d3 = (chain.points.col(1) - chain.points.col(0)).normalized();
  const Vector3 d1 = SegmentNormal(loose, layout, 0, rest_angle[0], d3);
  const Isometry first = truth.lab_from_tentacle * TentacleFromChain(chain, d1);
  std::vector<Hinge> hinges = Hinges(truth, shape.fold_angle, beyond.bend);
  AddSag(truth, design.thickness, shape.strips, PosesOfStrips(hinges, first), hinges);
  const std::vector<Isometry> poses = PosesOfStrips(hinges, first);
  for (std::size_t i = 0; i < poses.size(); ++i) shape.strips[i].lab_from_sheet = poses[i];
  shape.centerline = CenterlineOf(truth, poses, shape.fold_angle);
  return shape;
}

Eigen::Matrix<double, 3, 4> TrueTagCorners(const TrueShape& shape, const TagPlace& tag) {
  TENDRIL_CHECK(tag.tentacle >= 0 && static_cast<std::size_t>(tag.tentacle) < shape.tentacles.size());
  const std::vector<TrueStrip>& strips = shape.tentacles[static_cast<std::size_t>(tag.tentacle)].strips;
  const std::size_t first = static_cast<std::size_t>(tag.facet) * kStripsPerFacet;
  TENDRIL_CHECK(first + 2 < strips.size());
  Eigen::Matrix<double, 3, 4> corners;
  for (int i = 0; i < 4; ++i) {
    const Vector3 corner = tag.corners_in_sheet.col(i);
    const std::size_t strip = corner.z() < strips[first].to_z        ? first
                              : corner.z() <= strips[first + 1].to_z ? first + 1
                                                                     : first + 2;
    corners.col(i) = strips[strip].lab_from_sheet * corner;
  }
  return corners;
}

}  // namespace tendril
