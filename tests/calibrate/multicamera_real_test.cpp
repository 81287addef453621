// Four real cameras on a moving rig: their relative poses from the tags they share, and what their tags
// triangulate to. bench/multicamera_report.cpp prints the same figures.
#include <gtest/gtest.h>

#include "tests/support/multicamera.h"
#include "tests/support/shared_data.h"

namespace tendril {
namespace {

constexpr double kBorder = 0.125;  // tagslam.yaml
constexpr double kSlowPx = 2.5;

using testing_support::Half;
using testing_support::Report;

TEST(RealMultiCameraStream, TriangulatesTagsThatAreFixedToEachOther) {
  const auto folder = testing_support::SharedFolder() / "data" / "tagslam_test" / "test_6";
  TENDRIL_SKIP_WITHOUT(folder);
  const auto stream = testing_support::ReadTagStream(folder);
  ASSERT_EQ(stream.cameras.size(), 4u);
  ASSERT_EQ(stream.views.size(), 61619u);

  // Pictures of equal stamp lie up to half a frame apart (the report shows it), so the rig is fitted to what
  // hardly moves. The odd stamps are new to it.
  const std::vector<MovingTag> moving = MotionOf(stream.views);
  const auto slow = testing_support::Between(moving, 0, kSlowPx);
  CalibrateFromTagsOptions options{.border = kBorder, .tags_move = true, .cameras = {}};
  options.cameras.folds = 0;
  const auto rig = CalibrateFromTags(stream.cameras, Half(slow, 0), options);
  ASSERT_TRUE(rig.ok()) << rig.error().message;
  const std::vector<Camera>& cameras = rig.value().calibration.cameras;

  const auto unseen = Report(cameras, Half(slow, 1), kBorder);
  EXPECT_GT(unseen.tags, 300);
  EXPECT_LT(unseen.residual_px.At(0.5), 0.35);
  EXPECT_LT(unseen.residual_px.At(0.9), 0.9);
  EXPECT_LT(std::abs(unseen.side_error.At(0.5)), 0.001);
  EXPECT_LT(unseen.distance_std.At(0.5), 0.008);

  const auto all = Report(cameras, stream.views, kBorder);
  EXPECT_GE(all.stamps, 1330);
  EXPECT_EQ(all.refused, 0);
  EXPECT_LT(all.residual_px.At(0.5), 1.5);
  EXPECT_LT(all.residual_px.At(0.9), 4);
}

// The recording is of a sheet of 5 x 7 tags. Nobody tells the fit so; tags.yaml gives their side only.
TEST(RealMultiCameraStream, TagsOfASheetLieOnARegularGrid) {
  const auto folder = testing_support::SharedFolder() / "data" / "tagslam_test" / "test_6";
  TENDRIL_SKIP_WITHOUT(folder);
  const auto stream = testing_support::ReadTagStream(folder);
  const auto body = FindTagBody(stream.cameras, stream.views, {.border = kBorder});
  ASSERT_TRUE(body.ok()) << body.error().message;
  EXPECT_EQ(body.value().tags.size(), 35u);
  EXPECT_LT(body.value().rms_px, 0.15);
  const auto grid = testing_support::CompareWithGrid(body.value());
  EXPECT_LT(grid.in_plane_rms, 0.0008);
  EXPECT_LT(grid.off_plane_rms, 0.0015);
  EXPECT_NEAR(grid.pitch, 0.156, 0.0005);
}

// Lenses are refined, as the centre of camera 2's is 10 px from where its own pictures have it.
TEST(RealMultiCameraStream, EitherHalfOfTheMomentsGivesTheSamePoses) {
  const auto folder = testing_support::SharedFolder() / "data" / "tagslam_test" / "test_6";
  TENDRIL_SKIP_WITHOUT(folder);
  const auto stream = testing_support::ReadTagStream(folder);
  std::vector<std::vector<Camera>> found;
  for (const int half : {0, 1}) {
    auto tags = Half(UnlinkMoving(stream.views, kSlowPx, 0), half);
    for (const TagInPicture& tag : UnlinkMoving(stream.views, kSlowPx, 12)) {
      if (tag.stamp < 0) tags.push_back(tag);  // for the lenses
    }
    CalibrateFromTagsOptions options{.border = kBorder, .cameras = {}};
    options.cameras.folds = 0;
    options.cameras.refine_lenses = true;
    const auto rig = CalibrateFromTags(stream.cameras, tags, options);
    ASSERT_TRUE(rig.ok()) << rig.error().message;
    found.push_back(rig.value().calibration.cameras);
  }
  for (size_t c = 1; c < 4; ++c) {
    const auto off = testing_support::PoseDifference(found[0][c], found[1][c]);
    std::printf("camera %zu: %.2f mm, %.3f deg\n", c, 1e3 * off.metres, off.degrees);
    EXPECT_LT(off.metres, 0.008) << "camera " << c;
    EXPECT_LT(off.degrees, 0.3) << "camera " << c;
  }
}

}  // namespace
}  // namespace tendril
