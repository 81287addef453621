#include "calibrate/fold/fold_model.h"

#include <algorithm>

namespace tendril {

std::string NameOf(const FoldModel& model) {
  return std::string(NameOf(model.law)) + (model.rest_angle ? "+rest_angle" : "") +
         (model.friction ? "+friction" : "");
}

std::optional<FoldModel> FoldModelOf(const std::string& name) {
  for (const FoldModel& model : AllFoldModels()) {
    if (NameOf(model) == name) return model;
  }
  return std::nullopt;
}

std::vector<FoldModel> AllFoldModels() {
  std::vector<FoldModel> all;
  for (const auto& [rest, friction] : {std::pair{false, false}, {true, false}, {false, true}, {true, true}}) {
    for (const FoldLaw law : {FoldLaw::kPaper, FoldLaw::kExact}) all.push_back({law, rest, friction});
  }
  return all;
}

std::vector<FoldModel> ComparableFoldModels() {
  std::vector<FoldModel> models = AllFoldModels();
  std::erase(models, FoldModel{FoldLaw::kExact, false, true});
  return models;
}

const std::array<const char*, kFoldParameters>& FoldParameterNames() {
  static constexpr std::array<const char*, kFoldParameters> kNames = {
      "pull_scale", "stiffness_ratio", "stiffness_exponent", "rest_angle_deg", "friction"};
  return kNames;
}

std::vector<int> FreeParametersOf(const FoldModel& model) {
  std::vector<int> free = {0, 1, 2};
  if (model.rest_angle) free.push_back(3);
  if (model.friction) free.push_back(4);
  return free;
}

}  // namespace tendril
