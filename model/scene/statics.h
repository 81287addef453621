#pragma once
// A scene as a sequence of equilibria, without contact and inertia: what slow drives do to rods that do not
// touch (level `static`).

#include <cstdint>
#include <vector>

#include "model/result.h"
#include "model/scene/driven.h"
#include "model/scene/scene.h"

namespace tendril {

class StaticSolver {
 public:
  // Refers to the scene.
  //   errors  kBadInput  a rod whose base is not held or whose tip is (names it)
  static Result<StaticSolver> Make(const Scene& scene, std::vector<Driven> rods);

  // The rods at rest under the drives of that time, followed from the equilibrium of the time asked for
  // before, in parts where the rest shape has changed much.
  //   errors  kUnreachable  no equilibrium (names the rod and the time)
  Result<std::vector<Rod>> At(double time);

  std::int64_t solved() const { return solved_; }

 private:
  StaticSolver(const Scene& scene, std::vector<Driven> rods) : scene_(scene), rods_(std::move(rods)) {}
  Status Settle(Driven& driven, double time);

  const Scene& scene_;
  std::vector<Driven> rods_;
  std::int64_t solved_ = 0;
  bool started_ = false;
};

}  // namespace tendril
