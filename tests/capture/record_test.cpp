// capture/record/record.h: what is recorded, what is lost and counted, and what the lab says of a recording
// that was stopped or broke.
#include "capture/record/record.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <opencv2/core.hpp>
#include <thread>

#include "capture/record/video_file.h"
#include "db/files/recording_logs.h"
#include "db/trial_query.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using testing_support::TemporaryFolder;
using namespace std::chrono_literals;

// A camera with numbered pictures; live ones go on by themselves.
class FakeCamera : public FrameSource {
 public:
  struct Options {
    int frames = 20;
    bool paced = true;
    std::chrono::milliseconds every{0};
    int fails_at = -1;
    int skips_at = -1;  // the camera itself loses three pictures before this one
  };
  explicit FakeCamera(Options options) : options_(options) {}
  bool paced() const override { return options_.paced; }
  std::optional<std::int64_t> frames() const override { return options_.frames; }
  Result<std::optional<SourceFrame>> Next() override {
    if (next_ == options_.frames) return std::optional<SourceFrame>();
    if (next_ == options_.fails_at) return Error{ErrorKind::kIo, "the cable came off"};
    std::this_thread::sleep_for(options_.every);
    if (next_ == options_.skips_at) skipped_ = 3;
    SourceFrame frame;
    frame.image = cv::Mat(16, 24, CV_8UC1, cv::Scalar(next_ % 256));
    frame.time = 0.1 * (next_ + skipped_);
    frame.frame_id = next_ + skipped_;
    ++next_;
    return std::optional<SourceFrame>(std::move(frame));
  }

 private:
  Options options_;
  int next_ = 0;
  int skipped_ = 0;
};

class FakeServo : public ServoSource {
 public:
  explicit FakeServo(int rows) : rows_(rows) {}
  Result<std::optional<ServoSample>> Next() override {
    if (next_ == rows_) return std::optional<ServoSample>();
    ServoSample sample;
    sample.time = 0.05 * next_;
    sample.row.command = 0.01 * next_++;
    return std::optional<ServoSample>(std::move(sample));
  }

 private:
  int rows_;
  int next_ = 0;
};

class Recording : public testing::Test {
 protected:
  void SetUp() override {
    auto made = Lab::Create(folder_.path() / "lab");
    ASSERT_TRUE(made.ok()) << made.error().message;
    lab_.emplace(std::move(made).value());
  }
  static RecordPlan Plan(std::vector<FakeCamera::Options> cameras) {
    RecordPlan plan;
    plan.trial.label = "t";
    plan.trial.design_name = "paper";
    plan.trial.started_ns = 1700000000000000000;
    for (const auto& options : cameras) plan.cameras.push_back(std::make_unique<FakeCamera>(options));
    return plan;
  }
  TrialState State() {
    const auto trials = ListTrials(*lab_);
    EXPECT_TRUE(trials.ok() && trials.value().size() == 1U);
    id_ = trials.value().at(0).id;
    return trials.value().at(0).state;
  }
  std::vector<FrameRow> Log(int camera) {
    auto rows = ReadFrameLog(lab_->TrialFolder(id_) / ("cam" + std::to_string(camera) + ".csv"));
    EXPECT_TRUE(rows.ok()) << rows.error().message;
    return rows.ok() ? rows.value() : std::vector<FrameRow>();
  }
  // The levels of the pictures in a video, in order.
  std::vector<int> Levels(int camera) {
    std::vector<int> levels;
    auto video = VideoReader::Open(lab_->TrialFolder(id_) / ("cam" + std::to_string(camera) + ".mkv"));
    EXPECT_TRUE(video.ok()) << video.error().message;
    while (video.ok()) {
      auto frame = video.value().Next();
      EXPECT_TRUE(frame.ok()) << frame.error().message;
      if (!frame.ok() || !frame.value()) break;
      levels.push_back(frame.value()->image.at<std::uint8_t>(0, 0));
    }
    return levels;
  }

  TemporaryFolder folder_;
  std::optional<Lab> lab_;
  std::string id_;
};

TEST_F(Recording, KeepsEveryPictureOfPacedSourcesHoweverSlowTheDisk) {
  RecordPlan plan = Plan({{.frames = 15}, {.frames = 12}});
  plan.servo = std::make_unique<FakeServo>(30);
  plan.queue_frames = 2;
  plan.before_write = [](int) { std::this_thread::sleep_for(5ms); };
  const auto recorded = Record(*lab_, std::move(plan));
  ASSERT_TRUE(recorded.ok()) << recorded.error().message;
  EXPECT_EQ(recorded.value().state, TrialState::kRecorded);
  EXPECT_EQ(State(), TrialState::kRecorded);
  EXPECT_EQ(recorded.value().cameras[0].frames, 15);
  EXPECT_EQ(recorded.value().cameras[1].dropped, 0);
  const auto levels = Levels(0);
  ASSERT_EQ(levels.size(), 15U);
  for (int i = 0; i < 15; ++i) EXPECT_EQ(levels[static_cast<std::size_t>(i)], i);
  const auto log = Log(1);
  ASSERT_EQ(log.size(), 12U);
  EXPECT_EQ(log[11].host_ns, 1700000000000000000 + 1100000000);
  EXPECT_EQ(log[11].dropped_before, 0);
  const auto servo = ReadServoLog(lab_->TrialFolder(id_) / "servo.csv");
  ASSERT_TRUE(servo.ok());
  EXPECT_EQ(servo.value().size(), 30U);
  EXPECT_EQ(recorded.value().servo_rows, 30);
}

