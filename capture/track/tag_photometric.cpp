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

// Phi and phi at a fixed spacing, with the rest by Taylor's series to the third order: 1e-9.
class NormalTable {
 public:
  static const NormalTable& Get() {
    static const NormalTable table;
    return table;
  }
  // Share below z, and the density there.
  struct Normal {
    double share, density;
  };
  Normal At(double z) const {
    if (z <= -kReach) return {0, 0};
    if (z >= kReach) return {1, 0};
    const double scaled = (z + kReach) * kPerUnit;
    const int i = static_cast<int>(scaled + 0.5);
    const double d = z - (i * (1.0 / kPerUnit) - kReach), at = z - d;
    const double share = shares_[static_cast<std::size_t>(i)],
                 density = densities_[static_cast<std::size_t>(i)];
    // Derivatives of phi at `at`: -at phi, (at^2 - 1) phi, (3 at - at^3) phi.
    const double second = at * at - 1;
    return {share + density * d * (1 - d * (0.5 * at - d * (1. / 6) * second)),
            density * (1 - d * (at - d * (0.5 * second + d * (1. / 6) * (3 - at * at) * at)))};
  }

 private:
  static constexpr double kReach = 4.5;
  static constexpr int kPerUnit = 64, kSize = static_cast<int>(2 * kReach * kPerUnit) + 1;
  NormalTable() {
    for (int i = 0; i < kSize; ++i) {
      const double z = static_cast<double>(i) / kPerUnit - kReach;
      shares_[static_cast<std::size_t>(i)] = 0.5 * std::erfc(-z / std::numbers::sqrt2);
      densities_[static_cast<std::size_t>(i)] =
          std::exp(-0.5 * z * z) * std::numbers::inv_sqrtpi / std::numbers::sqrt2;
    }
  }
  std::array<double, kSize> shares_{}, densities_{};
};

// Rows of a pattern blurred along u, at a fixed spacing: value, slope and curvature.
struct Profiles {
  static constexpr int kPerModule = 32, kBeyond = 2;  // modules on either side
  int length = 0, rows = 0;
  std::vector<double> value, slope, curvature;  // [row][length]
  struct At {
    double value, slope, curvature;
  };

  void Make(const TagLook& look, double sigma) {
    const NormalTable& normal = NormalTable::Get();
    length = (look.modules + 2 * kBeyond) * kPerModule + 1;
    const std::size_t size = static_cast<std::size_t>(length) * look.steps.size();
    rows = static_cast<int>(look.steps.size());
    value.assign(size, 0);
    slope.assign(size, 0);
    curvature.assign(size, 0);
    const double inverse = 1 / sigma;
    const int reach = static_cast<int>(4.2 * sigma * kPerModule) + 1;
    for (std::size_t row = 0; row < look.steps.size(); ++row) {
      double* const v = value.data() + row * static_cast<std::size_t>(length);
      double* const s = slope.data() + row * static_cast<std::size_t>(length);
      double* const c = curvature.data() + row * static_cast<std::size_t>(length);
      double level = 0;
      int filled = 0;
      // Steps are whole modules apart, so they lie on the grid: every one has the same table.
      for (const TagLook::Step& step : look.steps[row]) {
        const int middle = static_cast<int>(std::lround((step.at + kBeyond) * kPerModule));
        for (; filled < std::min(middle, length); ++filled) v[filled] += level;
        level += step.rise;
        for (int i = std::max(0, middle - reach); i < std::min(length, middle + reach + 1); ++i) {
          const double z = (i - middle) * (inverse / kPerModule);
          const NormalTable::Normal n = normal.At(z);
          v[i] += step.rise * (i < middle ? n.share : n.share - 1);
          s[i] += step.rise * n.density * inverse;
          c[i] -= step.rise * n.density * z * inverse * inverse;
        }
      }
      for (; filled < length; ++filled) v[filled] += level;
    }
  }

  // Of the pattern's surround: nothing.
  At Look(int row, double u) const {
    if (row < 0 || row >= rows) return {0, 0, 0};
    const double scaled = (u + kBeyond) * kPerModule;
    const int i = std::clamp(static_cast<int>(scaled + 0.5), 0, length - 1);
    const double d =
        std::clamp(u - (static_cast<double>(i) / kPerModule - kBeyond), -1.0 / kPerModule, 1.0 / kPerModule);
    const auto at = static_cast<std::size_t>(row * length + i);
    return {value[at] + d * (slope[at] + 0.5 * d * curvature[at]), slope[at] + d * curvature[at],
            curvature[at]};
  }
};

