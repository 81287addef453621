#include "capture/track/tag_refine.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace tendril {
namespace {

// A pixel beside an edge: how far along it (0 .. 1), how far outside of it (px), how bright.
struct EdgePixel {
  double along;
  double outside;
  double gray;
};

struct Line {
  Eigen::Vector2d at;
  Eigen::Vector2d along;  // unit
};

std::vector<EdgePixel> PixelsBeside(const GrayImage& image, const Eigen::Vector2d& a,
                                    const Eigen::Vector2d& b, const Eigen::Vector2d& outward, double inside,
                                    double outside, double end_margin) {
  std::vector<EdgePixel> pixels;
  const double length = (b - a).norm();
  const Eigen::Vector2d along = (b - a) / length;
  const double band = std::max(inside, outside);
  const double left = std::floor(std::min(a.x(), b.x()) - band);
  const double right = std::ceil(std::max(a.x(), b.x()) + band);
  const double top = std::floor(std::min(a.y(), b.y()) - band);
  const double bottom = std::ceil(std::max(a.y(), b.y()) + band);
  if (!(left >= 0 && top >= 0 && right < image.width && bottom < image.height)) return pixels;
  for (int v = static_cast<int>(top); v <= static_cast<int>(bottom); ++v) {
    const unsigned char* row = image.pixels + static_cast<std::ptrdiff_t>(v) * image.stride;
    for (int u = static_cast<int>(left); u <= static_cast<int>(right); ++u) {
      const Eigen::Vector2d from_a(u - a.x(), v - a.y());
      const double s = from_a.dot(along) / length;
      const double e = from_a.dot(outward);
      if (e < -inside || e > outside || s < end_margin || s > 1 - end_margin) continue;
      pixels.push_back({s, e, static_cast<double>(row[u])});
    }
  }
  return pixels;
}

using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;

// Sum of squared residuals of gray = inside + step * Phi((outside - offset(along)) / blur) over the
// parameters (offset at a, offset at b, inside, step, log blur), with the normal equations where asked for.
double EdgeCost(const std::vector<EdgePixel>& pixels, const Vector5& x, Matrix5* hessian, Vector5* gradient) {
  const double blur = std::exp(x[4]);
  // On the smallest tags few pixels tell blur from contrast; a lens in focus blurs by about 0.7 px.
  constexpr double kBlurWeight = 30;  // gray levels per e-fold
  const double from_usual = kBlurWeight * (x[4] - std::log(0.7));
  double cost = from_usual * from_usual;
  if (hessian != nullptr) {
    (*hessian)(4, 4) += kBlurWeight * kBlurWeight;
    (*gradient)[4] += kBlurWeight * from_usual;
  }
  for (const EdgePixel& p : pixels) {
    const double z = (p.outside - x[0] * (1 - p.along) - x[1] * p.along) / blur;
    const double share = 0.5 * std::erfc(-z / std::numbers::sqrt2);
    const double residual = x[2] + x[3] * share - p.gray;
    cost += residual * residual;
    if (hessian == nullptr) continue;
    const double slope = x[3] * std::exp(-0.5 * z * z) * std::numbers::inv_sqrtpi / std::numbers::sqrt2;
    Vector5 j;
    j << -slope * (1 - p.along) / blur, -slope * p.along / blur, 1, share, -slope * z;
    *hessian += j * j.transpose();
    *gradient += residual * j;
  }
  return cost;
}

// Offsets of the edge at its two ends, px outward, by Levenberg-Marquardt.
std::optional<Eigen::Vector2d> FitEdge(const std::vector<EdgePixel>& pixels) {
  constexpr double kSmallestStep = 5;  // gray levels
  double inside = 0;
  double outside = 0;
  int inside_count = 0;
  for (const EdgePixel& p : pixels) {
    (p.outside < 0 ? inside : outside) += p.gray;
    inside_count += p.outside < 0 ? 1 : 0;
  }
  const int outside_count = static_cast<int>(pixels.size()) - inside_count;
  if (inside_count < 5 || outside_count < 5) return std::nullopt;
  inside /= inside_count;
  outside /= outside_count;
  Vector5 at;
  at << 0, 0, inside, outside - inside, std::log(0.7);
  if (!(at[3] > kSmallestStep)) return std::nullopt;  // the border is darker than its surround

  double damping = 1e-3;
  double cost = EdgeCost(pixels, at, nullptr, nullptr);
  for (int iteration = 0; iteration < 15; ++iteration) {
    Matrix5 hessian = Matrix5::Zero();
    Vector5 gradient = Vector5::Zero();
    EdgeCost(pixels, at, &hessian, &gradient);
    bool better = false;
    Vector5 step = Vector5::Zero();
    for (int trial = 0; trial < 6 && !better; ++trial) {
      Matrix5 damped = hessian;
      damped.diagonal() = damped.diagonal() * (1 + damping) + Vector5::Constant(1e-9);
      step = damped.ldlt().solve(-gradient);
      const Vector5 next = at + step;
      if (next.allFinite() && std::abs(next[4]) < 3) {
        const double next_cost = EdgeCost(pixels, next, nullptr, nullptr);
        if (next_cost < cost) {
          at = next;
          cost = next_cost;
          better = true;
        }
      }
      damping = better ? std::max(1e-9, damping * 0.1) : damping * 10;
    }
    if (!better || step.head<2>().cwiseAbs().maxCoeff() < 1e-4) break;
  }
  if (!(at[3] > kSmallestStep) || !at.allFinite()) return std::nullopt;
  return Eigen::Vector2d(at[0], at[1]);
}

std::optional<Eigen::Vector2d> Meet(const Line& a, const Line& b) {
  const double sine = a.along.x() * b.along.y() - a.along.y() * b.along.x();
  if (std::abs(sine) < 0.05) return std::nullopt;
  const Eigen::Vector2d apart = b.at - a.at;
  return a.at + a.along * ((apart.x() * b.along.y() - apart.y() * b.along.x()) / sine);
}

}  // namespace

