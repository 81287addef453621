// capture/track/tags_in_video.h: a drawn video, also with pictures missing and with what no tracker can
// foresee.
#include "capture/track/tags_in_video.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "capture/record/video_file.h"
#include "tests/support/program.h"
#include "tests/support/render_tag.h"

namespace tendril {
namespace {

using Corners = Eigen::Matrix<double, 2, 4>;
constexpr int kWidth = 320, kHeight = 160, kTags = 3;

Corners CornersAt(int id, double moment) {
  return testing_support::TiltedCorners({50 + 85.0 * id + 1.5 * moment, 60 + 0.4 * moment}, 22, 0.4, 1.0 + id,
                                        0.02 * moment);
}

// One picture per moment.
std::string Film(const testing_support::TemporaryFolder& folder, const std::vector<double>& moments) {
  std::mt19937 random(5);
  const std::string file = folder / "cam0.mkv";
  VideoWriter writer = VideoWriter::Open(file, kWidth, kHeight).value();
  for (std::size_t f = 0; f < moments.size(); ++f) {
    testing_support::Picture picture(kWidth, kHeight, 80);
    for (int id = 0; id < kTags; ++id) {
      testing_support::DrawTag(picture, PatternOf("tag36h11", id).value(), 8, CornersAt(id, moments[f]));
    }
    testing_support::Blur(picture, 0.8);
    testing_support::AddNoise(picture, 3, random);
    auto bytes = picture.Bytes();
    EXPECT_TRUE(
        writer.Write(cv::Mat(kHeight, kWidth, CV_8U, bytes.data()), 0.01 * static_cast<double>(f)).ok());
  }
  EXPECT_TRUE(writer.Close().ok());
  return file;
}

TagsInVideo Find(const std::string& file, const std::vector<double>& moments,
                 std::optional<TagTrackLevel> level) {
  auto found = FindTagsInVideo(file, 2, moments.size(), {.level = level, .detect = {}}, [] { return true; });
  EXPECT_TRUE(found.ok()) << found.error().message;
  return std::move(found).value();
}

void ExpectAllTags(const TagsInVideo& found, const std::vector<double>& moments, double within_px) {
  ASSERT_EQ(found.rows.size(), kTags * moments.size());
  for (std::size_t r = 0; r < found.rows.size(); ++r) {
    const DetectionRow& row = found.rows[r];
    EXPECT_EQ(row.camera, 2);
    EXPECT_EQ(row.frame, static_cast<std::int64_t>(r / kTags));
    EXPECT_EQ(row.tag, static_cast<int>(r % kTags));
    const Corners truth = CornersAt(row.tag, moments[r / kTags]);
    EXPECT_LT((row.corners_px - truth).cwiseAbs().maxCoeff(), within_px) << "frame " << row.frame;
  }
}

std::vector<double> Steady(int count) {
  std::vector<double> moments;
  for (int f = 0; f < count; ++f) moments.push_back(f);
  return moments;
}

TEST(TagsInVideo, FollowedTagsHaveASigmaAndAreRarelyDecoded) {
  const testing_support::TemporaryFolder folder;
  const auto moments = Steady(12);
  const std::string file = Film(folder, moments);
  for (const auto level : {TagTrackLevel::kPreview, TagTrackLevel::kStandard}) {
    const TagsInVideo found = Find(file, moments, level);
    ExpectAllTags(found, moments, 0.15);
    EXPECT_EQ(found.counts.decodes, 1);
    for (const DetectionRow& row : found.rows) {
      EXPECT_EQ(row.hamming.has_value(), row.frame == 0);
      EXPECT_EQ(std::isnan(row.margin), row.frame != 0);
      EXPECT_GT(row.sigma_px, 0.005);
      EXPECT_LT(row.sigma_px, 0.05);
    }
  }
}

TEST(TagsInVideo, WithoutALevelEachPictureIsDecoded) {
  const testing_support::TemporaryFolder folder;
  const auto moments = Steady(3);
  const TagsInVideo found = Find(Film(folder, moments), moments, std::nullopt);
  ExpectAllTags(found, moments, 0.3);
  EXPECT_EQ(found.counts.decodes, 3);
  for (const DetectionRow& row : found.rows) {
    EXPECT_EQ(row.hamming, 0);
    EXPECT_TRUE(std::isnan(row.sigma_px));
  }
  EXPECT_TRUE(RejectedByCause(found.counts).empty());
}

TEST(TagsInVideo, NoTagIsLostWherePicturesAreMissing) {
  const testing_support::TemporaryFolder folder;
  // 2 missing: 3 px beyond the prediction. 9 missing: 14 px.
  const std::vector<double> moments = {0, 1, 2, 3, 6, 7, 8, 18, 19, 20, 21};
  const std::string file = Film(folder, moments);
  for (const auto level : {TagTrackLevel::kPreview, TagTrackLevel::kStandard, TagTrackLevel::kBest}) {
    ExpectAllTags(Find(file, moments, level), moments, 0.15);
  }
}

// Three pictures a second of something that moves: nothing can be foreseen, everything is decoded.
TEST(TagsInVideo, NoTagIsLostWhereEachPictureIsFarFromTheLast) {
  const testing_support::TemporaryFolder folder;
  const std::vector<double> moments = {0, 12, -3, 20, 5, 25, 0, 11};
  const TagsInVideo found = Find(Film(folder, moments), moments, TagTrackLevel::kStandard);
  ExpectAllTags(found, moments, 0.15);
  // Nor are many hopeless fits made.
  long rejected = 0;
  for (const auto& [cause, count] : RejectedByCause(found.counts)) rejected += count;
  EXPECT_LE(rejected, 6);
}

TEST(TagsInVideo, WhatDoesNotFitIsNamed) {
  const testing_support::TemporaryFolder folder;
  const std::string file = Film(folder, Steady(2));
  const auto go_on = [] { return true; };
  EXPECT_NE(FindTagsInVideo(file, 0, 5, {}, go_on).error().message.find("2 frames, but its frame log has 5"),
            std::string::npos);
  EXPECT_EQ(FindTagsInVideo(file, 0, 2, {}, [] { return false; }).error().kind, ErrorKind::kStopped);
  EXPECT_EQ(FindTagsInVideo(folder / "none.mkv", 0, 2, {}, go_on).error().kind, ErrorKind::kNotFound);
  TagsInVideoOptions unknown;
  unknown.detect.family = "tag9";
  EXPECT_EQ(FindTagsInVideo(file, 0, 2, unknown, go_on).error().kind, ErrorKind::kBadInput);
  EXPECT_EQ(TagLevelOf("fast").error().kind, ErrorKind::kBadInput);
  EXPECT_EQ(TagLevelOf("decode").value(), std::nullopt);
}

}  // namespace
}  // namespace tendril
