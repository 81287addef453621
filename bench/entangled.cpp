// Eight tentacles in a tangle, every second facet tagged, four cameras of 1280 x 1024 px: how far off are the
// holes that tracking finds, how much of a tentacle is seen, and does the link computed from the video lie
// within its band? Shapes are the rod simulator's; every frame is rendered, searched for tags and solved.
// Prints the tables of docs/tracking.md ("Entangled") and docs/link.md.
//   bench_entangled [FIRST LAST [PICTURE.png|- [SETTINGS...]]]
//     seeds; 101 to 112 unless given. 1 to 11 were for tuning. SETTINGS: "sigma_swing=0.03,sigma_angle=0.05",
//     each a column of its own beside the solver's defaults; without any, those for loaded tentacles
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
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

using testing_support::EntangledOptions;
using testing_support::EntangledTrial;
using testing_support::FilmedMoment;

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

// Of one trial.
struct Totals {
  Errors seen, bridged;
  int not_seen = 0, nodes = 0, views = 0, rejected = 0, undecided = 0, frames = 0;
  std::map<std::string, Covered> links;
  std::string true_links;
  double solve_seconds = 0;
};

// How the truth turns beyond the fold at the creases, which no tag knows, and how it follows its rods.
struct Swings {
  double squares = 0, fold_squares = 0, worst = 0, off_rod = 0;
  int count = 0, holes = 0;

  void Add(const EntangledTrial& trial, std::size_t frame) {
    const TrueShape& shape = trial.shapes[frame];
    for (std::size_t t = 0; t < shape.tentacles.size(); ++t) {
      const TentacleDesign design = DesignOfTentacle(trial.gripper, trial.design, static_cast<int>(t));
      const TentacleLayout layout = LayOut(design).value();
      off_rod += testing_support::DistancesFromRod(layout, trial.rods[frame][t].curve.points,
                                                   shape.tentacles[t].centerline.points)
                     .squaredNorm();
      holes += static_cast<int>(layout.hole_z.size());
      const Eigen::VectorXd law = SolveFold(design, shape.tentacles[t].command).value().angle;
      const auto& strips = shape.tentacles[t].strips;
      for (Eigen::Index i = 0; i < law.size(); ++i) {
        const auto at = static_cast<std::size_t>(3 * i + 1);
        const Eigen::Vector3d crease = DirectionOfCrease(layout.crease_angle[i]);
        const Eigen::Matrix3d turned =
            strips[at].lab_from_sheet.linear().transpose() * strips[at + 3].lab_from_sheet.linear();
        const double folded = (i % 2 == 0 ? -2 : 2) * shape.tentacles[t].fold_angle[i];
        const double swing = LogSo3(Eigen::Matrix3d(turned * ExpSo3(-folded * crease))).norm();
        squares += swing * swing;
        worst = std::max(worst, swing);
        fold_squares += std::pow(shape.tentacles[t].fold_angle[i] - law[i], 2);
        ++count;
      }
    }
  }
  void Print() const {
    fmt::print("\ntruth: {:.4f} rad RMS of a crease's turning are not its fold's (worst {:.3f}), ",
               std::sqrt(squares / count), worst);
    fmt::print("folds {:.4f} rad off the law, holes {:.1f} mm off their rods\n",
               std::sqrt(fold_squares / count), 1e3 * std::sqrt(off_rod / holes));
  }
};

void AddNodes(const TrueShape& shape, const FilmedMoment& frame, const std::vector<ChainSolution>& solutions,
              Totals& totals) {
  for (std::size_t t = 0; t < solutions.size(); ++t) {
    const ChainSolution& solution = solutions[t];
    const Eigen::Matrix3Xd& holes = shape.tentacles[t].centerline.points;
    totals.views += static_cast<int>(frame.views[t].size());
    totals.rejected += solution.views_rejected;
    for (Eigen::Index i = 0; i < holes.cols(); ++i) {
      ++totals.nodes;
      const Eigen::Vector3d error = solution.curve.points.col(i) - holes.col(i);
      if (std::isnan(solution.sigma[i])) {
        ++totals.not_seen;
        continue;
      }
      const Eigen::MatrixXd factor = solution.covariance_factor.middleRows(3 * i, 3);
      const Eigen::Matrix3d covariance = factor * factor.transpose();
      (solution.interpolated[i] != 0 ? totals.bridged : totals.seen)
          .Add(error, solution.sigma[i], covariance);
    }
  }
}

