// db/files/recording_logs.h: the formats' headers, round trips, and every slip named.
#include "db/files/recording_logs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/program.h"

namespace tendril {
namespace {

using testing::HasSubstr;
using testing_support::TemporaryFolder;

class RecordingLogs : public testing::Test {
 protected:
  std::string File(const std::string& text) {
    testing_support::WriteText(folder_ / "log.csv", text);
    return folder_ / "log.csv";
  }
  template <class Rows>
  static std::string MessageOf(const Result<Rows>& read) {
    return read.ok() ? "" : read.error().message;
  }
  TemporaryFolder folder_;
};

constexpr const char* kFrames = "frame,frame_id,device_ns,host_ns,status,dropped_before\n";
constexpr const char* kServo =
    "host_ns,device_ms,servo,command,position_deg,current_mA,voltage_V,temperature_degC\n";
constexpr const char* kDetections = "camera,frame,tag,hamming,margin,x0,y0,x1,y1,x2,y2,x3,y3\n";

TEST_F(RecordingLogs, StampsStayWholeNumbersOfNanoseconds) {
  const std::vector<FrameRow> rows = {{0, 7, 9'007'199'254'740'993, 1'700'000'000'123'456'789, "ok", 0},
                                      {1, 9, INT64_MAX, 1'700'000'000'123'456'790, "incomplete", 1}};
  ASSERT_TRUE(WriteFrameLog(folder_ / "cam0.csv", rows).ok());
  const auto read = ReadFrameLog(folder_ / "cam0.csv");
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read.value().size(), 2U);
  EXPECT_EQ(read.value()[0].device_ns, 9'007'199'254'740'993);  // no double holds it
  EXPECT_EQ(read.value()[1].device_ns, INT64_MAX);
  EXPECT_EQ(read.value()[1].status, "incomplete");
  EXPECT_EQ(read.value()[1].dropped_before, 1);
  EXPECT_EQ(testing_support::ReadText(folder_ / "cam0.csv"),
            FrameLogHeader() + FrameLogLine(rows[0]) + FrameLogLine(rows[1]));
}

TEST_F(RecordingLogs, WhatAServoDoesNotReportIsEmptyAndComesBackEmpty) {
  const std::vector<ServoRow> rows = {
      {.host_ns = 1, .servo = 3, .command = 0.1},
      {.host_ns = 2, .device_ms = 5, .servo = 0, .position_deg = -0.25, .temperature_degC = 31}};
  ASSERT_TRUE(WriteServoLog(folder_ / "servo.csv", rows).ok());
  EXPECT_EQ(testing_support::ReadText(folder_ / "servo.csv"),
            std::string(kServo) + "1,,3,0.1,,,,\n2,5,0,,-0.25,,,31\n");
  const auto read = ReadServoLog(folder_ / "servo.csv");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_FALSE(read.value()[0].device_ms.has_value());
  EXPECT_EQ(read.value()[0].command, 0.1);
  EXPECT_EQ(read.value()[1].device_ms, 5);
  EXPECT_FALSE(read.value()[1].command.has_value());
  EXPECT_EQ(read.value()[1].temperature_degC, 31);
}

TEST_F(RecordingLogs, CornersKeepEveryBit) {
  DetectionRow row{.camera = 1, .frame = 2, .tag = 586, .hamming = 0, .margin = 0.1F, .corners_px = {}};
  for (int i = 0; i < 8; ++i) row.corners_px.data()[i] = 1000.0 / (i + 3);
  ASSERT_TRUE(WriteDetections(folder_ / "d.csv", std::vector{row}).ok());
  const auto read = ReadDetections(folder_ / "d.csv");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read.value()[0].corners_px, row.corners_px);
  EXPECT_EQ(read.value()[0].margin, row.margin);
  EXPECT_EQ(read.value()[0].tag, 586);
}

TEST_F(RecordingLogs, ATagThatWasFollowedHasNoBitsButASigma) {
  DetectionRow followed{.camera = 0, .frame = 0, .tag = 1, .corners_px = {}, .sigma_px = 0.025};
  followed.corners_px.setConstant(8);
  ASSERT_TRUE(WriteDetections(folder_ / "d.csv", std::vector{followed}).ok());
  EXPECT_THAT(testing_support::ReadText(folder_ / "d.csv"), HasSubstr("\n0,0,1,,,8,8,8,8,8,8,8,8,0.025\n"));
  const auto read = ReadDetections(folder_ / "d.csv");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_FALSE(read.value()[0].hamming);
  EXPECT_TRUE(std::isnan(read.value()[0].margin));
  EXPECT_EQ(read.value()[0].sigma_px, 0.025);
}

TEST_F(RecordingLogs, DetectionsWithoutSigmaAreReadAsBefore) {
  const auto read = ReadDetections(File(std::string(kDetections) + "0,0,1,2,30,1,2,3,4,5,6,7,8\n"));
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read.value()[0].hamming, 2);
  EXPECT_EQ(read.value()[0].corners_px(1, 3), 8);
  EXPECT_TRUE(std::isnan(read.value()[0].sigma_px));
}

TEST_F(RecordingLogs, ResidualsKeepEveryBitAndWhetherTheTagWasUsed) {
  std::vector<ResidualRow> rows(2);
  rows[0].camera = 1;
  rows[0].frame = 7;
  rows[0].tag = 586;
  rows[0].used = true;
  rows[0].corners_px << 0.1, -1.0 / 3, 1e-17, 4, 5, 6, 7, -0.0;
  rows[1].frame = 8;
  rows[1].corners_px.setConstant(std::nan(""));  // behind the camera
  ASSERT_TRUE(WriteResiduals(folder_ / "residuals.csv", rows).ok());
  EXPECT_THAT(testing_support::ReadText(folder_ / "residuals.csv"), HasSubstr("0,8,0,0,,,,,,,,\n"));
  const auto read = ReadResiduals(folder_ / "residuals.csv");
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read.value().size(), 2U);
  EXPECT_EQ(read.value()[0].corners_px, rows[0].corners_px);
  EXPECT_TRUE(read.value()[0].used);
  EXPECT_EQ(read.value()[0].frame, 7);
  EXPECT_FALSE(read.value()[1].used);
  EXPECT_TRUE(read.value()[1].corners_px.array().isNaN().all());
  EXPECT_THAT(
      MessageOf(ReadResiduals(File("camera,frame,tag,used,x0,y0,x1,y1,x2,y2,x3,y3\n0,0,0,2,,,,,,,,\n"))),
      HasSubstr("used = '2': expected"));
}

