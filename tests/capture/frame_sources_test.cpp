// capture/record/file_sources.h and virtual_trial.h: what is played is what was recorded; a virtual trial is
// the same for the same seed, and its logs say what its tentacles did.
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "capture/record/file_sources.h"
#include "capture/record/video_file.h"
#include "capture/record/virtual_trial.h"
#include "capture/rig/rig.h"
#include "capture/rig/virtual_rig.h"
#include "db/files/curve_files.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using testing_support::TemporaryFolder;

cv::Mat Picture(int level) { return cv::Mat(32, 48, CV_8UC1, cv::Scalar(level)); }

void WriteVideo(const std::string& file, int frames) {
  auto writer = VideoWriter::Open(file, 48, 32);
  ASSERT_TRUE(writer.ok());
  for (int i = 0; i < frames; ++i) ASSERT_TRUE(writer.value().Write(Picture(i), 0.5 * i).ok());
  ASSERT_TRUE(writer.value().Close().ok());
}

// Every frame until the end or the first error.
std::vector<SourceFrame> Play(FrameSource& source, std::string* error = nullptr) {
  std::vector<SourceFrame> frames;
  while (true) {
    auto next = source.Next();
    if (!next.ok()) {
      EXPECT_NE(error, nullptr) << next.error().message;
      if (error != nullptr) *error = next.error().message;
      return frames;
    }
    if (!next.value()) return frames;
    frames.push_back(std::move(*next.value()));
  }
}

TEST(VideoSource, PlaysAVideoWithItsOwnTimes) {
  const TemporaryFolder folder;
  WriteVideo(folder / "a.mkv", 3);
  auto source = MakeVideoSource(folder / "a.mkv");
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_TRUE(source.value()->paced());
  const auto frames = Play(*source.value());
  ASSERT_EQ(frames.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const SourceFrame& frame = frames[static_cast<std::size_t>(i)];
    EXPECT_EQ(cv::norm(frame.image, Picture(i), cv::NORM_INF), 0);
    EXPECT_NEAR(frame.time, 0.5 * i, 1e-9);
    EXPECT_EQ(frame.frame_id, i);
    EXPECT_FALSE(frame.host_ns.has_value());
  }
}

TEST(VideoSource, ALogBesideItGivesItsStamps) {
  const TemporaryFolder folder;
  WriteVideo(folder / "a.mkv", 3);
  const std::vector<FrameRow> rows = {
      {0, 5, 100, 1000, "ok", 0}, {1, 6, 200, 2000, "ok", 0}, {2, 9, 300, 3000, "late", 2}};
  ASSERT_TRUE(WriteFrameLog(folder / "a.csv", rows).ok());
  auto source = MakeVideoSource(folder / "a.mkv");
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_EQ(source.value()->first_host_ns(), 1000);
  EXPECT_EQ(source.value()->frames(), 3);
  const auto frames = Play(*source.value());
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[2].frame_id, 9);
  EXPECT_EQ(frames[2].device_ns, 300);
  EXPECT_EQ(frames[2].host_ns, 3000);
  EXPECT_EQ(frames[2].status, "late");
}

TEST(VideoSource, ALogOfAnotherLengthIsAnError) {
  const TemporaryFolder folder;
  WriteVideo(folder / "a.mkv", 3);
  std::vector<FrameRow> rows = {{0, 0, 1, 1, "ok", 0}, {1, 1, 2, 2, "ok", 0}};
  for (const std::size_t expected : {2U, 3U}) {
    ASSERT_TRUE(WriteFrameLog(folder / "a.csv", rows).ok());
    auto source = MakeVideoSource(folder / "a.mkv");
    ASSERT_TRUE(source.ok());
    std::string error;
    EXPECT_EQ(Play(*source.value(), &error).size(), expected);
    EXPECT_NE(error.find("a.mkv"), std::string::npos) << error;
    for (std::int64_t i = 2; i < 4; ++i) rows.push_back({i, i, i + 1, i + 1, "ok", 0});
  }
}

