// How often the intervals of camera calibration have the truth: four cameras in a row, of which camera 3
// shares views with camera 2 only, and a board shown to neighbours.
//
//   camera_calibration [corners|rendered] [seeds] [first]
//
// corners: 640 x 480 px, corners with normal noise of 0.2 px. rendered: drawn pictures of 1280 x 1024 px, in
// which the board is found; blur, noise, light and lenses are drawn per seed (DrawnRig), the lens is brown
// for odd seeds and equidistant for even ones. Seeds 1 to 4 were looked at while this was written;
// docs/cameras.md quotes 101 on.
#include <fmt/core.h>

#include <cstdlib>
#include <string>

#include "calibrate/cameras/calibrate_cameras.h"
#include "tests/support/calibration_rig.h"
#include "tests/support/render_board.h"

namespace {

using namespace tendril;
using namespace tendril::testing_support;

// FourInARow with pictures of 1280 x 1024 px and lenses and poses that differ from seed to seed.
std::vector<Camera> DrawnRig(Distortion lens, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Camera> cameras = FourInARow(lens);
  for (size_t i = 0; i < cameras.size(); ++i) {
    Camera& c = cameras[i];
    c.width_px = 1280;
    c.height_px = 1024;
    c.focal_x_px = 2 * c.focal_x_px * (1 + 0.08 * unit(random));
    c.focal_y_px = c.focal_x_px * (1 + 0.003 * unit(random));
    c.center_x_px = 639.5 + 15 * unit(random);
    c.center_y_px = 511.5 + 15 * unit(random);
    if (lens == Distortion::kBrown) {
      c.coefficients[0] = -0.2 + 0.1 * unit(random);
      c.coefficients[1] = 0.07 + 0.05 * unit(random);
      c.coefficients[2] = 0.001 * unit(random);
      c.coefficients[3] = 0.001 * unit(random);
    } else {
      c.coefficients[0] = 0.02 * unit(random);
      c.coefficients[1] = 0.02 * unit(random);
    }
    if (i == 0) continue;
    Eigen::Isometry3d lab_from_camera = c.camera_from_lab.inverse();
    lab_from_camera.translation() += 0.02 * Eigen::Vector3d(unit(random), unit(random), unit(random));
    c.camera_from_lab = lab_from_camera.inverse();
  }
  return cameras;
}

// The same moments as ChainedViews, seen in drawn pictures: blur 0.5 to 1.2 px, noise 1 to 5 levels.
std::vector<BoardView> RenderedViews(const std::vector<Camera>& cameras, const Board& board, int per_pair,
                                     std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const Eigen::Matrix3Xd points = BoardPoints(board);
  const double blur_px = 0.5 + 0.7 * unit(random);
  const double noise = 1 + 4 * unit(random);
  std::vector<RayTable> rays;
  for (const Camera& camera : cameras) rays.emplace_back(camera);
  std::vector<BoardView> views;
  for (size_t pair = 0; pair + 1 < cameras.size(); ++pair) {
    for (int i = 0; i < per_pair; ++i) {
      const Eigen::Isometry3d pose = ShownTo(cameras, pair, points, random);
      for (size_t c = pair; c <= pair + 1; ++c) {
        const Picture picture = RenderBoard(cameras[c], pose, board, blur_px, noise, random, 8, &rays[c]);
        const auto bytes = picture.Bytes();
        const auto seen = DetectBoard({bytes.data(), picture.width, picture.height, picture.width}, board);
        if (!seen.ok() || seen.value().ids.empty()) continue;
        views.push_back(
            {static_cast<std::int64_t>(pair) * per_pair + i, 0, static_cast<int>(c), seen.value()});
      }
    }
  }
  return views;
}

struct Tally {
  Coverage lenses;
  Coverage poses;
  double rms = 0;
  double seconds = 0;
  int fits = 0;
};

void Add(const Result<CameraCalibration>& fit, const std::vector<Camera>& truth, int seed, Tally& tally) {
  if (!fit.ok()) {
    fmt::print("seed {}: {}\n", seed, fit.error().message);
    return;
  }
  ++tally.fits;
  tally.rms += fit.value().rms_px;
  tally.seconds += fit.value().seconds;
  Count(fit.value(), truth, tally.lenses, tally.poses);
}

void Print(const char* what, const Tally& t) {
  fmt::print(
      "{}: {} fits, RMS {:.4f} px, {:.2f} s a fit\n"
      "  lenses: {} of {} intervals of 95 % have the truth ({:.1f} %), error / standard error RMS {:.3f}\n"
      "  poses:  {} of {} ({:.1f} %), {:.3f}; all {:.1f} %\n",
      what, t.fits, t.rms / t.fits, t.seconds / t.fits, t.lenses.inside, t.lenses.asked,
      100 * t.lenses.share(), t.lenses.spread(), t.poses.inside, t.poses.asked, 100 * t.poses.share(),
      t.poses.spread(), 100.0 * (t.lenses.inside + t.poses.inside) / (t.lenses.asked + t.poses.asked));
}

}  // namespace

int main(int argc, char** argv) {
  const bool rendered = argc > 1 && std::string(argv[1]) == "rendered";
  const int seeds = argc > 2 ? std::atoi(argv[2]) : 50;
  const int first = argc > 3 ? std::atoi(argv[3]) : 1;
  const Board board = ParseBoard("chessboard:9x6:0.03").value();
  const Eigen::Matrix3Xd points = BoardPoints(board);
  constexpr int kPerPair = 10;
  for (const Distortion lens : {Distortion::kBrown, Distortion::kEquidistant}) {
    Tally tally;
    for (int seed = first; seed < first + seeds; ++seed) {
      if (rendered && (seed % 2 == 1) != (lens == Distortion::kBrown)) continue;
      std::mt19937 random(static_cast<unsigned>(seed));
      const std::vector<Camera> truth = rendered ? DrawnRig(lens, random) : FourInARow(lens);
      const auto views = rendered ? RenderedViews(truth, board, kPerPair, random)
                                  : ChainedViews(truth, points, kPerPair, 0.2, random);
      Add(CalibrateCameras(Unknown(truth), views, points, {.folds = 0}), truth, seed, tally);
    }
    Print(fmt::format("{} {}", rendered ? "rendered" : "corners",
                      lens == Distortion::kBrown ? "brown" : "equidistant")
              .c_str(),
          tally);
  }
  return 0;
}
