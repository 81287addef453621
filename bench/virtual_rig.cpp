// Cost per picture of the virtual rig: drawing it, writing it as lossless video, reading it back. The
// argument is the number of tentacles; the pictures are those of the default pair's right camera.
#include <benchmark/benchmark.h>

#include <filesystem>

#include "capture/record/video_file.h"
#include "capture/rig/virtual_render.h"
#include "capture/rig/virtual_rig.h"

namespace {

using namespace tendril;

struct Scene {
  TrueShape shape;
  VirtualCamera camera;
};

Scene SceneOf(int tentacles) {
  Gripper gripper;
  gripper.tentacles = tentacles;
  const TentacleDesign design;
  std::mt19937_64 random(1);
  const auto truth = DrawTruth(design, gripper, {}, {}, {}, {}, random);
  const auto rig = VirtualRig(design, gripper);
  const auto tags = LayOutTags(design, gripper);
  return {TrueShapeAt(truth.value(), 8).value(),
          VirtualCamera::Make(rig.value().cameras[1], tags.value(), design.hole_diameter).value()};
}

void SetPixels(benchmark::State& state, const cv::Mat& image) {
  state.counters["Mpx"] = static_cast<double>(image.total()) * 1e-6;
}

void Render(benchmark::State& state) {
  const Scene scene = SceneOf(static_cast<int>(state.range(0)));
  std::mt19937_64 random(1);
  cv::Mat image;
  for (auto _ : state) image = scene.camera.Render(scene.shape, random);
  SetPixels(state, image);
}

void WriteVideo(benchmark::State& state) {
  const Scene scene = SceneOf(static_cast<int>(state.range(0)));
  std::mt19937_64 random(1);
  const cv::Mat image = scene.camera.Render(scene.shape, random);
  const auto file = std::filesystem::temp_directory_path() / "tendril_bench.mkv";
  auto writer = VideoWriter::Open(file, image.cols, image.rows);
  double time = 0;
  for (auto _ : state) {
    if (!writer.value().Write(image, time += 0.1).ok()) state.SkipWithError("not written");
  }
  (void)writer.value().Close();
  SetPixels(state, image);
  state.counters["MB"] =
      1e-6 * static_cast<double>(std::filesystem::file_size(file)) / static_cast<double>(state.iterations());
  std::filesystem::remove(file);
}

void ReadVideo(benchmark::State& state) {
  const Scene scene = SceneOf(static_cast<int>(state.range(0)));
  std::mt19937_64 random(1);
  const cv::Mat image = scene.camera.Render(scene.shape, random);
  const auto file = std::filesystem::temp_directory_path() / "tendril_bench.mkv";
  {
    auto writer = VideoWriter::Open(file, image.cols, image.rows);
    for (int i = 0; i < 40; ++i) (void)writer.value().Write(image, 0.1 * i);
    (void)writer.value().Close();
  }
  auto reader = VideoReader::Open(file);
  for (auto _ : state) {
    auto frame = reader.value().Next();
    if (!frame.ok() || !frame.value()) state.SkipWithError("no frame");
  }
  std::filesystem::remove(file);
}

BENCHMARK(Render)->Arg(2)->Arg(4)->Unit(benchmark::kMillisecond);
BENCHMARK(WriteVideo)->Arg(2)->Arg(4)->Unit(benchmark::kMillisecond);
BENCHMARK(ReadVideo)->Arg(2)->Iterations(40)->Unit(benchmark::kMillisecond);

}  // namespace
