// What each level costs and how far it is off, without contact, which makes any error grow: a scene of rods
// against the same with four times the elements and a quarter of the step. A table.
//   bench_rod_levels SCENE.toml
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "db/files/scene_toml.h"
#include "model/scene/simulate.h"

namespace tendril {
namespace {

using Eigen::Index;

void Refine(Scene& scene, int times) {
  if (scene.gripper) scene.gripper->rod.elements *= times;
  for (SceneRod& rod : scene.rods) rod.design.elements *= times;
}

// The farthest that a node is from where the fine run has it, as a share of the rod's length, by frame.
std::vector<double> Errors(const Simulated& run, const Simulated& fine) {
  std::vector<double> errors(run.curves[0].curves.size(), 0.0);
  for (std::size_t r = 0; r < run.curves.size(); ++r) {
    for (std::size_t f = 0; f < errors.size(); ++f) {
      const auto& points = run.curves[r].curves[f].points;
      const auto& exact = fine.curves[r].curves[f].points;
      const Index times = (exact.cols() - 1) / (points.cols() - 1);
      double length = 0;
      for (Index i = 0; i + 1 < exact.cols(); ++i) length += (exact.col(i + 1) - exact.col(i)).norm();
      for (Index i = 0; i < points.cols(); ++i) {
        errors[f] = std::max(errors[f], (points.col(i) - exact.col(times * i)).norm() / length);
      }
    }
  }
  return errors;
}

int Main(const std::string& file) {
  const Result<Scene> read = ReadScene(file);
  if (!read.ok()) {
    fmt::print(stderr, "{}\n", read.error().message);
    return 2;
  }
  Scene scene = read.value();
  scene.contact.stiffness = 0;
  std::vector<double> times;
  for (int i = 1; i <= 20; ++i) times.push_back(scene.duration * i / 20);

  Scene fine_scene = scene;
  fine_scene.level = SimulationLevel::kStandard;
  Refine(fine_scene, 4);
  const Simulated fine = Simulate(fine_scene, PlanScene(fine_scene, true).value(), times).value();
  fmt::print("{}, without contact; errors in % of the length\n", scene.name);
  fmt::print("level      elements    steps   wall s   largest   at the end\n");
  const struct {
    SimulationLevel level;
    int times;
  } runs[] = {{SimulationLevel::kPaper, 1},
              {SimulationLevel::kStandard, 1},
              {SimulationLevel::kStandard, 2},
              {SimulationLevel::kFast, 1},
              {SimulationLevel::kStatic, 1}};
  for (const auto& [level, refined] : runs) {
    Scene one = scene;
    one.level = level;
    Refine(one, refined);
    const SimulationPlan plan = PlanScene(one).value();
    const auto begin = std::chrono::steady_clock::now();
    const Result<Simulated> run = Simulate(one, plan, times);
    const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (!run.ok() || run.value().diverged) {
      fmt::print("{:<10} {}\n", NameOf(level),
                 run.ok() ? "diverged " + run.value().diverged->Sentence() : run.error().message);
      continue;
    }
    const std::vector<double> errors = Errors(run.value(), fine);
    fmt::print("{:<10} {:8} {:8} {:8.3f} {:9.3f} {:12.3f}\n", NameOf(level),
               run.value().curves[0].curves[0].points.cols() - 1, run.value().steps, wall,
               100 * *std::max_element(errors.begin(), errors.end()), 100 * errors.back());
  }
  return 0;
}

}  // namespace
}  // namespace tendril

int main(int argc, char** argv) { return tendril::Main(argc > 1 ? argv[1] : "examples/scenes/paper.toml"); }
