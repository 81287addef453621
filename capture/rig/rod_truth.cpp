#include "capture/rig/rod_truth.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "model/check.h"
#include "model/fold/facet_chain.h"
#include "model/fold/rest_curvature.h"
#include "model/fold/rising_fold.h"
#include "model/geometry/rotation.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

// Columns d1, d2, d3 of each piece between two nodes.
std::vector<Matrix3d> FramesOf(const FramedCurve& curve) {
  std::vector<Matrix3d> frames;
  for (Index i = 0; i + 1 < curve.points.cols(); ++i) {
    const Vector3d d3 = (curve.points.col(i + 1) - curve.points.col(i)).normalized();
    const Vector3d normal = curve.normals.col(i) + curve.normals.col(i + 1);
    const Vector3d d1 = (normal - normal.dot(d3) * d3).normalized();
    Matrix3d frame;
    frame << d1, d3.cross(d1), d3;
    frames.push_back(frame);
  }
  return frames;
}

// The frame at a share of the length; a piece's frame is that of its middle.
Matrix3d FrameAt(const std::vector<Matrix3d>& frames, double share) {
  const double place = share * static_cast<double>(frames.size()) - 0.5;
  const double last = static_cast<double>(frames.size() - 1);
  const auto before = static_cast<std::size_t>(std::clamp(std::floor(place), 0.0, last - 1));
  const double between = std::clamp(place - static_cast<double>(before), 0.0, 1.0);
  const Vector3d turn = LogSo3(Matrix3d(frames[before].transpose() * frames[before + 1]));
  return frames[before] * ExpSo3(between * turn);
}

// Where each hole lies on the rod, as a share of its length: as the rest curvature was laid on.
Eigen::VectorXd PlacesOfHoles(const TentacleLayout& layout, const TendonCurve& tendon) {
  const Index holes = layout.hole_z.size();
  const double span = layout.hole_z[holes - 1] - layout.hole_z[0];
  const double stretch = span / tendon.segment_length.sum();
  Eigen::VectorXd place(holes);
  place[0] = -layout.base_z;
  for (Index i = 1; i < holes; ++i) place[i] = place[i - 1] + stretch * tendon.segment_length[i - 1];
  return place / (layout.tip_z - layout.base_z);
}

// A drawn stiffness changes single folds; led on from crease to crease the tentacle would wander off its rod.
// Each error is split between its crease and the next one, which folds the other way, so that it tilts
// one facet.
Eigen::VectorXd TiltingOneFacetEach(const Eigen::VectorXd& error) {
  Eigen::VectorXd folds = error;
  for (Index i = 1; i < error.size(); ++i) folds[i] += error[i - 1];
  return folds / std::sqrt(2.0);
}

Status CheckRod(const RodShape& rod, std::size_t number) {
  const Index nodes = rod.curve.points.cols();
  if (nodes < 3 || rod.curve.normals.cols() != nodes) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("virtual rig: rod {} has {} nodes and {} normals; expected 3 or more of both",
                             number, nodes, rod.curve.normals.cols())};
  }
  if (!rod.curve.points.allFinite() || !rod.curve.normals.allFinite()) {
    return Error{
        ErrorKind::kBadInput,
        fmt::format("virtual rig: rod {} has a node that is not finite; expected a finished run", number)};
  }
  return Ok{};
}

}  // namespace

FramedCurve RodAtRest(const TentacleLayout& layout, const Eigen::VectorXd& angle, double pull, int elements,
                      const Eigen::Isometry3d& lab_from_tentacle) {
  const TendonCurve tendon = TendonCurveOf(layout, FoldChain(layout, angle), angle);
  RestCurvatureOptions options;
  options.elements = elements;
  options.bends_at_base = true;
  const RestCurvature rest = RestCurvatureOf(layout, tendon, options);
  const double length = rest.element_length * (1 - pull);
  std::vector<Matrix3d> frames;
  Matrix3d frame = lab_from_tentacle.linear() * ExpSo3(0.5 * rest.element_length * rest.base);
  FramedCurve curve;
  curve.points.resize(3, elements + 1);
  curve.points.col(0) = lab_from_tentacle * Vector3d(0, 0, layout.base_z);
  for (Index i = 0; i < elements; ++i) {
    if (i > 0) frame = frame * ExpSo3(rest.element_length * rest.curvature.col(i - 1));
    frames.push_back(frame);
    curve.points.col(i + 1) = curve.points.col(i) + length * frame.col(2);
  }
  curve.normals.resize(3, elements + 1);
  for (Index i = 0; i <= elements; ++i) {
    const Matrix3d& before = frames[static_cast<std::size_t>(std::max<Index>(i - 1, 0))];
    const Matrix3d& after = frames[static_cast<std::size_t>(std::min<Index>(i, elements - 1))];
    const Vector3d t = (before.col(2) + after.col(2)).normalized();
    const Vector3d n = before.col(0) + after.col(0);
    curve.normals.col(i) = (n - n.dot(t) * t).normalized();
  }
  return curve;
}

