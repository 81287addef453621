#include "capture/track/tag_search.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/render_tag.h"

namespace tendril {
namespace {

using namespace testing_support;
using Corners = Eigen::Matrix<double, 2, 4>;

TEST(TagSearch, FindsATagThatWentSixPixelsAnyWay) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> shift(-6, 6);
  std::uniform_real_distribution<double> any(0, 6.28), unit(0, 1);
  for (int trial = 0; trial < 200; ++trial) {
    const Corners corners = TiltedCorners({50 + unit(random), 50 + unit(random)}, 16 + 4 * unit(random),
                                          0.8 * unit(random), any(random), any(random));
    Picture picture(100, 100, 70);
    DrawTag(picture, PatternOf("tag36h11", trial).value(), 8, corners);
    Blur(picture, 0.8);
    AddNoise(picture, 3, random);
    const std::vector<unsigned char> bytes = picture.Bytes();
    const Eigen::Vector2d way(shift(random), shift(random));
    const auto found = SearchTag({bytes.data(), 100, 100, 100}, LookOf("tag36h11", trial).value(),
                                 corners.colwise() - way, 6);
    ASSERT_TRUE(found.has_value()) << trial;
    EXPECT_LT((*found - way).cwiseAbs().maxCoeff(), 1.5) << trial;
  }
}

TEST(TagSearch, FindsNothingWhereThereIsNothing) {
  std::mt19937 random(2);
  Picture picture(100, 100, 70);
  AddNoise(picture, 3, random);
  const std::vector<unsigned char> bytes = picture.Bytes();
  const TagLook look = LookOf("tag36h11", 0).value();
  const GrayImage image{bytes.data(), 100, 100, 100};
  const Corners corners = TiltedCorners({50, 50}, 18, 0, 0, 0);
  EXPECT_FALSE(SearchTag(image, look, corners, 6).has_value());
  EXPECT_FALSE(SearchTag(image, look, corners.colwise() + Eigen::Vector2d(300, 0), 6).has_value());
  EXPECT_FALSE(SearchTag(image, look, corners.colwise() + Eigen::Vector2d(1e30, 0), 6).has_value());
  EXPECT_FALSE(SearchTag(image, look, Corners::Constant(std::nan("")), 6).has_value());
  EXPECT_FALSE(SearchTag(image, look, Corners::Constant(50), 6).has_value());
  const std::vector<unsigned char> flat(100 * 100, 128);
  EXPECT_FALSE(SearchTag({flat.data(), 100, 100, 100}, look, corners, 6).has_value());
}

}  // namespace
}  // namespace tendril
