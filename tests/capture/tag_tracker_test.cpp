#include "capture/track/tag_tracker.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/render_tag.h"

namespace tendril {
namespace {

using testing_support::AddNoise;
using testing_support::Blur;
using testing_support::DrawTag;
using testing_support::Picture;
using testing_support::TiltedCorners;
using Corners = Eigen::Matrix<double, 2, 4>;

constexpr int kWidth = 240, kHeight = 120;

Corners CornersAt(int id, int frame) {
  return TiltedCorners({50 + 70.0 * id + 1.5 * frame, 55 + 0.4 * frame}, 20, 0.4, 1.0 + id, 0.02 * frame);
}

std::vector<unsigned char> Frame(int frame, const std::vector<int>& ids, std::mt19937& random) {
  Picture picture(kWidth, kHeight, 80);
  for (const int id : ids) DrawTag(picture, PatternOf("tag36h11", id).value(), 8, CornersAt(id, frame));
  Blur(picture, 0.8);
  AddNoise(picture, 3, random);
  return picture.Bytes();
}

std::vector<TrackedTag> Look(TagTracker& tracker, const std::vector<unsigned char>& bytes) {
  return tracker.Next({bytes.data(), kWidth, kHeight, kWidth}).value();
}

TEST(TagTracker, FollowsEveryTagAndDecodesRarely) {
  std::mt19937 random(1);
  for (const auto level : {TagTrackLevel::kPreview, TagTrackLevel::kStandard, TagTrackLevel::kBest}) {
    TagTrackOptions options;
    options.level = level;
    TagTracker tracker = TagTracker::Create(options).value();
    for (int frame = 0; frame < 18; ++frame) {
      const auto tags = Look(tracker, Frame(frame, {0, 1, 2}, random));
      ASSERT_EQ(tags.size(), 3u) << NameOf(level) << ", frame " << frame;
      for (int id = 0; id < 3; ++id) {
        const TrackedTag& tag = tags[static_cast<std::size_t>(id)];
        EXPECT_EQ(tag.id, id);
        EXPECT_LT((tag.corners_px - CornersAt(id, frame)).cwiseAbs().maxCoeff(), 0.15);
      }
    }
    EXPECT_EQ(tracker.counts().decodes, level == TagTrackLevel::kBest ? 18 : 1);
    EXPECT_EQ(tracker.counts().found, 3);
  }
}

TEST(TagTracker, WhatIsHiddenIsCountedAndFoundAgainByDecoding) {
  std::mt19937 random(2);
  TagTracker tracker = TagTracker::Create({}).value();
  for (int frame = 0; frame < 5; ++frame) Look(tracker, Frame(frame, {0, 1}, random));
  for (int frame = 5; frame < 12; ++frame) EXPECT_EQ(Look(tracker, Frame(frame, {0}, random)).size(), 1u);
  long refused = 0;
  for (const long count : tracker.counts().faults) refused += count;
  EXPECT_GE(refused, 3);
  int seen = 0;
  for (int frame = 12; frame < 18; ++frame) {
    seen = static_cast<int>(Look(tracker, Frame(frame, {0, 1}, random)).size());
  }
  EXPECT_EQ(seen, 2);
  EXPECT_EQ(tracker.counts().found, 3);
}

TEST(TagTracker, ATagThatSuddenlyLeavesIsFollowedWithoutDecoding) {
  std::mt19937 random(4);
  for (const auto level : {TagTrackLevel::kPreview, TagTrackLevel::kStandard}) {
    TagTrackOptions options;
    options.level = level;
    TagTracker tracker = TagTracker::Create(options).value();
    for (int frame = 0; frame < 16; ++frame) {
      // Stands for eight frames, then goes by 5.4 px a frame.
      const Corners there = TiltedCorners(
          {50 + 5.0 * std::max(0, frame - 8), 50 + 2.0 * std::max(0, frame - 8)}, 20, 0.4, 1, 0.3);
      Picture picture(kWidth, kHeight, 80);
      DrawTag(picture, PatternOf("tag36h11", 3).value(), 8, there);
      Blur(picture, 0.8);
      AddNoise(picture, 3, random);
      const auto tags = Look(tracker, picture.Bytes());
      ASSERT_EQ(tags.size(), 1u) << NameOf(level) << ", frame " << frame;
      EXPECT_LT((tags[0].corners_px - there).cwiseAbs().maxCoeff(), 0.15);
    }
    EXPECT_EQ(tracker.counts().decodes, 1);
  }
}

TEST(TagTracker, AnotherTagInItsPlaceIsNotTakenForIt) {
  std::mt19937 random(3);
  TagTracker tracker = TagTracker::Create({}).value();
  for (int frame = 0; frame < 4; ++frame) Look(tracker, Frame(frame, {0}, random));
  Picture picture(kWidth, kHeight, 80);
  DrawTag(picture, PatternOf("tag36h11", 7).value(), 8, CornersAt(0, 4));
  Blur(picture, 0.8);
  const auto tags = Look(tracker, picture.Bytes());
  ASSERT_EQ(tags.size(), 1u);
  EXPECT_EQ(tags[0].id, 7);
  EXPECT_TRUE(tags[0].decoded);
}

}  // namespace
}  // namespace tendril
