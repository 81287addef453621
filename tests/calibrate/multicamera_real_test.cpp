// Four real cameras on a moving rig: their relative poses from the tags they share, and what their tags
// triangulate to. bench/multicamera_report.cpp prints the same figures.
#include <gtest/gtest.h>

#include "tests/support/multicamera.h"
#include "tests/support/shared_data.h"

namespace tendril {
namespace {

using testing_support::Half;
using testing_support::Report;

TEST(RealMultiCameraStream, TriangulatesTagsThatAreFixedToEachOther) {
  const auto folder = testing_support::SharedFolder() / "data" / "tagslam_test" / "test_6";
  TENDRIL_SKIP_WITHOUT(folder);
  const auto stream = testing_support::ReadTagStream(folder);
  ASSERT_EQ(stream.cameras.size(), 4u);
  ASSERT_EQ(stream.views.size(), 61619u);
  constexpr double kBorder = 0.125;  // tagslam.yaml

  // Pictures of equal stamp lie up to half a frame apart (the report shows it), so the rig is fitted to what
  // hardly moves. The odd stamps are new to it.
  const auto slow = testing_support::Between(testing_support::Moving(stream.views), 0, 2.5);
  const auto rig = FitRigFromTags(stream.cameras, Half(slow, 0), {.border = kBorder});
  ASSERT_TRUE(rig.ok()) << rig.error().message;
  EXPECT_TRUE(rig.value().converged) << rig.value().stopped_because;

  const auto unseen = Report(rig.value().cameras, Half(slow, 1), kBorder);
  EXPECT_GT(unseen.tags, 300);
  EXPECT_LT(unseen.residual_px.At(0.5), 0.35);
  EXPECT_LT(unseen.residual_px.At(0.9), 0.9);
  EXPECT_LT(std::abs(unseen.side_error.At(0.5)), 0.001);
  EXPECT_LT(unseen.distance_std.At(0.5), 0.008);

  const auto all = Report(rig.value().cameras, stream.views, kBorder);
  EXPECT_GE(all.stamps, 1330);
  EXPECT_EQ(all.refused, 0);
  EXPECT_LT(all.residual_px.At(0.5), 1.5);
  EXPECT_LT(all.residual_px.At(0.9), 4);
}

}  // namespace
}  // namespace tendril
