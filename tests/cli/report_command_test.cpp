// tendril report, through the built program: the page of a small virtual trial has every part, its numbers
// are those of the files, it is XML, refers to nothing outside, and what is wrong with a trial is said.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "db/files/curve_files.h"
#include "db/files/recording_logs.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing_support::ProgramRun;
using testing_support::ReadText;
using testing_support::RunProgram;
using testing_support::TemporaryFolder;
using testing_support::WriteText;

constexpr const char* kLabel = "<b>&\" one";

// One trial, recorded and tracked once for all tests; each test has a copy of the lab.
const fs::path& TrackedLab() {
  static const TemporaryFolder folder;
  static const fs::path lab = [] {
    const std::string home = folder / "lab";
    EXPECT_EQ(RunProgram({"init", home}).exit_code, 0);
    WriteText(home + "/designs/short.toml", "[tentacle]\nlength = 0.2\nholes = 13\n");
    const ProgramRun recorded =
        RunProgram({"record", "--lab", home, "--design", "short", "--frames", "4", "--pull", "0.2", "--seed",
                    "71", "--label", kLabel, "--notes", "a < b & c", "--tentacles", "2"});
    EXPECT_EQ(recorded.exit_code, 0) << recorded.err;
    const ProgramRun tracked = RunProgram({"track", kLabel, "--lab", home});
    EXPECT_EQ(tracked.exit_code, 0) << tracked.err;
    return fs::path(home);
  }();
  return lab;
}

class ReportCommand : public testing::Test {
 protected:
  void SetUp() override {
    fs::copy(TrackedLab(), folder_.path() / "lab", fs::copy_options::recursive);
    lab_ = folder_ / "lab";
    for (const auto& entry : fs::directory_iterator(lab_ + "/trials")) trial_ = entry.path();
  }
  ProgramRun Report(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "report");
    arguments.insert(arguments.end(), {"--lab", lab_, "--draws", "50"});
    return RunProgram(arguments);
  }
  json ReportJson(const std::vector<std::string>& arguments) {
    std::vector<std::string> call = arguments;
    call.push_back("--json");
    const ProgramRun run = Report(call);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return json::parse(run.out);
  }
  void ExpectRefused(const std::vector<std::string>& arguments, const std::string& message) {
    const ProgramRun run = Report(arguments);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_THAT(run.err, HasSubstr(message));
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
  TemporaryFolder folder_;
  std::string lab_;
  fs::path trial_;
};

TEST_F(ReportCommand, ThePageHasEveryPartAndIsXmlThatRefersToNothingOutside) {
  const std::string file = folder_ / "page.html";
  const ProgramRun run = Report({kLabel, "--out", file});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("4 frames"));
  const std::string page = ReadText(file);
  for (const char* part :
       {"<h2>Pictures</h2>", "<h2>Fold angles</h2>", "<h2>What was seen</h2>", "<h2>Cameras</h2>",
        "<h2>Links</h2>", "<h2>Made from</h2>", "Tags that were expected and not believed",
        "Undecided crossings", "first frame", "last frame", "phi (degrees)", "link with the object",
        "RMS of the corners (px)", "sigma along the tentacle", "data:image/jpeg;base64,",
        "<th>design</th><td>short</td>", "<th>outcome</th><td>not judged</td>", "cam0.mkv",
        "a &lt; b &amp; c"}) {
    EXPECT_THAT(page, HasSubstr(part));
  }
  EXPECT_THAT(page, HasSubstr("<h1>&lt;b&gt;&amp;&quot; one</h1>"));
  EXPECT_THAT(page, AllOf(Not(HasSubstr("http")), Not(HasSubstr("<script")), Not(HasSubstr("<link")),
                          Not(HasSubstr("url(\"")), Not(HasSubstr("<b>"))));
  // Expat, another program's parser, finds every element closed; ids are of one element each.
  WriteText(folder_ / "check.py",
            "import sys, xml.etree.ElementTree as t\n"
            "root = t.parse(sys.argv[1]).getroot()\n"
            "ids = [e.get('id') for e in root.iter() if e.get('id')]\n"
            "assert len(ids) == len(set(ids)), 'an id is there twice'\n"
            "refs = [v for e in root.iter() for k, v in e.items() if k in ('src', 'href')]\n"
            "assert all(r.startswith(('data:', '#')) for r in refs), refs\n"
            "n = [sum(e.tag == w for e in root.iter()) for w in ('svg', 'img')]\n"
            "assert n[0] >= 8 and n[1] >= 4, n\n");
  EXPECT_EQ(std::system(("python3 " + (folder_ / "check.py") + " " + file).c_str()), 0);
}