// Returns the true mutual link.
double AddLinks(const TrueShape& shape, const std::vector<ChainSolution>& solutions, Totals& totals) {
  std::vector<FramedCurve> truth;
  std::vector<FramedCurve> found;
  std::vector<Eigen::MatrixXd> factors;
  std::vector<Eigen::MatrixXd> turns;
  for (std::size_t t = 0; t < solutions.size(); ++t) {
    truth.push_back(shape.tentacles[t].centerline);
    found.push_back(solutions[t].curve);
    factors.push_back(solutions[t].covariance_factor);
    turns.push_back(solutions[t].turn_factor);
  }
  const LinkReport report = MeasureLink(truth, {}).value();
  const LinkBands bands = MeasureLinkBands(found, factors, {}, {}, {}, turns).value();
  totals.links["mutual link"].Add(bands.mutual_link, report.mutual_link);
  for (std::size_t i = 0; i < bands.pairs.size(); ++i) {
    totals.links["link of a pair"].Add(bands.pairs[i].link, report.pairs[i].link.value);
    totals.links["gauss of a pair"].Add(bands.pairs[i].gauss, report.pairs[i].gauss.value);
  }
  for (std::size_t i = 0; i < bands.curves.size(); ++i) {
    totals.links["writhe"].Add(bands.curves[i].writhe, report.curves[i].writhe.value);
    totals.links["self-link"].Add(bands.curves[i].self_link, report.curves[i].self_link.value);
  }
  totals.undecided += static_cast<int>(bands.undecided.size());
  return report.mutual_link;
}

