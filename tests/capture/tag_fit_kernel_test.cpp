#include "capture/track/tag_fit_kernel.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>
#include <vector>

#include "capture/track/tag_fit_problem.h"
#include "model/machine.h"
#include "tests/support/render_tag.h"

namespace tendril::tag_fit {
namespace {

using testing_support::TiltedCorners;

// Any table, any pixels: kernels need no sense in them.
struct Case {
  std::vector<std::int16_t> seen;
  std::vector<float> sides_u, sides_v, x, y, gray;
  Evaluate evaluate{};
};
Case AnyCase(int pixels, std::mt19937& random) {
  std::uniform_real_distribution<float> unit(-1, 1);
  std::uniform_int_distribution<int> any(-32767, 32767);
  Case c;
  constexpr int kSide = 45;
  for (int i = 0; i < kSide * kSide * kSeenParts; ++i)
    c.seen.push_back(static_cast<std::int16_t>(any(random)));
  for (int i = 0; i < kSide * kSideParts; ++i) {
    c.sides_u.push_back(unit(random));
    c.sides_v.push_back(unit(random));
  }
  for (int i = 0; i < (pixels + 15) / 16 * 16; ++i) {
    c.x.push_back(14 * unit(random));  // some beyond the table's rim
    c.y.push_back(14 * unit(random));
    c.gray.push_back(100 + 90 * unit(random));
  }
  Evaluate& e = c.evaluate;
  e.table = {.side = kSide,
             .per_module = 4,
             .seen = c.seen.data(),
             .scale = {},
             .sides_u = c.sides_u.data(),
             .sides_v = c.sides_v.data(),
             .blur_uu = 0.11f,
             .blur_uv = 0.02f,
             .blur_vv = 0.09f};
  for (float& scale : e.table.scale) scale = 1.0f / 32767;
  e.pixels = pixels;
  e.x = c.x.data();
  e.y = c.y.data();
  e.gray = c.gray.data();
  const float g[9] = {0.1f, 0.02f, 0.01f, -0.03f, 0.11f, -0.02f, 0.001f, 0.002f, 1};
  std::copy_n(g, 9, e.g);
  e.black = 30;
  e.white = 150;
  e.surround = 40;
  e.blur_change = 0.1f;
  e.half = 4;
  e.middle = 5;
  return c;
}

std::vector<double> SumsOf(const Kernels& kernels, Case& c) {
  kernels.evaluate(c.evaluate);
  std::vector<double> sums;
  for (int r = 0; r < kRow; ++r) {
    for (int k = 0; k <= r; ++k) sums.push_back(c.evaluate.sums[r][k]);
  }
  return sums;
}

TEST(TagFitKernel, EveryInstructionSetGivesTheSameSums) {
  std::mt19937 random(1);
  for (const int pixels : {1, 15, 16, 17, 127, 128, 129, 640}) {
    Case c = AnyCase(pixels, random);
    const std::vector<double> base = SumsOf(BaseKernels(), c);
    std::vector<Kernels> others;
#if defined(__x86_64__)
    if (MachineDoubles() >= 4) others.push_back(Avx2Kernels());
    if (MachineDoubles() >= 8) others.push_back(Avx512Kernels());
#endif
    for (std::size_t k = 0; k < others.size(); ++k) {
      const std::vector<double> sums = SumsOf(others[k], c);
      for (std::size_t i = 0; i < sums.size(); ++i) {
        // Roundings are of the size of the columns, not of their product; far from the table its slopes
        // make much of them.
        const auto r = static_cast<std::size_t>((std::sqrt(8.0 * static_cast<double>(i) + 1) - 1) / 2);
        const std::size_t column = i - r * (r + 1) / 2;
        const double size = std::sqrt(base[r * (r + 1) / 2 + r] * base[column * (column + 1) / 2 + column]);
        EXPECT_NEAR(sums[i], base[i], 1e-3 * size) << pixels << " pixels, kernel " << k << ", sum " << i;
      }
    }
  }
}

// By its definition, in double precision, of a tag seen askew. Slopes between the places of the table are off
// by 2 % at most, which is the second order of half a blur.
TEST(TagFitKernel, TheTableGivesThePlainFormsNormalEquations) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(-1, 1), any(0, 6.28);
  const TagFitOptions options;
  for (int trial = 0; trial < 30; ++trial) {
    const TagLook look = LookOf("tag36h11", trial).value();
    const Corners corners = TiltedCorners({0, 0}, 18, 0.7, any(random), any(random));
    Unknowns x;
    x << HomographyTo(corners).value(), 40, 150, 20, std::log(options.blur_px);
    const Eigen::Matrix3d tag_from_pixel = Matrix(x).inverse();
    Pixels pixels;
    for (int v = -9; v <= 9; ++v) {
      for (int u = -9; u <= 9; ++u) {
        const Eigen::Vector3d at = tag_from_pixel * Eigen::Vector3d(u + 0.3, v - 0.2, 1);
        if (!(at.head<2>().cwiseAbs().maxCoeff() < 1.2 * at.z())) continue;
        pixels.x.push_back(static_cast<float>(u + 0.3));
        pixels.y.push_back(static_cast<float>(v - 0.2));
        pixels.gray.push_back(static_cast<float>(100 + 60 * unit(random)));
      }
    }
    pixels.count = static_cast<int>(pixels.x.size());
    for (auto* column : {&pixels.x, &pixels.y, &pixels.gray}) column->resize((column->size() + 15) / 16 * 16);
    TagFollow follow;
    const auto plain = MakePlainProblem(look, pixels, options);
    const auto table = MakeTableProblem(look, pixels, options, follow, x);
    ASSERT_NE(table, nullptr);
    Normals one, other;
    Unknowns one_gradient, other_gradient;
    const double one_cost = plain->Cost(x, one, one_gradient);
    const double other_cost = table->Cost(x, other, other_gradient);
    EXPECT_NEAR(other_cost, one_cost, 0.01 * one_cost);
    for (int r = 0; r < kUnknowns; ++r) {
      EXPECT_NEAR(other_gradient[r], one_gradient[r], 0.02 * std::sqrt(one(r, r) * one_cost)) << r;
      for (int c = 0; c < kUnknowns; ++c) {
        EXPECT_NEAR(other(r, c), one(r, c), 0.06 * std::sqrt(one(r, r) * one(c, c)))
            << r << ", " << c << ": of " << std::sqrt(one(r, r) * one(c, c));
      }
    }
  }
}

TEST(TagFitKernel, AHomographyTakesTheCornersWhereTheyAre) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(0, 6.28), size(4, 400), tilt(0, 1.4);
  for (int trial = 0; trial < 1000; ++trial) {
    const double side = size(random);
    const Corners corners = TiltedCorners({3, -2}, side, tilt(random), any(random), any(random));
    Unknowns x = Unknowns::Zero();
    const auto h = HomographyTo(corners);
    ASSERT_TRUE(h.has_value());
    x.head<8>() = *h;
    EXPECT_LT((CornersOf(x) - corners).cwiseAbs().maxCoeff(), 1e-9 * side);
  }
  Corners line;
  line << 0, 1, 2, 3, 0, 1, 2, 3;
  EXPECT_FALSE(HomographyTo(line).has_value());
  Corners crossed;
  crossed << -1, 1, -1, 1, 1, 1, -1, -1;
  EXPECT_FALSE(HomographyTo(crossed).has_value());
}

}  // namespace
}  // namespace tendril::tag_fit