BeyondFold TurningBeyondFold(const TentacleLayout& layout, const Eigen::VectorXd& angle,
                             const Eigen::Isometry3d& lab_from_tentacle, const FramedCurve& rest,
                             const FramedCurve& now) {
  TENDRIL_CHECK(rest.points.cols() == now.points.cols() && now.points.cols() >= 3);
  const Index creases = layout.crease_z.size();
  const FacetChain chain = FoldChain(layout, angle);
  const Eigen::VectorXd place = PlacesOfHoles(layout, TendonCurveOf(layout, chain, angle));
  const std::vector<Matrix3d> rest_frames = FramesOf(rest);
  const std::vector<Matrix3d> now_frames = FramesOf(now);
  BeyondFold beyond{Eigen::VectorXd(creases), Matrix3Xd(3, creases)};
  Matrix3d before = Matrix3d::Identity();  // turns what is at rest to how it is now, in the lab
  for (Index i = 0; i < creases; ++i) {
    const Matrix3d after = FrameAt(now_frames, place[i + 1]) * FrameAt(rest_frames, place[i + 1]).transpose();
    const Matrix3d lab_from_facet =
        lab_from_tentacle.linear() * chain.tentacle_from_sheet[static_cast<std::size_t>(i)].linear();
    const Vector3d more =
        LogSo3(Matrix3d(lab_from_facet.transpose() * before.transpose() * after * lab_from_facet));
    const Vector3d crease = DirectionOfCrease(layout.crease_angle[i]);
    const double folds = more.dot(crease);
    beyond.fold[i] = (i % 2 == 0 ? -0.5 : 0.5) * folds;
    beyond.bend.col(i) = LogSo3(Matrix3d(ExpSo3(more) * ExpSo3(-folds * crease)));
    before = after;
  }
  return beyond;
}

Result<TrueShape> TrueShapeOnRods(const VirtualTruth& truth, const Gripper& gripper,
                                  std::span<const RodShape> rods, double time) {
  if (rods.size() != truth.tentacles.size()) {
    return Error{ErrorKind::kBadInput, fmt::format("virtual rig: {} rods for {} tentacles; expected one each",
                                                   rods.size(), truth.tentacles.size())};
  }
  TrueShape shape;
  shape.time = time;
  shape.object = truth.object;
  for (std::size_t i = 0; i < rods.size(); ++i) {
    const RodShape& rod = rods[i];
    if (Status s = CheckRod(rod, i); !s.ok()) return s.error();
    const auto within = [&](const Error& error) {
      return Error(error).Within(fmt::format("virtual rig: tentacle {}", i));
    };
    const TentacleDesign design = DesignOfTentacle(gripper, truth.design, static_cast<int>(i));
    const Result<TentacleLayout> layout = LayOut(design);
    if (!layout.ok()) return within(layout.error());
    const TentacleTruth& drawn = truth.tentacles[i];
    const Result<RisingFold> fold = SolveRisingFold(truth.fold.law, design, layout.value(), rod.pull);
    if (!fold.ok()) return within(fold.error());
    const Result<RisingFold> off = SolveRisingFold(truth.fold.law, design, drawn.layout, rod.pull);
    if (!off.ok()) return within(off.error());
    const Eigen::VectorXd& angle = fold.value().angle;
    const Eigen::Isometry3d pose = LabFromTentacle(gripper, static_cast<int>(i));
    const int elements = static_cast<int>(rod.curve.points.cols()) - 1;
    BeyondFold beyond = TurningBeyondFold(
        layout.value(), angle, pose, RodAtRest(layout.value(), angle, rod.pull, elements, pose), rod.curve);
    beyond.fold += TiltingOneFacetEach(off.value().angle - angle);
    TentacleTruth without_sag = drawn;
    without_sag.sag_compliance = 0;
    TrueTentacle tentacle = ShapeOfStrips(without_sag, design, angle, beyond);
    tentacle.command = rod.command;
    tentacle.pull = rod.pull;
    shape.tentacles.push_back(std::move(tentacle));
  }
  return shape;
}

}  // namespace tendril
