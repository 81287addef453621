#include "capture/track/tag_photometric.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

namespace tendril {
namespace {

// Eight of the homography; black, what white and the surround are brighter; the blur's logarithm.
constexpr int kUnknowns = 12, kBlack = 8, kWhite = 9, kSurround = 10, kBlur = 11;
using Normals = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Corners = Eigen::Matrix<double, 2, 4>;

constexpr double kCornerX[4] = {-1, 1, 1, -1}, kCornerY[4] = {1, 1, -1, -1};

// From tag coordinates (corners at +-1) to pixels: h0 .. h7, with h8 = 1.
std::optional<Eigen::Matrix<double, 8, 1>> HomographyTo(const Corners& corners) {
  Eigen::Matrix<double, 8, 8> a;
  Eigen::Matrix<double, 8, 1> b;
  for (int i = 0; i < 4; ++i) {
    const double x = kCornerX[i], y = kCornerY[i], u = corners(0, i), v = corners(1, i);
    a.row(2 * i) << x, y, 1, 0, 0, 0, -u * x, -u * y;
    a.row(2 * i + 1) << 0, 0, 0, x, y, 1, -v * x, -v * y;
    b.segment<2>(2 * i) << u, v;
  }
  const Eigen::FullPivLU<Eigen::Matrix<double, 8, 8>> lu(a);
  if (!lu.isInvertible()) return std::nullopt;
  const Eigen::Matrix<double, 8, 1> h = lu.solve(b);
  // The whole tag lies before the camera.
  for (int i = 0; i < 4; ++i) {
    if (!(h[6] * kCornerX[i] + h[7] * kCornerY[i] + 1 > 0.2)) return std::nullopt;
  }
  return h;
}

Eigen::Matrix3d Matrix(const Unknowns& x) {
  Eigen::Matrix3d m;
  m << x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], 1;
  return m;
}

Corners CornersOf(const Unknowns& x) {
  Corners corners;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d p = Matrix(x) * Eigen::Vector3d(kCornerX[i], kCornerY[i], 1);
    corners.col(i) = p.head<2>() / p.z();
  }
  return corners;
}

// How a pixel moves with h0 .. h7.
Eigen::Matrix<double, 2, 8> ByHomography(double x, double y, double u, double v, double depth) {
  Eigen::Matrix<double, 2, 8> by;
  const double s = 1 / depth;
  by << s * x, s * y, s, 0, 0, 0, -s * u * x, -s * u * y,  //
      0, 0, 0, s * x, s * y, s, -s * v * x, -s * v * y;
  return by;
}

struct Pixel {
  double x, y;  // from the tag's middle
  double gray;
};

Eigen::Matrix2d BlurOf(const Unknowns& x, const Eigen::Matrix3d& tag_from_pixel, double half, double blur) {
  // The middle of the tag stands for all of it.
  const Eigen::Matrix3d& g = tag_from_pixel;
  const double d = 1 / (g(2, 0) * x[2] + g(2, 1) * x[5] + g(2, 2));
  Eigen::Matrix2d j;
  j << g(0, 0) * d, g(0, 1) * d, g(1, 0) * d, g(1, 1) * d;
  return (half * half * blur * blur) * j * j.transpose();
}
bool IsFine(const Eigen::Matrix2d& blur) {
  return blur.allFinite() && blur(0, 0) < 4 && blur(1, 1) < 4 && blur(0, 0) > 1e-4 && blur(1, 1) > 1e-4;
}

// Sums of squared residuals and their normal equations.
class Problem {
 public:
  Problem(const TagLook& look, const std::vector<Pixel>& pixels, const TagFitOptions& options)
      : look_(look), pixels_(pixels), options_(options), half_(0.5 * look.border_width) {}
  virtual ~Problem() = default;

  // From now on the tag is nearly in its place, and its blur may be told. (Before, blur would make up for
  // what is out of place.)
  void ComeNear() { far_ = false; }
  bool far() const { return far_; }

  // Brightnesses that fit best where everything else is given.
  virtual void StartContrast(Unknowns& x) const = 0;
  // Infinite where the tag is degenerate.
  virtual double Cost(const Unknowns& x, Normals& normals, Unknowns& gradient) = 0;

