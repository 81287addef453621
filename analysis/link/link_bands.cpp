#include "analysis/link/link_bands.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "model/geometry/segment_distance.h"

namespace tendril {
namespace {

constexpr double kApart = 0.5;  // turns: modes lie a whole turn apart
constexpr double kAlong = 3;    // a bend brings places together, too; its arc is half as long

LinkBand BandOf(std::vector<double>& values) {
  LinkBand band;
  if (!std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); })) {
    const double none = std::numeric_limits<double>::quiet_NaN();
    band.mean = band.standard_deviation = band.low68 = band.high68 = band.low95 = band.high95 = none;
    return band;
  }
  std::sort(values.begin(), values.end());
  const auto count = static_cast<double>(values.size());
  for (const double v : values) band.mean += v / count;
  for (const double v : values) band.standard_deviation += (v - band.mean) * (v - band.mean) / (count - 1);
  band.standard_deviation = std::sqrt(band.standard_deviation);
  const auto quantile = [&](double p) {
    const double at = p * (count - 1);
    const auto low = static_cast<std::size_t>(at);
    const std::size_t high = std::min(low + 1, values.size() - 1);
    return values[low] + (at - static_cast<double>(low)) * (values[high] - values[low]);
  };
  band.low68 = quantile(0.16);
  band.high68 = quantile(0.84);
  band.low95 = quantile(0.025);
  band.high95 = quantile(0.975);
  for (std::size_t begin = 0; begin < values.size();) {
    std::size_t end = begin + 1;
    double sum = values[begin];
    for (; end < values.size() && values[end] - values[end - 1] <= kApart; ++end) sum += values[end];
    const auto size = static_cast<double>(end - begin);
    band.modes.push_back({sum / size, size / count});
    begin = end;
  }
  std::stable_sort(band.modes.begin(), band.modes.end(),
                   [](const LinkMode& a, const LinkMode& b) { return a.share > b.share; });
  return band;
}

Status Check(std::span<const FramedCurve> curves, std::span<const Eigen::MatrixXd> factors,
             std::span<const Eigen::MatrixXd> turns, int draws) {
  if (factors.size() != curves.size()) {
    return Error{ErrorKind::kBadInput, fmt::format("{} covariance factors for {} curves, expected one each",
                                                   factors.size(), curves.size())};
  }
  if (!turns.empty() && turns.size() != curves.size()) {
    return Error{ErrorKind::kBadInput, fmt::format("{} turn factors for {} curves, expected one each or none",
                                                   turns.size(), curves.size())};
  }
  for (std::size_t k = 0; k < turns.size(); ++k) {
    const Eigen::MatrixXd& turn = turns[k];
    if (turn.rows() == 0) continue;
    if (turn.rows() != curves[k].points.cols() || turn.cols() < factors[k].cols() || !turn.allFinite()) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("curve {}: a turn factor of {} x {}, expected {} rows and {} columns or more, "
                               "all finite",
                               k, turn.rows(), turn.cols(), curves[k].points.cols(), factors[k].cols())};
    }
  }
  for (std::size_t k = 0; k < curves.size(); ++k) {
    if (factors[k].rows() != 3 * curves[k].points.cols() || !factors[k].allFinite()) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("curve {}: a covariance factor of {} rows, expected {} finite ones", k,
                               factors[k].rows(), 3 * curves[k].points.cols())};
    }
  }
  if (draws < 2) {
    return Error{ErrorKind::kBadInput, fmt::format("{} draws, expected two or more", draws)};
  }
  return Ok{};
}

// A curve off by F z and G z.
FramedCurve DrawnCurve(const FramedCurve& curve, const Eigen::MatrixXd& factor, const Eigen::MatrixXd& turn,
                       std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Eigen::VectorXd z(std::max(factor.cols(), turn.cols()));
  for (double& number : z) number = normal(random);
  const Eigen::VectorXd off = factor * z.head(factor.cols());
  FramedCurve drawn = curve;
  drawn.points += Eigen::Map<const Eigen::Matrix3Xd>(off.data(), 3, curve.points.cols());
  if (turn.rows() == 0 || curve.normals.cols() != curve.points.cols() || curve.points.cols() < 2)
    return drawn;
  const Eigen::VectorXd angle = turn * z;
  const Eigen::Index last = curve.points.cols() - 1;
  for (Eigen::Index i = 0; i <= last; ++i) {
    const auto direction = [&](Eigen::Index from) {
      return (drawn.points.col(from + 1) - drawn.points.col(from)).stableNormalized();
    };
    const Eigen::Vector3d tangent =
        (direction(std::clamp<Eigen::Index>(i - 1, 0, last - 1)) + direction(std::min(i, last - 1)))
            .stableNormalized();
    const Eigen::Vector3d square = curve.normals.col(i) - tangent.dot(curve.normals.col(i)) * tangent;
    drawn.normals.col(i) = std::cos(angle[i]) * square + std::sin(angle[i]) * tangent.cross(square);
  }
  return drawn;
}

