// How often the intervals of camera calibration have the truth: four cameras in a row, of which camera 3
// shares views with camera 2 only, and a board shown to neighbours.
//
//   camera_calibration [corners|rendered] [seeds]
//
// corners: corners with normal noise of 0.2 px; rendered: drawn pictures, in which the board is found.
#include <fmt/core.h>

#include <cstdlib>
#include <string>

#include "calibrate/cameras/calibrate_cameras.h"
#include "tests/support/calibration_rig.h"
#include "tests/support/render_board.h"

namespace {

using namespace tendril;
using namespace tendril::testing_support;

// The same moments as ChainedViews, seen in drawn pictures.
std::vector<BoardView> RenderedViews(const std::vector<Camera>& cameras, const Board& board, int per_pair,
                                     std::mt19937& random) {
  const Eigen::Matrix3Xd points = BoardPoints(board);
  std::vector<BoardView> views;
  for (size_t pair = 0; pair + 1 < cameras.size(); ++pair) {
    for (int i = 0; i < per_pair; ++i) {
      const Eigen::Isometry3d pose = ShownTo(cameras, pair, points, random);
      for (size_t c = pair; c <= pair + 1; ++c) {
        const Picture picture = RenderBoard(cameras[c], pose, board, 0.7, 4, random, 4);
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

}  // namespace

int main(int argc, char** argv) {
  const bool rendered = argc > 1 && std::string(argv[1]) == "rendered";
  const int seeds = argc > 2 ? std::atoi(argv[2]) : 50;
  const Board board = ParseBoard("chessboard:9x6:0.03").value();
  const Eigen::Matrix3Xd points = BoardPoints(board);
  constexpr int kPerPair = 10;
  for (const Distortion lens : {Distortion::kBrown, Distortion::kEquidistant}) {
    const std::vector<Camera> truth = FourInARow(lens);
    Coverage lenses;
    Coverage poses;
    double rms = 0;
    double held = 0;
    double ratio = 0;
    double seconds = 0;
    int fits = 0;
    for (int seed = 1; seed <= seeds; ++seed) {
      std::mt19937 random(static_cast<unsigned>(seed));
      const auto views = rendered ? RenderedViews(truth, board, kPerPair, random)
                                  : ChainedViews(truth, points, kPerPair, 0.2, random);
      const auto fit = CalibrateCameras(Unknown(truth), views, points, {.folds = rendered ? 5 : 0});
      if (!fit.ok()) {
        fmt::print("seed {}: {}\n", seed, fit.error().message);
        continue;
      }
      ++fits;
      rms += fit.value().rms_px;
      held += fit.value().held_out_rms_px;
      ratio += fit.value().refit_ratio;
      seconds += fit.value().seconds;
      Count(fit.value(), truth, lenses, poses);
    }
    fmt::print(
        "{} {}: {} fits, RMS {:.4f} px, held out {:.4f} px, refit ratio {:.2f}, {:.2f} s a fit\n"
        "  lenses: {} of {} intervals of 95 % have the truth ({:.1f} %), error / standard error RMS {:.3f}\n"
        "  poses:  {} of {} ({:.1f} %), {:.3f}; all {:.1f} %\n",
        rendered ? "rendered" : "corners", lens == Distortion::kBrown ? "brown" : "equidistant", fits,
        rms / fits, held / fits, ratio / fits, seconds / fits, lenses.inside, lenses.asked,
        100 * lenses.share(), lenses.spread(), poses.inside, poses.asked, 100 * poses.share(), poses.spread(),
        100.0 * (lenses.inside + poses.inside) / (lenses.asked + poses.asked));
  }
  return 0;
}
