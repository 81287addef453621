// Are the bands of reconstructed tentacles as wide as they say? True shapes of the virtual rig (facets bent,
// holes and creases off, sag, tags glued by hand), two cameras that are not quite where the rig file says,
// every facet tagged: errors, and how often the truth lies inside the stated 68 and 95 %.
//   bench_chain_bands [rendered [PICTURE.png]] [first seed] [seeds] [moments]
// Prints the tables of docs/tracking.md. Corners are projected with a noise that is stated; with `rendered`
// every picture is drawn as `record --source virtual` draws it and searched for tags as `track` does.
// Seeds 1000 .. 1059 were used for tuning; the tables' are 7000 on, rendered 13000 on.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>
#include <vector>

#include "capture/track/recall.h"
#include "model/fold/fold.h"
#include "tests/support/normal_turns.h"
#include "tests/support/tag_film.h"
#include "tests/support/virtual_views.h"

namespace tendril {
namespace {

using testing_support::SeenTentacle;
using testing_support::SightOptions;

struct Share {
  double inside68 = 0;
  double inside95 = 0;
  double count = 0;
  double squares = 0;

  // chi2 of the error in so many dimensions.
  void Add(double chi2, int dimensions) {
    inside68 += chi2 < (dimensions == 3 ? 3.5059 : 0.98890) ? 1 : 0;
    inside95 += chi2 < (dimensions == 3 ? 7.8147 : 3.8415) ? 1 : 0;
    squares += chi2 / dimensions;
    count += 1;
  }
  std::string text() const {
    if (count == 0) return "-";
    return fmt::format("{:.0f} / {:.0f} ({:.2f})", 100 * inside68 / count, 100 * inside95 / count,
                       squares / count);
  }
};

struct Nodes {
  Share ellipsoid;
  std::array<Share, 3> axis;  // of the facet: normal, across, along
  double squares = 0;

  void Add(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance, const Eigen::Matrix3d& rotation) {
    ellipsoid.Add(error.dot(covariance.ldlt().solve(error)), 3);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d along = rotation.col(k);
      axis[static_cast<std::size_t>(k)].Add(std::pow(along.dot(error), 2) / along.dot(covariance * along), 1);
    }
    squares += error.squaredNorm();
  }
  double rms_mm() const { return ellipsoid.count > 0 ? 1e3 * std::sqrt(squares / ellipsoid.count) : NAN; }
};

double LengthOf(const Eigen::Matrix3Xd& holes) {
  return (holes.rightCols(holes.cols() - 1) - holes.leftCols(holes.cols() - 1)).colwise().norm().sum();
}

// Fold angles by how many facets in a row beside the crease were not seen: 0, 1, 2, 3 and more.
struct Angles {
  Share share;
  double squares = 0;
  double error = 0;
  double law = 0;  // the law's own error
  double variance = 0;
  double by_pictures = 0;
};
using AnglesByGap = std::array<Angles, 4>;

void AddAngles(const ChainSolution& found, const SeenTentacle& truth, AnglesByGap& by_gap) {
  const auto facets = static_cast<int>(found.facets.size());
  std::vector<int> run(found.facets.size(), 0);  // facets in a row around here that were not seen
  for (int i = 0; i < facets;) {
    int end = i;
    while (end < facets && found.interpolated[end] != 0) ++end;
    for (int k = i; k < end; ++k) run[static_cast<std::size_t>(k)] = end - i;
    i = std::max(end, i + 1);
  }
  for (int i = 0; i + 1 < facets; ++i) {
    if (std::isnan(found.sigma[i]) || std::isnan(found.sigma[i + 1])) continue;
    const auto k = static_cast<std::size_t>(i);
    Angles& angles = by_gap[static_cast<std::size_t>(std::min(std::max(run[k], run[k + 1]), 3))];
    const double error = found.angle[i] - truth.fold_angle[i];
    angles.share.Add(std::pow(error / found.angle_sigma[i], 2), 1);
    angles.squares += error * error;
    angles.error += error;
    angles.law += truth.model.expected_angle[i] - truth.fold_angle[i];
    angles.variance += found.angle_sigma[i] * found.angle_sigma[i];
    angles.by_pictures += found.angle_by_pictures[i];
  }
}

void PrintAngles(const AnglesByGap& by_gap) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  for (std::size_t gap = 0; gap < by_gap.size(); ++gap) {
    const Angles& a = by_gap[gap];
    const double n = a.share.count;
    if (n == 0) continue;
    fmt::print(
        "  angles, {}{} unseen beside: {:.0f}, {:.2f} deg RMS (mean {:+.2f}, the law's {:+.2f}), stated "
        "{:.2f}, inside {}, by pictures {:.0f} %\n",
        gap, gap == 3 ? "+" : "", n, kDegrees * std::sqrt(a.squares / n), kDegrees * a.error / n,
        kDegrees * a.law / n, kDegrees * std::sqrt(a.variance / n), a.share.text(), 100 * a.by_pictures / n);
  }
}

