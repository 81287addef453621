// How often does `calibrate fold --compare` choose the true model, and how often do the intervals of the true
// model's parameters hold the truth? Draws virtual campaigns (trials of one design; true shapes of the
// virtual rig by a true law, with all of its perturbations; a fast model of the tracker's noise, no video).
//
//   bench_fold_model_choice [campaigns] [trials] [first seed] [true model's name, or part of it] [parameter]
//   [friction]
//
// A part that begins with `=` is the whole name. With a parameter, the true model's profile of it is drawn,
// too, and its interval counted beside the symmetric one (docs/calibration.md, "Profiles"). A friction is the
// truth's in place of 0.05, where it has one: near 0 the bound there matters.
//
// Seeds: tuning used 7'000'000 and up; the table of docs/calibration.md uses 8'000'000 and up.

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "calibrate/fold/fold_compare.h"
#include "calibrate/fold/fold_profile.h"
#include "capture/rig/virtual_truth.h"
#include "tests/support/perturbed_tentacle.h"

namespace tendril::test {
namespace {

struct Case {
  TrueFold truth;
  FoldModel model;
  double pull = 0.3;
};

std::vector<Case> Cases() {
  const double degree = std::numbers::pi / 180;
  const auto truth = [&](FoldLaw law, double rest_deg, double friction) {
    return TrueFold{0.93, 1.3, 1.2, law, rest_deg * degree, friction};
  };
  return {{truth(FoldLaw::kPaper, 0, 0), {FoldLaw::kPaper, false, false}},
          {truth(FoldLaw::kPaper, 8, 0), {FoldLaw::kPaper, true, false}},
          {truth(FoldLaw::kPaper, 0, 0.05), {FoldLaw::kPaper, false, true}},
          {truth(FoldLaw::kExact, 12, 0), {FoldLaw::kExact, true, false}},
          {truth(FoldLaw::kExact, 12, 0.05), {FoldLaw::kExact, true, true}},
          {truth(FoldLaw::kExact, 0, 0), {FoldLaw::kExact, false, false}}};
}

std::vector<FoldObservation> Campaign(const Case& one, int trials, std::uint64_t seed) {
  Gripper gripper;
  gripper.tentacles = 1;
  constexpr double kRate = 0.03;
  std::vector<FoldObservation> observations;
  for (int trial = 0; trial < trials; ++trial) {
    Random random(seed + static_cast<std::uint64_t>(trial));
    // Held at three pulls, as a campaign that wants to tell laws apart would.
    const double pull = one.pull * std::array{1.0, 0.6, 0.3}[static_cast<std::size_t>(trial % 3)];
    const VirtualTruth drawn = DrawTruth({}, gripper, one.truth, {pull, kRate}, {}, {}, random).value();
    const double ramp_end = pull / kRate;
    const double last = ramp_end + 3.2;
    for (int frame = 0; frame < 6; ++frame) {
      FoldObservation o;
      o.trial = fmt::format("t{}", trial);
      o.time = last * frame / 5;
      o.commanded_pull = std::min(kRate * o.time, pull);
      o.steady_for = o.time > ramp_end ? o.time - ramp_end : frame == 0 ? 1e9 : o.time;
      o.settled_for = o.time > ramp_end ? o.time - ramp_end : frame == 0 ? 1e9 : 0;
      const TrueShape shape = TrueShapeAt(drawn, o.time).value();
      for (int tentacle = 0; tentacle < gripper.tentacles; ++tentacle) {
        o.tentacle = tentacle;
        o.design = DesignOfTentacle(gripper, {}, tentacle);
        Observe(shape.tentacles[static_cast<std::size_t>(tentacle)].centerline.points, {}, random, o);
        observations.push_back(o);
      }
    }
  }
  return observations;
}

struct Tally {
  double sum = 0, squares = 0, errors = 0;
  int hits = 0, count = 0, unidentified = 0;
};

// How often a profile's interval holds the truth, and how wide it is beside the symmetric one.
struct ProfileTally {
  int hits = 0, symmetric_hits = 0, count = 0, failed = 0, at_bound = 0, open = 0;
  double width = 0, symmetric_width = 0, seconds = 0;
};

void AddProfile(std::span<const FoldObservation> observations, FoldFitOptions options, const FoldModel& model,
                const std::string& parameter, double truth, ProfileTally& tally) {
  options.model = model;
  const auto started = std::chrono::steady_clock::now();
  const Result<FoldProfile> profiled = ProfileFold(observations, options, parameter);
  tally.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  if (!profiled.ok()) {
    ++tally.failed;
    return;
  }
  const FoldProfile& p = profiled.value();
  ++tally.count;
  // An end that the profile does not reach is no bound.
  const bool above = std::isnan(p.interval.low) || p.interval.low <= truth;
  const bool below = std::isnan(p.interval.high) || p.interval.high >= truth;
  tally.hits += above && below ? 1 : 0;
  const bool open = std::isnan(p.interval.low) || std::isnan(p.interval.high);
  tally.open += open ? 1 : 0;
  for (const FittedParameter& q : p.fit.parameters) {
    if (q.name != parameter) continue;
    tally.symmetric_hits += q.interval.low <= truth && truth <= q.interval.high ? 1 : 0;
    tally.at_bound += q.at_bound ? 1 : 0;
    if (open) continue;
    tally.symmetric_width += q.interval.high - q.interval.low;
    tally.width += p.interval.high - p.interval.low;
  }
}

void Run(const Case& one, int campaigns, int trials, std::uint64_t first_seed, const std::string& parameter) {
  const std::map<std::string, double> wanted = {
      {"pull_scale", one.truth.pull_scale},
      {"stiffness_ratio", one.truth.stiffness_ratio},
      {"stiffness_exponent", one.truth.stiffness_exponent},
      {"rest_angle_deg", one.truth.rest_angle * 180 / std::numbers::pi},
      {"friction", one.truth.friction}};
  std::map<std::string, Tally> tallies;
  ProfileTally profiles;
  std::map<std::string, int> chosen;
  int law = 0, model = 0, done = 0;
  double seconds = 0, slowest = 0;
  for (int campaign = 0; campaign < campaigns; ++campaign) {
    const std::vector<FoldObservation> observations =
        Campaign(one, trials, first_seed + 1000 * static_cast<std::uint64_t>(campaign));
    FoldComparisonOptions options;
    options.fit.longest_lag = 1.5;  // delays and rates are not logged here
    const Result<FoldComparison> compared = CompareFoldModels(observations, options);
    if (!compared.ok()) {
      fmt::print(stderr, "campaign {}: {}\n", campaign, compared.error().message);
      continue;
    }
    ++done;
    if (!parameter.empty())
      AddProfile(observations, options.fit, one.model, parameter, wanted.at(parameter), profiles);
    seconds += compared.value().seconds;
    slowest = std::max(slowest, compared.value().seconds);
    for (const ComparedModel& m : compared.value().models) {
      if (campaigns <= 3) {
        fmt::print(stderr,
                   "  {:28} held-out {:.5f} mm, behind {:.4f} +- {:.4f}, AIC {:.1f}, fit {:.1f} s {}\n",
                   NameOf(m.model), 1e3 * m.held_out, m.behind, m.behind_error, m.aic_difference,
                   m.fit ? m.fit->seconds : 0.0, m.why_not);
      }
      if (!(m.model == one.model) || !m.fit) continue;
      for (const FittedParameter& p : m.fit->parameters) {
        Tally& tally = tallies[p.name];
        if (campaigns <= 3)
          fmt::print(stderr, "    {} {:.4f} +- {:.4f}\n", p.name, p.value, p.standard_error);
        if (!p.identified) {
          ++tally.unidentified;
          continue;
        }
        const double off = p.value - wanted.at(p.name);
        ++tally.count;
        tally.sum += off;
        tally.squares += off * off;
        tally.errors += p.standard_error;
        tally.hits += p.interval.low <= wanted.at(p.name) && wanted.at(p.name) <= p.interval.high ? 1 : 0;
      }
    }
    const FoldModel& found = compared.value().models[static_cast<std::size_t>(compared.value().chosen)].model;
    if (campaigns <= 3) {
      for (const std::string& line : compared.value().verdict) fmt::print(stderr, "  {}\n", line);
    }
    law += found.law == one.model.law ? 1 : 0;
    model += found == one.model ? 1 : 0;
    ++chosen[NameOf(found)];
  }
  std::string others;
  for (const auto& [name, count] : chosen)
    others += fmt::format("{}{} {}", others.empty() ? "" : ", ", name, count);
  fmt::print("| {} | law {}/{}, model {}/{} | {} | {:.1f} (at most {:.1f}) |\n", NameOf(one.model), law, done,
             model, done, others, seconds / std::max(done, 1), slowest);
  for (const auto& [name, tally] : tallies) {
    const double n = std::max(tally.count, 1);
    const double bias = tally.sum / n;
    const double spread = n > 1 ? std::sqrt((tally.squares - n * bias * bias) / (n - 1)) : 0;
    fmt::print("| {} | {} | {:.4g} | {:+.4f} | {:.4f} | {:.4f} | {}/{}{} |\n", NameOf(one.model), name,
               wanted.at(name), bias, spread, tally.errors / n, tally.hits, tally.count,
               tally.unidentified > 0 ? fmt::format(", {} not identified", tally.unidentified) : "");
  }
  if (!parameter.empty()) {
    const double closed = std::max(profiles.count - profiles.open, 1);
    fmt::print(
        "| {} | {} | profile {}/{}, symmetric {}/{} | {} at 0, {} open, {} without | {:.4f}, symmetric "
        "{:.4f} "
        "| {:.1f} s |\n",
        NameOf(one.model), parameter, profiles.hits, profiles.count, profiles.symmetric_hits, profiles.count,
        profiles.at_bound, profiles.open, profiles.failed, profiles.width / closed,
        profiles.symmetric_width / closed, profiles.seconds / std::max(done, 1));
  }
  std::fflush(stdout);
}

}  // namespace
}  // namespace tendril::test

int main(int argc, char** argv) {
  using namespace tendril::test;
  const int campaigns = argc > 1 ? std::atoi(argv[1]) : 50;
  const int trials = argc > 2 ? std::atoi(argv[2]) : 9;
  const std::uint64_t seed = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 8'000'000;
  const std::string only = argc > 4 ? argv[4] : "";
  fmt::print("| true model | chosen | models chosen | s per comparison |\n");
  const std::string parameter = argc > 5 ? argv[5] : "";
  const auto& names = tendril::FoldParameterNames();
  if (!parameter.empty() && std::find(names.begin(), names.end(), parameter) == names.end()) {
    fmt::print(stderr, "no parameter {}\n", parameter);
    return 2;
  }
  fmt::print("| true model | parameter | truth | bias | SD | mean SE | in 95 % |\n");
  for (const Case& one : Cases()) {
    const std::string name = tendril::NameOf(one.model);
    if (only.starts_with("=") ? name != only.substr(1) : name.find(only) == std::string::npos) continue;
    Case with = one;
    if (argc > 6 && one.model.friction) with.truth.friction = std::atof(argv[6]);
    Run(with, campaigns, trials, seed, parameter);
  }
  return 0;
}
