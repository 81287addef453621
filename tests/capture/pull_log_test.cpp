// capture/record/pull_log.h: a command's state from its log, and each tentacle's pull.
#include "capture/record/pull_log.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "tests/support/servo_log.h"

namespace tendril {
namespace {

using test::kLogStart;
using test::RampLog;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(StateAt, FollowsRestRampAndHold) {
  const CommandLog log = CommandsOf(RampLog(3), 3, kLogStart);
  ASSERT_EQ(log.time.size(), 51);
  const CommandState rest = StateAt(log, 0.55);
  EXPECT_EQ(rest.pull, 0);
  EXPECT_EQ(rest.settled_for, kInfinity);
  EXPECT_EQ(rest.steady_for, kInfinity);
  EXPECT_EQ(StateAt(log, -3).pull, 0);
  EXPECT_EQ(StateAt(log, -3).settled_for, kInfinity);

  const CommandState ramp = StateAt(log, 2.25);
  EXPECT_NEAR(ramp.pull, 0.125, 1e-9);
  EXPECT_EQ(ramp.settled_for, 0);
  EXPECT_NEAR(ramp.steady_for, 1.25, 0.11);

  const CommandState hold = StateAt(log, 4.25);
  EXPECT_NEAR(hold.pull, 0.2, 1e-12);
  EXPECT_NEAR(hold.settled_for, 1.25, 0.11);
  EXPECT_NEAR(hold.steady_for, 1.25, 0.11);

  EXPECT_NEAR(StateAt(log, 5.4).pull, 0.2, 1e-12);
  EXPECT_TRUE(std::isnan(StateAt(log, 6).pull));
  EXPECT_TRUE(std::isnan(StateAt(CommandsOf(RampLog(3), 4, kLogStart), 1).pull));
}

TEST(StateAt, ALogThatBeginsPulledSaysOnlyWhatItSaw) {
  std::vector<ServoRow> rows = RampLog(0);
  rows.erase(rows.begin(), rows.begin() + 40);
  const CommandLog log = CommandsOf(rows, 0, kLogStart);
  EXPECT_NEAR(StateAt(log, 4.7).settled_for, 0.7, 1e-6);
  EXPECT_TRUE(std::isnan(StateAt(log, 3).pull));
}

TEST(CommandsOf, OfRowsAtTheSameTimeTheLastCounts) {
  std::vector<ServoRow> rows = RampLog(0);
  rows.push_back(rows[20]);
  rows.back().command = 0.07;
  const CommandLog log = CommandsOf(rows, 0, kLogStart);
  ASSERT_EQ(log.time.size(), 51);
  EXPECT_EQ(StateAt(log, 2).pull, 0.07);
}

class PullLogTest : public ::testing::Test {
 protected:
  PullLogTest() {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ("pull_log_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    trial_.started_ns = kLogStart;
    trial_.pull = 0.3;
    trial_.pull_rate = 0.03;
  }
  ~PullLogTest() override { std::filesystem::remove_all(folder_); }

  PullLog Read(const std::vector<ServoRow>& rows) {
    EXPECT_TRUE(WriteServoLog(folder_ / "servo.csv", rows).ok());
    return PullLog::Read(folder_, trial_).value();
  }

  std::filesystem::path folder_;
  TrialSpec trial_;
};

TEST_F(PullLogTest, WithoutALogThePullIsTheRamp) {
  const PullLog log = PullLog::Read(folder_, trial_).value();
  EXPECT_NEAR(log.At(0, 5), 0.15, 1e-15);
  EXPECT_EQ(log.At(1, -1), 0);
  EXPECT_EQ(log.At(1, 60), 0.3);
}

TEST_F(PullLogTest, ServoIPullsTentacleIAndOneAlonePullsAll) {
  std::vector<ServoRow> rows = RampLog(0);
  for (const ServoRow& row : RampLog(2, 0.5)) rows.push_back(row);
  const PullLog two = Read(rows);
  EXPECT_NEAR(two.At(0, 2.25), 0.125, 1e-9);
  EXPECT_NEAR(two.At(2, 2.25), 0.075, 1e-9);
  EXPECT_NEAR(two.At(1, 2), 0.06, 1e-15);  // no log of its own: the ramp
  EXPECT_NEAR(two.At(0, 99), 0.2, 1e-12);  // beyond the log as at its end

  const PullLog alone = Read(RampLog(2147483647));
  for (const int tentacle : {0, 7}) EXPECT_NEAR(alone.At(tentacle, 2.25), 0.125, 1e-9);
}

}  // namespace
}  // namespace tendril
