// Eight tentacles in a tangle, every second facet tagged, four cameras of 1280 x 1024 px: how far off are the
// holes that tracking finds, how much of a tentacle is seen, and does the link computed from the video lie
// within its band? Shapes are the rod simulator's; every frame is rendered, searched for tags and solved.
// Prints the tables of docs/tracking.md ("Entangled") and docs/link.md.
//   bench_entangled [FIRST LAST [PICTURE.png]]     seeds; 101 to 112 unless given. 1 to 20 were for tuning
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "analysis/link/link_bands.h"
#include "capture/track/overlay.h"
#include "tests/support/entangled.h"

namespace tendril {
namespace {

using testing_support::EntangledFrame;
using testing_support::EntangledOptions;
using testing_support::EntangledTrial;

struct Errors {
  double squares = 0, normalised = 0, worst = 0;
  int nodes = 0, in68 = 0, in95 = 0;

  void Add(const Eigen::Vector3d& error, double sigma, const Eigen::Matrix3d& covariance) {
    squares += error.squaredNorm();
    normalised += error.squaredNorm() / (sigma * sigma);
    worst = std::max(worst, error.norm());
    const double distance = error.dot(Eigen::Vector3d(covariance.ldlt().solve(error)));
    in68 += distance < 3.506 ? 1 : 0;  // of chi-square with three degrees of freedom
    in95 += distance < 7.815 ? 1 : 0;
    ++nodes;
  }
  void Add(const Errors& o) {
    squares += o.squares;
    normalised += o.normalised;
    worst = std::max(worst, o.worst);
    nodes += o.nodes;
    in68 += o.in68;
    in95 += o.in95;
  }
  std::string Row() const {
    const double n = std::max(1, nodes);
    return fmt::format("{:5.2f} | {:5.1f} | {:4.2f} | {:2.0f} / {:2.0f}", 1e3 * std::sqrt(squares / n),
                       1e3 * worst, normalised / n, 100 * in68 / n, 100 * in95 / n);
  }
};

struct Covered {
  int in68 = 0, in95 = 0, of = 0, torn = 0;
  double width = 0, error = 0;

