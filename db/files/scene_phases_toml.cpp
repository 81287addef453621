#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "db/files/scene_tables.h"

namespace tendril {
namespace {

constexpr double kMostPhases = 1e5;

bool HoldsSomething(const Scene& scene) {
  return scene.gripper || std::any_of(scene.rods.begin(), scene.rods.end(), [](const SceneRod& rod) {
           return rod.design.base != EndHold::kFree || rod.design.tip != EndHold::kFree;
         });
}

Phase ReadPhase(TomlTable& table, std::size_t number, const Scene& scene) {
  Phase phase;
  phase.name = fmt::format("phase{}", number);
  ReadName(table, phase.name);
  table.Required().Number("duration", phase.duration, Above(0, "s"));
  double pull = 0;
  if (table.Number("pull", pull, Between(0, 1))) {
    phase.pull = pull;
    if (!scene.gripper) {
      table.Reject("pull", "a [gripper] that pulls");
    } else if (pull >= 1 && scene.gripper->shortening == Shortening::kCarrier) {
      table.Reject("pull", "a number below 1: the carrier grows as 1 / (1 - pull)");
    }
  }
  if (table.Number("pull_rate", phase.pull_rate, Above(0, "1/s")) && !table.Has("pull")) {
    table.Reject("pull_rate", "a pull beside it");
  }
  table.Vector("move", phase.move, Finite("m"));
  table.Degrees("turn_deg", phase.turn);
  if (table.Vector("turn_axis", phase.turn_axis) && !(phase.turn_axis.norm() > 0)) {
    table.Reject("turn_axis", "a direction, not all zeros");
  }
  TomlTable shake = table.Table("shake");
  if (shake.exists()) {
    shake.Required().Vector("amplitude", phase.shake_amplitude, Finite("m"));
    shake.Required().Number("frequency", phase.shake_frequency, Above(0, "Hz"));
  }
  for (const char* key : {"move", "turn_deg", "shake"}) {
    if (table.Has(key) && !HoldsSomething(scene)) table.Reject(key, "a [gripper] or a [[rod]] that is held");
  }
  return phase;
}

}  // namespace

void ReadPhases(TomlDocument& document, Scene& scene) {
  TomlTable& root = document.Root();
  std::int64_t cycles = 1;
  root.Integer("cycles", cycles, AtLeast(1));
  std::vector<Phase> once;
  for (TomlTable& table : document.Tables("phase")) once.push_back(ReadPhase(table, once.size(), scene));
  if (once.empty()) {
    if (root.Has("cycles")) root.Reject("cycles", "[[phase]] tables, which it repeats");
    return;
  }
  if (static_cast<double>(cycles) * static_cast<double>(once.size()) > kMostPhases) {
    root.Reject("cycles", fmt::format("{:.0f} phases in all, or fewer", kMostPhases));
    return;
  }
  double duration = 0;
  for (std::int64_t i = 0; i < cycles; ++i) {
    for (const Phase& phase : once) {
      scene.phases.push_back(phase);
      duration += phase.duration;
    }
  }
  if (root.Has("duration") && std::abs(scene.duration - duration) > 1e-9 * duration) {
    root.Reject("duration", fmt::format("{:.9g} s, the sum of the phases, or no duration", duration));
  }
  scene.duration = duration;
}

}  // namespace tendril
