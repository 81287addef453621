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

  const auto rig =
      FitRigFromTags(stream.cameras, Half(stream.views, 0), {.border = kBorder, .most_tags = 1000});
  ASSERT_TRUE(rig.ok()) << rig.error().message;

  // The odd stamps are new to the rig.
  const auto unseen = Report(rig.value().cameras, Half(stream.views, 1), kBorder);
  EXPECT_LT(unseen.residual_px.At(0.5), 1.5);
  EXPECT_LT(unseen.residual_px.At(0.9), 4.0);
  const auto all = Report(rig.value().cameras, stream.views, kBorder);
  EXPECT_GE(all.stamps, 1300);
  EXPECT_LT(std::abs(all.side_error.At(0.5)), 0.002);
  EXPECT_LT(all.distance_std.At(0.5), 0.03);
}

}  // namespace
}  // namespace tendril
