// How far reconstructed holes are off, and whether sigma says so: synthetic tentacles near their design, seen
// by one, two and four cameras, with all or 30 % of the visible tags and with or without gross outliers.
// Prints the table of docs/tracking.md. Argument: draws per pull (default 25).
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

#include "tests/support/synthetic_view.h"

namespace tendril {
namespace {

using testing_support::CamerasAround;
using testing_support::MakeTruth;
using testing_support::Truth;
using testing_support::Visibility;

struct Sum {
  double squares = 0;
  double normalised = 0;
  double worst = 0;
  int nodes = 0;

  void Add(double error, double sigma) {
    squares += error * error;
    normalised += error * error / (sigma * sigma);
    worst = std::max(worst, error);
    ++nodes;
  }
  double rms_mm() const { return nodes > 0 ? 1e3 * std::sqrt(squares / nodes) : 0; }
  double chi() const { return nodes > 0 ? normalised / nodes : 0; }
};

void Row(const char* name, const TentacleDesign& design, int cameras, const Visibility& picture, int draws) {
  const std::vector<Camera> rig = CamerasAround(cameras);
  Sum seen;
  Sum bridged;
  int not_seen = 0;
  int bad = 0;
  int bad_used = 0;
  int good = 0;
  int good_left_out = 0;
  for (const double pull : {0.0, 0.1, 0.2, 0.3}) {
    for (int draw = 0; draw < draws; ++draw) {
      std::mt19937_64 random(5000 + draw);
      const Truth truth = MakeTruth(design, pull, rig, picture, {}, random);
      const ChainSolution solution = SolveChain(truth.model, rig, truth.views);
      for (int i = 0; i < truth.holes.cols(); ++i) {
        const double error = (solution.curve.points.col(i) - truth.holes.col(i)).norm();
        if (std::isnan(solution.sigma[i])) {
          ++not_seen;
        } else {
          (solution.interpolated[i] != 0 ? bridged : seen).Add(error, solution.sigma[i]);
        }
      }
      for (std::size_t v = 0; v < truth.views.size(); ++v) {
        (truth.outlier[v] != 0 ? bad : good) += 1;
        if (truth.outlier[v] != 0) bad_used += solution.used[v];
        if (truth.outlier[v] == 0) good_left_out += 1 - solution.used[v];
      }
    }
  }
  fmt::print(
      "| {:6} | {} | {:3.0f} % | {:1.0f} % | {:5.2f} | {:5.2f} | {:4.2f} | {:5.2f} | {:4.2f} | {:4.1f} % | "
      "{}/{} | {}/{} |\n",
      name, cameras, 100 * picture.kept, 100 * picture.outliers, seen.rms_mm(), 1e3 * seen.worst, seen.chi(),
      bridged.rms_mm(), bridged.chi(), 100.0 * not_seen / (4.0 * draws * 49), bad_used, bad, good_left_out,
      good);
}

}  // namespace
}  // namespace tendril

int main(int argc, char** argv) {
  const int draws = argc > 1 ? std::max(1, std::atoi(argv[1])) : 25;
  fmt::print(
      "| design | cameras | tags | outliers | seen: rms, mm | worst, mm | chi2 | bridged: rms, mm | chi2 | "
      "not "
      "seen | outliers used | good left out |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const bool planar : {false, true}) {
    const tendril::TentacleDesign design =
        planar ? tendril::testing_support::PlanarDesign() : tendril::TentacleDesign{};
    for (const int cameras : {1, 2, 4}) {
      for (const double kept : {1.0, 0.3}) {
        for (const double outliers : {0.0, 0.05}) {
          tendril::Row(planar ? "planar" : "coil", design, cameras, {.kept = kept, .outliers = outliers},
                       draws);
        }
      }
    }
  }
}