  void Add(const LinkBand& band, double truth) {
    if (std::isnan(band.mean) || std::isnan(truth)) return;
    ++of;
    in68 += truth >= band.low68 && truth <= band.high68 ? 1 : 0;
    in95 += truth >= band.low95 && truth <= band.high95 ? 1 : 0;
    torn += band.modes.size() > 1 ? 1 : 0;
    width += band.high95 - band.low95;
    error += std::abs(band.mean - truth);
  }
};

struct Totals {
  Errors seen, bridged;
  int not_seen = 0, nodes = 0, views = 0, rejected = 0, tags_seen = 0, undecided = 0, frames = 0;
  std::map<std::string, Covered> links;
  std::vector<double> worst_trial;  // share of a trial's pair links in their band
  double swing_squares = 0, fold_squares = 0, swing_worst = 0;
  int swings = 0;
  std::array<double, 4> seconds{};  // simulating, rendering, finding, solving
};

// How the truth turns beyond the fold, which no tag knows.
void AddSwings(const EntangledTrial& trial, const TrueShape& shape, Totals& totals) {
  for (std::size_t t = 0; t < shape.tentacles.size(); ++t) {
    const TentacleDesign design = DesignOfTentacle(trial.gripper, trial.design, static_cast<int>(t));
    const TentacleLayout layout = LayOut(design).value();
    const Eigen::VectorXd law = SolveFold(design, shape.tentacles[t].command).value().angle;
    const auto& strips = shape.tentacles[t].strips;
    for (Eigen::Index i = 0; i < law.size(); ++i) {
      const auto at = static_cast<std::size_t>(3 * i + 1);
      const Eigen::Vector3d crease = DirectionOfCrease(layout.crease_angle[i]);
      const Eigen::Matrix3d turned =
          strips[at].lab_from_sheet.linear().transpose() * strips[at + 3].lab_from_sheet.linear();
      const double folded = (i % 2 == 0 ? -2 : 2) * shape.tentacles[t].fold_angle[i];
      const double swing = LogSo3(Eigen::Matrix3d(turned * ExpSo3(-folded * crease))).norm();
      totals.swing_squares += swing * swing;
      totals.swing_worst = std::max(totals.swing_worst, swing);
      totals.fold_squares += std::pow(shape.tentacles[t].fold_angle[i] - law[i], 2);
      ++totals.swings;
    }
  }
}

void AddNodes(const TrueShape& shape, const EntangledFrame& frame, Totals& totals) {
  for (std::size_t t = 0; t < frame.solutions.size(); ++t) {
    const ChainSolution& solution = frame.solutions[t];
    const Eigen::Matrix3Xd& holes = shape.tentacles[t].centerline.points;
    totals.views += static_cast<int>(frame.views[t].size());
    totals.rejected += solution.views_rejected;
    for (Eigen::Index i = 0; i < holes.cols(); ++i) {
      ++totals.nodes;
      const Eigen::Vector3d error = solution.curve.points.col(i) - holes.col(i);
      const Eigen::MatrixXd factor = solution.covariance_factor.middleRows(3 * i, 3);
      const Eigen::Matrix3d covariance = factor * factor.transpose();
      if (std::isnan(solution.sigma[i])) {
        ++totals.not_seen;
      } else {
        (solution.interpolated[i] != 0 ? totals.bridged : totals.seen)
            .Add(error, solution.sigma[i], covariance);
      }
    }
  }
}

// Returns the true mutual link.
double AddLinks(const TrueShape& shape, const EntangledFrame& frame, Totals& totals, Covered& pairs) {
  std::vector<FramedCurve> truth;
  std::vector<FramedCurve> found;
  std::vector<Eigen::MatrixXd> factors;
  for (std::size_t t = 0; t < frame.solutions.size(); ++t) {
    truth.push_back(shape.tentacles[t].centerline);
    found.push_back(frame.solutions[t].curve);
    factors.push_back(frame.solutions[t].covariance_factor);
  }
  const LinkReport report = MeasureLink(truth, {}).value();
  const LinkBands bands = MeasureLinkBands(found, factors, {}).value();
  totals.links["mutual link"].Add(bands.mutual_link, report.mutual_link);
  for (std::size_t i = 0; i < bands.pairs.size(); ++i) {
    totals.links["link of a pair"].Add(bands.pairs[i].link, report.pairs[i].link.value);
    totals.links["gauss of a pair"].Add(bands.pairs[i].gauss, report.pairs[i].gauss.value);
    pairs.Add(bands.pairs[i].link, report.pairs[i].link.value);
  }
  for (std::size_t i = 0; i < bands.curves.size(); ++i) {
    totals.links["writhe"].Add(bands.curves[i].writhe, report.curves[i].writhe.value);
    totals.links["self-link"].Add(bands.curves[i].self_link, report.curves[i].self_link.value);
  }
  totals.undecided += static_cast<int>(bands.undecided.size());
  return report.mutual_link;
}

void Draw(const std::string& file, const EntangledTrial& trial, const EntangledFrame& frame) {
  std::vector<CurveSeries> curves;
  for (const ChainSolution& solution : frame.solutions) {
    CurveSeries series;
    series.time = Eigen::VectorXd::Zero(1);
    series.curves = {solution.curve};
    series.sigma = {solution.sigma};
    series.interpolated = {solution.interpolated};
    curves.push_back(series);
  }
  for (std::size_t c = 0; c < frame.pictures.size(); ++c) {
    std::vector<DetectionRow> rows;
    for (const auto& views : frame.views) {
      for (const TagView& view : views) {
        if (view.camera != static_cast<int>(c)) continue;
        DetectionRow row;
        row.camera = view.camera;
        row.tag = view.place->id;
        row.corners_px = view.corners_px;
        rows.push_back(row);
      }
    }
    const cv::Mat drawn =
        DrawOverlay(trial.known_cameras[c], frame.pictures[c], rows, trial.tags, curves, 0, 1);
    std::string name = file;
    name.insert(name.size() - 4, std::to_string(c));
    cv::imwrite(name, drawn);
  }
}

void PrintTotals(const Totals& all) {
  const double nodes = all.nodes;
  fmt::print(
      "\nseen nodes {:.1f} % (tags on 51 %), bridged {:.1f} %, not seen {:.1f} %; views {} ({} rejected)\n",
      100 * all.seen.nodes / nodes, 100 * all.bridged.nodes / nodes, 100 * all.not_seen / nodes, all.views,
      all.rejected);
  fmt::print("nodes | rms, mm | worst, mm | chi2 | within 68 / 95 %\nseen | {}\nbridged | {}\n",
             all.seen.Row(), all.bridged.Row());
  fmt::print(
      "truth: turned beyond folds {:.4f} rad RMS per crease (worst {:.3f}), folds {:.4f} rad off the law\n",
      std::sqrt(all.swing_squares / all.swings), all.swing_worst, std::sqrt(all.fold_squares / all.swings));
  fmt::print(
      "\n| value | samples | within 68 % | within 95 % | several modes | mean error | mean 95 % width |\n");
  fmt::print("|---|---|---|---|---|---|---|\n");
  for (const auto& [name, c] : all.links) {
    const double n = c.of;
    fmt::print("| {} | {} | {:.1f} % | {:.1f} % | {} | {:.4f} | {:.4f} |\n", name, c.of, 100 * c.in68 / n,
               100 * c.in95 / n, c.torn, c.error / n, c.width / n);
  }
  fmt::print("undecided crossings: {:.2f} a frame\n", static_cast<double>(all.undecided) / all.frames);
  fmt::print("seconds a frame: render {:.2f}, find tags {:.2f}, solve {:.3f}; simulate {:.1f} a trial\n",
             all.seconds[1] / all.frames, all.seconds[2] / all.frames, all.seconds[3] / all.frames,
             all.seconds[0] / static_cast<double>(all.worst_trial.size()));
}

int Run(int first, int last, const std::string& picture, const ChainOptions& chain,
        const EntangledOptions& options) {
  Totals all;
  fmt::print(
      "| seed | mutual link | seen | seen: rms, mm | worst | chi2 | 68 / 95 | bridged: rms, mm | worst | "
      "chi2 "
      "| 68 / 95 | links in band |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (int seed = first; seed <= last; ++seed) {
    const auto trial = testing_support::MakeEntangledTrial(static_cast<std::uint64_t>(seed), options);
    if (!trial.ok()) {
      fmt::print(stderr, "seed {}: {}\n", seed, trial.error().message);
      return 1;
    }
    for (const std::string& doubt : trial.value().doubts) fmt::print("seed {}: {}\n", seed, doubt);
    testing_support::EntangledTracker tracker(trial.value(), static_cast<std::uint64_t>(seed), chain);
    Totals own;
    Covered pairs;
    std::string links;
    all.seconds[0] += trial.value().simulate_seconds;
    for (std::size_t f = 0; f < options.times.size(); ++f) {
      const EntangledFrame frame = tracker.Next(f);
      const TrueShape& shape = trial.value().shapes[f];
      AddNodes(shape, frame, own);
      AddNodes(shape, frame, all);
      AddSwings(trial.value(), shape, all);
      links += fmt::format("{}{:.2f}", links.empty() ? "" : " ", AddLinks(shape, frame, all, pairs));
      all.seconds[1] += frame.render_seconds;
      all.seconds[2] += frame.find_seconds;
      all.seconds[3] += frame.solve_seconds;
      ++all.frames;
      if (picture.size() > 4 && seed == first && f + 1 == options.times.size()) {
        Draw(picture, trial.value(), frame);
      }
    }
    all.worst_trial.push_back(static_cast<double>(pairs.in95) / pairs.of);
    fmt::print("| {} | {} | {:.0f} % | {} | {} | {} of {} |\n", seed, links,
               100.0 * own.seen.nodes / own.nodes, own.seen.Row(), own.bridged.Row(), pairs.in95, pairs.of);
    std::fflush(stdout);
  }
  PrintTotals(all);
  return 0;
}

}  // namespace
}  // namespace tendril

int main(int argc, char** argv) {
  const int first = argc > 2 ? std::atoi(argv[1]) : 101;
  const int last = argc > 2 ? std::atoi(argv[2]) : 112;
  tendril::testing_support::EntangledOptions options;
  options.scene = TENDRIL_SOURCE_DIR "/examples/scenes/entangled.toml";
  options.times = {6.0, 8.0, 10.0, 13.0};
  tendril::ChainOptions chain;
  for (int i = 4; i + 1 < argc; i += 2) {  // NAME VALUE
    const std::string name = argv[i];
    const double value = std::atof(argv[i + 1]);
    if (name == "swing") chain.sigma_swing = value;
    if (name == "angle") chain.sigma_angle = value;
    if (name == "walk") chain.sigma_opening_walk = value;
    if (name == "corner") chain.sigma_corner_px = value;
    if (name == "turn") chain.sigma_tag_turn = value;
    if (name == "gap") chain.sigma_gap = value;
    if (name == "hole") chain.sigma_hole = value;
    if (name == "base") chain.sigma_base_turn = value;
  }
  return tendril::Run(first, last, argc > 3 ? argv[3] : "", chain, options);
}
