// bench_distance_bands FOLDER: are the distances of tags that are fixed to each other constant within their
// stated bands, in a recorded stream of several real cameras that no trigger couples? FOLDER as for
// multicamera_report. Cameras, offsets in time and what the bands are made of come from the even stamps; the
// odd ones are only looked at. docs/detection.md quotes what it prints.
#include <fmt/core.h>

#include <cstdio>

#include "tests/support/distance_bands.h"

namespace tendril {
namespace {

using namespace testing_support;

constexpr double kBorder = 0.125;      // m
constexpr double kSlowPx = 2.5;        // per picture
constexpr double kSynchronisedPx = 5;  // likewise, once offsets are known

void Print(const std::string& title, const std::vector<BandedDistance>& all) {
  fmt::print("{}\n", title);
  for (const auto& [from, to] : {std::pair{0.0, kSlowPx},
                                 {0.0, 1.25},
                                 {1.25, 2.5},
                                 {2.5, 5.0},
                                 {5.0, 10.0},
                                 {10.0, 1e9},
                                 {0.0, 1e9}}) {
    const BandShares s = SharesInside(all, from, to);
    if (s.distances == 0) continue;
    fmt::print(
        "  {:5.2f} to {:5.2f} px a picture: {:5} distances of {:3} pairs; stated {:5.2f} mm (median), "
        "scatter {:5.2f} mm; "
        "{:4.1f} % inside 68 %, {:4.1f} % inside 95 %; mean square by its sigma {:.2f}\n",
        from, std::min(to, 99.0), s.distances, s.pairs, 1e3 * s.median_sigma, 1e3 * s.scatter,
        100.0 * s.in68 / s.distances, 100.0 * s.in95 / s.distances, s.z2);
  }
}

// Residuals of two views by something of theirs, root mean square.
void PrintResiduals(const std::string& by, const BandModel& model, double BandModel::Residual::*value,
                    const std::vector<double>& edges) {
  fmt::print("  residuals by {}, even stamps, offsets taken out:", by);
  for (std::size_t e = 0; e + 1 < edges.size(); ++e) {
    double sum2 = 0;
    int count = 0;
    for (const BandModel::Residual& r : model.residuals) {
      if (r.*value < edges[e] || r.*value >= edges[e + 1]) continue;
      sum2 += r.px * r.px;
      ++count;
    }
    fmt::print(" {}-{}: {:.2f} px ({});", edges[e], edges[e + 1], std::sqrt(sum2 / std::max(1, count)),
               count);
  }
  fmt::print("\n");
}

int Main(const char* folder) {
  const auto stream = ReadTagStream(folder);
  if (stream.cameras.empty() || stream.views.empty()) {
    fmt::print(stderr, "{}: no cameras.yaml or no tag_detections.csv.gz\n", folder);
    return 2;
  }
  std::map<std::int64_t, int> rank;
  for (const TagInPicture& view : stream.views) rank.emplace(view.stamp, 0);
  int next = 0;
  for (auto& [stamp, number] : rank) number = next++;
  // Even stamps follow each other at twice the interval: a tag moves twice as far.
  const std::vector<TagInPicture> even = Half(stream.views, 0);
  std::vector<MovingTag> even_moving = MotionOf(even);
  for (MovingTag& m : even_moving) m.px_per_picture /= 2;
  CalibrateFromTagsOptions sheet{.border = kBorder, .cameras = {}};
  sheet.cameras.folds = 0;
  sheet.cameras.refine_lenses = true;
  auto rig = CalibrateFromTags(stream.cameras, UnlinkMoving(even, 2 * kSlowPx), sheet);
  if (!rig.ok()) {
    fmt::print(stderr, "{}\n", rig.error().message);
    return 1;
  }
  const auto seen_even = SeenTags(even_moving, rank, 0);
  const std::vector<MovingTag> moving = MotionOf(stream.views);
  const auto seen_odd = SeenTags(moving, rank, 1);
  BandModel plain{.center_px = rig.value().body.rms_px / std::sqrt(8),
                  .pair_px = {},
                  .offset = {},
                  .elsewhere = {0, 0.015},
                  .residuals = {}};
  Print(
      "odd stamps, pictures taken as of one moment give or take 15 ms, corners and cameras' covariance alone",
      BandedDistances(rig.value().calibration, seen_odd, plain));
  BandModel model = EstimateBands(rig.value().calibration, seen_even, rig.value().body.rms_px / std::sqrt(8));
  rig = CalibrateFromTags(
      stream.cameras,
      UnlinkMoving(OnOneClock(even_moving, rank, model, static_cast<int>(stream.cameras.size())),
                   2 * kSynchronisedPx),
      sheet);
  if (!rig.ok()) {
    fmt::print(stderr, "{}\n", rig.error().message);
    return 1;
  }
  const CameraCalibration& fit = rig.value().calibration;
  const double corner_px = rig.value().body.rms_px / std::sqrt(2);
  fmt::print("cameras from even stamps: {} views, rms {:.3f} px, variance factor {:.2f}; corners {:.3f} px\n",
             fit.views, fit.rms_px, fit.covariance.variance_factor, corner_px);
  model = EstimateBands(fit, seen_even, corner_px / 2);
  for (const auto& [pair, px] : model.pair_px) {
    Spread seconds;
    Spread sigma;
    for (const auto& [key, offset] : model.offset) {
      if (key.first != pair) continue;
      seconds.values.push_back(offset.seconds);
      sigma.values.push_back(offset.sigma);
    }
    fmt::print(
        "  cameras {} and {}: {:.2f} px beyond corners and covariance; {} windows of {} stamps, offset "
        "{:+.1f} to {:+.1f} ms, sigma {:.1f} ms "
        "(median)\n",
        pair.first, pair.second, px, seconds.values.size(), kWindow, 1e3 * seconds.At(0), 1e3 * seconds.At(1),
        1e3 * sigma.At(0.5));
  }
  PrintResiduals("speed, px a picture", model, &BandModel::Residual::speed, {0, 1.25, 2.5, 5, 10, 15, 30});
  PrintResiduals("distance from the picture's centre, px", model, &BandModel::Residual::rim,
                 {300, 400, 420, 440, 460, 480, 500, 600});
  auto even_distances = BandedDistances(fit, seen_even, model);
  model.factor = std::sqrt(SharesInside(even_distances, 0, 1e9).z2);
  for (BandedDistance& d : even_distances) d.sigma *= model.factor;
  fmt::print("  factor on every sigma, from the even stamps' distances: {:.2f}\n", model.factor);
  Print("even stamps, which all of it was estimated on", even_distances);
  Print("odd stamps", BandedDistances(fit, seen_odd, model));
  return 0;
}

}  // namespace
}  // namespace tendril

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  if (argc != 2) {
    fmt::print(stderr, "usage: bench_distance_bands FOLDER\n");
    return 2;
  }
  return tendril::Main(argv[1]);
}
