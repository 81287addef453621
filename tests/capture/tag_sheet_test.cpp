// capture/rig/tag_sheet.h: what rsvg-convert makes of a sheet is read back by the detector, at the stated
// size.
#include "capture/rig/tag_sheet.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/imgcodecs.hpp>

#include "capture/track/tag_detect.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

TEST(TagSheet, PrintedPagesShowEveryTagAtItsSize) {
  if (std::system("rsvg-convert --version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "rsvg-convert is not installed";
  const testing_support::TemporaryFolder folder;
  Gripper gripper;
  gripper.tentacles = 3;
  const auto layout = LayOutTags(TentacleDesign{}, gripper);
  ASSERT_TRUE(layout.ok());
  const auto pages = TagSheet(layout.value(), {.title = "a <b> & c"});
  ASSERT_TRUE(pages.ok());
  EXPECT_GE(pages.value().size(), 1u);
  auto detector = TagDetector::Create();
  ASSERT_TRUE(detector.ok());
  constexpr double kDpi = 200;
  size_t seen = 0;
  for (size_t page = 0; page < pages.value().size(); ++page) {
    testing_support::WriteText(folder / "page.svg", pages.value()[page]);
    const std::string command =
        "rsvg-convert -d 200 -p 200 -o '" + (folder / "page.png") + "' '" + (folder / "page.svg") + "'";
    ASSERT_EQ(std::system(command.c_str()), 0);
    const cv::Mat gray = cv::imread(folder / "page.png", cv::IMREAD_GRAYSCALE);
    ASSERT_FALSE(gray.empty());
    EXPECT_NEAR(gray.cols, 210 / 25.4 * kDpi, 2);
    const auto tags = detector.value().Detect({gray.data, gray.cols, gray.rows, static_cast<int>(gray.step)});
    ASSERT_TRUE(tags.ok());
    for (const TagDetection& tag : tags.value()) {
      const TagPlace* place = layout.value().Find(tag.id);
      ASSERT_NE(place, nullptr) << tag.id;
      ++seen;
      const double expected_px = place->footprint * 0.8 / 0.0254 * kDpi;
      for (int i = 0; i < 4; ++i) {
        EXPECT_NEAR((tag.corners_px.col((i + 1) % 4) - tag.corners_px.col(i)).norm(), expected_px,
                    0.02 * expected_px);
      }
      EXPECT_GT(tag.corners_px(1, 0), tag.corners_px(1, 3));  // upright
    }
  }
  EXPECT_EQ(seen, layout.value().tags.size());
}

TEST(TagSheet, ATagWiderThanThePageIsRefused) {
  TagLayout layout{
      .family = "tag36h11",
      .tags = {{.id = 0, .footprint = 0.5, .corners_in_sheet = Eigen::Matrix<double, 3, 4>::Zero()}}};
  EXPECT_EQ(TagSheet(layout).error().kind, ErrorKind::kBadInput);
  layout.tags[0].footprint = 0.01;
  EXPECT_TRUE(TagSheet(layout).ok());
  layout.tags[0].id = 9999;
  EXPECT_EQ(TagSheet(layout).error().kind, ErrorKind::kBadInput);
  EXPECT_TRUE(TagSheet({.family = "tag36h11", .tags = {}}).ok());
}

}  // namespace
}  // namespace tendril