struct Case {
  std::string name;
  SightOptions sight;
  double calibration_px = 0.2;
  ChainOptions chain;
  int lag = 0;  // near moments before and after
  bool rendered = false;
  std::string picture = {};  // of the first seed's last moment; empty: none
};

void Run(const Case& one, std::uint64_t first, int seeds, int moments) {
  const TentacleDesign design;
  Gripper gripper;
  gripper.tentacles = 1;
  gripper.first_azimuth = 0;
  const TagLayout drawn = LayOutTags(design, gripper).value();
  const std::vector<Camera> told = VirtualRig(design, gripper).value().cameras;
  Nodes seen;
  Nodes bridged;
  Share reach;
  Share length;
  Share tip;
  std::array<Share, 3> turn;  // of normals: of facets seen, of bridged ones, the tip's less the base's
  double turn_squares = 0;
  double not_seen = 0;
  AnglesByGap angles;
  double chi_square = 0;
  double views = 0;
  double rejected = 0;
  int frames = 0;
  for (int s = 0; s < seeds; ++s) {
    std::mt19937_64 random(first + static_cast<std::uint64_t>(s));
    const TruthRanges ranges;
    const VirtualTruth truth =
        DrawTruth(design, gripper, {0.95, 1, 1}, {0.3, 0.03}, {.radius = 0}, ranges, random).value();
    const TagLayout glued = GlueTags(drawn, ranges, random);
    std::vector<Eigen::Vector3d> points;
    for (const double time : {0.0, 5.0, 11.0}) {
      const TrueShape shape = TrueShapeAt(truth, time).value();
      for (const auto& hole : shape.tentacles[0].centerline.points.colwise()) points.emplace_back(hole);
    }
    std::vector<Camera> cameras;
    for (const Camera& camera : told) {
      cameras.push_back(testing_support::MiscalibratedCamera(camera, points, one.calibration_px, random));
    }
    std::optional<testing_support::TagFilm> film;
    std::vector<double> times;
    if (one.rendered) {
      film.emplace(cameras, drawn, glued, design.hole_diameter, random(), TagTrackLevel::kStandard);
      for (int m = 0; m < moments; ++m) times.push_back(DrawUniform(random, 0, 11));
      std::sort(times.begin(), times.end());
    }
    for (int m = 0; m < moments; ++m) {
      const double time = one.rendered ? times[static_cast<std::size_t>(m)] : DrawUniform(random, 0, 11);
      const TrueShape shape = TrueShapeAt(truth, time).value();
      SeenTentacle tentacle;
      if (film) {
        testing_support::FilmedMoment moment = film->Next(shape);
        tentacle = {testing_support::KnownOf(gripper, design, shape, 0), std::move(moment.views[0]),
                    shape.tentacles[0].centerline.points, shape.tentacles[0].fold_angle};
        if (s == 0 && m + 1 == moments && !one.picture.empty()) {
          cv::imwrite(one.picture, moment.pictures[0]);
        }
      } else {
        tentacle = testing_support::SeeTentacle(shape, gripper, 0, drawn, glued, cameras, one.sight, random);
      }
      ChainSolution found = SolveChain(tentacle.model, told, tentacle.views, one.chain);
      if (one.lag > 0) {  // moments 20 ms apart, as `track --smooth-lag` takes them
        const MomentAngles now = AnglesOf(time, tentacle.model, found);
        std::vector<MomentAngles> near;
        for (int k = -one.lag; k <= one.lag; ++k) {
          if (k == 0) continue;
          const double other = std::clamp(time + 0.02 * k, 0.0, 11.0);
          const SeenTentacle then = testing_support::SeeTentacle(TrueShapeAt(truth, other).value(), gripper,
                                                                 0, drawn, glued, cameras, one.sight, random);
          near.push_back(AnglesOf(other, then.model, SolveChain(then.model, told, then.views, one.chain)));
        }
        ChainModel model = tentacle.model;
        model.recalled = RecallAngles(now, near, one.chain);
        found = SolveChain(model, told, tentacle.views, one.chain, &found);
      }
      const Eigen::MatrixXd& factor = found.covariance_factor;
      const Eigen::Matrix3Xd error = found.curve.points - tentacle.holes;
      const Eigen::VectorXd turned =
          testing_support::TurnsBetween(found.curve, shape.tentacles[0].centerline);
      for (int i = 0; i < error.cols(); ++i) {
        if (std::isnan(found.sigma[i])) {
          ++not_seen;
          continue;
        }
        const Eigen::Matrix3d own = factor.middleRows<3>(3 * i) * factor.middleRows<3>(3 * i).transpose();
        (found.interpolated[i] != 0 ? bridged : seen)
            .Add(error.col(i), own, found.facets[static_cast<std::size_t>(i)].rotation);
        turn[found.interpolated[i] != 0 ? 1 : 0].Add(
            turned[i] * turned[i] / found.turn_factor.row(i).squaredNorm(), 1);
        turn_squares += turned[i] * turned[i];
      }
      const int last = static_cast<int>(error.cols()) - 1;
      AddAngles(found, tentacle, angles);
      ++frames;
      chi_square += found.chi_square;
      views += found.views_used;
      rejected += found.views_rejected;
      if (std::isnan(found.sigma[last]) || std::isnan(found.sigma[0])) continue;
      turn[2].Add(std::pow(turned[last] - turned[0], 2) /
                      (found.turn_factor.row(last) - found.turn_factor.row(0)).squaredNorm(),
                  1);
      const Eigen::Matrix3Xd& p = found.curve.points;
      Eigen::VectorXd slope = Eigen::VectorXd::Zero(p.size());
      const Eigen::Vector3d chord = p.col(last) - p.col(0);
      slope.head<3>() = -chord.normalized();
      slope.tail<3>() = chord.normalized();
      const auto variance = [&] { return (factor.transpose() * slope).squaredNorm(); };
      reach.Add(
          std::pow(chord.norm() - (tentacle.holes.col(last) - tentacle.holes.col(0)).norm(), 2) / variance(),
          1);
      slope.setZero();
      slope[slope.size() - 1] = 1;
      tip.Add(std::pow(error(2, last), 2) / variance(), 1);
      slope.setZero();
      for (int i = 0; i < last; ++i) {
        const Eigen::Vector3d d = (p.col(i + 1) - p.col(i)).normalized();
        slope.segment<3>(3 * i) -= d;
        slope.segment<3>(3 * i + 3) += d;
      }
      length.Add(std::pow(LengthOf(p) - LengthOf(tentacle.holes), 2) / variance(), 1);
    }
  }
  const double nodes = frames * static_cast<double>(design.holes);
  fmt::print("| {} | {:.1f} | {:.1f} % | {:.2f} | {:.2f} |", one.name, views / frames,
             100 * seen.ellipsoid.count / nodes, seen.rms_mm(), bridged.rms_mm());
  fmt::print(" {} | {} | {} | {} | {} |\n", seen.ellipsoid.text(), bridged.ellipsoid.text(), reach.text(),
             length.text(), tip.text());
  fmt::print(
      "  seen: normal {}, across {}, along {}; bridged: normal {}, across {}, along {}; not seen {:.1f} %, "
      "chi2 {:.2f}, left out {:.2f} a frame\n",
      seen.axis[0].text(), seen.axis[1].text(), seen.axis[2].text(), bridged.axis[0].text(),
      bridged.axis[1].text(), bridged.axis[2].text(), 100 * not_seen / nodes, chi_square / frames,
      rejected / frames);
  fmt::print("  turn of normals, {:.4f} rad RMS: seen {}, bridged {}, tip less base {}\n",
             std::sqrt(turn_squares / (seen.ellipsoid.count + bridged.ellipsoid.count)), turn[0].text(),
             turn[1].text(), turn[2].text());
  PrintAngles(angles);
  std::fflush(stdout);
}

}  // namespace
}  // namespace tendril