// Across u the blur is cut at the rows' borders; along it, it is in the profiles.
class Seer {
 public:
  Seer(const TagLook& look, const Eigen::Matrix2d& covariance)
      : rows_(static_cast<int>(look.steps.size())),
        along_(covariance(0, 0)),
        both_(covariance(0, 1)),
        across_(covariance(1, 1)),
        sigma_(std::sqrt(across_)),
        lean_(both_ / across_) {
    profiles_.Make(look, std::sqrt(std::max(along_ - both_ * lean_, 1e-4)));
  }

  SeenTag See(double u, double v) const {
    const NormalTable& normal = NormalTable::Get();
    const int first = std::clamp(static_cast<int>(std::floor(v - 4 * sigma_)), -1, rows_);
    const int last = std::clamp(static_cast<int>(std::floor(v + 4 * sigma_)), first, rows_);
    SeenTag seen{};
    NormalTable::Normal above{0, 0};
    double uu = 0, uv = 0, vv = 0;
    for (int row = first; row <= last; ++row) {
      const double edge = row + 1 - v;  // of the row's lower border, from here
      const NormalTable::Normal below = row == last ? NormalTable::Normal{1, 0} : normal.At(edge / sigma_);
      const double share = below.share - above.share;
      if (share > 1e-9) {
        // Where in the row the blur's mass lies, and with it, how far along.
        const double mean = -sigma_ * (below.density - above.density) / share;
        const Profiles::At at = profiles_.Look(row, u + lean_ * mean);
        seen.white += share * at.value;
        seen.by_u += share * at.slope;
        uu += share * at.curvature;
      }
      if (row < last && below.density > 1e-12) {
        const double there = u + lean_ * edge;
        const Profiles::At here = profiles_.Look(row, there);
        const Profiles::At next = profiles_.Look(row + 1, there);
        const double density = below.density / sigma_, jump = next.value - here.value;
        const double steeper = next.slope - here.slope;
        seen.by_v += density * jump;
        uv += density * steeper;
        vv += density * (edge / across_ * jump - lean_ * steeper);
      }
      above = below;
    }
    seen.by_blur = along_ * uu + 2 * both_ * uv + across_ * vv;
    Surround(u, v, seen);
    return seen;
  }

 private:
  // As if the blur were the same along both sides: near the corners off by a little of a little.
  void Surround(double u, double v, SeenTag& seen) const {
    const double reach_u = 4.4 * std::sqrt(along_), reach_v = 4.4 * sigma_;
    if (u > reach_u && u < rows_ - reach_u && v > reach_v && v < rows_ - reach_v) return;
    const NormalTable& normal = NormalTable::Get();
    const double su = 1 / std::sqrt(along_), sv = 1 / sigma_;
    const NormalTable::Normal left = normal.At(-u * su), right = normal.At((rows_ - u) * su);
    const NormalTable::Normal top = normal.At(-v * sv), bottom = normal.At((rows_ - v) * sv);
    const double in_u = right.share - left.share, in_v = bottom.share - top.share;
    seen.surround = 1 - in_u * in_v;
    seen.surround_by_u = (right.density - left.density) * su * in_v;
    seen.surround_by_v = (bottom.density - top.density) * sv * in_u;
  }

  int rows_;
  double along_, both_, across_, sigma_, lean_;
  Profiles profiles_;
};

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

class Fit {
 public:
  Fit(const TagLook& look, const std::vector<Pixel>& pixels, const TagFitOptions& options)
      : look_(look), pixels_(pixels), options_(options), half_(0.5 * look.border_width) {}