 protected:
  // A blur that is blur_spread off costs as much as a gray level's squared error.
  double Prior(const Unknowns& x, Normals& normals, Unknowns& gradient) const {
    const double weight = (far_ ? 1000 : 9) / (options_.blur_spread * options_.blur_spread);
    const double away = x[kBlur] - std::log(options_.blur_px);
    normals(kBlur, kBlur) += weight;
    gradient[kBlur] += weight * away;
    // Where no pixel sees the surround, its brightness means nothing.
    normals(kSurround, kSurround) += 1e-6;
    return weight * away * away;
  }

  const TagLook& look_;
  const std::vector<Pixel>& pixels_;
  const TagFitOptions& options_;
  double half_;

 private:
  bool far_ = true;
};

// A row of the Jacobian: how what a pixel sees changes with the unknowns. The pattern moves under the pixel:
// gray by pixel, then pixel by homography with its sign turned.
//   g       tag_from_pixel
//   tx, ty  where the pixel is in the tag; s the inverse of its depth there
template <class S, class Seen>
inline void RowOf(const S* x, const S* g, S half, S px, S py, S tx, S ty, S s, const Seen& seen, S* row) {
  const S d = 1 / s;
  const S by_tx = half * d * (x[kWhite] * seen.by_u + x[kSurround] * seen.surround_by_u);
  const S by_ty = half * d * (x[kWhite] * seen.by_v + x[kSurround] * seen.surround_by_v);
  const S by_x = by_tx * (g[0] - tx * g[6]) + by_ty * (g[3] - ty * g[6]);
  const S by_y = by_tx * (g[1] - tx * g[7]) + by_ty * (g[4] - ty * g[7]);
  const S cx = -s * by_x, cy = -s * by_y;
  const S bend = -(cx * px + cy * py);
  const S all[kUnknowns] = {cx * tx,   cx * ty,   cx, cy * tx,    cy * ty,       cy,
                            bend * tx, bend * ty, 1,  seen.white, seen.surround, x[kWhite] * seen.by_blur};
  std::copy_n(all, kUnknowns, row);
}

// By TagSeer in double precision.
class PlainProblem : public Problem {
 public:
  using Problem::Problem;

  void StartContrast(Unknowns& x) const override {
    const Eigen::Matrix3d g = Matrix(x).inverse();
    const Eigen::Matrix2d blur = BlurOf(x, g, half_, std::exp(x[kBlur]));
    if (!IsFine(blur)) return;
    const TagSeer seer(look_, blur);
    Eigen::Matrix3d normals = Eigen::Vector3d(0, 0, 1e-6).asDiagonal();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Pixel& p : pixels_) {
      const double d = half_ / (g(2, 0) * p.x + g(2, 1) * p.y + g(2, 2));
      const SeenTag seen = seer.See(d * (g(0, 0) * p.x + g(0, 1) * p.y + g(0, 2)) + 0.5 * look_.modules,
                                    d * (g(1, 0) * p.x + g(1, 1) * p.y + g(1, 2)) + 0.5 * look_.modules);
      const Eigen::Vector3d j(1, seen.white, seen.surround);
      normals += j * j.transpose();
      right += p.gray * j;
    }
    x.segment<3>(kBlack) = normals.ldlt().solve(right);
  }

  double Cost(const Unknowns& x, Normals& normals, Unknowns& gradient) override {
    const Eigen::Matrix3d inverse = Matrix(x).inverse();
    const Eigen::Matrix2d blur = BlurOf(x, inverse, half_, std::exp(x[kBlur]));
    if (!IsFine(blur)) return std::numeric_limits<double>::infinity();
    const TagSeer seer(look_, blur);
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rows = inverse;
    const double* const g = rows.data();
    normals.setZero();
    gradient.setZero();
    double cost = Prior(x, normals, gradient);
    Unknowns j;
    for (const Pixel& p : pixels_) {
      const double s = g[6] * p.x + g[7] * p.y + g[8];
      const double tx = (g[0] * p.x + g[1] * p.y + g[2]) / s, ty = (g[3] * p.x + g[4] * p.y + g[5]) / s;
      const SeenTag seen = seer.See(tx * half_ + 0.5 * look_.modules, ty * half_ + 0.5 * look_.modules);
      const double residual = x[kBlack] + x[kWhite] * seen.white + x[kSurround] * seen.surround - p.gray;
      cost += residual * residual;
      RowOf(x.data(), g, half_, p.x, p.y, tx, ty, s, seen, j.data());
      normals.selfadjointView<Eigen::Lower>().rankUpdate(j);
      gradient += residual * j;
    }
    normals.triangularView<Eigen::StrictlyUpper>() = normals.transpose();
    return cost;
  }
};