std::optional<Eigen::Matrix<double, 2, 4>> RefineTagCorners(const GrayImage& image,
                                                            const Eigen::Matrix<double, 2, 4>& corners_px,
                                                            int border_width,
                                                            const TagRefineOptions& options) {
  const Eigen::Vector2d center = corners_px.rowwise().mean();
  std::array<Line, 4> lines;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector2d a = corners_px.col(i);
    const Eigen::Vector2d b = corners_px.col((i + 1) % 4);
    const double length = (b - a).norm();
    if (!(length > 1)) return std::nullopt;
    const Eigen::Vector2d along = (b - a) / length;
    Eigen::Vector2d outward(along.y(), -along.x());
    if (outward.dot(center - a) > 0) outward = -outward;
    // A module's extent across the edge, from the tag's height over it.
    const double height = 0.5 * (std::abs(outward.dot(corners_px.col((i + 2) % 4) - a)) +
                                 std::abs(outward.dot(corners_px.col((i + 3) % 4) - a)));
    const double inside = std::min(options.band_inside * height / border_width, options.largest_band_px);
    const double outside = std::min(options.band_outside * height / border_width, options.largest_band_px);
    const double end = (options.corner_margin + options.band_outside) / border_width;
    const auto offsets = FitEdge(PixelsBeside(image, a, b, outward, inside, outside, end));
    if (!offsets || offsets->cwiseAbs().maxCoeff() > options.largest_shift_px) return std::nullopt;
    const Eigen::Vector2d from = a + outward * offsets->x();
    const Eigen::Vector2d to = b + outward * offsets->y();
    lines[static_cast<size_t>(i)] = {from, (to - from).normalized()};
  }
  Eigen::Matrix<double, 2, 4> refined;
  for (int i = 0; i < 4; ++i) {
    const auto corner = Meet(lines[static_cast<size_t>((i + 3) % 4)], lines[static_cast<size_t>(i)]);
    if (!corner || !((*corner - corners_px.col(i)).norm() <= 1.5 * options.largest_shift_px))
      return std::nullopt;
    refined.col(i) = *corner;
  }
  return refined;
}

}  // namespace tendril
