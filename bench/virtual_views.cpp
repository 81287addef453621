// Where should the virtual rig's two cameras stand? Renders grippers at several pulls from pairs of places
// and prints which share of the facets libapriltag decodes in at least one picture. The table of
// docs/virtual_rig.md comes from here:  build/test/bench/virtual_views [tentacles...]
#include <apriltag/apriltag.h>
#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <numbers>
#include <opencv2/core/mat.hpp>
#include <set>
#include <vector>

#include "capture/rig/tag_family.h"
#include "capture/rig/tag_layout.h"
#include "capture/rig/virtual_render.h"
#include "capture/rig/virtual_rig.h"

namespace {

using tendril::Gripper;

constexpr double kDegree = std::numbers::pi / 180;

void Decode(apriltag_detector_t* detector, const cv::Mat& image, std::set<int>& ids) {
  image_u8_t view = {image.cols, image.rows, static_cast<int>(image.step), image.data};
  zarray_t* found = apriltag_detector_detect(detector, &view);
  for (int i = 0; i < zarray_size(found); ++i) {
    apriltag_detection_t* d = nullptr;
    zarray_get(found, i, &d);
    if (d->hamming <= 1) ids.insert(d->id);
  }
  apriltag_detections_destroy(found);
}

int Measure(const tendril::TentacleDesign& design, const Gripper& gripper,
            const tendril::VirtualRigOptions& options, apriltag_detector_t* detector) {
  const auto layout = tendril::LayOutTags(design, gripper);
  const auto rig = tendril::VirtualRig(design, gripper, options);
  std::mt19937_64 random(1);
  tendril::VirtualCylinder object;
  const auto truth = tendril::DrawTruth(design, gripper, {1, 1, 1}, {0.3, 0.03}, object, {}, random);
  if (!layout.ok() || !rig.ok() || !truth.ok()) {
    fmt::print(stderr, "{}\n",
               !layout.ok() ? layout.error().message
               : !rig.ok()  ? rig.error().message
                            : truth.error().message);
    return 1;
  }
  fmt::print("{:>2}  {:>4.0f} {:>4.0f}  {:>4.0f} {:>4.0f}  {:>4} x {:<4}  {:4.1f}", gripper.tentacles,
             options.views[0].azimuth / kDegree, options.views[0].elevation / kDegree,
             options.views[1].azimuth / kDegree, options.views[1].elevation / kDegree,
             rig.value().cameras[0].width_px, rig.value().cameras[0].height_px,
             1e3 * layout.value().tags[0].footprint);
  const double facets = design.holes * gripper.tentacles;
  double worst = 1;
  double sum = 0;
  for (const double pull : {0.0, 0.1, 0.2, 0.3}) {
    const auto shape = tendril::TrueShapeAt(truth.value(), pull == 0 ? 0 : pull / 0.03 + 0.5);
    std::set<std::pair<int, int>> seen;
    double both = 0;
    for (const auto& camera : rig.value().cameras) {
      const auto virtual_camera = tendril::VirtualCamera::Make(camera, layout.value(), design.hole_diameter);
      std::set<int> ids;
      Decode(detector, virtual_camera.value().Render(shape.value(), random), ids);
      for (const int id : ids) {
        const tendril::TagPlace* tag = layout.value().Find(id);
        if (tag == nullptr) continue;
        if (!seen.insert({tag->tentacle, tag->facet}).second) ++both;
      }
    }
    const double share = static_cast<double>(seen.size()) / facets;
    fmt::print("  {:5.1f} ({:2.0f})", 100 * share, 100 * both / facets);
    worst = std::min(worst, share);
    sum += share;
  }
  fmt::print("   worst {:5.1f} mean {:5.1f}\n", 100 * worst, 25 * sum);
  std::fflush(stdout);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  apriltag_family_t* family = tendril::CreateFamily("tag36h11");
  apriltag_detector_t* detector = apriltag_detector_create();
  apriltag_detector_add_family_bits(detector, family, 1);
  detector->quad_decimate = 1;
  detector->qtp.min_white_black_diff = 40;

  fmt::print(
      "tentacles, views (azimuth from tentacle 0, elevation; deg), image px, tag mm, % of facets decoded at "
      "pulls 0, 0.1, 0.2, 0.3 (in both)\n");
  std::vector<int> counts;
  for (int i = 1; i < argc; ++i) counts.push_back(std::atoi(argv[i]));
  if (counts.empty()) counts = {2, 3, 4};
  int failed = 0;
  for (const int count : counts) {
    Gripper gripper;
    gripper.tentacles = count;
    for (const double middle : {0.0, 30.0, 45.0, 60.0}) {
      for (const double apart : {20.0, 28.0}) {
        for (const auto& [low, high] : {std::pair{0.0, 0.0},
                                        {-25.0, 25.0},
                                        {-40.0, 40.0},
                                        {40.0, -40.0},
                                        {-50.0, 50.0},
                                        {-40.0, 20.0}}) {
          tendril::VirtualRigOptions options;
          options.views = {{(middle - apart) * kDegree, low * kDegree},
                           {(middle + apart) * kDegree, high * kDegree}};
          failed |= Measure(tendril::TentacleDesign{}, gripper, options, detector);
        }
      }
    }
  }
  apriltag_detector_destroy(detector);
  tendril::DestroyFamily(family);
  return failed;
}