// Covariance of a point between two nodes, with itself.
Eigen::Matrix3d CovarianceAt(const Eigen::MatrixXd& factor, Eigen::Index node, double part) {
  const Eigen::MatrixXd rows =
      (1 - part) * factor.middleRows<3>(3 * node) + part * factor.middleRows<3>(3 * (node + 1));
  return rows * rows.transpose();
}

// What two places of one curve have in common: they move together.
Eigen::Matrix3d CovarianceBetween(const Eigen::MatrixXd& factor, Eigen::Index i, double s, Eigen::Index j,
                                  double t) {
  const Eigen::MatrixXd one = (1 - s) * factor.middleRows<3>(3 * i) + s * factor.middleRows<3>(3 * (i + 1));
  const Eigen::MatrixXd other = (1 - t) * factor.middleRows<3>(3 * j) + t * factor.middleRows<3>(3 * (j + 1));
  const Eigen::MatrixXd difference = one - other;
  return difference * difference.transpose();
}

// Keeps of candidates that are neighbours the one with the fewest sigmas.
void KeepNearest(std::vector<UndecidedCrossing>& found) {
  std::sort(found.begin(), found.end(), [](const UndecidedCrossing& x, const UndecidedCrossing& y) {
    return x.separation * y.sigma < y.separation * x.sigma;
  });
  std::vector<UndecidedCrossing> kept;
  for (const UndecidedCrossing& one : found) {
    const bool near = std::any_of(kept.begin(), kept.end(), [&](const UndecidedCrossing& other) {
      return one.a == other.a && one.b == other.b && std::abs(one.node_a - other.node_a) < 3 &&
             (one.b < 0 || std::abs(one.node_b - other.node_b) < 3);
    });
    if (!near) kept.push_back(one);
  }
  found = std::move(kept);
}

}  // namespace

std::vector<UndecidedCrossing> FindUndecided(std::span<const FramedCurve> curves,
                                             std::span<const Eigen::MatrixXd> factors,
                                             const std::optional<Axis>& axis, double sigmas) {
  std::vector<UndecidedCrossing> found;
  // A bound on a node's standard deviation in any direction: most pairs need no more.
  std::vector<Eigen::VectorXd> most(curves.size());
  for (std::size_t k = 0; k < curves.size(); ++k) {
    const Eigen::Index nodes = curves[k].points.cols();
    most[k].resize(nodes);
    for (Eigen::Index i = 0; i < nodes; ++i) most[k][i] = factors[k].middleRows<3>(3 * i).norm();
  }
  for (std::size_t a = 0; a < curves.size(); ++a) {
    const Eigen::Matrix3Xd& p = curves[a].points;
    for (std::size_t b = a; b < curves.size(); ++b) {
      const Eigen::Matrix3Xd& q = curves[b].points;
      const bool itself = a == b;
      for (Eigen::Index i = 0; i + 1 < p.cols(); ++i) {
        for (Eigen::Index j = itself ? i + 4 : 0; j + 1 < q.cols(); ++j) {
          const ClosestPoints closest = ClosestOfSegments(p.col(i), p.col(i + 1), q.col(j), q.col(j + 1));
          const double separation = closest.apart.norm();
          const double bound = std::max(most[a][i], most[a][i + 1]) + std::max(most[b][j], most[b][j + 1]);
          if (!(separation < sigmas * bound)) continue;
          if (itself &&
              (p.middleCols(i + 2, j - i - 1) - p.middleCols(i + 1, j - i - 1)).colwise().norm().sum() <
                  kAlong * separation) {
            continue;
          }
          const Eigen::Matrix3d covariance = itself
                                                 ? CovarianceBetween(factors[a], i, closest.s, j, closest.t)
                                                 : Eigen::Matrix3d(CovarianceAt(factors[a], i, closest.s) +
                                                                   CovarianceAt(factors[b], j, closest.t));
          const Eigen::Vector3d way =
              separation > 0 ? Eigen::Vector3d(closest.apart / separation) : Eigen::Vector3d::UnitX();
          const double sigma = std::sqrt(way.dot(covariance * way));
          if (!(separation < sigmas * sigma)) continue;
          found.push_back({static_cast<int>(a), static_cast<int>(b), static_cast<double>(i) + closest.s,
                           static_cast<double>(j) + closest.t, separation, sigma});
        }
      }
    }
    if (!axis) continue;
    const Eigen::Vector3d line = axis->direction.normalized();
    // Far enough to reach past the curve.
    const double reach = 10 * (p.colwise() - axis->point).colwise().norm().maxCoeff() + 1;
    const Eigen::Vector3d low = axis->point - reach * line, high = axis->point + reach * line;
    for (Eigen::Index i = 0; i + 1 < p.cols(); ++i) {
      const ClosestPoints closest = ClosestOfSegments(p.col(i), p.col(i + 1), low, high);
      const double separation = closest.apart.norm();
      const Eigen::Vector3d way =
          separation > 0 ? Eigen::Vector3d(closest.apart / separation) : line.unitOrthogonal();
      const double sigma = std::sqrt(way.dot(CovarianceAt(factors[a], i, closest.s) * way));
      if (!(separation < sigmas * sigma)) continue;
      found.push_back({static_cast<int>(a), -1, static_cast<double>(i) + closest.s, 0, separation, sigma});
    }
  }
  KeepNearest(found);
  return found;
}