void Draw(const std::string& file, const EntangledTrial& trial, const FilmedMoment& frame,
          const std::vector<ChainSolution>& solutions) {
  std::vector<CurveSeries> curves;
  for (const ChainSolution& solution : solutions) {
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

// Pairs of a frame and frames of a trial are not independent, trials are: standard error of a share, from the
// scatter between trials.
std::string ShareAndError(const std::vector<std::pair<int, int>>& of_trials) {
  double in = 0, all = 0;
  for (const auto& [k, n] : of_trials) {
    in += k;
    all += n;
  }
  const double share = in / all;
  double squares = 0;
  for (const auto& [k, n] : of_trials) squares += std::pow(k - share * n, 2);
  const double trials = static_cast<double>(of_trials.size());
  const double error = trials > 1 ? std::sqrt(squares * trials / (trials - 1)) / all : NAN;
  return fmt::format("{:.1f} % +- {:.1f}", 100 * share, 100 * error);
}

void PrintLinks(const std::vector<Totals>& trials) {
  fmt::print(
      "\n| value | samples | within 68 % | within 95 % | several modes | mean error | mean 95 % width |\n"
      "|---|---|---|---|---|---|---|\n");
  for (const auto& [name, unused] : trials.front().links) {
    std::vector<std::pair<int, int>> in68;
    std::vector<std::pair<int, int>> in95;
    Covered all;
    for (const Totals& trial : trials) {
      const Covered& c = trial.links.at(name);
      in68.emplace_back(c.in68, c.of);
      in95.emplace_back(c.in95, c.of);
      all.of += c.of;
      all.torn += c.torn;
      all.error += c.error;
      all.width += c.width;
    }
    fmt::print("| {} | {} | {} | {} | {} | {:.4f} | {:.4f} |\n", name, all.of, ShareAndError(in68),
               ShareAndError(in95), all.torn, all.error / all.of, all.width / all.of);
  }
}

struct Setting {
  std::string name;
  ChainOptions chain;
  std::vector<Totals> trials;
};

void PrintSetting(const Setting& setting, int first) {
  fmt::print(
      "\n{}\n| seed | mutual link | seen | seen: rms, mm | worst | chi2 | 68 / 95 | bridged: rms, mm | worst "
      "| "
      "chi2 | 68 / 95 | not seen | undecided |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      setting.name);
  Totals all;
  const auto row = [](const std::string& name, const std::string& links, const Totals& t) {
    fmt::print("| {} | {} | {:.0f} % | {} | {} | {:.1f} % | {} |\n", name, links,
               100.0 * t.seen.nodes / t.nodes, t.seen.Row(), t.bridged.Row(), 100.0 * t.not_seen / t.nodes,
               t.undecided);
  };
  for (std::size_t i = 0; i < setting.trials.size(); ++i) {
    const Totals& t = setting.trials[i];
    row(std::to_string(first + static_cast<int>(i)), t.true_links, t);
    all.seen.Add(t.seen);
    all.bridged.Add(t.bridged);
    all.not_seen += t.not_seen;
    all.nodes += t.nodes;
    all.views += t.views;
    all.rejected += t.rejected;
    all.undecided += t.undecided;
    all.frames += t.frames;
    all.solve_seconds += t.solve_seconds;
  }
  row("all", "", all);
  fmt::print("views {} ({} left out); undecided crossings {:.2f} a frame; {:.3f} s to solve a frame\n",
             all.views, all.rejected, static_cast<double>(all.undecided) / all.frames,
             all.solve_seconds / all.frames);
  PrintLinks(setting.trials);
}

int Run(int first, int last, const std::string& picture, std::vector<Setting> settings,
        const EntangledOptions& options) {
  Swings swings;
  double simulate = 0, render = 0, find = 0;
  int frames = 0;
  for (int seed = first; seed <= last; ++seed) {
    const auto trial = testing_support::MakeEntangledTrial(static_cast<std::uint64_t>(seed), options);
    if (!trial.ok()) {
      fmt::print(stderr, "seed {}: {}\n", seed, trial.error().message);
      return 1;
    }
    for (const std::string& doubt : trial.value().doubts) fmt::print("seed {}: {}\n", seed, doubt);
    testing_support::EntangledFilm film(trial.value(), static_cast<std::uint64_t>(seed));
    simulate += trial.value().simulate_seconds;
    std::vector<std::vector<ChainSolution>> solutions(settings.size());
    for (Setting& setting : settings) setting.trials.emplace_back();
    for (std::size_t f = 0; f < options.times.size(); ++f) {
      const TrueShape& shape = trial.value().shapes[f];
      const FilmedMoment frame = film.Next(shape);
      render += frame.render_seconds;
      find += frame.find_seconds;
      ++frames;
      swings.Add(trial.value(), f);
      for (std::size_t s = 0; s < settings.size(); ++s) {
        Totals& own = settings[s].trials.back();
        const auto start = std::chrono::steady_clock::now();
        testing_support::SolveTentacles(trial.value(), shape, frame, settings[s].chain, solutions[s]);
        own.solve_seconds += testing_support::SecondsOf(start);
        ++own.frames;
        AddNodes(shape, frame, solutions[s], own);
        own.true_links += fmt::format("{}{:.2f}", f == 0 ? "" : " ", AddLinks(shape, solutions[s], own));
      }
      if (picture.size() > 4 && seed == first && f + 1 == options.times.size()) {
        Draw(picture, trial.value(), frame, solutions.back());
      }
    }
    fmt::print(stderr, "seed {} done\n", seed);
  }
  for (const Setting& setting : settings) PrintSetting(setting, first);
  swings.Print();
  fmt::print("seconds: simulate {:.1f} a trial; render {:.2f}, find tags {:.2f} a frame\n",
             simulate / (last - first + 1), render / frames, find / frames);
  return 0;
}

// "sigma_swing=0.03,sigma_angle=0.05"
ChainOptions Parsed(const std::string& text) {
  ChainOptions chain;
  const std::map<std::string, double*> known = {{"sigma_corner_px", &chain.sigma_corner_px},
                                                {"sigma_tag_place", &chain.sigma_tag_place},
                                                {"sigma_tag_turn", &chain.sigma_tag_turn},
                                                {"sigma_hole", &chain.sigma_hole},
                                                {"sigma_gap", &chain.sigma_gap},
                                                {"sigma_swing", &chain.sigma_swing},
                                                {"sigma_angle", &chain.sigma_angle},
                                                {"sigma_opening_walk", &chain.sigma_opening_walk}};
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    const std::size_t equals = text.find('=', at);
    if (equals < end) {
      const auto found = known.find(text.substr(at, equals - at));
      if (found != known.end()) *found->second = std::atof(text.substr(equals + 1, end - equals - 1).c_str());
      if (found == known.end()) fmt::print(stderr, "no setting {}\n", text.substr(at, equals - at));
    }
    at = end + 1;
  }
  return chain;
}

}  // namespace
}  // namespace tendril

int main(int argc, char** argv) {
  const int first = argc > 2 ? std::atoi(argv[1]) : 101;
  const int last = argc > 2 ? std::atoi(argv[2]) : 112;
  tendril::testing_support::EntangledOptions options;
  options.scene = TENDRIL_SOURCE_DIR "/examples/scenes/entangled.toml";
  options.times = {6.0, 8.0, 10.0, 13.0};
  std::vector<tendril::Setting> settings = {{"solver's defaults", {}, {}}};
  for (int i = 4; i < argc; ++i) settings.push_back({argv[i], tendril::Parsed(argv[i]), {}});
  if (argc <= 4) {
    settings.push_back({"loaded tentacles", tendril::LoadedTentacles(), {}});
  }
  return tendril::Run(first, last, argc > 3 ? argv[3] : "", settings, options);
}
