// What a frame of a scene's film costs to draw: eight wound rods of 100 elements about a bar, 1280 x 720 px.
#include "analysis/study/scene_picture.h"

#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>

namespace tendril {
namespace {

ScenePicture Octagon() {
  ScenePicture picture{.title = "octagon", .time = 1};
  for (int rod = 0; rod < 8; ++rod) {
    const double toward = std::numbers::pi * rod / 4;
    Tube tube{.points = Eigen::Matrix3Xd(3, 101),
              .radius = Eigen::VectorXd::LinSpaced(101, 0.020, 0.010),
              .name = "rod" + std::to_string(rod)};
    for (int i = 0; i <= 100; ++i) {
      const double turned = toward + 4 * std::numbers::pi * i / 100;
      tube.points.col(i) << 0.15 * std::cos(toward) + 0.06 * std::cos(turned),
          0.15 * std::sin(toward) + 0.06 * std::sin(turned), -0.003 * i;
    }
    picture.tubes.push_back(tube);
  }
  picture.objects = {{.shape = {{.kind = PrimitiveKind::kCapsule, .radius = 0.0225, .half = {0, 0, 0.14}}}}};
  picture.objects[0].pose =
      Eigen::Translation3d(0, 0, -0.15) * Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitY());
  return picture;
}

void Frame(benchmark::State& state) {
  const ScenePicture picture = Octagon();
  ScenePainter painter(FitView({picture}, 1280, 720));
  for (auto _ : state) benchmark::DoNotOptimize(painter.Draw(picture));
}
// With the backdrop, which is painted again where the eye has moved.
void FrameFromElsewhere(benchmark::State& state) {
  const ScenePicture picture = Octagon();
  SceneView view = FitView({picture}, 1280, 720);
  ScenePainter painter(view);
  for (auto _ : state) {
    view.camera_from_lab.translation().x() += 1e-6;
    painter.LookFrom(view);
    benchmark::DoNotOptimize(painter.Draw(picture));
  }
}
BENCHMARK(FrameFromElsewhere)->Unit(benchmark::kMillisecond);
BENCHMARK(Frame)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tendril