TEST_F(Recording, CountsWhatALiveSourceLosesToAFullQueue) {
  RecordPlan plan = Plan({{.frames = 60, .paced = false, .every = 1ms}});
  plan.queue_frames = 2;
  plan.before_write = [](int) { std::this_thread::sleep_for(10ms); };
  const auto recorded = Record(*lab_, std::move(plan));
  ASSERT_TRUE(recorded.ok()) << recorded.error().message;
  const CameraAccount& camera = recorded.value().cameras[0];
  EXPECT_EQ(recorded.value().state, TrialState::kDegraded);
  EXPECT_EQ(State(), TrialState::kDegraded);
  EXPECT_NE(recorded.value().reason.find("cam0 lost"), std::string::npos);
  EXPECT_GT(camera.dropped, 20);
  EXPECT_EQ(camera.frames + camera.dropped, 60);
  // The log accounts for every picture up to the last that was kept, and the video holds the ones it names.
  const auto log = Log(0);
  const auto levels = Levels(0);
  ASSERT_EQ(log.size(), levels.size());
  std::int64_t expected_id = 0;
  for (std::size_t i = 0; i < log.size(); ++i) {
    expected_id += log[i].dropped_before;
    EXPECT_EQ(log[i].frame_id, expected_id);
    EXPECT_EQ(levels[i], expected_id);
    ++expected_id;
  }
}

TEST_F(Recording, CountsWhatTheCameraItselfLost) {
  const auto recorded = Record(*lab_, Plan({{.frames = 10, .skips_at = 4}}));
  ASSERT_TRUE(recorded.ok());
  EXPECT_EQ(recorded.value().cameras[0].dropped, 3);
  EXPECT_EQ(State(), TrialState::kDegraded);
  const auto log = Log(0);
  EXPECT_EQ(log[3].dropped_before, 0);
  EXPECT_EQ(log[4].dropped_before, 3);
}

TEST_F(Recording, StoppedKeepsWhatItHas) {
  RecordPlan plan = Plan({{.frames = 100000, .every = 2ms}, {.frames = 100000, .every = 2ms}});
  const auto started = std::chrono::steady_clock::now();
  const auto recorded = Record(*lab_, std::move(plan),
                               [&](double) { return std::chrono::steady_clock::now() - started < 300ms; });
  ASSERT_TRUE(recorded.ok()) << recorded.error().message;
  EXPECT_EQ(recorded.value().state, TrialState::kAborted);
  EXPECT_EQ(State(), TrialState::kAborted);
  for (int camera = 0; camera < 2; ++camera) {
    EXPECT_GT(Levels(camera).size(), 1U);
    EXPECT_EQ(Levels(camera).size(), Log(camera).size());
  }
}

TEST_F(Recording, ABrokenSourceLeavesAFailedRowAndTheFiles) {
  const auto recorded = Record(*lab_, Plan({{.frames = 10, .fails_at = 6}, {.frames = 10}}));
  ASSERT_FALSE(recorded.ok());
  EXPECT_NE(recorded.error().message.find("cam0: the cable came off"), std::string::npos);
  EXPECT_EQ(State(), TrialState::kFailed);
  EXPECT_EQ(Levels(0).size(), 6U);
}

TEST_F(Recording, ADiskThatTakesNoMoreLeavesAFailedRow) {
  RecordPlan plan = Plan({{.frames = 10}});
  plan.write_also = [](const std::filesystem::path& folder) -> Status {
    std::filesystem::create_directory(folder / "cam0.mkv");  // in the video's way
    return Ok{};
  };
  ASSERT_FALSE(Record(*lab_, std::move(plan)).ok());
  EXPECT_EQ(State(), TrialState::kFailed);
}

TEST_F(Recording, NoPictureIsAFailure) {
  const auto recorded = Record(*lab_, Plan({{.frames = 0}}));
  ASSERT_FALSE(recorded.ok());
  EXPECT_NE(recorded.error().message.find("no picture"), std::string::npos);
  EXPECT_EQ(State(), TrialState::kFailed);
}

TEST_F(Recording, ACallWithoutSourcesLeavesNothingBehind) {
  EXPECT_FALSE(Record(*lab_, Plan({})).ok());
  RecordPlan plan = Plan({{.frames = 1}});
  plan.queue_frames = 0;
  EXPECT_FALSE(Record(*lab_, std::move(plan)).ok());
  EXPECT_TRUE(ListTrials(*lab_).value().empty());
}

TEST_F(Recording, TheRowSaysRecordingFromTheFirstMoment) {
  RecordPlan plan = Plan({{.frames = 3}});
  std::optional<TrialState> during;
  plan.write_also = [&](const std::filesystem::path& folder) -> Status {
    EXPECT_TRUE(std::filesystem::exists(folder / "trial.toml"));
    during = State();
    return Ok{};
  };
  ASSERT_TRUE(Record(*lab_, std::move(plan)).ok());
  EXPECT_EQ(during, TrialState::kRecording);
}

}  // namespace
}  // namespace tendril
