#include "capture/track/tag_photometric.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "capture/track/tag_fit_problem.h"

namespace tendril {
namespace {

using namespace tag_fit;

// How a pixel moves with h0 .. h7.
Eigen::Matrix<double, 2, 8> ByHomography(double x, double y, double u, double v, double depth) {
  Eigen::Matrix<double, 2, 8> by;
  const double s = 1 / depth;
  by << s * x, s * y, s, 0, 0, 0, -s * u * x, -s * u * y,  //
      0, 0, 0, s * x, s * y, s, -s * v * x, -s * v * y;
  return by;
}

// Pixels whose light comes from the printed pattern, but for a sixth at most.
constexpr double kInside = 1;  // off its rim, standard deviations of the blur
struct Chosen {
  Pixels pixels;
  double share = 0;  // of them that lie in the picture
};
Chosen ChoosePixels(const GrayImage& image, const TagLook& look, const Unknowns& x,
                    const Eigen::Vector2d& middle, double blur) {
  const Eigen::Matrix3d h = Matrix(x), g = h.inverse();
  const double half = 0.5 * look.border_width, rim = 0.5 * look.modules / half;
  double low = 1e9, high = -1e9;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d p = h * Eigen::Vector3d(rim * kCornerX[i], rim * kCornerY[i], 1);
    low = std::min(low, p.y() / p.z());
    high = std::max(high, p.y() / p.z());
  }
  // What is kept off the rim, in tag coordinates: as in the middle.
  const double s = 1 / (g(2, 0) * x[2] + g(2, 1) * x[5] + g(2, 2));
  const double rim_x = rim - kInside * blur * s * std::hypot(g(0, 0), g(0, 1));
  const double rim_y = rim - kInside * blur * s * std::hypot(g(1, 0), g(1, 1));
  // Each side of the tag: the pixels p with side . (p, 1) >= 0 lie inside.
  const Eigen::RowVector3d sides[4] = {rim_x * g.row(2) + g.row(0), rim_x * g.row(2) - g.row(0),
                                       rim_y * g.row(2) + g.row(1), rim_y * g.row(2) - g.row(1)};
  Chosen chosen;
  Pixels& pixels = chosen.pixels;
  const double most = static_cast<double>(image.width) * image.height;
  const auto room = static_cast<std::size_t>(std::min(most, (high - low + 3) * (high - low + 3))) + 16;
  pixels.x.reserve(room);
  pixels.y.reserve(room);
  pixels.gray.reserve(room);
  long all = 0;
  const int top = static_cast<int>(std::floor(low + middle.y()));
  const int bottom = static_cast<int>(std::ceil(high + middle.y()));
  for (int v = top; v <= bottom; ++v) {
    const double py = v - middle.y();
    double left = -1e9, right = 1e9;
    for (const Eigen::RowVector3d& side : sides) {
      const double rest = side[1] * py + side[2];
      if (side[0] > 0) left = std::max(left, -rest / side[0]);
      if (side[0] < 0) right = std::min(right, -rest / side[0]);
      if (side[0] == 0 && rest < 0) right = left - 1;
    }
    if (!(left <= right) || left < -1e8 || right > 1e8) continue;
    int from = static_cast<int>(std::ceil(left + middle.x()));
    int to = static_cast<int>(std::floor(right + middle.x()));
    all += std::max(0, to - from + 1);
    if (v < 0 || v >= image.height) continue;
    from = std::max(from, 0);
    to = std::min(to, image.width - 1);
    const unsigned char* const row = image.pixels + static_cast<std::ptrdiff_t>(v) * image.stride;
    for (int u = from; u <= to; ++u) {
      pixels.x.push_back(static_cast<float>(u - middle.x()));
      pixels.y.push_back(static_cast<float>(py));
      pixels.gray.push_back(row[u]);
    }
  }
  pixels.count = static_cast<int>(pixels.x.size());
  const std::size_t whole = (pixels.x.size() + 15) / 16 * 16;
  pixels.x.resize(whole, 0);
  pixels.y.resize(whole, 0);
  pixels.gray.resize(whole, 0);
  chosen.share = all > 0 ? static_cast<double>(pixels.count) / static_cast<double>(all) : 0;
  return chosen;
}

// A fit before its first step.
struct Started {
  TagFit fit;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  Corners start = Corners::Zero();  // about the middle
  Unknowns x = Unknowns::Zero();
  Pixels pixels;
};
Started Start(const GrayImage& image, const TagLook& look, const Corners& corners_px,
              const TagFitOptions& options) {
  Started s;
  const auto faulty = [&](TagFitFault fault) {
    s.fit.fault = fault;
    return s;
  };
  s.fit.corners_px = corners_px;
  if (!corners_px.allFinite()) return faulty(TagFitFault::kTooSmall);
  s.middle = corners_px.rowwise().mean();
  s.start = corners_px.colwise() - s.middle;
  const auto h = HomographyTo(s.start);
  if (!h || s.start.cwiseAbs().maxCoeff() > 2000) return faulty(TagFitFault::kTooSmall);
  s.x << *h, 0, 0, 0, std::log(options.blur_px);
  Chosen chosen = ChoosePixels(image, look, s.x, s.middle, options.blur_px);
  s.fit.pixels = chosen.pixels.count;
  if (chosen.share < 0.7) return faulty(TagFitFault::kOutside);
  if (s.fit.pixels < 4 * kUnknowns) return faulty(TagFitFault::kTooSmall);
  s.pixels = std::move(chosen.pixels);
  return s;
}

// What no pixel's noise explains, of a corner in x and y: blur that is not normal, the table's steps; and
// where the residual is larger than a sensor's noise makes it (smear, glare, something before the tag), how
// far it may have drawn a corner.
constexpr double kFloor = 0.01;          // px
constexpr double kNoiseResidual = 0.03;  // of the contrast
constexpr double kPerResidual = 6;       // px per contrast

TagFit Settle(Started& started, Problem& problem, const TagFitOptions& options) {
  TagFit& fit = started.fit;
  Unknowns& x = started.x;
  const auto faulty = [&](TagFitFault fault) {
    fit.fault = fault;
    return fit;
  };
  problem.StartContrast(x);
  Normals normals;
  Unknowns gradient;
  double cost = problem.Cost(x, normals, gradient), damping = 1e-3;
  bool settled = false;
  while (fit.iterations < options.most_iterations && !settled && std::isfinite(cost)) {
    ++fit.iterations;
    Normals damped = normals;
    damped.diagonal() *= 1 + damping;
    const Unknowns step = damped.llt().solve(-gradient);
    if (!step.allFinite()) break;
    const Unknowns next = x + step;
    const Corners way = CornersOf(next) - CornersOf(x);
    if (!(way.cwiseAbs().maxCoeff() < 50)) break;
    // What is left to gain is less than a tenth of a corner's own uncertainty: not worth a look back.
    const double gain = -gradient.dot(step), noise = cost / std::max(1, fit.pixels - kUnknowns);
    settled = gain < options.settled_gain * noise && !problem.far();
    if (settled) {
      x = next;
      cost -= gain;
      break;
    }
    Normals next_normals;
    Unknowns next_gradient;
    const double next_cost = problem.Cost(next, next_normals, next_gradient);
    if (next_cost <= cost * (1 + 1e-12)) {
      x = next;
      cost = next_cost;
      normals = next_normals;
      gradient = next_gradient;
      damping = std::max(1e-7, 0.1 * damping);
      if (problem.far() && way.cwiseAbs().maxCoeff() < 0.2) {
        problem.ComeNear();
        cost = problem.Cost(x, normals, gradient);
      }
    } else {
      // Slopes are a little less exact than the cost: near the minimum they lead past it.
      settled = settled || (way.cwiseAbs().maxCoeff() < 0.02 && !problem.far());
      damping *= 10;
    }
  }
  const Corners found = CornersOf(x);
  fit.corners_px = found.colwise() + started.middle;
  fit.black = x[kBlack];
  fit.white = x[kBlack] + x[kWhite];
  fit.surround = x[kBlack] + x[kSurround];
  fit.blur_px = std::exp(x[kBlur]);
  const double variance = cost / std::max(1, fit.pixels - kUnknowns);
  fit.residual = std::sqrt(variance) / std::max(1.0, std::abs(x[kWhite]));
  if (!std::isfinite(cost) || !found.allFinite()) return faulty(TagFitFault::kNotSettled);
  if (!((found - started.start).colwise().norm().maxCoeff() <= options.largest_shift_px)) {
    return faulty(TagFitFault::kMoved);
  }
  if (!(x[kWhite] >= options.least_contrast)) return faulty(TagFitFault::kNoContrast);
  if (!(fit.residual <= options.largest_residual)) return faulty(TagFitFault::kNotThisTag);
  if (!settled) return faulty(TagFitFault::kNotSettled);
  Eigen::Matrix<double, 8, 8> by;
  for (int i = 0; i < 4; ++i) {
    const double depth = x[6] * kCornerX[i] + x[7] * kCornerY[i] + 1;
    by.middleRows<2>(2 * i) = ByHomography(kCornerX[i], kCornerY[i], found(0, i), found(1, i), depth);
  }
  const Normals inverse = normals.ldlt().solve(Normals::Identity());
  fit.covariance = variance * by * inverse.topLeftCorner<8, 8>() * by.transpose();
  const double hidden = kPerResidual * std::max(0.0, fit.residual - kNoiseResidual);
  fit.covariance.diagonal().array() += kFloor * kFloor + hidden * hidden;
  return fit;
}

}  // namespace

