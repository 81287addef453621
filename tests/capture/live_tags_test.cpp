// capture/record/live_source.h, capture/track/live_tags.h: real sockets, pipes and files, and what goes
// wrong.
#include "capture/track/live_tags.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <csignal>

#include "tests/support/stream_server.h"

namespace tendril {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing_support::FilmOfTags;
using testing_support::StreamServer;
using testing_support::TemporaryFolder;
using Clock = std::chrono::steady_clock;

LiveTags Start(const std::vector<std::string>& sources, LiveTagsOptions options = {}) {
  options.retry = 0.1;
  auto started = LiveTags::Start(sources, options);
  EXPECT_TRUE(started.ok()) << started.error().message;
  return std::move(started).value();
}

// Looks until `enough`, 20 s at most.
template <class Enough>
std::vector<LiveCamera> LookUntil(const LiveTags& tags, const Enough& enough) {
  const auto end = Clock::now() + std::chrono::seconds(20);
  std::vector<LiveCamera> now;
  do {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    now = tags.Look(true);
  } while (!enough(now) && Clock::now() < end);
  return now;
}

TEST(LiveTags, AStreamOverASocketIsFollowedAndReachedAgain) {
  const TemporaryFolder folder;
  const StreamServer server(FilmOfTags(folder / "a.mkv", {3, 7}, 30, 100), 30, 10);
  const LiveTags tags = Start({server.url()});
  auto now = LookUntil(tags, [](const auto& c) { return c[0].seen.size() == 2; });
  EXPECT_THAT(now[0].seen, ElementsAre(3, 7));
  EXPECT_EQ(now[0].width_px, 240);
  EXPECT_EQ(now[0].picture.cols, 240);
  EXPECT_EQ(now[0].tags.size(), 2u);
  EXPECT_NEAR(now[0].blur_px, 0.8, 0.25);
  // The server hangs up at the film's end: told, and tried again.
  now = LookUntil(tags, [](const auto& c) { return c[0].times_lost >= 2 && c[0].arrived > 70; });
  EXPECT_GE(now[0].times_lost, 2);
  EXPECT_GE(server.callers(), 3);
  EXPECT_THAT(now[0].problem.message, HasSubstr(server.url() + ": the stream ended"));
}

TEST(LiveTags, APipeIsFollowedWhileAnotherCameraIsGone) {
  const TemporaryFolder folder;
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const std::string film = testing_support::ReadText(FilmOfTags(folder / "a.mkv", {1}, 40, 100));
  FilmOfTags(folder / "short.mkv", {9}, 5, 100);
  const LiveTags tags = Start({pipe, folder / "short.mkv"});
  std::signal(SIGPIPE, SIG_IGN);
  std::thread writer([&] {
    const int out = open(pipe.c_str(), O_WRONLY | O_CLOEXEC);  // waits for the reader
    for (std::size_t at = 0; at < film.size(); at += 4096) {
      if (write(out, film.data() + at, std::min<std::size_t>(4096, film.size() - at)) < 0) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(3));
    }
    close(out);
  });
  const auto now =
      LookUntil(tags, [](const auto& c) { return c[0].arrived >= 30 && c[1].state == LiveState::kEnded; });
  writer.join();
  EXPECT_GE(now[0].arrived, 30);
  EXPECT_THAT(now[0].seen, ElementsAre(1));
  EXPECT_EQ(now[1].state, LiveState::kEnded);
  EXPECT_EQ(now[1].arrived, 5);
  EXPECT_GE(now[1].tracked, 1);
  EXPECT_LE(now[1].tracked, 5);
}

TEST(LiveTags, AFilePlaysAtItsOwnPace) {
  const TemporaryFolder folder;
  const LiveTags tags = Start({FilmOfTags(folder / "a.mkv", {5}, 41, 50)});
  const auto start = Clock::now();
  const auto now = LookUntil(tags, [](const auto& c) { return c[0].state == LiveState::kEnded; });
  EXPECT_GT(std::chrono::duration<double>(Clock::now() - start).count(), 0.75);
  EXPECT_EQ(now[0].arrived, 41);
  EXPECT_EQ(now[0].times_lost, 0);
}

TEST(LiveTags, ATagThatIsNotSeenAnyMoreIsLost) {
  const TemporaryFolder folder;
  LiveTagsOptions options;
  options.now = 0.1;
  const LiveTags tags = Start({FilmOfTags(folder / "a.mkv", {5}, 3, 100)}, options);
  LookUntil(tags, [](const auto& c) { return c[0].state == LiveState::kEnded; });
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  const auto now = tags.Look();
  EXPECT_TRUE(now[0].seen.empty());
  EXPECT_THAT(now[0].lost, ElementsAre(5));
  EXPECT_TRUE(now[0].picture.empty());
}

TEST(LiveTags, WhatCannotBeOpenedIsNamed) {
  const TemporaryFolder folder;
  testing_support::WriteText(folder / "text", "no video");
  int port = 0;
  { port = std::stoi(StreamServer(folder / "text", 1, 0).url().substr(16)); }  // nobody listens there now
  struct Bad {
    std::string source, says;
    ErrorKind kind;
  };
  const std::vector<Bad> all = {
      {"/dev/video77", "no such device or file", ErrorKind::kNotFound},
      {folder / "text", "no video", ErrorKind::kBadInput},
      {folder.path().string(), "neither a device", ErrorKind::kBadInput},
      {"/dev/null", "not a V4L2 camera", ErrorKind::kIo},
      {"morse://somewhere", "a protocol that libavformat does not know", ErrorKind::kBadInput},
      {"tcp://127.0.0.1:" + std::to_string(port), "Connection refused", ErrorKind::kIo},
  };
  for (const Bad& bad : all) {
    const LiveTags tags = Start({bad.source});
    const auto now = LookUntil(tags, [](const auto& c) { return c[0].state == LiveState::kFailed; });
    EXPECT_EQ(now[0].state, LiveState::kFailed) << bad.source;
    EXPECT_THAT(now[0].problem.message, HasSubstr(bad.source));
    EXPECT_THAT(now[0].problem.message, HasSubstr(bad.says));
    EXPECT_EQ(now[0].problem.kind, bad.kind) << now[0].problem.message;
  }
  EXPECT_EQ(LiveTags::Start({}, {}).error().kind, ErrorKind::kBadInput);
}

TEST(LiveTags, SilenceIsToldAndEndsAtOnceWhenStopped) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  LiveTagsOptions options;
  options.open_wait = 0.2;
  {
    const LiveTags tags = Start({folder / "pipe"}, options);
    const auto now = LookUntil(tags, [](const auto& c) { return c[0].state == LiveState::kFailed; });
    EXPECT_THAT(now[0].problem.message, HasSubstr("nothing arrived for 0.2 s"));
  }
  const auto start = Clock::now();
  { const LiveTags tags = Start({folder / "pipe"}); }  // would wait for 10 s
  EXPECT_LT(Clock::now() - start, std::chrono::seconds(2));
}

}  // namespace
}  // namespace tendril
