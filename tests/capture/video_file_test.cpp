// capture/record/video_file.h: lossless to the bit and the millisecond; files that are no video, empty,
// damaged or cut off end in one clear line.
#include "capture/record/video_file.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>

namespace tendril {
namespace {

namespace fs = std::filesystem;

class VideoFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              (std::string("video_file_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  // All levels, in noise that no codec can predict.
  static cv::Mat Picture(int width, int height, int seed) {
    cv::RNG random(static_cast<std::uint64_t>(seed) + 1);
    cv::Mat image(height, width, CV_8UC1);
    random.fill(image, cv::RNG::UNIFORM, 0, 256);
    return image;
  }

  fs::path Record(const std::string& name, int width, int height, int frames) {
    const fs::path file = folder_ / name;
    auto writer = VideoWriter::Open(file, width, height);
    EXPECT_TRUE(writer.ok()) << writer.error().message;
    for (int i = 0; i < frames; ++i) {
      const Status s = writer.value().Write(Picture(width, height, i), 0.25 * i);
      EXPECT_TRUE(s.ok()) << s.error().message;
    }
    const Status s = writer.value().Close();
    EXPECT_TRUE(s.ok()) << s.error().message;
    return file;
  }

  // Frames read before the end or the first error; the error's message, if any.
  static std::pair<int, std::string> ReadAll(const fs::path& file) {
    auto reader = VideoReader::Open(file);
    if (!reader.ok()) return {0, reader.error().message};
    for (int n = 0;; ++n) {
      auto frame = reader.value().Next();
      if (!frame.ok()) return {n, frame.error().message};
      if (!frame.value()) return {n, ""};
    }
  }

  static std::string Bytes(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  fs::path folder_;
};

TEST_F(VideoFile, RoundTripIsExact) {
  for (const auto& [width, height] : {std::pair{64, 48}, {16, 16}, {17, 31}, {333, 517}, {1216, 800}}) {
    const fs::path file = Record("a.mkv", width, height, 5);
    auto reader = VideoReader::Open(file);
    ASSERT_TRUE(reader.ok()) << reader.error().message;
    EXPECT_EQ(reader.value().width_px(), width);
    EXPECT_EQ(reader.value().height_px(), height);
    for (int i = 0; i < 5; ++i) {
      auto frame = reader.value().Next();
      ASSERT_TRUE(frame.ok()) << frame.error().message;
      ASSERT_TRUE(frame.value().has_value());
      EXPECT_EQ(frame.value()->index, i);
      EXPECT_NEAR(frame.value()->time, 0.25 * i, 1e-9);
      EXPECT_EQ(cv::norm(frame.value()->image, Picture(width, height, i), cv::NORM_INF), 0)
          << width << " x " << height;
    }
    auto end = reader.value().Next();
    ASSERT_TRUE(end.ok()) << end.error().message;
    EXPECT_FALSE(end.value().has_value());
  }
}

TEST_F(VideoFile, TheSamePicturesGiveTheSameBytes) {
  EXPECT_EQ(Bytes(Record("a.mkv", 200, 150, 3)), Bytes(Record("b.mkv", 200, 150, 3)));
}

TEST_F(VideoFile, TimesKeepRisingWhereTheClockStandsStill) {
  auto writer = VideoWriter::Open(folder_ / "a.mkv", 16, 16);
  ASSERT_TRUE(writer.ok());
  for (const double t : {0.0, 0.0, -5.0, 1.0}) ASSERT_TRUE(writer.value().Write(Picture(16, 16, 1), t).ok());
  ASSERT_TRUE(writer.value().Close().ok());
  ASSERT_TRUE(writer.value().Close().ok());  // again is nothing
  EXPECT_EQ(ReadAll(folder_ / "a.mkv"), (std::pair<int, std::string>{4, ""}));
}

TEST_F(VideoFile, NoFramesIsAVideoOfNoFrames) {
  const auto [frames, message] = ReadAll(Record("none.mkv", 64, 64, 0));
  EXPECT_EQ(frames, 0);
}

TEST_F(VideoFile, WhatIsNoVideoIsSaidSo) {
  std::ofstream(folder_ / "empty.mkv").flush();
  std::ofstream(folder_ / "text.mkv") << "frame,frame_id\n0,0\n";
  std::ofstream(folder_ / "header.mkv", std::ios::binary) << "\x1A\x45\xDF\xA3";
  EXPECT_NE(ReadAll(folder_ / "empty.mkv").second.find("empty.mkv: an empty file"), std::string::npos);
  EXPECT_NE(ReadAll(folder_ / "text.mkv").second.find("text.mkv: not a video"), std::string::npos);
  EXPECT_NE(ReadAll(folder_ / "header.mkv").second.find("header.mkv"), std::string::npos);
  const auto missing = VideoReader::Open(folder_ / "nowhere.mkv");
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().kind, ErrorKind::kNotFound);
  EXPECT_FALSE(VideoReader::Open(folder_).ok());
}

TEST_F(VideoFile, ATruncatedFileGivesItsWholeFramesThenAnError) {
  const fs::path file = Record("a.mkv", 200, 150, 8);
  const auto size = fs::file_size(file);
  for (const double share : {0.95, 0.6, 0.3}) {
    const fs::path cut = folder_ / "cut.mkv";
    fs::copy_file(file, cut, fs::copy_options::overwrite_existing);
    fs::resize_file(cut, static_cast<std::uintmax_t>(share * static_cast<double>(size)));
    const auto [frames, message] = ReadAll(cut);
    EXPECT_FALSE(message.empty()) << share;
    EXPECT_GE(frames, static_cast<int>(8 * share) - 1);
    EXPECT_LT(frames, 8);
  }
}

TEST_F(VideoFile, ADamagedFrameIsNoticed) {
  const fs::path file = Record("a.mkv", 200, 150, 4);
  std::fstream bytes(file, std::ios::binary | std::ios::in | std::ios::out);
  bytes.seekp(static_cast<std::streamoff>(fs::file_size(file) / 2));
  bytes << "xxxxxxxxxxxxxxxx";
  bytes.close();
  const auto [frames, message] = ReadAll(file);
  EXPECT_NE(message.find("is damaged"), std::string::npos) << message;
  EXPECT_LT(frames, 4);
}

TEST_F(VideoFile, WithoutCloseTheFramesSoFarCanBeRead) {
  {
    auto writer = VideoWriter::Open(folder_ / "a.mkv", 100, 80);
    ASSERT_TRUE(writer.ok());
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer.value().Write(Picture(100, 80, i), i).ok());
  }
  EXPECT_EQ(ReadAll(folder_ / "a.mkv"), (std::pair<int, std::string>{3, ""}));
}

TEST_F(VideoFile, BadCallsAreRefused) {
  EXPECT_FALSE(VideoWriter::Open(folder_ / "a.mkv", 0, 20).ok());
  const auto nowhere = VideoWriter::Open(folder_ / "no" / "a.mkv", 20, 20);
  ASSERT_FALSE(nowhere.ok());
  EXPECT_EQ(nowhere.error().kind, ErrorKind::kIo);
  auto writer = VideoWriter::Open(folder_ / "b.mkv", 20, 20);
  ASSERT_TRUE(writer.ok());
  EXPECT_FALSE(writer.value().Write(Picture(21, 20, 1), 0).ok());
  EXPECT_FALSE(writer.value().Write(cv::Mat(), 0).ok());
  EXPECT_FALSE(writer.value().Write(cv::Mat(20, 20, CV_8UC3), 0).ok());
}

TEST_F(VideoFile, AFullDiskIsAnError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  auto writer = VideoWriter::Open("/dev/full", 400, 300);
  bool failed = !writer.ok();
  for (int i = 0; i < 4 && !failed; ++i) failed = !writer.value().Write(Picture(400, 300, i), i).ok();
  if (!failed) failed = !writer.value().Close().ok();
  EXPECT_TRUE(failed);
}

}  // namespace
}  // namespace tendril