// By a TagTable in single precision.
class TableProblem : public Problem {
 public:
  TableProblem(const TagLook& look, const std::vector<Pixel>& pixels, const TagFitOptions& options,
               TagFollow& follow)
      : Problem(look, pixels, options),
        follow_(follow),
        rows_(kUnknowns + 1, static_cast<Eigen::Index>(pixels.size())) {}

  // Makes the table anew where it must; false: the tag is degenerate.
  bool Prepare(const Unknowns& x) {
    const Eigen::Matrix2d blur = BlurOf(x, Matrix(x).inverse(), half_, options_.blur_px);
    if (!IsFine(blur)) return false;
    if (!follow_.table.Serves(blur)) follow_.table.Make(look_, blur);
    if (follow_.white - follow_.black > 0) ComeNear();
    return true;
  }

  void StartContrast(Unknowns& x) const override {
    Eigen::Matrix3d normals = Eigen::Vector3d(0, 0, 1e-6).asDiagonal();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    if (follow_.white - follow_.black > 0) {
      x.segment<3>(kBlack) << follow_.black, follow_.white - follow_.black, follow_.surround - follow_.black;
      return;
    }
    ForEach(x, [&](const Pixel& p, float, float, float, const TagTable::Seen& seen) {
      const Eigen::Vector3d j(1, seen.white, seen.surround);
      normals += j * j.transpose();
      right += p.gray * j;
    });
    x.segment<3>(kBlack) = normals.ldlt().solve(right);
  }

  double Cost(const Unknowns& x, Normals& normals, Unknowns& gradient) override {
    const Eigen::Matrix<float, kUnknowns, 1> xf = x.cast<float>();
    const Eigen::Matrix<float, 3, 3, Eigen::RowMajor> g = Matrix(x).inverse().cast<float>();
    const float half = static_cast<float>(half_);
    // What blur has come to since the table's, to the first order.
    const float change = static_cast<float>(x[kBlur] - std::log(options_.blur_px));
    float* row = rows_.data();
    ForEach(x, [&](const Pixel& p, float tx, float ty, float s, const TagTable::Seen& as_made) {
      TagTable::Seen seen = as_made;
      seen.white += change * seen.by_blur;
      const float px = static_cast<float>(p.x), py = static_cast<float>(p.y);
      RowOf(xf.data(), g.data(), half, px, py, tx, ty, s, seen, row);
      row[kUnknowns] =
          xf[kBlack] + xf[kWhite] * seen.white + xf[kSurround] * seen.surround - static_cast<float>(p.gray);
      row += kUnknowns + 1;
    });
    // Sums of products of all columns at once.
    sums_.noalias() = rows_ * rows_.transpose();
    normals = sums_.topLeftCorner<kUnknowns, kUnknowns>().cast<double>();
    gradient = sums_.col(kUnknowns).head<kUnknowns>().cast<double>();
    const double cost = sums_(kUnknowns, kUnknowns);
    return cost + Prior(x, normals, gradient);
  }

 private:
  template <class Work>
  void ForEach(const Unknowns& x, const Work& work) const {
    const Eigen::Matrix3f g = Matrix(x).inverse().cast<float>();
    const float half = static_cast<float>(half_), middle = 0.5f * static_cast<float>(look_.modules);
    for (const Pixel& p : pixels_) {
      const float px = static_cast<float>(p.x), py = static_cast<float>(p.y);
      const float s = g(2, 0) * px + g(2, 1) * py + g(2, 2), d = 1 / s;
      const float tx = d * (g(0, 0) * px + g(0, 1) * py + g(0, 2));
      const float ty = d * (g(1, 0) * px + g(1, 1) * py + g(1, 2));
      work(p, tx, ty, s, follow_.table.See(tx * half + middle, ty * half + middle));
    }
  }

  TagFollow& follow_;
  Eigen::Matrix<float, kUnknowns + 1, Eigen::Dynamic> rows_;
  Eigen::Matrix<float, kUnknowns + 1, kUnknowns + 1> sums_;
};

