#include "capture/rig/virtual_truth.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "capture/rig/portable_random.h"
#include "capture/rig/strip_chain.h"
#include "model/check.h"

namespace tendril {
namespace {

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
                                                {"tag_place_sd", r.tag_place_sd},
                                                {"tag_turn_sd", r.tag_turn_sd},
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

// Both ends of a crease, where it meets the ribbon's edges: at negative y, then at positive y.
std::array<Vector3, 2> CreaseEnds(double z, double angle, double width, double width_slope) {
  const double s = std::sin(angle);
  const double c = std::cos(angle);
  const double positive = 0.5 * width / (s - 0.5 * width_slope * c);
  const double negative = -0.5 * width / (s + 0.5 * width_slope * c);
  const Vector3 center(0, 0, z);
  return {center + negative * DirectionOfCrease(angle), center + positive * DirectionOfCrease(angle)};
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

}  // namespace

Result<VirtualTruth> DrawTruth(const TentacleDesign& design, const Gripper& gripper, const TrueFold& fold,
                               const PullCommand& command, const VirtualCylinder& object,
                               const TruthRanges& ranges, std::mt19937_64& random) {
  if (Status s = CheckRanges(ranges); !s.ok()) return s.error();
  VirtualTruth truth;
  truth.design = design;
  truth.design.stiffness_ratio = fold.stiffness_ratio;
  truth.design.stiffness_exponent = fold.stiffness_exponent;
  truth.design.rest_angle = fold.rest_angle;
  truth.design.tendon_friction = fold.friction;
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

TagLayout GlueTags(const TagLayout& drawn, const TruthRanges& ranges, std::mt19937_64& random) {
  TagLayout glued = drawn;
  for (TagPlace& tag : glued.tags) {
    const double y = DrawNormal(random, ranges.tag_place_sd);
    const double z = DrawNormal(random, ranges.tag_place_sd);
    const Eigen::AngleAxisd turn(DrawNormal(random, ranges.tag_turn_sd), Vector3::UnitX());
    const Vector3 middle = tag.corners_in_sheet.rowwise().mean();
    const Eigen::Matrix<double, 3, 4> arms = tag.corners_in_sheet.colwise() - middle;
    tag.corners_in_sheet = (turn.toRotationMatrix() * arms).colwise() + (middle + Vector3(0, y, z));
  }
  return glued;
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
    const Result<RisingFold> fold = SolveRisingFold(truth.fold.law, truth.design, one.layout, pull);
    if (!fold.ok()) return Error(fold.error()).Within(fmt::format("virtual rig: tentacle {}", i));
    TrueTentacle tentacle = ShapeOfStrips(one, truth.design, fold.value().angle);
    tentacle.command = command;
    tentacle.pull = pull;
    shape.tentacles.push_back(std::move(tentacle));
  }
  return shape;
}

}  // namespace tendril