  // Brightnesses that fit best where everything else is given.
  void StartContrast(Unknowns& x) const {
    const Eigen::Matrix3d g = Matrix(x).inverse();
    const auto [seer, fine] = SeerAt(x, g);
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

  // From now on the tag is nearly in its place, and its blur may be told. (Before, blur would make up for
  // what is out of place.)
  void ComeNear() { far_ = false; }
  bool far() const { return far_; }

  // Sum of squared residuals with the normal equations; infinite where the tag is degenerate.
  double Cost(const Unknowns& x, Normals* normals, Unknowns* gradient) const {
    const Eigen::Matrix3d tag_from_pixel = Matrix(x).inverse();
    const auto [seer, fine] = SeerAt(x, tag_from_pixel);
    if (!fine) return std::numeric_limits<double>::infinity();
    const double away = x[kBlur] - std::log(options_.blur_px), weight = PriorWeight();
    double cost = weight * away * away;
    if (normals != nullptr) {
      normals->setZero();
      gradient->setZero();
      (*normals)(kBlur, kBlur) += weight;
      (*gradient)[kBlur] += weight * away;
      // Where no pixel sees the surround, its brightness means nothing.
      (*normals)(kSurround, kSurround) += 1e-6;
    }
    const Eigen::Matrix3d& g = tag_from_pixel;
    Unknowns j;
    for (const Pixel& p : pixels_) {
      const double d = 1 / (g(2, 0) * p.x + g(2, 1) * p.y + g(2, 2));
      const double tx = d * (g(0, 0) * p.x + g(0, 1) * p.y + g(0, 2));
      const double ty = d * (g(1, 0) * p.x + g(1, 1) * p.y + g(1, 2));
      const SeenTag seen = seer.See(tx * half_ + 0.5 * look_.modules, ty * half_ + 0.5 * look_.modules);
      const double residual = x[kBlack] + x[kWhite] * seen.white + x[kSurround] * seen.surround - p.gray;
      cost += residual * residual;
      if (normals == nullptr) continue;
      // The pattern moves under the pixel: gray by pixel, then pixel by homography with its sign turned.
      const double by_tx = half_ * d * (x[kWhite] * seen.by_u + x[kSurround] * seen.surround_by_u);
      const double by_ty = half_ * d * (x[kWhite] * seen.by_v + x[kSurround] * seen.surround_by_v);
      const double by_x = by_tx * (g(0, 0) - tx * g(2, 0)) + by_ty * (g(1, 0) - ty * g(2, 0));
      const double by_y = by_tx * (g(0, 1) - tx * g(2, 1)) + by_ty * (g(1, 1) - ty * g(2, 1));
      const double s = 1 / (x[6] * tx + x[7] * ty + 1), cx = -s * by_x, cy = -s * by_y;
      const double bend = -(cx * p.x + cy * p.y);
      j << cx * tx, cx * ty, cx, cy * tx, cy * ty, cy, bend * tx, bend * ty, 1, seen.white, seen.surround,
          x[kWhite] * seen.by_blur;
      normals->selfadjointView<Eigen::Lower>().rankUpdate(j);
      *gradient += residual * j;
    }
    if (normals != nullptr) normals->triangularView<Eigen::StrictlyUpper>() = normals->transpose();
    return cost;
  }

 private:
  // A blur that is blur_spread off costs as much as a gray level's squared error.
  double PriorWeight() const { return (far_ ? 1000 : 9) / (options_.blur_spread * options_.blur_spread); }

  std::pair<Seer, bool> SeerAt(const Unknowns& x, const Eigen::Matrix3d& g) const {
    // The middle of the tag stands for all of it.
    const Eigen::Vector2d middle(x[2], x[5]);
    const double d = 1 / (g(2, 0) * middle.x() + g(2, 1) * middle.y() + g(2, 2));
    Eigen::Matrix2d j;
    j << g(0, 0) * d, g(0, 1) * d, g(1, 0) * d, g(1, 1) * d;
    const double blur = std::exp(x[kBlur]);
    const Eigen::Matrix2d spread = (half_ * half_ * blur * blur) * j * j.transpose();
    const bool fine = spread.allFinite() && spread(0, 0) < 4 && spread(1, 1) < 4 && spread(1, 1) > 1e-4;
    return {Seer(look_, fine ? spread : Eigen::Matrix2d(Eigen::Matrix2d::Identity())), fine};
  }

  const TagLook& look_;
  const std::vector<Pixel>& pixels_;
  const TagFitOptions& options_;
  double half_;
  bool far_ = true;
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
      const double ax = std::hypot(d * (g(0, 0) - tx * g(2, 0)), d * (g(0, 1) - tx * g(2, 1)));
      const double ay = std::hypot(d * (g(1, 0) - ty * g(2, 0)), d * (g(1, 1) - ty * g(2, 1)));
      if (std::abs(tx) > rim - kInside * blur * ax || std::abs(ty) > rim - kInside * blur * ay) continue;
      all += 1;
      if (u < 0 || v < 0 || u >= image.width || v >= image.height) continue;
      chosen.pixels.push_back(
          {px, py, static_cast<double>(image.pixels[static_cast<std::ptrdiff_t>(v) * image.stride + u])});
    }
  }
  chosen.share = all > 0 ? static_cast<double>(chosen.pixels.size()) / all : 0;
  return chosen;
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