// Pixels whose light comes from the printed pattern, but for a sixth at most.
constexpr double kInside = 1;  // off its rim, standard deviations of the blur
struct Chosen {
  std::vector<Pixel> pixels;
  double share = 0;  // of them that lie in the picture
};
Chosen ChoosePixels(const GrayImage& image, const TagLook& look, const Unknowns& x,
                    const Eigen::Vector2d& middle, double blur) {
  const Eigen::Matrix3d h = Matrix(x), g = h.inverse();
  const double half = 0.5 * look.border_width, rim = 0.5 * look.modules / half;
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d p = h * Eigen::Vector3d(rim * kCornerX[i], rim * kCornerY[i], 1);
    low = low.cwiseMin(p.head<2>() / p.z());
    high = high.cwiseMax(p.head<2>() / p.z());
  }
  // What is kept off the rim, in tag coordinates: as in the middle.
  const double s = 1 / (g(2, 0) * x[2] + g(2, 1) * x[5] + g(2, 2));
  const double rim_x = rim - kInside * blur * s * std::hypot(g(0, 0), g(0, 1));
  const double rim_y = rim - kInside * blur * s * std::hypot(g(1, 0), g(1, 1));
  Chosen chosen;
  double all = 0;
  const Eigen::Vector2i from = (low + middle).array().floor().cast<int>();
  const Eigen::Vector2i to = (high + middle).array().ceil().cast<int>();
  for (int v = from.y(); v <= to.y(); ++v) {
    for (int u = from.x(); u <= to.x(); ++u) {
      const double px = u - middle.x(), py = v - middle.y();
      const double d = 1 / (g(2, 0) * px + g(2, 1) * py + g(2, 2));
      const double tx = d * (g(0, 0) * px + g(0, 1) * py + g(0, 2));
      const double ty = d * (g(1, 0) * px + g(1, 1) * py + g(1, 2));
      if (std::abs(tx) > rim_x || std::abs(ty) > rim_y) continue;
      all += 1;
      if (u < 0 || v < 0 || u >= image.width || v >= image.height) continue;
      chosen.pixels.push_back(
          {px, py, static_cast<double>(image.pixels[static_cast<std::ptrdiff_t>(v) * image.stride + u])});
    }
  }
  chosen.share = all > 0 ? static_cast<double>(chosen.pixels.size()) / all : 0;
  return chosen;
}

// A fit before its first step.
struct Started {
  TagFit fit;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  Corners start = Corners::Zero();  // about the middle
  Unknowns x = Unknowns::Zero();
  std::vector<Pixel> pixels;
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
  s.fit.pixels = static_cast<int>(chosen.pixels.size());
  if (chosen.share < 0.7) return faulty(TagFitFault::kOutside);
  if (s.fit.pixels < 4 * kUnknowns) return faulty(TagFitFault::kTooSmall);
  s.pixels = std::move(chosen.pixels);
  return s;
}

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
    const Unknowns step = damped.ldlt().solve(-gradient);
    if (!step.allFinite()) break;
    const Unknowns next = x + step;
    const Corners way = CornersOf(next) - CornersOf(x);
    if (!(way.cwiseAbs().maxCoeff() < 50)) break;
    // What is left to gain is less than a tenth of a corner's own uncertainty.
    const double gain = -gradient.dot(step), noise = cost / std::max(1, fit.pixels - kUnknowns);
    settled = gain < options.settled_gain * noise && !problem.far();
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
  PlainProblem problem(look, started.pixels, options);
  return Settle(started, problem, options);
}

TagFit FitTag(const GrayImage& image, const TagLook& look, const Corners& corners_px,
              const TagFitOptions& options, TagFollow& follow) {
  Started started = Start(image, look, corners_px, options);
  if (started.fit.fault != TagFitFault::kNone) return started.fit;
  TableProblem problem(look, started.pixels, options, follow);
  if (!problem.Prepare(started.x)) {
    started.fit.fault = TagFitFault::kTooSmall;
    return started.fit;
  }
  TagFit fit = Settle(started, problem, options);
  const bool believed = fit.fault == TagFitFault::kNone;
  follow.black = believed ? fit.black : 0;
  follow.white = believed ? fit.white : 0;
  follow.surround = believed ? fit.surround : 0;
  return fit;
}

}  // namespace tendril
