// multicamera_report FOLDER: how well the tags of a recorded stream of several real cameras triangulate, and
// how far the cameras' pictures of equal stamp lie apart in time (distances against their bands:
// bench/distance_bands). FOLDER holds cameras.yaml and tag_detections.csv.gz of the tagslam_test data;
// docs/detection.md quotes what it prints.
#include <fmt/core.h>

#include <cstdio>

#include "tests/support/multicamera.h"

namespace tendril {
namespace {

using testing_support::Between;
using testing_support::Half;
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
                  const std::vector<std::pair<const MovingTag*, const MovingTag*>>& both, double later) {
  double sum = 0;
  int count = 0;
  for (const auto& [a, b] : both) {
    const std::vector<Sighting> seen = {
        {a->seen.camera, a->seen.corners_px.col(0)},
        {b->seen.camera, b->seen.corners_px.col(0) + 1e9 * later * b->velocity.col(0)}};
    if (const auto point = Triangulate(cameras, seen)) {
      sum += std::min(3.0, point->rms_px);
      ++count;
    }
  }
  return count > 0 ? sum / count : NAN;
}

void PrintTimeOffsets(const std::vector<Camera>& cameras, const std::vector<MovingTag>& moving) {
  std::map<std::int64_t, int> rank;
  for (const MovingTag& m : moving) rank[m.seen.stamp] = 0;
  int next = 0;
  for (auto& [stamp, number] : rank) number = next++;
  std::map<std::pair<std::int64_t, int>, std::vector<const MovingTag*>> together;
  for (const MovingTag& m : moving) together[{m.seen.stamp, m.seen.tag}].push_back(&m);
  std::map<std::array<int, 3>, std::vector<std::pair<const MovingTag*, const MovingTag*>>> blocks;
  for (const auto& [key, views] : together) {
    for (size_t i = 0; i < views.size(); ++i) {
      for (size_t j = 0; j < views.size(); ++j) {
        if (views[i]->seen.camera >= views[j]->seen.camera) continue;
        blocks[{rank[key.first] / 250, views[i]->seen.camera, views[j]->seen.camera}].emplace_back(views[i],
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

void PrintPoses(const std::vector<Camera>& cameras, const std::vector<Camera>& other) {
  for (size_t c = 1; c < cameras.size(); ++c) {
    const Eigen::Isometry3d lab_from_camera = cameras[c].camera_from_lab.inverse();
    const Eigen::Vector3d at = 1e3 * lab_from_camera.translation();
    const auto off = testing_support::PoseDifference(cameras[c], other[c]);
    fmt::print(
        "  {}: at {:+7.2f} {:+7.2f} {:+7.2f} mm, turned by {:.2f} deg; {:5.2f} mm, {:.3f} deg from the "
        "first\n",
        cameras[c].name, at.x(), at.y(), at.z(),
        Eigen::AngleAxisd(lab_from_camera.linear()).angle() * 180 / M_PI, 1e3 * off.metres, off.degrees);
  }
}

// The tags taken as one sheet that nobody measured.
void PrintSheet(const testing_support::TagStream& stream, const std::vector<Camera>& first) {
  for (const bool refine : {false, true}) {
    for (const int half : {-1, 0, 1}) {
      std::vector<TagInPicture> tags = UnlinkMoving(stream.views, kSlowPx);
      if (half >= 0) {
        std::vector<TagInPicture> some = Half(UnlinkMoving(stream.views, kSlowPx, 0), half);
        for (const TagInPicture& tag : tags) {
          if (tag.stamp < 0) some.push_back(tag);
        }
        tags = std::move(some);
      }
      CalibrateFromTagsOptions sheet{.border = kBorder, .cameras = {}};
      sheet.cameras.folds = 0;
      sheet.cameras.refine_lenses = refine;
      const auto rig = CalibrateFromTags(stream.cameras, tags, sheet);
      if (!rig.ok()) {
        fmt::print("{}\n", rig.error().message);
        continue;
      }
      const auto grid = testing_support::CompareWithGrid(rig.value().body);
      fmt::print(
          "rig from the sheet of tags, lenses {}, {}: {} views, rms {:.3f} px; the tags: {:.3f} px, a grid "
          "of "
          "{:.3f} mm to within {:.3f} mm in its plane, {:.3f} mm off it\n",
          refine ? "refined" : "as given",
          half < 0    ? "all stamps"
          : half == 0 ? "even stamps"
                      : "odd stamps",
          rig.value().calibration.views, rig.value().calibration.rms_px, rig.value().body.rms_px,
          1e3 * grid.pitch, 1e3 * grid.in_plane_rms, 1e3 * grid.off_plane_rms);
      PrintPoses(rig.value().calibration.cameras, first);
      if (refine) {
        for (const Camera& c : rig.value().calibration.cameras) {
          fmt::print("    {}: focal {:.2f} {:.2f}, centre {:.2f} {:.2f} px\n", c.name, c.focal_x_px,
                     c.focal_y_px, c.center_x_px, c.center_y_px);
        }
      }
    }
  }
}

int Main(const char* folder) {
  const auto stream = testing_support::ReadTagStream(folder);
  fmt::print("{} cameras, {} detections\n", stream.cameras.size(), stream.views.size());
  if (stream.cameras.empty() || stream.views.empty()) return 2;
  const std::vector<MovingTag> moving = MotionOf(stream.views);
  const std::vector<TagInPicture> slow = Between(moving, 0, kSlowPx);
  CalibrateFromTagsOptions apart{.border = kBorder, .tags_move = true, .cameras = {}};
  apart.cameras.folds = 0;
  const auto rig = CalibrateFromTags(stream.cameras, Half(slow, 0), apart);
  if (!rig.ok()) {
    fmt::print(stderr, "{}\n", rig.error().message);
    return 1;
  }
  fmt::print(
      "rig from slow tags (< {} px a frame) of every second stamp, each tag for itself: {} views, rms {:.3f} "
      "px\n",
      kSlowPx, rig.value().calibration.views, rig.value().calibration.rms_px);
  const std::vector<Camera>& cameras = rig.value().calibration.cameras;
  PrintPoses(cameras, cameras);
  PrintSheet(stream, cameras);
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