TEST_F(ReportCommand, ItsNumbersAreThoseOfTheFiles) {
  const json report = ReportJson({kLabel, "--out", folder_ / "page.html"});
  for (const json& remark : report["remarks"]) {
    EXPECT_THAT(remark.get<std::string>(), Not(HasSubstr("calibrat")));  // nothing is wrong with its cameras
  }
  const std::string page = ReadText(folder_ / "page.html");
  const auto curves = ReadCurves(trial_ / "curves.h5");
  ASSERT_TRUE(curves.ok()) << curves.error().message;
  ASSERT_EQ(report["tentacles"].size(), curves.value().size());
  for (std::size_t t = 0; t < curves.value().size(); ++t) {
    const CurveSeries& series = curves.value()[t];
    ASSERT_EQ(series.angle.size(), series.curves.size());
    EXPECT_EQ(series.angle[0].size(), 12);
    double seen = 0;
    double worst = 0;
    for (std::size_t f = 0; f < series.curves.size(); ++f) {
      for (int i = 0; i < 13; ++i) {
        seen += series.interpolated[f][i] == 0 && !std::isnan(series.sigma[f][i]) ? 1 : 0;
        if (series.sigma[f][i] > worst) worst = series.sigma[f][i];
      }
    }
    seen /= 13.0 * 4;
    EXPECT_GT(seen, 0.3);
    EXPECT_NEAR(report["tentacles"][t]["seen_fraction"], seen, 1e-12);
    EXPECT_NEAR(report["tentacles"][t]["worst_sigma_mm"], 1e3 * worst, 1e-9);
    char text[64];
    std::snprintf(text, sizeof text, "<td>tentacle%d</td><td>%.1f %%</td>", static_cast<int>(t), 100 * seen);
    EXPECT_THAT(page, HasSubstr(text));
  }
  const auto found = ReadDetections(trial_ / "detections.csv");
  const auto residuals = ReadResiduals(trial_ / "residuals.csv");
  ASSERT_TRUE(found.ok() && residuals.ok());
  ASSERT_EQ(report["cameras"].size(), 2U);
  for (int c = 0; c < 2; ++c) {
    const long tags = std::count_if(found.value().begin(), found.value().end(),
                                    [&](const DetectionRow& row) { return row.camera == c; });
    double squares = 0;
    double x = 0;
    long used = 0;
    for (const ResidualRow& row : residuals.value()) {
      if (row.camera != c || !row.used) continue;
      ++used;
      squares += row.corners_px.colwise().squaredNorm().mean();
      x += row.corners_px.row(0).mean();
    }
    ASSERT_GT(used, 0);
    const json& camera = report["cameras"][static_cast<std::size_t>(c)];
    EXPECT_EQ(camera["tags_found"], tags);
    EXPECT_EQ(camera["tags_used"], used);
    EXPECT_EQ(camera["tags_used"].get<long>() + camera["tags_left_out"].get<long>(), tags);
    EXPECT_NEAR(camera["rms_px"], std::sqrt(squares / static_cast<double>(used)), 1e-12);
    EXPECT_NEAR(camera["shift_px"][0], x / static_cast<double>(used), 1e-12);
    EXPECT_LT(camera["rms_px"], 1);
    EXPECT_TRUE(camera["rejected"].is_object());
  }
  // The last moment's link is what `link --bands` says of it, up to the number of draws.
  const ProgramRun link =
      RunProgram({"link", "--trial", kLabel, "--lab", lab_, "--bands", "--draws", "50", "--json"});
  ASSERT_EQ(link.exit_code, 0) << link.err;
  const json bands = json::parse(link.out)["bands"];
  EXPECT_NEAR(report["link_at_end"]["object_link"], bands["object_link"]["mean"], 1e-9);
}

