#include "model/scene/actuation.h"

#include <algorithm>

#include "model/fold/facet_chain.h"
#include "model/fold/fold.h"
#include "model/fold/rising_fold.h"
#include "model/scene/stow.h"

namespace tendril {
namespace {

constexpr int kTable = 300;  // entries over the pull

std::uint64_t Mixed(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31);
}

// As published; or as a calibration found, with its own pull scale.
Result<Eigen::VectorXd> FoldedTo(const TentacleDesign& design, const TentacleLayout& layout, double pull) {
  const double real = design.pull_scale * pull;
  if (design.law) {
    Result<RisingFold> fold = SolveRisingFold(*design.law, design, layout, real);
    if (!fold.ok()) return fold.error();
    return std::move(fold).value().angle;
  }
  Result<Fold> fold = SolveFold(layout, design.base_width, design.closed_angle, real);
  if (!fold.ok()) return fold.error();
  return std::move(fold).value().angle;
}

}  // namespace

double UniformDraw(std::uint64_t seed, std::uint64_t trial, std::uint64_t tentacle, std::uint64_t which) {
  std::uint64_t hash = 0;
  for (const std::uint64_t word : {seed, trial, tentacle, which}) {
    hash = Mixed(hash + word + 0x9E3779B97F4A7C15U);
  }
  return static_cast<double>(hash >> 11) * 0x1p-53;
}

RodDesign TentacleRod(const SceneGripper& gripper) {
  RodDesign rod = gripper.rod;
  rod.length = gripper.design.length;
  rod.taper = gripper.design.taper;
  return rod;
}

Result<TentacleActuation> TentacleActuation::Make(const SceneGripper& gripper, bool bends_at_base,
                                                  std::uint64_t seed, std::uint64_t trial, int tentacle,
                                                  const std::vector<Phase>& phases) {
  const auto draw = [&](std::uint64_t which) {
    return UniformDraw(seed, trial, static_cast<std::uint64_t>(tentacle), which);
  };
  const double delay = gripper.delay_low + (gripper.delay_high - gripper.delay_low) * draw(0);
  const double rate = gripper.pull_rate + gripper.rate_perturbation * (2 * draw(1) - 1);
  const double earliest = gripper.stowed ? gripper.stowed->release_time + gripper.stowed->unroll_time : 0;
  const double strongest = StrongestPull(gripper, phases);
  TentacleActuation actuation(PullSchedule(gripper, phases, delay, rate, earliest), strongest);
  actuation.stow_ = gripper.stowed;
  if (gripper.stowed) {
    // Toward the carrier's outer side, where there is room.
    const bool inside_out = gripper.gripper.handedness == Handedness::kNormals && tentacle % 2 != 0;
    Result<Eigen::Matrix3Xd> roll =
        RolledCurvature(TentacleRod(gripper), *gripper.stowed, inside_out ? -1 : 1);
    if (!roll.ok()) return std::move(roll).error();
    if (!bends_at_base) roll.value().col(0).setZero();
    actuation.table_.push_back(std::move(roll).value());
  }
  const TentacleDesign design = DesignOfTentacle(gripper.gripper, gripper.design, tentacle);
  const Result<TentacleLayout> layout = LayOut(design);
  if (!layout.ok()) return layout.error();
  for (int i = 0; i <= kTable; ++i) {
    const Result<Eigen::VectorXd> angle = FoldedTo(design, layout.value(), strongest * i / kTable);
    if (!angle.ok()) return angle.error();
    const FacetChain chain = FoldChain(layout.value(), angle.value());
    const TendonCurve curve = TendonCurveOf(layout.value(), chain, angle.value());
    const RestCurvature rest = RestCurvatureOf(
        layout.value(), curve,
        {.elements = gripper.rod.elements, .map = gripper.curvature_map, .bends_at_base = bends_at_base});
    Eigen::Matrix3Xd& entry = actuation.table_.emplace_back(3, gripper.rod.elements);
    entry.col(0) = rest.base;
    entry.rightCols(gripper.rod.elements - 1) = rest.curvature;
  }
  actuation.strongest_.setZero(gripper.rod.elements);
  for (const Eigen::Matrix3Xd& entry : actuation.table_) {
    actuation.strongest_ = actuation.strongest_.cwiseMax(entry.colwise().norm().transpose());
  }
  return actuation;
}

TentacleActuation::Place TentacleActuation::PlaceOf(double pull) const {
  const std::size_t first = stow_ ? 1 : 0;  // of pull 0
  const double place = strongest_pull_ > 0 ? pull / strongest_pull_ * kTable : 0;
  const auto entry = std::min(static_cast<std::size_t>(place), table_.size() - first - 2);
  return {entry + first, place - static_cast<double>(entry)};
}

TentacleActuation::Place TentacleActuation::PlaceAt(double time) const {
  const double rolled = stow_ ? RolledShare(*stow_, time) : 0;
  if (rolled > 0) return {0, 1 - rolled};  // nothing is pulled before it is unrolled
  return PlaceOf(PullAt(time));
}

}  // namespace tendril
