#include "capture/track/tag_look.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

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

}  // namespace

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

void TagProfiles::Make(const TagLook& look, double sigma, int places, int around) {
  const NormalTable& normal = NormalTable::Get();
  per_module = places;
  beyond = around;
  length = (look.modules + 2 * beyond) * per_module + 1;
  rows = static_cast<int>(look.steps.size());
  const std::size_t size = static_cast<std::size_t>(length) * look.steps.size();
  value.assign(size, 0);
  slope.assign(size, 0);
  curvature.assign(size, 0);
  const double inverse = 1 / sigma;
  const int reach = static_cast<int>(4.2 * sigma * per_module) + 1;
  // Steps are whole modules apart, so they lie on the grid: every one has the same table.
  std::vector<NormalTable::Normal> step_table;
  for (int i = -reach; i <= reach; ++i) step_table.push_back(normal.At(i * (inverse / per_module)));
  for (std::size_t row = 0; row < look.steps.size(); ++row) {
    double* const v = value.data() + row * static_cast<std::size_t>(length);
    double* const s = slope.data() + row * static_cast<std::size_t>(length);
    double* const c = curvature.data() + row * static_cast<std::size_t>(length);
    double level = 0;
    int filled = 0;
    for (const TagLook::Step& step : look.steps[row]) {
      const int middle = static_cast<int>(std::lround((step.at + beyond) * per_module));
      for (; filled < std::min(middle, length); ++filled) v[filled] += level;
      level += step.rise;
      for (int i = std::max(0, middle - reach); i < std::min(length, middle + reach + 1); ++i) {
        const NormalTable::Normal n = step_table[static_cast<std::size_t>(i - middle + reach)];
        v[i] += step.rise * (i < middle ? n.share : n.share - 1);
        s[i] += step.rise * n.density * inverse;
        c[i] -= step.rise * n.density * (i - middle) * (inverse / per_module) * inverse * inverse;
      }
    }
    for (; filled < length; ++filled) v[filled] += level;
  }
}

// Of the pattern's surround: nothing.
TagProfiles::At TagProfiles::Look(int row, double u) const {
  if (row < 0 || row >= rows) return {0, 0, 0};
  const double scaled = (u + beyond) * per_module, spacing = 1.0 / per_module;
  const int i = std::clamp(static_cast<int>(scaled + 0.5), 0, length - 1);
  const double d = std::clamp(u - (i * spacing - beyond), -spacing, spacing);
  const auto at = static_cast<std::size_t>(row * length + i);
  return {value[at] + d * (slope[at] + 0.5 * d * curvature[at]), slope[at] + d * curvature[at],
          curvature[at]};
}

TagSeer::TagSeer(const TagLook& look, const Eigen::Matrix2d& covariance)
    : rows_(static_cast<int>(look.steps.size())),
      along_(covariance(0, 0)),
      both_(covariance(0, 1)),
      across_(covariance(1, 1)),
      sigma_(std::sqrt(across_)),
      lean_(both_ / across_) {
  profiles_.Make(look, std::sqrt(std::max(along_ - both_ * lean_, 1e-4)), 32, 2);
}

