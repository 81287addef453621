#include "capture/rig/virtual_truth.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "capture/rig/portable_random.h"
#include "model/check.h"
#include "model/fold/fold.h"

namespace tendril {
namespace {

constexpr double kGravity = 9.80665;  // m/s^2
constexpr double kPetDensity = 1390;  // kg/m^3
constexpr int kStripsPerFacet = 3;

using Isometry = Eigen::Isometry3d;
using Vector3 = Eigen::Vector3d;

Status CheckRanges(const TruthRanges& r) {
  const std::pair<const char*, double> all[] = {{"position_sd", r.position_sd},
                                                {"crease_angle_sd", r.crease_angle_sd},
                                                {"stiffness_sd", r.stiffness_sd},
                                                {"facet_bend_sd", r.facet_bend_sd},
                                                {"largest_sag_compliance", r.largest_sag_compliance},
                                                {"base_position_sd", r.base_position_sd},
                                                {"base_angle_sd", r.base_angle_sd},
                                                {"largest_delay", r.largest_delay},
                                                {"rate_perturbation", r.rate_perturbation},
                                                {"object_position_sd", r.object_position_sd},
                                                {"object_angle_sd", r.object_angle_sd}};
  for (const auto& [name, value] : all) {
    if (!(value >= 0) || !std::isfinite(value)) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("virtual rig: {} is {}; expected a finite number from 0", name, value)};
    }
  }
  return Ok{};
}

Vector3 DrawVector(std::mt19937_64& random, double sd) {
  Vector3 v;
  for (int i = 0; i < 3; ++i) v[i] = DrawNormal(random, sd);
  return v;
}

Eigen::Quaterniond RotationOfVector(const Vector3& v) {
  const double angle = v.norm();
  if (angle == 0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, v / angle));
}

Vector3 CreaseDirection(double angle) { return {0, std::sin(angle), std::cos(angle)}; }

// Both ends of a crease, where it meets the ribbon's edges: at negative y, then at positive y.
std::array<Vector3, 2> CreaseEnds(double z, double angle, double width, double width_slope) {
  const double s = std::sin(angle);
  const double c = std::cos(angle);
  const double positive = 0.5 * width / (s - 0.5 * width_slope * c);
  const double negative = -0.5 * width / (s + 0.5 * width_slope * c);
  const Vector3 center(0, 0, z);
  return {center + negative * CreaseDirection(angle), center + positive * CreaseDirection(angle)};
}

// The facets between creases that are not where they were drawn.
void RebuildFacets(const TentacleDesign& design, TentacleLayout& layout) {
  const double slope = design.base_width * (design.taper - 1) / (layout.tip_z - layout.base_z);
  const auto width_at = [&](double z) { return design.base_width + slope * (z - layout.base_z); };
  const Eigen::Index creases = layout.crease_z.size();
  std::vector<std::array<Vector3, 2>> cuts;
  cuts.push_back(CreaseEnds(layout.base_z, std::numbers::pi / 2, width_at(layout.base_z), slope));
  for (Eigen::Index i = 0; i < creases; ++i) {
    layout.width[i] = width_at(layout.crease_z[i]);
    cuts.push_back(CreaseEnds(layout.crease_z[i], layout.crease_angle[i], layout.width[i], slope));
  }
  cuts.push_back(CreaseEnds(layout.tip_z, std::numbers::pi / 2, width_at(layout.tip_z), slope));
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    layout.facets[i].resize(3, 4);
    layout.facets[i] << cuts[i][0], cuts[i][1], cuts[i + 1][1], cuts[i + 1][0];
  }
}

Status PerturbLayout(const TentacleDesign& design, const TruthRanges& ranges, std::mt19937_64& random,
                     TentacleTruth& truth) {
  TentacleLayout& layout = truth.layout;
  const Eigen::Index holes = layout.hole_z.size();
  truth.hole_y.resize(holes);
  for (Eigen::Index i = 0; i < holes; ++i) {
    layout.hole_z[i] += DrawNormal(random, ranges.position_sd);
    truth.hole_y[i] = DrawNormal(random, ranges.position_sd);
  }
  for (Eigen::Index i = 0; i + 1 < holes; ++i) {
    layout.crease_z[i] += DrawNormal(random, ranges.position_sd);
    layout.crease_angle[i] += DrawNormal(random, ranges.crease_angle_sd);
    layout.stiffness[i] *= std::exp(DrawNormal(random, ranges.stiffness_sd));
    layout.half_spacing[i] = 0.5 * (layout.hole_z[i + 1] - layout.hole_z[i]);
    if (!(layout.hole_z[i] < layout.crease_z[i] && layout.crease_z[i] < layout.hole_z[i + 1])) {
      return Error{
          ErrorKind::kBadInput,
          fmt::format("virtual rig: position_sd {} m moves crease {} past a hole beside it; expected "
                      "well below half the hole spacing",
                      ranges.position_sd, i)};
    }
  }
  truth.facet_bend.resize(holes);
  for (Eigen::Index i = 0; i < holes; ++i) truth.facet_bend[i] = DrawNormal(random, ranges.facet_bend_sd);
  RebuildFacets(design, layout);
  return Ok{};
}

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
  int crease = -1;  // -1: a bend within a facet
};

Isometry TurnAbout(const Hinge& hinge) {
  return Isometry(Eigen::Translation3d(hinge.at) * Eigen::AngleAxisd(hinge.turn, hinge.direction) *
                  Eigen::Translation3d(-hinge.at));
}

