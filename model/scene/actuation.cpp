#include "model/scene/actuation.h"

#include <algorithm>

#include "model/fold/facet_chain.h"
#include "model/fold/fold.h"

namespace tendril {
namespace {

constexpr int kTable = 300;  // entries over the pull

std::uint64_t Mixed(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31);
}

}  // namespace

double UniformDraw(std::uint64_t seed, std::uint64_t trial, std::uint64_t tentacle, std::uint64_t which) {
  std::uint64_t hash = 0;
  for (const std::uint64_t word : {seed, trial, tentacle, which}) {
    hash = Mixed(hash + word + 0x9E3779B97F4A7C15U);
  }
  return static_cast<double>(hash >> 11) * 0x1p-53;
}

Result<TentacleActuation> TentacleActuation::Make(const SceneGripper& gripper, bool bends_at_base,
                                                  std::uint64_t seed, std::uint64_t trial, int tentacle) {
  const auto draw = [&](std::uint64_t which) {
    return UniformDraw(seed, trial, static_cast<std::uint64_t>(tentacle), which);
  };
  TentacleActuation actuation;
  actuation.pull_ = gripper.pull;
  actuation.delay_ = gripper.delay_low + (gripper.delay_high - gripper.delay_low) * draw(0);
  actuation.rate_ = gripper.pull_rate + gripper.rate_perturbation * (2 * draw(1) - 1);
  const TentacleDesign design = DesignOfTentacle(gripper.gripper, gripper.design, tentacle);
  const Result<TentacleLayout> layout = LayOut(design);
  if (!layout.ok()) return layout.error();
  for (int i = 0; i <= kTable; ++i) {
    const Result<Fold> fold = SolveFold(design, gripper.pull * i / kTable);
    if (!fold.ok()) return fold.error();
    const FacetChain chain = FoldChain(layout.value(), fold.value().angle);
    const TendonCurve curve = TendonCurveOf(layout.value(), chain, fold.value().angle);
    const RestCurvature rest = RestCurvatureOf(
        layout.value(), curve,
        {.elements = gripper.rod.elements, .map = gripper.curvature_map, .bends_at_base = bends_at_base});
    Eigen::Matrix3Xd& entry = actuation.table_.emplace_back(3, gripper.rod.elements);
    entry.col(0) = rest.base;
    entry.rightCols(gripper.rod.elements - 1) = rest.curvature;
  }
  return actuation;
}

double TentacleActuation::PullAt(double time) const {
  return std::clamp(rate_ * (time - delay_), 0.0, pull_);
}

double TentacleActuation::PullRateAt(double time) const {
  const double pulled = rate_ * (time - delay_);
  return pulled > 0 && pulled < pull_ ? rate_ : 0;
}

TentacleActuation::Place TentacleActuation::PlaceOf(double pull) const {
  const double place = pull_ > 0 ? pull / pull_ * kTable : 0;
  const auto entry = std::min(static_cast<std::size_t>(place), table_.size() - 2);
  return {entry, place - static_cast<double>(entry)};
}

}  // namespace tendril
