#include "analysis/statistics/hysteresis.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <utility>

#include "model/check.h"
#include "model/median.h"

namespace tendril {
namespace {

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

// A stroke's response as a function of the drive.
struct Profile {
  Eigen::VectorXd response, sigma;  // at the levels; NaN: not reached
};

Profile ProfileOf(const DriveStroke& stroke, const Eigen::VectorXd& drive, const Eigen::VectorXd& response,
                  const Eigen::VectorXd& sigma, const Eigen::VectorXd& level, double largest_gap) {
  struct Knot {
    double drive = 0, response = 0, sigma = 0;
    int rows = 1;
  };
  std::vector<Knot> rows;
  for (Eigen::Index i = stroke.first; i <= stroke.last; ++i) {
    if (std::isfinite(drive[i]) && std::isfinite(response[i])) {
      rows.push_back({.drive = drive[i], .response = response[i], .sigma = sigma[i]});
    }
  }
  std::stable_sort(rows.begin(), rows.end(), [](const Knot& a, const Knot& b) { return a.drive < b.drive; });
  std::vector<Knot> knots;
  for (const Knot& row : rows) {
    if (!knots.empty() && knots.back().drive == row.drive) {
      Knot& same = knots.back();
      ++same.rows;
      same.response += (row.response - same.response) / same.rows;
      same.sigma += (row.sigma - same.sigma) / same.rows;
    } else {
      knots.push_back(row);
    }
  }
  Profile profile{Eigen::VectorXd::Constant(level.size(), kNotKnown),
                  Eigen::VectorXd::Constant(level.size(), kNotKnown)};
  // Levels of a drive that has few values should meet them in spite of rounding.
  const double near = 1e-9 * (level[level.size() - 1] - level[0]);
  for (Eigen::Index l = 0; l < level.size(); ++l) {
    const auto above = std::find_if(knots.begin(), knots.end(),
                                    [&](const Knot& knot) { return knot.drive >= level[l] - near; });
    if (above == knots.end()) continue;
    if (above->drive <= level[l] + near) {
      profile.response[l] = above->response;
      profile.sigma[l] = above->sigma;
    } else if (above != knots.begin()) {
      const Knot& below = *std::prev(above);
      const double gap = above->drive - below.drive;
      if (gap > largest_gap) continue;
      const double share = (level[l] - below.drive) / gap;
      profile.response[l] = (1 - share) * below.response + share * above->response;
      profile.sigma[l] = (1 - share) * below.sigma + share * above->sigma;
    }
  }
  return profile;
}

HysteresisCycle Compare(const DriveStroke& one, const DriveStroke& next, const Profile& of_one,
                        const Profile& of_next) {
  const Profile& up = one.rises ? of_one : of_next;
  const Profile& down = one.rises ? of_next : of_one;
  HysteresisCycle cycle{.first = one.first,
                        .last = next.last,
                        .rising = up.response,
                        .falling = down.response,
                        .difference_sigma = (up.sigma.array().square() + down.sigma.array().square()).sqrt()};
  double up_sigma = 0;
  double down_sigma = 0;
  for (Eigen::Index l = 0; l < cycle.rising.size(); ++l) {
    const double difference = cycle.rising[l] - cycle.falling[l];
    if (std::isnan(difference)) {
      cycle.rising[l] = cycle.falling[l] = kNotKnown;
      continue;
    }
    ++cycle.levels;
    cycle.width += difference;
    up_sigma += up.sigma[l];
    down_sigma += down.sigma[l];
  }
  cycle.width /= cycle.levels;
  cycle.sigma = std::hypot(up_sigma, down_sigma) / cycle.levels;
  return cycle;
}

void Summarise(Hysteresis& all) {
  double levels = 0;
  double sum = 0;
  double variance = 0;
  for (const HysteresisCycle& cycle : all.cycles) {
    levels += cycle.levels;
    sum += cycle.levels * cycle.width;
    variance += std::pow(cycle.levels * cycle.sigma, 2);
  }
  all.width = all.standard_error = all.half_95 = all.sigma = kNotKnown;
  if (all.cycles.empty()) return;
  all.width = sum / levels;
  all.sigma = std::sqrt(variance) / levels;
  const auto count = static_cast<double>(all.cycles.size());
  if (count < 2) return;
  double scatter = 0;
  for (const HysteresisCycle& cycle : all.cycles)
    scatter += std::pow(cycle.levels * (cycle.width - all.width), 2);
  all.standard_error = std::sqrt(scatter * count / (count - 1)) / levels;
  all.half_95 = all.standard_error * boost::math::quantile(boost::math::students_t(count - 1), 0.975);
}

}  // namespace

std::vector<DriveStroke> DriveStrokes(const Eigen::VectorXd& drive, double reversal) {
  std::vector<DriveStroke> strokes;
  // The last rows at which the drive was lowest and highest since the last turn. What is held at the end of a
  // stroke moves its turn along.
  Eigen::Index low = -1;
  Eigen::Index high = -1;
  int way = 0;  // +1 rising, -1 falling, 0 not known yet
  for (Eigen::Index i = 0; i < drive.size(); ++i) {
    if (std::isnan(drive[i])) continue;
    if (low < 0 || drive[i] <= drive[low]) low = i;
    if (high < 0 || drive[i] >= drive[high]) high = i;
    const bool turned_down = way >= 0 && drive[high] - drive[i] > reversal;
    const bool turned_up = way <= 0 && drive[i] - drive[low] > reversal;
    if (!turned_down && !turned_up) continue;
    const Eigen::Index turn = turned_down ? high : low;
    if (!strokes.empty()) strokes.back().last = turn;
    strokes.push_back({.first = turn + 1, .last = drive.size() - 1, .rises = turned_up});
    way = turned_up ? 1 : -1;
    low = high = i;
  }
  return strokes;
}

Hysteresis MeasureHysteresis(const Eigen::VectorXd& drive, const Eigen::VectorXd& response,
                             const Eigen::VectorXd& sigma, const HysteresisOptions& options) {
  TENDRIL_CHECK(drive.size() == response.size() && (sigma.size() == 0 || sigma.size() == drive.size()));
  TENDRIL_CHECK(options.levels >= 2 && options.reversal >= 0 && options.largest_gap >= 0);
  const Eigen::VectorXd known_sigma =
      sigma.size() > 0 ? sigma : Eigen::VectorXd::Constant(drive.size(), kNotKnown);
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (Eigen::Index i = 0; i < drive.size(); ++i) {
    if (!std::isfinite(drive[i]) || !std::isfinite(response[i])) continue;
    low = std::min(low, drive[i]);
    high = std::max(high, drive[i]);
  }
  Hysteresis all;
  Summarise(all);
  if (!(high > low)) return all;
  const double range = high - low;
  all.level = Eigen::VectorXd::LinSpaced(options.levels, low, high);
  all.strokes = DriveStrokes(drive, options.reversal * range);
  std::vector<Profile> profiles;
  for (const DriveStroke& stroke : all.strokes) {
    profiles.push_back(
        ProfileOf(stroke, drive, response, known_sigma, all.level, options.largest_gap * range));
  }
  int most = -1;
  for (const std::size_t from : {std::size_t{0}, std::size_t{1}}) {
    std::vector<HysteresisCycle> cycles;
    int levels = 0;
    for (std::size_t s = from; s + 1 < profiles.size(); s += 2) {
      HysteresisCycle cycle = Compare(all.strokes[s], all.strokes[s + 1], profiles[s], profiles[s + 1]);
      levels += cycle.levels;
      if (cycle.levels > 0) cycles.push_back(std::move(cycle));
    }
    if (levels <= most) continue;
    most = levels;
    all.cycles = std::move(cycles);
  }
  Summarise(all);
  return all;
}

double RowScatter(const Eigen::VectorXd& values) {
  std::vector<double> known;
  for (const double v : values) {
    if (std::isfinite(v)) known.push_back(v);
  }
  std::vector<double> third;
  for (std::size_t i = 3; i < known.size(); ++i) {
    third.push_back(std::abs(known[i] - 3 * known[i - 1] + 3 * known[i - 2] - known[i - 3]));
  }
  // sqrt(1 + 9 + 9 + 1) of one row's; a normal's median is 0.6745 of its standard deviation.
  return third.size() < 2 ? kNotKnown : Median(std::move(third)) / (0.6744897501960817 * std::sqrt(20.0));
}

}  // namespace tendril