int main(int argc, char** argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  const bool rendered = !words.empty() && words[0] == "rendered";
  if (rendered) words.erase(words.begin());
  std::string picture;
  if (rendered && !words.empty() && words[0].ends_with(".png")) {
    picture = words[0];
    words.erase(words.begin());
  }
  const auto number = [&](std::size_t i, int otherwise) {
    return words.size() > i ? std::max(1, std::atoi(words[i].c_str())) : otherwise;
  };
  const auto first = static_cast<std::uint64_t>(number(0, rendered ? 13000 : 7000));
  const int seeds = number(1, 120);
  const int moments = number(2, 3);
  fmt::print("seeds {} .. {}, {} moments each; inside 68 / 95 % (mean chi2 per dimension)\n", first,
             first + static_cast<std::uint64_t>(seeds) - 1, moments);
  fmt::print(
      "| case | tags seen | facets seen | seen: rms, mm | bridged: rms, mm | seen nodes | bridged nodes | "
      "base to tip | "
      "length | tip's height |\n|---|---|---|---|---|---|---|---|---|---|\n");
  const tendril::ChainOptions chain;
  tendril::ChainOptions lawless;
  lawless.fold_law = false;
  std::vector<tendril::Case> cases = {
      {"as drawn", {}, 0.2, chain},
      {"calibration 0 px", {}, 0, chain},
      {"calibration 0.4 px", {}, 0.4, chain},
      {"half of the tags", {.kept = 0.5}, 0.2, chain},
      {"every second facet", {.every = 2}, 0.2, chain},
      {"half of the tags, lag 3", {.kept = 0.5}, 0.2, chain, 3},
      {"as drawn, no fold law", {}, 0.2, lawless},
      {"half of the tags, no fold law", {.kept = 0.5}, 0.2, lawless},
      {"every second facet, no fold law", {.every = 2}, 0.2, lawless},
      {"half of the tags, no fold law, lag 3", {.kept = 0.5}, 0.2, lawless, 3}};
  if (rendered) cases = {{"rendered", {}, 0.2, chain, 0, true, picture}};
  for (const tendril::Case& one : cases) tendril::Run(one, first, seeds, moments);
}
