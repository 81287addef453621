// multicamera_report FOLDER: how well the tags of a recorded stream of several real cameras triangulate.
// FOLDER holds cameras.yaml and tag_detections.csv.gz of the tagslam_test data; docs/tracking.md quotes what
// it prints.
#include <fmt/core.h>

#include "tests/support/multicamera.h"

namespace {

void Print(const char* title, const tendril::testing_support::MultiCameraReport& r) {
  fmt::print("{}\n", title);
  fmt::print("  stamps {}, tags triangulated {}, refused {}\n", r.stamps, r.tags, r.refused);
  fmt::print("  reprojection residual        median {:.3f} px, p90 {:.3f} px\n", r.residual_px.At(0.5),
             r.residual_px.At(0.9));
  fmt::print("  side less its stated length  p10 {:+.2f} mm, median {:+.2f} mm, p90 {:+.2f} mm\n",
             1e3 * r.side_error.At(0.1), 1e3 * r.side_error.At(0.5), 1e3 * r.side_error.At(0.9));
  fmt::print(
      "  tag-to-tag distance, std     median {:.2f} mm, p90 {:.2f} mm over {} pairs (median distance {:.2f} "
      "m)\n",
      1e3 * r.distance_std.At(0.5), 1e3 * r.distance_std.At(0.9), r.pairs, r.distance_mean.At(0.5));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: multicamera_report FOLDER\n");
    return 2;
  }
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const auto stream = tendril::testing_support::ReadTagStream(argv[1]);
  fmt::print("{} cameras, {} detections\n", stream.cameras.size(), stream.views.size());
  if (stream.cameras.empty() || stream.views.empty()) return 2;
  constexpr double kBorder = 0.125;
  const auto rig = tendril::FitRigFromTags(stream.cameras, tendril::testing_support::Half(stream.views, 0),
                                           {.border = kBorder});
  if (!rig.ok()) {
    fmt::print(stderr, "{}\n", rig.error().message);
    return 1;
  }
  fmt::print("rig from every second stamp: {} tags, {} views, rms {:.3f} px, {} iterations ({})\n",
             rig.value().tags, rig.value().views, rig.value().rms_px, rig.value().iterations,
             rig.value().stopped_because);
  for (const tendril::Camera& camera : rig.value().cameras) {
    const Eigen::Vector3d at = camera.camera_from_lab.inverse().translation();
    const Eigen::AngleAxisd turn(camera.camera_from_lab.linear());
    fmt::print("  {}: at {:+.4f} {:+.4f} {:+.4f} m, turned by {:.2f} deg\n", camera.name, at.x(), at.y(),
               at.z(), turn.angle() * 180 / M_PI);
  }
  Print("all stamps", tendril::testing_support::Report(rig.value().cameras, stream.views, kBorder));
  Print("the stamps that the rig was not fitted to",
        tendril::testing_support::Report(rig.value().cameras, tendril::testing_support::Half(stream.views, 1),
                                         kBorder));
  return 0;
}