const char* NameOf(TagFitFault fault) {
  switch (fault) {
    case TagFitFault::kNone:
      return "none";
    case TagFitFault::kOutside:
      return "outside the picture";
    case TagFitFault::kTooSmall:
      return "too small";
    case TagFitFault::kNoContrast:
      return "no contrast";
    case TagFitFault::kMoved:
      return "moved too far";
    case TagFitFault::kNotThisTag:
      return "does not look like it";
    case TagFitFault::kNotSettled:
      return "did not settle";
  }
  return "none";
}

TagFit FitTag(const GrayImage& image, const TagLook& look, const Corners& corners_px,
              const TagFitOptions& options) {
  Started started = Start(image, look, corners_px, options);
  if (started.fit.fault != TagFitFault::kNone) return started.fit;
  const auto problem = MakePlainProblem(look, started.pixels, options);
  return Settle(started, *problem, options);
}

TagFit FitTag(const GrayImage& image, const TagLook& look, const Corners& corners_px,
              const TagFitOptions& options, TagFollow& follow) {
  Started started = Start(image, look, corners_px, options);
  if (started.fit.fault != TagFitFault::kNone) return started.fit;
  const auto problem = MakeTableProblem(look, started.pixels, options, follow, started.x);
  if (problem == nullptr) {
    const auto plain = MakePlainProblem(look, started.pixels, options);
    return Settle(started, *plain, options);
  }
  TagFit fit = Settle(started, *problem, options);
  const bool believed = fit.fault == TagFitFault::kNone;
  follow.black = believed ? fit.black : 0;
  follow.white = believed ? fit.white : 0;
  follow.surround = believed ? fit.surround : 0;
  return fit;
}

}  // namespace tendril