SeenTag TagSeer::See(double u, double v) const {
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
      const TagProfiles::At at = profiles_.Look(row, u + lean_ * mean);
      seen.white += share * at.value;
      seen.by_u += share * at.slope;
      uu += share * at.curvature;
    }
    if (row < last && below.density > 1e-12) {
      const double there = u + lean_ * edge;
      const TagProfiles::At here = profiles_.Look(row, there);
      const TagProfiles::At next = profiles_.Look(row + 1, there);
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

// As if the blur were the same along both sides: near the corners off by a little of a little.
void TagSeer::Surround(double u, double v, SeenTag& seen) const {
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

bool TagTable::Serves(const Eigen::Matrix2d& covariance) const {
  return side_ > 0 && (covariance - covariance_).cwiseAbs().maxCoeff() <= 0.05 * covariance_.trace();
}

void TagTable::Make(const TagLook& look, const Eigen::Matrix2d& covariance) {
  covariance_ = covariance;
  side_ = (look.modules + 1) * kPerModule + 1;
  const double along = covariance(0, 0), both = covariance(0, 1), across = covariance(1, 1);
  const double sigma = std::sqrt(across), lean = both / across;
  TagProfiles profiles;
  constexpr int kBeyond = 3;
  profiles.Make(look, std::sqrt(std::max(along - both * lean, 1e-4)), kPerModule, kBeyond);
  const NormalTable& normal = NormalTable::Get();
  const auto n = static_cast<std::size_t>(side_);
  // Of one row of places: shares of white, by u, by v, and the three second derivatives.
  std::vector<float> rows(6 * n);
  float *const white = rows.data(), *const by_u = white + n, *const by_v = by_u + n, *const uu = by_v + n;
  float *const uv = uu + n, *const vv = uv + n;
  // Profiles in single precision, with rows of nothing before and behind.
  const auto length = static_cast<std::size_t>(profiles.length);
  std::vector<float> value(length * (look.steps.size() + 2), 0.0f), slope = value, curvature = value;
  std::copy(profiles.value.begin(), profiles.value.end(), value.begin() + profiles.length);
  std::copy(profiles.slope.begin(), profiles.slope.end(), slope.begin() + profiles.length);
  std::copy(profiles.curvature.begin(), profiles.curvature.end(), curvature.begin() + profiles.length);
  // The place 0 of a row of places, leaned by `way` modules: its index in a profile, and what is left,
  // modules.
  struct Start {
    std::size_t at;
    float rest;
  };
  const auto start_of = [&](int row, double way) {
    const double scaled =
        std::clamp((way + kBeyond - 0.5) * kPerModule, 0.0, (2 * kBeyond - 1.0) * kPerModule);
    const auto whole = static_cast<std::size_t>(scaled + 0.5);
    return Start{static_cast<std::size_t>(row + 1) * length + whole,
                 static_cast<float>((scaled - static_cast<double>(whole)) / kPerModule)};
  };
  seen_.resize(n * n);
  std::vector<NormalTable::Normal> sides(n);  // inside of the pattern, along u
  for (std::size_t k = 0; k < n; ++k) {
    const double u = static_cast<double>(k) / kPerModule - 0.5, s = 1 / std::sqrt(along);
    const NormalTable::Normal left = normal.At(-u * s), right = normal.At((look.modules - u) * s);
    sides[k] = {right.share - left.share, (right.density - left.density) * s};
  }
  for (std::size_t j = 0; j < n; ++j) {
    const double v = static_cast<double>(j) / kPerModule - 0.5;
    std::fill(rows.begin(), rows.end(), 0.0f);
    const int first = std::clamp(static_cast<int>(std::floor(v - 4 * sigma)), -1, look.modules);
    const int last = std::clamp(static_cast<int>(std::floor(v + 4 * sigma)), first, look.modules);
    NormalTable::Normal above{0, 0};
    for (int row = first; row <= last; ++row) {
      const double edge = row + 1 - v;
      const NormalTable::Normal below = row == last ? NormalTable::Normal{1, 0} : normal.At(edge / sigma);
      const double share = below.share - above.share;
      if (share > 1e-5) {
        const Start start = start_of(row, lean * -sigma * (below.density - above.density) / share);
        const float *const p = value.data() + start.at, *const q = slope.data() + start.at;
        const float* const c = curvature.data() + start.at;
        const float w = static_cast<float>(share), d = start.rest;
        for (std::size_t k = 0; k < n; ++k) {
          white[k] += w * (p[k] + d * (q[k] + 0.5f * d * c[k]));
          by_u[k] += w * (q[k] + d * c[k]);
          uu[k] += w * c[k];
        }
      }
      if (row < last && below.density > 1e-6) {
        const Start start = start_of(row, lean * edge);
        const float *const p = value.data() + start.at, *const q = slope.data() + start.at;
        const float* const c = curvature.data() + start.at;
        const float density = static_cast<float>(below.density / sigma), d = start.rest;
        const float far = static_cast<float>(edge / across), leaned = static_cast<float>(lean);
        for (std::size_t k = 0; k < n; ++k) {
          const std::size_t next = k + length;
          const float steeper = q[next] - q[k], bent = c[next] - c[k];
          const float jump = p[next] - p[k] + d * (steeper + 0.5f * d * bent), steep = steeper + d * bent;
          by_v[k] += density * jump;
          uv[k] += density * steep;
          vv[k] += density * (far * jump - leaned * steep);
        }
      }
      above = below;
    }
    const double s = 1 / sigma;
    const NormalTable::Normal top = normal.At(-v * s), bottom = normal.At((look.modules - v) * s);
    const float in_v = static_cast<float>(bottom.share - top.share);
    const float in_v_by = static_cast<float>((bottom.density - top.density) * s);
    const float a = static_cast<float>(along), b = static_cast<float>(2 * both),
                c = static_cast<float>(across);
    Seen* const to = seen_.data() + j * n;
    for (std::size_t k = 0; k < n; ++k) {
      const float in_u = static_cast<float>(sides[k].share), in_u_by = static_cast<float>(sides[k].density);
      to[k] = {white[k],        by_u[k],        by_v[k],        a * uu[k] + b * uv[k] + c * vv[k],
               1 - in_u * in_v, in_u_by * in_v, in_v_by * in_u, 0};
    }
  }
}

}  // namespace tendril
