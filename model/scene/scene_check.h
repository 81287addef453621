#pragma once
// What a scene asks for that its level or its contact law does not have.

#include <optional>
#include <string>

#include "model/scene/scene.h"

namespace tendril {

// A value of the scene file that does not go with others.
struct SceneConflict {
  std::string table;     // "contact"; empty: the top
  std::string key;       // "law"
  std::string expected;  // what would do, and why
};

// The first one, if there is any. Level static has neither motion nor a medium; the published contact laws
// know neither friction nor objects other than fixed ones with round ends.
std::optional<SceneConflict> ConflictIn(const Scene& scene);

// The largest mu that anything in the scene has; 0: nothing rubs.
double LargestFriction(const Scene& scene);

}  // namespace tendril