TEST_F(RecordingLogs, AHeaderAloneIsARecordingOfNothing) {
  EXPECT_TRUE(ReadFrameLog(File(kFrames)).value().empty());
  EXPECT_TRUE(ReadServoLog(File(kServo)).value().empty());
  EXPECT_TRUE(ReadDetections(File(kDetections)).value().empty());
}

TEST_F(RecordingLogs, EachSlipIsOneLineWithPlaceFieldAndWhatWasExpected) {
  const std::string f = kFrames;
  EXPECT_THAT(MessageOf(ReadFrameLog(File(""))), HasSubstr("log.csv: empty, expected the header frame,"));
  EXPECT_THAT(MessageOf(ReadFrameLog(File(kServo))), HasSubstr("log.csv:1: header is"));
  EXPECT_THAT(MessageOf(ReadFrameLog(File(f + "0,1,2,3,ok,0\n2,2,3,4,ok,0\n"))),
              HasSubstr("log.csv:3: frame = '2': expected 1"));
  EXPECT_THAT(MessageOf(ReadFrameLog(File(f + "0,5,2,3,ok,0\n1,4,3,4,ok,0\n"))), HasSubstr("frame_id = '4'"));
  EXPECT_THAT(MessageOf(ReadFrameLog(File(f + "0,5,2,3,ok,0\n1,6,3,2,ok,0\n"))), HasSubstr("host_ns = '2'"));
  EXPECT_THAT(MessageOf(ReadFrameLog(File(f + "0,1,2.5,3,ok,0\n"))),
              HasSubstr("device_ns = '2.5': expected a whole number"));
  EXPECT_THAT(MessageOf(ReadFrameLog(File(f + "0,1,2,3,ok,-1\n"))),
              HasSubstr("dropped_before = '-1': expected a whole number >= 0"));
  EXPECT_THAT(MessageOf(ReadFrameLog(File(f + "0,1,99999999999999999999,3,ok,0\n"))),
              HasSubstr("device_ns = '9999"));
  EXPECT_THAT(MessageOf(ReadFrameLog(File(f + "0,1,2,3,ok,1"))),
              HasSubstr("log.csv:2: the last line has no newline"));
  EXPECT_THAT(MessageOf(ReadServoLog(File(std::string(kServo) + "1,,0,nan,,,,\n"))),
              HasSubstr("command = 'nan': expected a number"));
  EXPECT_THAT(MessageOf(ReadServoLog(File(std::string(kServo) + "1,,-1,,,,,\n"))), HasSubstr("servo = '-1'"));
  EXPECT_THAT(MessageOf(ReadDetections(File(std::string(kDetections) + "0,0,1,0,30,1,2,3,4,5,6,7\n"))),
              HasSubstr("has 12 fields, expected 13"));
  EXPECT_THAT(MessageOf(ReadDetections(File(std::string(kDetections) + "0,0,1,0,30,1,2,3,4,5,6,7,inf\n"))),
              HasSubstr("y3 = 'inf'"));
  EXPECT_EQ(ReadDetections("/nowhere.csv").error().kind, ErrorKind::kNotFound);
}

TEST_F(RecordingLogs, BinaryRubbishIsShownHarmlessly) {
  const std::string message = MessageOf(ReadFrameLog(File(std::string("\x00\x1b[2J\xff\xfe garbage", 14))));
  EXPECT_EQ(message.find('\x1b'), std::string::npos);
  EXPECT_THAT(message, HasSubstr("log.csv:1: header is"));
}

TEST_F(RecordingLogs, AStatusThatWouldTearTheRowIsRefused) {
  const Status s = WriteFrameLog(folder_ / "x.csv", std::vector<FrameRow>{{.status = "bad, very"}});
  ASSERT_FALSE(s.ok());
  EXPECT_FALSE(std::filesystem::exists(folder_ / "x.csv"));
}

}  // namespace
}  // namespace tendril