Result<TagLook> LookOf(const std::string& family, int id) {
  const Result<TagFamily> known = FamilyOf(family);
  if (!known.ok()) return known.error();
  const Result<TagPattern> pattern = PatternOf(family, id);
  if (!pattern.ok()) return pattern.error();
  const TagPattern& p = pattern.value();
  TagLook look;
  look.modules = static_cast<int>(p.rows());
  look.border_width = known.value().border_width;
  for (Eigen::Index row = 0; row < p.rows(); ++row) {
    std::vector<TagLook::Step>& steps = look.steps.emplace_back();
    const auto white = [&](Eigen::Index c) { return c >= 0 && c < p.cols() && p(row, c) > 127 ? 1 : 0; };
    for (Eigen::Index c = 0; c <= p.cols(); ++c) {
      const int rise = white(c) - white(c - 1);
      if (rise != 0) steps.push_back({static_cast<double>(c), static_cast<double>(rise)});
    }
  }
  return look;
}

std::vector<SeenTag> SeeTag(const TagLook& look, const Eigen::Matrix2d& covariance,
                            const Eigen::Matrix2Xd& places) {
  const Seer seer(look, covariance);
  std::vector<SeenTag> seen;
  for (Eigen::Index i = 0; i < places.cols(); ++i) seen.push_back(seer.See(places(0, i), places(1, i)));
  return seen;
}

TagFit FitTag(const GrayImage& image, const TagLook& look, const Corners& corners_px,
              const TagFitOptions& options) {
  TagFit fit;
  const auto faulty = [&](TagFitFault fault) {
    fit.fault = fault;
    return fit;
  };
  fit.corners_px = corners_px;
  if (!corners_px.allFinite()) return faulty(TagFitFault::kTooSmall);
  const Eigen::Vector2d middle = corners_px.rowwise().mean();
  const Corners start = corners_px.colwise() - middle;
  const auto h = HomographyTo(start);
  if (!h || start.cwiseAbs().maxCoeff() > 2000) return faulty(TagFitFault::kTooSmall);
  Unknowns x;
  x << *h, 0, 0, 0, std::log(options.blur_px);
  const Chosen chosen = ChoosePixels(image, look, x, middle, options.blur_px);
  fit.pixels = static_cast<int>(chosen.pixels.size());
  if (chosen.share < 0.7) return faulty(TagFitFault::kOutside);
  if (fit.pixels < 4 * kUnknowns) return faulty(TagFitFault::kTooSmall);
  Fit problem(look, chosen.pixels, options);
  problem.StartContrast(x);
  Normals normals;
  Unknowns gradient;
  double cost = problem.Cost(x, &normals, &gradient), damping = 1e-3;
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
    const double next_cost = problem.Cost(next, &next_normals, &next_gradient);
    if (next_cost <= cost * (1 + 1e-12)) {
      x = next;
      cost = next_cost;
      normals = next_normals;
      gradient = next_gradient;
      damping = std::max(1e-7, 0.1 * damping);
      if (problem.far() && way.cwiseAbs().maxCoeff() < 0.2) {
        problem.ComeNear();
        cost = problem.Cost(x, &normals, &gradient);
      }
    } else {
      // Slopes are a little less exact than the cost: near the minimum they lead past it.
      settled = settled || (way.cwiseAbs().maxCoeff() < 0.02 && !problem.far());
      damping *= 10;
    }
  }
  const Corners found = CornersOf(x);
  fit.corners_px = found.colwise() + middle;
  fit.black = x[kBlack];
  fit.white = x[kBlack] + x[kWhite];
  fit.surround = x[kBlack] + x[kSurround];
  fit.blur_px = std::exp(x[kBlur]);
  const double variance = cost / std::max(1, fit.pixels - kUnknowns);
  fit.residual = std::sqrt(variance) / std::max(1.0, std::abs(x[kWhite]));
  if (!std::isfinite(cost) || !found.allFinite()) return faulty(TagFitFault::kNotSettled);
  if (!((found - start).colwise().norm().maxCoeff() <= options.largest_shift_px)) {
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

}  // namespace tendril
