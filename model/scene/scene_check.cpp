#include "model/scene/scene_check.h"

#include <algorithm>

namespace tendril {

double LargestFriction(const Scene& scene) {
  double friction = std::max(scene.contact.friction, scene.contact.static_friction);
  for (const SceneObject& object : scene.objects) friction = std::max(friction, object.friction.value_or(0));
  return friction;
}

std::optional<SceneConflict> ConflictIn(const Scene& scene) {
  bool moves = false;
  bool not_round = false;
  for (const SceneObject& object : scene.objects) {
    moves = moves || object.motion != ObjectMotion::kFixed;
    not_round = not_round || object.kind == "box" || object.kind == "union" || object.kind == "table";
  }
  const char* const levels = "paper, standard or fast, where ";
  if (scene.level == SimulationLevel::kStatic) {
    if (moves) return SceneConflict{"", "level", std::string(levels) + "an object moves"};
    if (scene.medium.density > 0)
      return SceneConflict{"", "level", std::string(levels) + "there is a medium"};
  }
  const char* const laws = "hertz_segments, where ";
  if (scene.contact.law != ContactLaw::kHertzSegments) {
    if (LargestFriction(scene) > 0)
      return SceneConflict{"contact", "law", std::string(laws) + "there is friction"};
    if (moves) return SceneConflict{"contact", "law", std::string(laws) + "an object moves"};
    if (not_round) {
      return SceneConflict{"contact", "law", std::string(laws) + "an object is a box, a union or a table"};
    }
  }
  return std::nullopt;
}

}  // namespace tendril
