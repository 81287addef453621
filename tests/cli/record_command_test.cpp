// tendril record, through the built program: a virtual trial in a lab, the same trial played from its files,
// and calls that cannot be.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "db/files/curve_files.h"
#include "db/files/recording_logs.h"
#include "db/lab.h"
#include "db/trial_query.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using testing_support::ReadText;
using testing_support::RunProgram;
using testing_support::TemporaryFolder;
using testing_support::WriteText;

class RecordCommand : public testing::Test {
 protected:
  void SetUp() override {
    const auto lab = Lab::Create(folder_.path() / "lab");
    ASSERT_TRUE(lab.ok()) << lab.error().message;
    WriteText(folder_ / "lab/designs/short.toml", "[tentacle]\nlength = 0.2\nholes = 13\n");
  }
  testing_support::ProgramRun Record(std::vector<std::string> more) {
    std::vector<std::string> call = {"record", "--lab", folder_ / "lab", "--design", "short", "--json"};
    call.insert(call.end(), more.begin(), more.end());
    return RunProgram(call);
  }
  std::size_t Trials() {
    auto lab = Lab::Open(folder_.path() / "lab");
    return ListTrials(lab.value()).value().size();
  }
  TemporaryFolder folder_;
};

// Tags on every second facet and outside only: the pictures have them there, and `track` looks for them
// there.
TEST_F(RecordCommand, TracksTagsAsTheTagsFileLaysThemOut) {
  WriteText(folder_ / "tags.toml",
            "[tags]\nfamily = \"tag36h10\"\nfirst_id = 7\nsizes = \"each\"\nevery = 2\nsides = \"outer\"\n");
  const auto run = Record({"--frames", "2", "--label", "few", "--pull", "0.02", "--distance", "0.15",
                           "--tentacles", "2", "--tags", folder_ / "tags.toml"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::string trial = nlohmann::json::parse(run.out)["folder"];
  const auto tracked = RunProgram({"track", "few", "--lab", folder_ / "lab", "--json"});
  ASSERT_EQ(tracked.exit_code, 0) << tracked.err;
  const auto json = nlohmann::json::parse(tracked.out);
  EXPECT_EQ(json["unknown_tags"], 0);
  const auto found = ReadDetections(trial + "/detections.csv");
  ASSERT_TRUE(found.ok());
  EXPECT_GT(found.value().size(), 14U);  // 2 pictures, 2 cameras, 2 tentacles of 7 outer tags
  for (const DetectionRow& row : found.value()) {
    EXPECT_GE(row.tag, 7);
    EXPECT_LT(row.tag, 7 + 2 * 7);
  }
  const auto curves = ReadCurves(trial + "/curves.h5");
  const auto truth = ReadCurves(trial + "/truth.h5");
  ASSERT_TRUE(curves.ok() && truth.ok());
  for (std::size_t c = 0; c < 2; ++c) {
    const double off =
        (curves.value()[c].curves[0].points - truth.value()[c].curves[0].points).colwise().norm().maxCoeff();
    EXPECT_LT(off, 6e-3) << "tentacle "
                         << c;  // tags taken for those of other facets would be off by 15 mm and more
  }
  const auto both = Record({"--tags", folder_ / "tags.toml", "--tag-family", "tag36h11"});
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_EQ(Record({"--tags", folder_ / "none.toml"}).exit_code, 2);
  WriteText(folder_ / "wide.toml", "[tags]\nfootprint = 0.012\n");
  EXPECT_EQ(Record({"--tags", folder_ / "wide.toml"}).exit_code, 2);
  EXPECT_EQ(Trials(), 1U);
}

TEST_F(RecordCommand, AVirtualTrialThenTheSameFromItsFiles) {
  const auto first = Record({"--frames", "3", "--seed", "5", "--label", "one", "--distance", "0.1"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const auto one = nlohmann::json::parse(first.out);
  EXPECT_EQ(one["state"], "recorded");
  EXPECT_EQ(one["kind"], "virtual");
  EXPECT_EQ(one["label"], "one");
  ASSERT_EQ(one["cameras"].size(), 2U);
  EXPECT_EQ(one["cameras"][1]["frames"], 3);
  const std::filesystem::path trial = one["folder"].get<std::string>();
  for (const char* file : {"cam0.mkv", "cam0.csv", "cam1.mkv", "cam1.csv", "servo.csv", "trial.toml",
                           "truth.h5", "truth.toml"}) {
    EXPECT_TRUE(std::filesystem::exists(trial / file)) << file;
  }

  // The same seed again: the same pictures, to the byte.
  const auto second = Record({"--frames", "3", "--seed", "5", "--distance", "0.1"});
  ASSERT_EQ(second.exit_code, 0) << second.err;
  const std::filesystem::path again = nlohmann::json::parse(second.out)["folder"].get<std::string>();
  EXPECT_EQ(ReadText(trial / "cam0.mkv"), ReadText(again / "cam0.mkv"));
  EXPECT_EQ(ReadText(trial / "truth.toml"), ReadText(again / "truth.toml"));

  const auto played =
      Record({"--source", "video:" + (trial / "cam0.mkv").string() + "," + (trial / "cam1.mkv").string(),
              "--servo", (trial / "servo.csv").string()});
  ASSERT_EQ(played.exit_code, 0) << played.err;
  const auto copy = nlohmann::json::parse(played.out);
  EXPECT_EQ(copy["kind"], "real");
  const std::filesystem::path copied = copy["folder"].get<std::string>();
  EXPECT_EQ(ReadText(copied / "cam1.csv"), ReadText(trial / "cam1.csv"));
  EXPECT_EQ(ReadText(copied / "cam1.mkv"), ReadText(trial / "cam1.mkv"));
  EXPECT_EQ(ReadText(copied / "servo.csv"), ReadText(trial / "servo.csv"));
  EXPECT_FALSE(std::filesystem::exists(copied / "truth.toml"));
}

TEST_F(RecordCommand, BadCallsEndWithTwoAndLeaveNothing) {
  WriteText(folder_ / "text.mkv", "not a video");
  const std::vector<std::vector<std::string>> calls = {{"--design", "nowhere"},
                                                       {"--source", "webcam"},
                                                       {"--source", "video:"},
                                                       {"--source", "video:" + (folder_ / "text.mkv")},
                                                       {"--source", "video:" + (folder_ / "none.mkv")},
                                                       {"--source", "images:" + (folder_ / "none")},
                                                       {"--frames", "0"},
                                                       {"--pull", "-1"},
                                                       {"--rig", "nowhere"},
                                                       {"--pull-rate", "0"},
                                                       {"--tag-family", "tag1"},
                                                       {"--handedness", "left"}};
  for (const auto& call : calls) {
    std::vector<std::string> arguments = {"record", "--lab", folder_ / "lab"};
    if (call[0] != "--design") arguments.insert(arguments.end(), {"--design", "short"});
    arguments.insert(arguments.end(), call.begin(), call.end());
    const auto run = RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 2) << call[0] << " " << call[1] << ": " << run.err;
    EXPECT_FALSE(run.err.empty());
  }
  EXPECT_EQ(RunProgram({"record", "--lab", folder_ / "nolab", "--design", "short"}).exit_code, 2);
  EXPECT_EQ(Trials(), 0U);
}

}  // namespace
}  // namespace tendril
