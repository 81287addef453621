// capture/track/tag_detect.h and tag_refine.h, against drawn pictures whose corners are known exactly.
#include "capture/track/tag_detect.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "capture/track/tag_refine.h"
#include "tests/support/render_tag.h"

namespace tendril {
namespace {

using testing_support::AddNoise;
using testing_support::Blur;
using testing_support::DrawTag;
using testing_support::Picture;
using testing_support::TiltedCorners;
using Corners = Eigen::Matrix<double, 2, 4>;

struct Errors {
  int shown = 0;
  int found = 0;
  double sum2 = 0;
  Eigen::Vector2d bias = Eigen::Vector2d::Zero();
  double grow = 0;  // mean outward error of corners, px

  double rms() const { return std::sqrt(sum2 / (8.0 * found)); }
};

// Random tags at random places, one per picture of 120 x 120.
Errors Measure(const TagDetectOptions& options, double side_px, double tilt, double blur, double noise,
               int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  auto detector = TagDetector::Create(options);
  EXPECT_TRUE(detector.ok());
  const TagFamily family = FamilyOf(options.family).value();
  Errors errors;
  for (int i = 0; i < count; ++i) {
    const int id = static_cast<int>(unit(random) * family.ids);
    Picture picture(120, 120, 200);
    const Eigen::Vector2d center(59 + 2 * unit(random), 59 + 2 * unit(random));
    const Corners truth =
        TiltedCorners(center, side_px, tilt, 2 * M_PI * unit(random), 2 * M_PI * unit(random));
    DrawTag(picture, PatternOf(options.family, id).value(), family.border_width, truth);
    if (blur > 0) Blur(picture, blur);
    if (noise > 0) AddNoise(picture, noise, random);
    const auto bytes = picture.Bytes();
    const auto tags = detector.value().Detect({bytes.data(), 120, 120, 120});
    EXPECT_TRUE(tags.ok());
    ++errors.shown;
    for (const TagDetection& tag : tags.value()) {
      if (tag.id != id) continue;
      const Corners off = tag.corners_px - truth;
      ++errors.found;
      errors.sum2 += off.squaredNorm();
      errors.bias += off.rowwise().mean();
      for (int c = 0; c < 4; ++c) errors.grow += off.col(c).dot((truth.col(c) - center).normalized()) / 4;
    }
  }
  errors.bias /= std::max(1, errors.found);
  errors.grow /= std::max(1, errors.found);
  return errors;
}

// The half pixel: over random places, neither estimator may be off to one side.
TEST(TagDetector, CornersAreCountedFromThePixelsCentre) {
  for (const TagCorners corners : {TagCorners::kLibrary, TagCorners::kRefined}) {
    const Errors e = Measure({.corners = corners}, 40, 0, 0.6, 0, 60, 5);
    EXPECT_EQ(e.found, 60);
    // The library's own corners lean to the top left by 0.05 px; a convention missed would show as 0.5.
    EXPECT_LT(e.bias.cwiseAbs().maxCoeff(), corners == TagCorners::kLibrary ? 0.1 : 0.01)
        << e.bias.transpose();
  }
}

TEST(TagDetector, RefinementIsBetterThanTheLibraryAtEverySizeAndTilt) {
  const struct {
    double side;
    double tilt;
    double bound_px;
  } cases[] = {{20, 0, 0.06}, {28, 0, 0.03}, {28, 0.8, 0.04}, {40, 0.8, 0.025}, {60, 0, 0.02}};
  for (const auto& c : cases) {
    const Errors library = Measure({.corners = TagCorners::kLibrary}, c.side, c.tilt, 0.7, 2, 40, 11);
    const Errors refined = Measure({.corners = TagCorners::kRefined}, c.side, c.tilt, 0.7, 2, 40, 11);
    EXPECT_EQ(refined.found, 40);
    EXPECT_LT(refined.rms(), 0.7 * library.rms()) << c.side << " px, tilt " << c.tilt;
    EXPECT_LT(refined.rms(), c.bound_px) << c.side << " px, tilt " << c.tilt;
  }
}

TEST(TagDetector, FindsTagsDownToTwoPixelsPerModule) {
  EXPECT_GE(Measure({}, 17, 0, 0.5, 2, 60, 3).found, 57);
  EXPECT_GE(Measure({}, 24, M_PI / 4, 0.5, 2, 60, 4).found, 57);
}

// A white ring that the picture's rim cuts spoils the edge there and cannot be refined; the tag is found all
// the same.
TEST(TagDetector, ATagAtTheRimKeepsTheLibrarysCorners) {
  Picture picture(100, 100, 220);
  const Corners truth = TiltedCorners({24, 50}, 40, 0, 0, 0);
  DrawTag(picture, PatternOf("tag36h11", 3).value(), 8, truth);
  const auto bytes = picture.Bytes();
  for (const int left : {0, 3}) {
    auto detector = TagDetector::Create();
    ASSERT_TRUE(detector.ok());
    const auto tags = detector.value().Detect({bytes.data() + left, 100 - left, 100, 100});
    ASSERT_TRUE(tags.ok());
    ASSERT_EQ(tags.value().size(), 1u);
    Corners off = tags.value()[0].corners_px - truth;
    off.row(0).array() += left;
    EXPECT_LT((off.middleCols<2>(1).cwiseAbs().maxCoeff()), 0.6);  // the side that is not at the rim
    EXPECT_LT(off.cwiseAbs().maxCoeff(), 4);
  }
}

TEST(TagDetector, EveryFamilyIsRead) {
  for (const std::string& name : TagFamilyNames()) {
    if (name == "tagStandard52h13" || name == "tagCustom48h12" || name == "tagCircle49h12")
      continue;  // large tables
    const Errors e =
        Measure({.family = name, .max_hamming = 0}, name == "tag16h5" ? 40 : 44, 0.2, 0.5, 1, 10, 9);
    EXPECT_GE(e.found, 9) << name;
    EXPECT_LT(e.rms(), 0.25) << name;
  }
}

TEST(TagDetector, AnEmptyPictureShowsNothing) {
  auto detector = TagDetector::Create();
  ASSERT_TRUE(detector.ok());
  for (const int size : {1, 7, 8, 9, 64, 65}) {
    const std::vector<unsigned char> gray(static_cast<size_t>(size * size), 128);
    const auto tags = detector.value().Detect({gray.data(), size, size, size});
    ASSERT_TRUE(tags.ok());
    EXPECT_TRUE(tags.value().empty());
  }
}

TEST(TagDetector, BadInputIsRefused) {
  EXPECT_EQ(TagDetector::Create({.family = "tag1"}).error().kind, ErrorKind::kBadInput);
  EXPECT_FALSE(TagDetector::Create({.decimate = 0}).ok());
  EXPECT_FALSE(TagDetector::Create({.decimate = std::nan("")}).ok());
  EXPECT_FALSE(TagDetector::Create({.min_white_black_diff = 300}).ok());
  EXPECT_FALSE(TagDetector::Create({.max_hamming = 3}).ok());
  EXPECT_FALSE(TagDetector::Create({.threads = 0}).ok());
  auto detector = TagDetector::Create();
  ASSERT_TRUE(detector.ok());
  const unsigned char one = 0;
  EXPECT_FALSE(detector.value().Detect({}).ok());
  EXPECT_FALSE(detector.value().Detect({&one, 1, 1, 0}).ok());
}

}  // namespace
}  // namespace tendril
