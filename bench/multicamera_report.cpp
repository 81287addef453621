// multicamera_report FOLDER: how well the tags of a recorded stream of several real cameras triangulate, and
// how far the cameras' pictures of equal stamp lie apart in time. FOLDER holds cameras.yaml and
// tag_detections.csv.gz of the tagslam_test data; docs/detection.md quotes what it prints.
#include <fmt/core.h>

#include <cstdio>

#include "tests/support/multicamera.h"

namespace tendril {
namespace {

using testing_support::Between;
using testing_support::Half;
using testing_support::MovingView;
using testing_support::MultiCameraReport;
using testing_support::Report;

constexpr double kBorder = 0.125;  // m
constexpr double kSlowPx = 2.5;    // per frame

void Print(const std::string& title, const MultiCameraReport& r) {
  fmt::print("{}\n  stamps {}, tags triangulated {}, refused {}\n", title, r.stamps, r.tags, r.refused);
  fmt::print("  reprojection residual        median {:.3f} px, p90 {:.3f} px\n", r.residual_px.At(0.5),
             r.residual_px.At(0.9));
  fmt::print("  side less its stated length  p10 {:+.2f} mm, median {:+.2f} mm, p90 {:+.2f} mm\n",
             1e3 * r.side_error.At(0.1), 1e3 * r.side_error.At(0.5), 1e3 * r.side_error.At(0.9));
  fmt::print(
      "  tag-to-tag distance, std     median {:.2f} mm, p90 {:.2f} mm over {} pairs (median distance {:.2f} "
      "m)\n",
      1e3 * r.distance_std.At(0.5), 1e3 * r.distance_std.At(0.9), r.pairs, r.distance_mean.At(0.5));
}

// Mean residual of what cameras a and b see at once, with b's corners moved along their velocity by `later`
// seconds.
double ResidualAt(const std::vector<Camera>& cameras,
                  const std::vector<std::pair<const MovingView*, const MovingView*>>& both, double later) {
  double sum = 0;
  int count = 0;
  for (const auto& [a, b] : both) {
    const std::vector<Sighting> seen = {
        {a->view.camera, a->view.corners_px.col(0)},
        {b->view.camera, b->view.corners_px.col(0) + later * b->velocity.col(0)}};
    if (const auto point = Triangulate(cameras, seen)) {
      sum += std::min(3.0, point->rms_px);
      ++count;
    }
  }
  return count > 0 ? sum / count : NAN;
}

void PrintTimeOffsets(const std::vector<Camera>& cameras, const std::vector<MovingView>& moving) {
  std::map<std::int64_t, int> rank;
  for (const MovingView& m : moving) rank[m.view.stamp] = 0;
  int next = 0;
  for (auto& [stamp, number] : rank) number = next++;
  std::map<std::pair<std::int64_t, int>, std::vector<const MovingView*>> together;
  for (const MovingView& m : moving) together[{m.view.stamp, m.view.tag}].push_back(&m);
  std::map<std::array<int, 3>, std::vector<std::pair<const MovingView*, const MovingView*>>> blocks;
  for (const auto& [key, views] : together) {
    for (size_t i = 0; i < views.size(); ++i) {
      for (size_t j = 0; j < views.size(); ++j) {
        if (views[i]->view.camera >= views[j]->view.camera) continue;
        blocks[{rank[key.first] / 250, views[i]->view.camera, views[j]->view.camera}].emplace_back(views[i],
                                                                                                   views[j]);
      }
    }
  }
  fmt::print("time by which the second camera's pictures would have to be later, per 250 stamps\n");
  for (const auto& [block, both] : blocks) {
    if (both.size() < 100) continue;
    double best_ms = 0;
    double best = INFINITY;
    for (int ms = -40; ms <= 40; ms += 2) {
      const double residual = ResidualAt(cameras, both, 1e-3 * ms);
      if (residual < best) {
        best = residual;
        best_ms = ms;
      }
    }
    fmt::print("  block {}, cameras {} and {}: {:+3.0f} ms, mean residual {:.2f} -> {:.2f} px over {} tags\n",
               block[0], block[1], block[2], best_ms, ResidualAt(cameras, both, 0), best, both.size());
  }
}

int Main(const char* folder) {
  const auto stream = testing_support::ReadTagStream(folder);
  fmt::print("{} cameras, {} detections\n", stream.cameras.size(), stream.views.size());
  if (stream.cameras.empty() || stream.views.empty()) return 2;
  const std::vector<MovingView> moving = testing_support::Moving(stream.views);
  const std::vector<TagView> slow = Between(moving, 0, kSlowPx);
  const auto rig = FitRigFromTags(stream.cameras, Half(slow, 0), {.border = kBorder});
  if (!rig.ok()) {
    fmt::print(stderr, "{}\n", rig.error().message);
    return 1;
  }
  fmt::print(
      "rig from slow views (< {} px a frame) of every second stamp: {} tags, {} views, rms {:.3f} px, {} "
      "iterations\n",
      kSlowPx, rig.value().tags, rig.value().views, rig.value().rms_px, rig.value().iterations);
  const std::vector<Camera>& cameras = rig.value().cameras;
  for (const Camera& camera : cameras) {
    const Eigen::Vector3d at = camera.camera_from_lab.inverse().translation();
    fmt::print("  {}: at {:+.4f} {:+.4f} {:+.4f} m, turned by {:.2f} deg\n", camera.name, at.x(), at.y(),
               at.z(), Eigen::AngleAxisd(camera.camera_from_lab.linear()).angle() * 180 / M_PI);
  }
  Print("all stamps", Report(cameras, stream.views, kBorder));
  Print("slow views of the stamps that the rig was not fitted to", Report(cameras, Half(slow, 1), kBorder));
  fmt::print("residual by speed of the corners\n");
  for (const auto& [from, to] : {std::pair{0.0, 2.5}, {2.5, 5.0}, {5.0, 10.0}, {10.0, 1e9}}) {
    const MultiCameraReport r = Report(cameras, Between(moving, from, to), kBorder);
    fmt::print("  from {:4.1f} px a frame: median {:.3f} px, p90 {:.3f} px ({} tags)\n", from,
               r.residual_px.At(0.5), r.residual_px.At(0.9), r.tags);
  }
  PrintTimeOffsets(cameras, moving);
  return 0;
}

}  // namespace
}  // namespace tendril

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  if (argc != 2) {
    fmt::print(stderr, "usage: multicamera_report FOLDER\n");
    return 2;
  }
  return tendril::Main(argv[1]);
}