TEST(ImageSource, PlaysAFolderByName) {
  const TemporaryFolder folder;
  for (const int i : {2, 0, 1}) cv::imwrite(folder / ("p" + std::to_string(i) + ".png"), Picture(10 * i));
  testing_support::WriteText(folder / "notes.txt", "not a picture");
  auto source = MakeImageSource(folder.path(), 0.1);
  ASSERT_TRUE(source.ok()) << source.error().message;
  const auto frames = Play(*source.value());
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[2].image.at<std::uint8_t>(0, 0), 20);
  EXPECT_NEAR(frames[2].time, 0.2, 1e-12);
}

TEST(ImageSource, BadFoldersAndPicturesAreNamed) {
  const TemporaryFolder folder;
  EXPECT_EQ(MakeImageSource(folder / "none", 1).error().kind, ErrorKind::kNotFound);
  EXPECT_NE(MakeImageSource(folder.path(), 1).error().message.find("no pictures"), std::string::npos);
  EXPECT_FALSE(MakeImageSource(folder.path(), 0).ok());
  cv::imwrite(folder / "a.png", Picture(1));
  testing_support::WriteText(folder / "b.png", "nonsense");
  auto source = MakeImageSource(folder.path(), 1);
  ASSERT_TRUE(source.ok());
  std::string error;
  EXPECT_EQ(Play(*source.value(), &error).size(), 1U);
  EXPECT_NE(error.find("b.png"), std::string::npos);
  cv::imwrite(folder / "b.png", cv::Mat(10, 10, CV_8UC1, cv::Scalar(0)));
  source = MakeImageSource(folder.path(), 1);
  Play(*source.value(), &error);
  EXPECT_NE(error.find("10 x 10"), std::string::npos);
}

TrialSpec SmallTrial() {
  TrialSpec trial;
  trial.gripper.tentacles = 2;
  trial.object.mass = 0.015;
  const auto rig =
      VirtualRig(trial.design, trial.gripper, {.views = {}, .pixel_pitch = 2e-3, .margin_px = 20});
  EXPECT_TRUE(rig.ok()) << rig.error().message;
  trial.rig_toml = RigToml(rig.value());
  return trial;
}

RecordPlan Plan(const TrialSpec& trial, const VirtualTrialOptions& options) {
  auto plan = PlanVirtualTrial(trial, options);
  EXPECT_TRUE(plan.ok()) << plan.error().message;
  return std::move(plan).value();
}

TEST(VirtualTrial, TheSameSeedGivesTheSamePicturesAndLogs) {
  VirtualTrialOptions options;
  options.frames = 3;
  for (const bool same : {true, false}) {
    RecordPlan a = Plan(SmallTrial(), options);
    options.seed = same ? 1 : 2;
    RecordPlan b = Plan(SmallTrial(), options);
    ASSERT_EQ(a.cameras.size(), 2U);
    for (std::size_t c = 0; c < 2; ++c) {
      const auto left = Play(*a.cameras[c]);
      const auto right = Play(*b.cameras[c]);
      ASSERT_EQ(left.size(), 3U);
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(cv::norm(left[i].image, right[i].image, cv::NORM_INF) == 0, same);
        EXPECT_EQ(left[i].time, right[i].time);
      }
    }
    bool equal = true;
    while (true) {
      auto x = a.servo->Next();
      auto y = b.servo->Next();
      ASSERT_TRUE(x.ok() && y.ok());
      if (!x.value() || !y.value()) break;
      equal = equal && x.value()->row.position_deg == y.value()->row.position_deg;
    }
    EXPECT_EQ(equal, same);
    options.seed = 1;
  }
}

