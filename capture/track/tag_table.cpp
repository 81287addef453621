#include "capture/track/tag_table.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "capture/track/normal_table.h"

namespace tendril {
namespace {

using namespace tag_fit;

constexpr int kLeast = 4, kMost = 16;  // places to a module
constexpr int kFiner = 4;              // of the profiles than of the table
constexpr int kBeyond = 3;             // modules of profiles on either side of the pattern

int PlacesPerModule(const Eigen::Matrix2d& covariance) {
  const double trace = covariance.trace(), determinant = covariance.determinant();
  const double least = 0.5 * (trace - std::sqrt(std::max(0.0, trace * trace - 4 * determinant)));
  return static_cast<int>(std::ceil(std::min(1000.0, 1 / std::sqrt(std::max(least, 1e-12)))));
}

// What a grid's places see of a pattern's inside along one direction; its density and that one's slope.
std::vector<float> SidesOf(int side, int per_module, int modules, double variance) {
  const NormalTable& normal = NormalTable::Get();
  const double s = 1 / std::sqrt(variance);
  std::vector<float> sides(static_cast<std::size_t>(side) * kSideParts, 0.0f);
  for (int k = 0; k < side; ++k) {
    const double u = static_cast<double>(k) / per_module - 0.5, before = -u * s, behind = (modules - u) * s;
    const NormalTable::Normal left = normal.At(before), right = normal.At(behind);
    float* const to = sides.data() + k * kSideParts;
    to[kSideShare] = static_cast<float>(right.share - left.share);
    // By u: the arguments fall with it.
    to[kSideSlope] = static_cast<float>((left.density - right.density) * s);
    to[kSideCurvature] = static_cast<float>((before * left.density - behind * right.density) * s * s);
  }
  return sides;
}

// Blurred rows of the pattern, each kFiner times as fine as the table, sorted so that places a table's
// spacing apart stand side by side; with a row of nothing before and behind.
struct Profiles {
  std::size_t length = 0, row = 0;  // places side by side; numbers to a row
  std::vector<float> value, slope, curvature;

  Profiles(const TagLook& look, double sigma, int per_module) {
    TagProfiles fine;
    fine.Make(look, sigma, kFiner * per_module, kBeyond);
    length = static_cast<std::size_t>((fine.length - 1) / kFiner + 1);
    row = length * kFiner;
    const auto sort = [&](const std::vector<double>& from) {
      std::vector<float> to(row * static_cast<std::size_t>(fine.rows + 2), 0.0f);
      for (int r = 0; r < fine.rows; ++r) {
        for (int i = 0; i < fine.length; ++i) {
          to[static_cast<std::size_t>(r + 1) * row + static_cast<std::size_t>(i % kFiner) * length +
             static_cast<std::size_t>(i / kFiner)] =
              static_cast<float>(from[static_cast<std::size_t>(r * fine.length + i)]);
        }
      }
      return to;
    };
    value = sort(fine.value);
    slope = sort(fine.slope);
    curvature = sort(fine.curvature);
  }

