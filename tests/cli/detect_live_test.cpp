// tendril detect --live through the built program: real streams in, lines out, and calls that cannot be.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "tests/support/stream_server.h"

namespace tendril {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing_support::FilmOfTags;
using testing_support::RunProgram;
using testing_support::StreamServer;
using testing_support::TemporaryFolder;

std::vector<json> Lines(const std::string& text) {
  std::vector<json> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(json::parse(line));
  return lines;
}

TEST(DetectLive, SaysWhatEachCameraSeesNowAndWhatTooFewSee) {
  const TemporaryFolder folder;
  const StreamServer left(FilmOfTags(folder / "left.mkv", {0, 1}, 60, 100), 60, 70);
  FilmOfTags(folder / "right.mkv", {1, 2}, 80, 20);
  const auto run = RunProgram({"detect", "--live", left.url(), folder / "right.mkv", "--expect", "0-3",
                               "--json", "--seconds", "3.4", "--overlay", folder / "now.png"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::vector<json> lines = Lines(run.out);
  ASSERT_GE(lines.size(), 3u);
  const json& second = lines[lines.size() - 2];
  ASSERT_EQ(second["cameras"].size(), 2u);
  EXPECT_EQ(second["cameras"][0]["source"], left.url());
  EXPECT_EQ(second["cameras"][0]["state"], "running");
  EXPECT_THAT(second["cameras"][0]["seen"], ElementsAre(0, 1));
  EXPECT_THAT(second["cameras"][1]["seen"], ElementsAre(1, 2));
  EXPECT_THAT(second["expected_unseen"], ElementsAre(3));
  EXPECT_THAT(second["expected_seen_by_too_few"], ElementsAre(0, 2, 3));
  EXPECT_GT(second["cameras"][0]["fps"], 1);
  EXPECT_NEAR(second["cameras"][1]["blur_px"], 0.8, 0.25);
  EXPECT_THAT(lines.back()["never_seen_by_enough_cameras"], ElementsAre(0, 2, 3));
  // Side by side.
  const cv::Mat picture = cv::imread(folder / "now.png");
  EXPECT_EQ(picture.cols, 480);
  EXPECT_EQ(picture.rows, 120);
}

TEST(DetectLive, EndsWithItsFilesAndSumsUpForPeople) {
  const TemporaryFolder folder;
  const auto run =
      RunProgram({"detect", "--live", FilmOfTags(folder / "a.mkv", {4, 5, 6}, 66, 50), "--expect", "4-6"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("3 tags: 4-6\n    expected tags: all are seen\n"));
  EXPECT_THAT(run.out, HasSubstr("went away 0 times; ids seen: 4-6; rejected: none\n"));
  EXPECT_THAT(run.out, HasSubstr("expected but at no time seen by the camera: none\n"));
}

TEST(DetectLive, ACameraThatGoesAwayIsToldAndTriedAgain) {
  const TemporaryFolder folder;
  const StreamServer server(FilmOfTags(folder / "a.mkv", {8}, 20, 100), 20, 20);
  const auto run = RunProgram({"detect", "--live", server.url(), "--seconds", "3.2", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("the stream ended; trying again"));
  EXPECT_GE(Lines(run.out).back()["cameras"][0]["times_lost"], 2);
  EXPECT_THAT(Lines(run.out).back()["cameras"][0]["ever_seen"], ElementsAre(8));
}

TEST(DetectLive, InterruptedItEndsWithItsSummary) {
  const TemporaryFolder folder;
  const std::string film = FilmOfTags(folder / "a.mkv", {8}, 30, 1);  // half a minute
  const pid_t child = fork();
  if (child == 0) {
    if (freopen((folder / "out").c_str(), "w", stdout) == nullptr) _exit(126);
    execl(TENDRIL_PROGRAM, TENDRIL_PROGRAM, "detect", "--live", film.c_str(), nullptr);
    _exit(127);
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  kill(child, SIGINT);
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_THAT(testing_support::ReadText(folder / "out"), HasSubstr("ids seen: 8"));
}

TEST(DetectLive, BadCallsAreOneLine) {
  const TemporaryFolder folder;
  const std::string film = FilmOfTags(folder / "a.mkv", {8}, 100, 50);
  struct Bad {
    std::vector<std::string> call;
    int code;
    std::string says;
  };
  const std::vector<Bad> all = {
      {{"detect", "--live", "/dev/video77"}, 2, "/dev/video77: no such device or file"},
      {{"detect", "--live", film, "tcp://127.0.0.1:1"}, 1, "Connection refused"},
      {{"detect", "--live", film, "--expect", "7-"}, 2, "--expect: '7-'"},
      {{"detect", "--live", film, "--expect", "0-999999"}, 2, "from 0 to 99999"},
      {{"detect", "--live", film, "--family", "tag9"}, 2, "tag9"},
      {{"detect", "--live", film, "--overlay", "/nowhere/a.png"}, 1, "/nowhere/a.png"},
      {{"detect", "--live", film, "--overlay", folder / "a.doc"}, 1, "expected .png or .jpg"},
      {{"detect", film, "--seconds", "3"}, 2, "--live"},
  };
  for (const Bad& bad : all) {
    const auto run = RunProgram(bad.call);
    EXPECT_EQ(run.exit_code, bad.code) << run.err;
    EXPECT_THAT(run.err, HasSubstr(bad.says));
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
}

}  // namespace
}  // namespace tendril