TEST_F(ReportCommand, ACameraThatMovedSinceItsCalibrationIsSaid) {
  std::string text = ReadText(trial_ / "trial.toml");
  const std::size_t at = text.find("position = [", text.find("right")) + 12;
  const std::size_t end = text.find(',', at);
  text.replace(at, end - at, std::to_string(std::stod(text.substr(at, end - at)) + 0.002));
  fs::permissions(trial_ / "trial.toml", fs::perms::owner_write, fs::perm_options::add);
  WriteText(trial_ / "trial.toml", text);
  ASSERT_EQ(RunProgram({"track", kLabel, "--lab", lab_, "--from-detections"}).exit_code, 0);
  const json report = ReportJson({kLabel});
  EXPECT_THAT(report["remarks"].dump(), HasSubstr("the cameras contradict each other"));
  // Counted here in another way: tags of one frame that both cameras saw, sorted apart by what became of
  // them.
  const auto rows = ReadResiduals(trial_ / "residuals.csv");
  ASSERT_TRUE(rows.ok());
  long shared = 0;
  long contradicted = 0;
  for (const ResidualRow& left : rows.value()) {
    for (const ResidualRow& right : rows.value()) {
      if (left.camera != 0 || right.camera != 1 || left.frame != right.frame || left.tag != right.tag)
        continue;
      ++shared;
      contradicted += left.used && right.used ? 0 : 1;
    }
  }
  EXPECT_GE(shared, 12);
  EXPECT_EQ(report["shared_tags"], shared);
  EXPECT_EQ(report["shared_tags_contradicted"], contradicted);
}

TEST_F(ReportCommand, WhatAnOlderTrackLacksIsSaidWithTheCommandThatMakesIt) {
  fs::remove(trial_ / "residuals.csv");
  const json report = ReportJson({kLabel});
  EXPECT_THAT(report["remarks"].dump(), HasSubstr("residuals.csv"));
  EXPECT_THAT(report["remarks"].dump(), HasSubstr("tendril track"));
  EXPECT_TRUE(report["cameras"][0]["rms_px"].is_null());
  EXPECT_GT(report["cameras"][0]["tags_found"], 0);
}

TEST_F(ReportCommand, AllMakesAnIndexThatLinksThePagesAndNamesWhatIsNotTracked) {
  for (const char* label : {"index", "later"}) {
    ASSERT_EQ(RunProgram({"record", "--lab", lab_, "--design", "short", "--frames", "1", "--label", label})
                  .exit_code,
              0);
  }
  ASSERT_EQ(RunProgram({"track", "index", "--lab", lab_}).exit_code, 0);
  ExpectRefused({"later"}, "is not tracked yet; do it with: tendril track later");
  const json report = ReportJson({"--all", "--out", folder_ / "pages"});
  ASSERT_EQ(report["reports"].size(), 2U);
  EXPECT_EQ(report["left_out"].size(), 1U);
  const std::string index = ReadText(folder_ / "pages/index.html");
  for (const json& one : report["reports"]) {
    EXPECT_NE(one["page"], report["index"]);  // a trial is named "index"
    const std::string page = fs::path(one["page"].get<std::string>()).filename();
    EXPECT_THAT(index, HasSubstr("href=\"" + page + "\""));
    EXPECT_TRUE(fs::exists(folder_.path() / "pages" / page));
  }
  EXPECT_THAT(index, HasSubstr("Trials of lab"));
  EXPECT_THAT(index,
              AllOf(HasSubstr("&lt;b&gt;&amp;&quot; one"), HasSubstr("not tracked: tendril track later")));
}

TEST_F(ReportCommand, CallsThatCannotBeAreRefusedInOneLineAndWriteNothing) {
  ExpectRefused({}, "name one or more trials, or --all");
  ExpectRefused({"none-such"}, "no trial has this id or label");
  fs::remove(trial_ / "curves.h5");
  ExpectRefused({kLabel}, "not tracked yet");
  EXPECT_FALSE(fs::exists(lab_ + "/reports"));
  EXPECT_EQ(Report({kLabel, "--out", folder_ / "no/such/page.html"}).exit_code, 2);
  EXPECT_FALSE(fs::exists(folder_ / "no"));
}

}  // namespace
}  // namespace tendril