// Hinges between the strips, in order. The law's angle is that between the facets' middle strips, so a
// facet's bend is taken off again at the creases beside it: bent facets do not make the whole tentacle
// wander.
std::vector<Hinge> Hinges(const TentacleTruth& truth, const Eigen::VectorXd& angle) {
  std::vector<Hinge> hinges;
  for (Eigen::Index facet = 0; facet < truth.facet_bend.size(); ++facet) {
    const double bend = truth.facet_bend[facet];
    for (const double z : JointsOfFacet(truth.layout, facet)) {
      hinges.push_back({{0, 0, z}, Vector3::UnitY(), 0.5 * bend, -1});
    }
    if (facet >= angle.size()) continue;
    const double mountain = facet % 2 == 0 ? -1 : 1;  // a mountain turns the next facet toward -x
    hinges.push_back({{0, 0, truth.layout.crease_z[facet]},
                      CreaseDirection(truth.layout.crease_angle[facet]),
                      2 * mountain * angle[facet] - 0.5 * (bend + truth.facet_bend[facet + 1]),
                      static_cast<int>(facet)});
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
  const Vector3 axis = poses[before].linear() * CreaseDirection(layout.crease_angle[i]);
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

TrueTentacle ShapeOf(const TentacleTruth& truth, const TentacleDesign& design, const Eigen::VectorXd& angle) {
  const TentacleLayout& layout = truth.layout;
  TrueTentacle shape;
  shape.fold_angle = angle;
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

  std::vector<Hinge> hinges = Hinges(truth, angle);
  const std::vector<Isometry> loose = PosesOfStrips(hinges, Isometry::Identity());
  const FramedCurve chain = CenterlineOf(truth, loose, angle);
  const Vector3 d3 = (chain.points.col(1) - chain.points.col(0)).normalized();
  const Vector3 d1 = SegmentNormal(loose, layout, 0, angle[0], d3);
  const Isometry first = truth.lab_from_tentacle * TentacleFromChain(chain, d1);
  AddSag(truth, design.thickness, shape.strips, PosesOfStrips(hinges, first), hinges);
  const std::vector<Isometry> poses = PosesOfStrips(hinges, first);
  for (std::size_t i = 0; i < poses.size(); ++i) shape.strips[i].lab_from_sheet = poses[i];
  shape.centerline = CenterlineOf(truth, poses, angle);
  return shape;
}

}  // namespace

Result<VirtualTruth> DrawTruth(const TentacleDesign& design, const Gripper& gripper, const TrueFold& fold,
                               const PullCommand& command, const VirtualCylinder& object,
                               const TruthRanges& ranges, std::mt19937_64& random) {
  if (Status s = CheckRanges(ranges); !s.ok()) return s.error();
  VirtualTruth truth;
  truth.design = design;
  truth.design.stiffness_ratio = fold.stiffness_ratio;
  truth.design.stiffness_exponent = fold.stiffness_exponent;
  truth.fold = fold;
  truth.command = command;
  for (int i = 0; i < gripper.tentacles; ++i) {
    const TentacleDesign own = DesignOfTentacle(gripper, truth.design, i);
    Result<TentacleLayout> layout = LayOut(own);
    if (!layout.ok()) return layout.error();
    TentacleTruth tentacle;
    tentacle.layout = std::move(layout).value();
    Isometry offset = Isometry::Identity();
    offset.translation() = DrawVector(random, ranges.base_position_sd);
    offset.linear() = RotationOfVector(DrawVector(random, ranges.base_angle_sd)).toRotationMatrix();
    tentacle.lab_from_tentacle = LabFromTentacle(gripper, i) * offset;
    tentacle.delay = DrawUniform(random, 0, ranges.largest_delay);
    tentacle.rate_offset = DrawUniform(random, -ranges.rate_perturbation, ranges.rate_perturbation);
    tentacle.sag_compliance = DrawUniform(random, 0, ranges.largest_sag_compliance);
    if (Status s = PerturbLayout(own, ranges, random, tentacle); !s.ok()) return s.error();
    truth.tentacles.push_back(std::move(tentacle));
  }
  truth.object = object;
  truth.object.center += DrawVector(random, ranges.object_position_sd);
  truth.object.axis = RotationOfVector(DrawVector(random, ranges.object_angle_sd)) * object.axis.normalized();
  return truth;
}

double CommandAt(const VirtualTruth& truth, int tentacle, double time) {
  const TentacleTruth& one = truth.tentacles.at(static_cast<std::size_t>(tentacle));
  const double rate = std::max(0.0, truth.command.rate + one.rate_offset);
  return std::clamp(rate * (time - one.delay), 0.0, truth.command.pull);
}

Result<TrueShape> TrueShapeAt(const VirtualTruth& truth, double time) {
  TrueShape shape;
  shape.time = time;
  shape.object = truth.object;
  for (std::size_t i = 0; i < truth.tentacles.size(); ++i) {
    const TentacleTruth& one = truth.tentacles[i];
    const double command = CommandAt(truth, static_cast<int>(i), time);
    const double pull = truth.fold.pull_scale * command;
    const Result<Fold> fold = SolveFold(one.layout, truth.design.base_width, truth.design.closed_angle, pull);
    if (!fold.ok()) return Error(fold.error()).Within(fmt::format("virtual rig: tentacle {}", i));
    TrueTentacle tentacle = ShapeOf(one, truth.design, fold.value().angle);
    tentacle.command = command;
    tentacle.pull = pull;
    shape.tentacles.push_back(std::move(tentacle));
  }
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