  // Where the table's first place lies in row `r` shifted by `way` modules, and what is left of it, modules.
  struct Start {
    std::size_t at;
    float rest;
  };
  Start StartOf(int r, double way, int per_module) const {
    const int fine = kFiner * per_module;
    const double scaled = std::clamp((way + kBeyond - 0.5) * fine, 0.0, (2.0 * kBeyond - 1) * fine);
    const auto whole = static_cast<std::size_t>(scaled + 0.5);
    return {static_cast<std::size_t>(r + 1) * row + whole % kFiner * length + whole / kFiner,
            static_cast<float>((scaled - static_cast<double>(whole)) / fine)};
  }
};

}  // namespace

bool TagTable::CanServe(const Eigen::Matrix2d& covariance) { return PlacesPerModule(covariance) <= kMost; }

bool TagTable::Serves(const Eigen::Matrix2d& covariance) const {
  return side_ > 0 && (covariance - covariance_).cwiseAbs().maxCoeff() <= 0.05 * covariance_.trace();
}

TableView TagTable::View() const {
  TableView view{.side = side_,
                 .per_module = static_cast<float>(per_module_),
                 .seen = seen_.data(),
                 .scale = {},
                 .sides_u = sides_u_.data(),
                 .sides_v = sides_v_.data(),
                 .blur_uu = static_cast<float>(covariance_(0, 0)),
                 .blur_uv = static_cast<float>(2 * covariance_(0, 1)),
                 .blur_vv = static_cast<float>(covariance_(1, 1))};
  std::copy(scale_.begin(), scale_.end(), view.scale);
  return view;
}

void TagTable::Make(const TagLook& look, const Eigen::Matrix2d& covariance) {
  covariance_ = covariance;
  per_module_ = std::max(kLeast, PlacesPerModule(covariance));
  side_ = (look.modules + 1) * per_module_ + 1;
  const double along = covariance(0, 0), both = covariance(0, 1), across = covariance(1, 1);
  const double sigma = std::sqrt(across), lean = both / across;
  sides_u_ = SidesOf(side_, per_module_, look.modules, along);
  sides_v_ = SidesOf(side_, per_module_, look.modules, across);

  const Profiles profiles(look, std::sqrt(std::max(along - both * lean, 1e-4)), per_module_);
  const NormalTable& normal = NormalTable::Get();
  const auto n = static_cast<std::size_t>(side_), all = n * n;
  std::vector<float> parts(kSeenParts * all, 0.0f);
  const auto part = [&](SeenPart which) { return parts.data() + which * all; };
  for (std::size_t j = 0; j < n; ++j) {
    float *const white = part(kSeenWhite) + j * n, *const by_u = part(kSeenByU) + j * n;
    float *const by_v = part(kSeenByV) + j * n, *const uu = part(kSeenByUU) + j * n;
    float *const uv = part(kSeenByUV) + j * n, *const vv = part(kSeenByVV) + j * n;
    const double v = static_cast<double>(j) / per_module_ - 0.5;
    const int first = std::clamp(static_cast<int>(std::floor(v - 4 * sigma)), -1, look.modules);
    const int last = std::clamp(static_cast<int>(std::floor(v + 4 * sigma)), first, look.modules);
    NormalTable::Normal above{0, 0};
    for (int row = first; row <= last; ++row) {
      const double edge = row + 1 - v;
      const NormalTable::Normal below = row == last ? NormalTable::Normal{1, 0} : normal.At(edge / sigma);
      const double share = below.share - above.share;
      if (share > 1e-5) {
        const double mean = lean * -sigma * (below.density - above.density) / share;
        const Profiles::Start start = profiles.StartOf(row, mean, per_module_);
        const float* const p = profiles.value.data() + start.at;
        const float* const q = profiles.slope.data() + start.at;
        const float* const c = profiles.curvature.data() + start.at;
        const float w = static_cast<float>(share), d = start.rest;
        for (std::size_t k = 0; k < n; ++k) {
          white[k] += w * (p[k] + d * (q[k] + 0.5f * d * c[k]));
          by_u[k] += w * (q[k] + d * c[k]);
          uu[k] += w * c[k];
        }
      }
      if (row < last && below.density > 1e-6) {
        const Profiles::Start start = profiles.StartOf(row, lean * edge, per_module_);
        const float* const p = profiles.value.data() + start.at;
        const float* const q = profiles.slope.data() + start.at;
        const float* const c = profiles.curvature.data() + start.at;
        const float density = static_cast<float>(below.density / sigma), d = start.rest;
        const float far = static_cast<float>(edge / across), leaned = static_cast<float>(lean);
        for (std::size_t k = 0; k < n; ++k) {
          const std::size_t next = k + profiles.row;
          const float steeper = q[next] - q[k], bent = c[next] - c[k];
          const float jump = p[next] - p[k] + d * (steeper + 0.5f * d * bent), steep = steeper + d * bent;
          by_v[k] += density * jump;
          uv[k] += density * steep;
          vv[k] += density * (far * jump - leaned * steep);
        }
      }
      above = below;
    }
  }

  // How the slope by blur changes from place to place.
  const float a = static_cast<float>(along), b = static_cast<float>(2 * both), c = static_cast<float>(across);
  const float *const uu = part(kSeenByUU), *const uv = part(kSeenByUV), *const vv = part(kSeenByVV);
  const auto by_blur = [&](std::size_t i) { return a * uu[i] + b * uv[i] + c * vv[i]; };
  const float twice = 0.5f * static_cast<float>(per_module_);
  for (std::size_t j = 1; j + 1 < n; ++j) {
    for (std::size_t i = j * n + 1; i + 1 < (j + 1) * n; ++i) {
      part(kSeenBlurByU)[i] = twice * (by_blur(i + 1) - by_blur(i - 1));
      part(kSeenBlurByV)[i] = twice * (by_blur(i + n) - by_blur(i - n));
    }
  }

  seen_.resize(kSeenParts * all);
  for (std::size_t which = 0; which < kSeenParts; ++which) {
    const float* const from = parts.data() + which * all;
    const float most =
        Eigen::Map<const Eigen::ArrayXf>(from, static_cast<Eigen::Index>(all)).abs().maxCoeff();
    scale_[which] = std::max(most, 1e-6f) / 32767;
    const float inverse = 1 / scale_[which];
    for (std::size_t i = 0; i < all; ++i) {
      seen_[i * kSeenParts + which] =
          static_cast<std::int16_t>(static_cast<int>(from[i] * inverse + 32768.5f) - 32768);
    }
  }
}

}  // namespace tendril
