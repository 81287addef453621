#pragma once
// A model of the fold fit: a law plus the parameters that the fit may move (docs/calibration.md, "Models").

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "model/fold/rising_fold.h"

namespace tendril {

// pull_scale, stiffness_ratio and stiffness_exponent are always free; what is not free stays at the design's
// value under law `exact` and at 0 under law `paper`, which as published knows neither.
struct FoldModel {
  FoldLaw law = FoldLaw::kPaper;
  bool rest_angle = false;
  bool friction = false;

  bool operator==(const FoldModel&) const = default;
  int parameters() const { return 3 + (rest_angle ? 1 : 0) + (friction ? 1 : 0); }
};

std::string NameOf(const FoldModel& model);                     // "exact+rest_angle+friction"
std::optional<FoldModel> FoldModelOf(const std::string& name);  // what NameOf gives

// Both laws, each with and without a rest angle, with and without friction; fewest parameters first.
std::vector<FoldModel> AllFoldModels();

inline constexpr int kFoldParameters = 5;

// Those worth comparing: all but law exact with friction and no rest angle, whose creases jump from flat to
// folded (docs/calibration.md).
std::vector<FoldModel> ComparableFoldModels();

// In the order of the fit: pull_scale, stiffness_ratio, stiffness_exponent, rest_angle_deg, friction.
const std::array<const char*, kFoldParameters>& FoldParameterNames();

// Indices into those names, of what is free.
std::vector<int> FreeParametersOf(const FoldModel& model);

}  // namespace tendril
