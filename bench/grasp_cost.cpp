// What friction and an object that moves cost: a scene as it is, without friction, and without friction about
// a fixed object, in turns. A table of medians, s of one core.
//   bench_grasp_cost [SCENE.toml] [TIMES]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <string>
#include <vector>

#include "db/files/scene_toml.h"
#include "model/scene/simulate.h"

namespace tendril {
namespace {

// This thread's own time: what else the machine does is not the scene's.
double CpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Variant {
  std::string name;
  Scene scene;
  std::vector<double> seconds{};
  std::int64_t steps = 0;
};

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

int Main(const std::string& file, int times) {
  const Result<Scene> read = ReadScene(file);
  if (!read.ok()) {
    fmt::print(stderr, "{}\n", read.error().message);
    return 2;
  }
  Scene smooth = read.value();
  smooth.contact.friction = smooth.contact.static_friction = 0;
  for (SceneObject& object : smooth.objects) object.friction.reset();
  Scene fixed = smooth;
  for (SceneObject& object : fixed.objects) object.motion = ObjectMotion::kFixed;
  fmt::print("{}, {} s: medians of {} runs in turns, s of one core\n", read.value().name, fixed.duration,
             times);
  fmt::print("level      variant                             steps        s   by the first\n");
  for (const SimulationLevel level : {SimulationLevel::kStandard, SimulationLevel::kPaper}) {
    std::vector<Variant> variants = {{"fixed object, no friction", fixed},
                                     {"object moves, no friction", smooth},
                                     {"object moves, friction", read.value()}};
    for (int k = 0; k < times; ++k) {
      for (Variant& variant : variants) {
        variant.scene.level = level;
        const SimulationPlan plan = PlanScene(variant.scene).value();
        const double begin = CpuSeconds();
        const Simulated run = Simulate(variant.scene, plan, {variant.scene.duration}).value();
        variant.seconds.push_back(CpuSeconds() - begin);
        variant.steps = run.steps;
        if (!run.doubts.empty()) fmt::print("{}: {}\n", variant.name, run.doubts[0]);
      }
    }
    for (const Variant& variant : variants) {
      const double seconds = Median(variant.seconds);
      fmt::print("{:<10} {:<32} {:8} {:8.2f} {:9.2f}\n", NameOf(level), variant.name, variant.steps, seconds,
                 seconds / Median(variants[0].seconds));
    }
  }
  return 0;
}

}  // namespace
}  // namespace tendril

int main(int argc, char** argv) {
  return tendril::Main(argc > 1 ? argv[1] : "examples/scenes/grasp/sixteen.toml",
                       argc > 2 ? std::stoi(argv[2]) : 3);
}