Result<LinkBands> MeasureLinkBands(std::span<const FramedCurve> curves,
                                   std::span<const Eigen::MatrixXd> factors, const LinkOptions& options,
                                   const LinkBandOptions& band_options, const Progress& progress,
                                   std::span<const Eigen::MatrixXd> turns) {
  if (Status s = Check(curves, factors, turns, band_options.draws); !s.ok()) return s.error();
  const std::size_t count = curves.size(), pairs = count * (count - 1) / 2;
  const auto draws = static_cast<std::size_t>(band_options.draws);
  LinkOptions fast = options;
  fast.method = LinkMethod::kFast;
  // [value][draw]: three of each curve, two of each pair, three of all.
  std::vector<std::vector<double>> values(3 * count + 2 * pairs + 3, std::vector<double>(draws));
  std::mt19937_64 random(band_options.seed);
  std::vector<FramedCurve> drawn(curves.begin(), curves.end());
  LinkBands bands;
  bands.normals_drawn = !turns.empty();
  for (std::size_t k = 0; k < turns.size(); ++k) {
    if (turns[k].rows() == 0 && curves[k].normals.cols() > 0) bands.normals_drawn = false;
  }
  const Eigen::MatrixXd no_turn;
  for (std::size_t draw = 0; draw < draws; ++draw) {
    for (std::size_t k = 0; k < count; ++k) {
      drawn[k] = DrawnCurve(curves[k], factors[k], turns.empty() ? no_turn : turns[k], random);
    }
    Result<LinkReport> measured = MeasureLink(drawn, fast);
    if (!measured.ok()) return measured.error();
    const LinkReport& report = measured.value();
    std::size_t value = 0;
    for (const CurveLink& curve : report.curves) {
      values[value++][draw] = curve.writhe.value;
      values[value++][draw] = curve.self_link.value;
      values[value++][draw] = curve.object_link.value;
    }
    for (const PairLink& pair : report.pairs) {
      if (draw == 0) bands.pairs.push_back({pair.a, pair.b, {}, {}});
      values[value++][draw] = pair.link.value;
      values[value++][draw] = pair.gauss.value;
    }
    values[value++][draw] = report.mutual_link;
    values[value++][draw] = report.object_link;
    values[value++][draw] = report.performance;
    if (progress && !progress(static_cast<double>(draw + 1) / static_cast<double>(draws))) {
      return Error{ErrorKind::kStopped, fmt::format("stopped after draw {} of {}", draw + 1, draws)};
    }
  }
  std::size_t value = 0;
  const auto next = [&] { return BandOf(values[value++]); };
  for (std::size_t k = 0; k < count; ++k) {
    CurveBands& curve = bands.curves.emplace_back();
    curve.writhe = next();
    curve.self_link = next();
    curve.object_link = next();
  }
  for (PairBands& pair : bands.pairs) {
    pair.link = next();
    pair.gauss = next();
  }
  bands.mutual_link = next();
  bands.object_link = next();
  bands.performance = next();
  bands.undecided = FindUndecided(curves, factors, options.axis, band_options.undecided_sigmas);
  bands.draws = band_options.draws;
  return bands;
}

}  // namespace tendril
