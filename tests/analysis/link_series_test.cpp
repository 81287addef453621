// analysis/link/link_series.h: values over time, at both ends, events, and frames that are not known.
#include "analysis/link/link_series.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tendril {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

CurveSeries Still(const std::string& name, int frames) {
  CurveSeries series;
  series.name = name;
  series.time = Eigen::VectorXd::LinSpaced(frames, 0, 0.1 * (frames - 1));
  series.curves.resize(static_cast<size_t>(frames));
  return series;
}

// A straight rod along z, and one along y that moves through it in x: a body passage.
std::vector<CurveSeries> Passage(int frames) {
  std::vector<CurveSeries> both{Still("post", frames), Still("bar", frames)};
  for (int k = 0; k < frames; ++k) {
    const double x = 0.01 * (k - 0.5 * frames + 0.25);
    FramedCurve post{Matrix3Xd(3, 3), {}}, bar{Matrix3Xd(3, 3), {}};
    for (int i = 0; i < 3; ++i) {
      post.points.col(i) = Vector3d(0, 0, i - 1);
      bar.points.col(i) = Vector3d(x, i - 1, 0.1);
    }
    both[0].curves[static_cast<size_t>(k)] = post;
    both[1].curves[static_cast<size_t>(k)] = bar;
  }
  return both;
}

TEST(MeasureLinkSeries, ABodyThatPassesAnotherIsAnEvent) {
  const auto series = MeasureLinkSeries(Passage(10), {});
  ASSERT_TRUE(series.ok());
  ASSERT_EQ(series.value().frames.size(), 10U);
  ASSERT_EQ(series.value().events.size(), 1U);
  const LinkEvent& event = series.value().events[0];
  EXPECT_EQ(event.kind, LinkEvent::Kind::kBodyPassed);
  EXPECT_EQ(event.a, 0);
  EXPECT_EQ(event.b, 1);
  EXPECT_EQ(event.frame, 5);
  EXPECT_NEAR(std::abs(event.jump), 1, 0.05);
}

TEST(MeasureLinkSeries, ABodyThatSweepsOverARayIsAnEventOfTheClosure) {
  auto curves = Passage(10);
  for (FramedCurve& bar : curves[1].curves) bar.points.row(2).array() += 3;  // above the post, on its tip ray
  LinkOptions options;
  options.axis = Axis{{0, 0.5, 0}, {0, 0, 1}};  // and through an axis
  const auto series = MeasureLinkSeries(curves, options);
  ASSERT_TRUE(series.ok());
  ASSERT_EQ(series.value().events.size(), 2U);
  EXPECT_EQ(series.value().events[0].kind, LinkEvent::Kind::kRayCrossed);
  EXPECT_EQ(series.value().events[0].b, 1);
  EXPECT_EQ(series.value().events[1].kind, LinkEvent::Kind::kBodyPassed);
  EXPECT_EQ(series.value().events[1].b, -1);
  EXPECT_EQ(series.value().events[1].a, 1);
}

TEST(MeasureLinkSeries, FramesThatAreNotKnownStayUnknown) {
  auto curves = Passage(6);
  curves[1].curves[2].points(0, 1) = std::nan("");
  LinkOptions options;
  options.axis = Axis{{1, 0, 0}, {0, 0, 1}};
  const auto series = MeasureLinkSeries(curves, options);
  ASSERT_TRUE(series.ok());
  EXPECT_TRUE(std::isnan(series.value().frames[2].mutual_link));
  EXPECT_EQ(series.value().frames[2].pairs[0].link.flags, LinkFlags{kMissing});
  EXPECT_TRUE(std::isfinite(series.value().frames[3].mutual_link));
  const LinkRows rows = RowsOf(series.value());
  ASSERT_EQ(rows.tentacles.size(), 12U);
  ASSERT_EQ(rows.pairs.size(), 6U);
  EXPECT_EQ(rows.tentacles[5].tentacle, 1);
  EXPECT_TRUE(std::isnan(rows.tentacles[5].object_link));
  EXPECT_NE(rows.tentacles[5].flags.find("missing"), std::string::npos);
  EXPECT_EQ(rows.pairs[2].flags, "missing");
  EXPECT_TRUE(std::isfinite(rows.performance));
  EXPECT_EQ(rows.mutual_link_at_zero, series.value().frames[0].mutual_link);
  EXPECT_NEAR(rows.performance, rows.mutual_link + rows.object_link, 1e-15);
}

TEST(MeasureLinkSeries, RefusesWhatDoesNotFitAndStopsWhenAsked) {
  EXPECT_FALSE(MeasureLinkSeries({}, {}).ok());
  auto curves = Passage(4);
  curves[1].curves.pop_back();
  const auto uneven = MeasureLinkSeries(curves, {});
  ASSERT_FALSE(uneven.ok());
  EXPECT_NE(uneven.error().message.find("bar"), std::string::npos);
  const auto stopped = MeasureLinkSeries(Passage(4), {}, [](double) { return false; });
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().kind, ErrorKind::kStopped);
}

}  // namespace
}  // namespace tendril