// From the flat shape to the full pull, every tentacle arrived, whatever delays were drawn.
TEST(VirtualTrial, ServosGoFromNothingToTheWholePull) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    VirtualTrialOptions options;
    options.seed = seed;
    RecordPlan plan = Plan(SmallTrial(), options);
    std::vector<double> first(2, -1), last(2, -1), previous(2, -1);
    double largest_error = 0;
    while (true) {
      auto next = plan.servo->Next();
      ASSERT_TRUE(next.ok());
      if (!next.value()) break;
      const ServoRow& row = next.value()->row;
      const auto s = static_cast<std::size_t>(row.servo);
      if (first[s] < 0) first[s] = *row.command;
      EXPECT_GE(*row.command, previous[s]);
      previous[s] = last[s] = *row.command;
      // The paper's tendon is 720 mm; it is wound on a spool of 15 mm.
      const double wound = *row.position_deg * M_PI / 180 * 0.015 / 0.720;
      largest_error = std::max(largest_error, std::abs(wound - *row.command));
    }
    for (std::size_t s = 0; s < 2; ++s) {
      EXPECT_EQ(first[s], 0);
      EXPECT_EQ(last[s], 0.3);
    }
    EXPECT_LT(largest_error, 1e-3);
  }
}

TEST(VirtualTrial, TheTruthIsWrittenAndReadBack) {
  const TemporaryFolder folder;
  VirtualTrialOptions options;
  options.fold = {0.93, 1.4, 1.2};
  options.frames = 4;
  options.seed = 18446744073709551615ULL;
  RecordPlan plan = Plan(SmallTrial(), options);
  const Status written = plan.write_also(folder.path());
  ASSERT_TRUE(written.ok()) << written.error().message;
  const auto truth = ReadTruthFile(folder / "truth.toml");
  ASSERT_TRUE(truth.ok()) << truth.error().message;
  EXPECT_EQ(truth.value().seed, options.seed);
  EXPECT_EQ(truth.value().fold.pull_scale, 0.93);
  EXPECT_EQ(truth.value().fold.stiffness_ratio, 1.4);
  EXPECT_EQ(truth.value().fold.stiffness_exponent, 1.2);
  EXPECT_NEAR(truth.value().object.axis.norm(), 1, 1e-12);
  EXPECT_LT((truth.value().object.center - Eigen::Vector3d(0, 0, -0.15)).norm(), 0.03);
  const auto curves = ReadCurves(folder / "truth.h5");
  ASSERT_TRUE(curves.ok()) << curves.error().message;
  ASSERT_EQ(curves.value().size(), 2U);
  EXPECT_EQ(curves.value()[0].name, "tentacle0");
  EXPECT_EQ(curves.value()[0].curves.size(), 4U);
  EXPECT_EQ(curves.value()[0].curves[0].points.cols(), 49);
  // Flat, 720 mm from the first hole to the last.
  const auto& flat = curves.value()[0].curves[0].points;
  EXPECT_NEAR((flat.col(48) - flat.col(0)).norm(), 0.720, 2e-3);
}

TEST(VirtualTrial, BadInputIsNamed) {
  const auto message = [](const TrialSpec& trial, const VirtualTrialOptions& options) {
    const auto plan = PlanVirtualTrial(trial, options);
    return plan.ok() ? std::string() : plan.error().message;
  };
  VirtualTrialOptions options;
  options.frames = 0;
  EXPECT_NE(message(SmallTrial(), options).find("0 frames"), std::string::npos);
  TrialSpec trial = SmallTrial();
  trial.pull_rate = 0;
  EXPECT_NE(message(trial, {}).find("pull rate"), std::string::npos);
  trial = SmallTrial();
  trial.rig_toml = "name = 3";
  EXPECT_FALSE(message(trial, {}).empty());
  trial = SmallTrial();
  trial.object.kind = "sphere";
  EXPECT_NE(message(trial, {}).find("sphere"), std::string::npos);
  trial = SmallTrial();
  trial.tags.family = "tag1";
  EXPECT_NE(message(trial, {}).find("tag1"), std::string::npos);
}

}  // namespace
}  // namespace tendril
