#include "capture/track/tag_look.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "capture/track/normal_table.h"

namespace tendril {

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

}  // namespace tendril
