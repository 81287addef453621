// tendril fold, design show, design cut: what other programs rely on, and what a wrong call gets.
#include <gtest/gtest.h>

#include <fstream>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "db/files/curve_files.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using testing_support::ProgramRun;
using testing_support::ReadText;
using testing_support::RunProgram;
using testing_support::TemporaryFolder;
using testing_support::WriteText;

const std::string kDesigns = TENDRIL_SOURCE_DIR "/examples/designs/";

TEST(FoldCommand, JsonHasTheFieldsThatProgramsRelyOn) {
  const TemporaryFolder folder;
  const std::string curves = folder / "folded.csv";
  const ProgramRun run = RunProgram(
      {"fold", kDesigns + "paper.toml", "--pull", "0.4", "--law", "paper", "--curves", curves, "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json.at("fold_angle_rad").size(), 48u);
  EXPECT_EQ(json.at("holes_m").size(), 49u);
  EXPECT_EQ(json.at("holes_m").at(0), nlohmann::json({0.0, 0.0, 0.0}));
  EXPECT_TRUE(json.at("tension_N").is_null());
  EXPECT_GT(json.at("scale").get<double>(), 0);
  EXPECT_NEAR(json.at("tendon_length_m").get<double>(), 0.6 * 0.72, 1e-12);
  EXPECT_LT(json.at("kinematic_pull").get<double>(), 0.4);
  EXPECT_EQ(json.at("overlapping_facets").size(), 9u);
  EXPECT_EQ(json.at("warnings").size(), 1u);
  // Narrow creases at the tip close first.
  for (const int crease : json.at("closed")) EXPECT_GT(crease, 30);

  const auto read = ReadCurves(curves);
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read.value().size(), 1u);
  const FramedCurve& curve = read.value()[0].curves.at(0);
  ASSERT_EQ(curve.points.cols(), 49);
  ASSERT_EQ(curve.normals.cols(), 49);
  for (int i = 0; i < 49; ++i) {
    for (int k = 0; k < 3; ++k) EXPECT_EQ(curve.points(k, i), json["holes_m"][i][k].get<double>());
  }
}

TEST(FoldCommand, TheExactLawHasATensionAndNoScale) {
  const ProgramRun run =
      RunProgram({"fold", kDesigns + "paper.toml", "--pull", "0.3", "--law", "exact", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json json = nlohmann::json::parse(run.out);
  EXPECT_TRUE(json.at("scale").is_null());
  EXPECT_GT(json.at("tension_N").get<double>(), 0);
  EXPECT_EQ(json.at("slack"), false);
  EXPECT_NEAR(json.at("kinematic_pull").get<double>(), 0.3, 1e-12);
  EXPECT_EQ(RunProgram({"fold", kDesigns + "paper.toml", "--pull", "0.3", "--law", "exakt"}).exit_code, 2);
}

TEST(FoldCommand, WithFrictionTheShapeDependsOnThePath) {
  const TemporaryFolder folder;
  const std::string design = folder / "rough.toml";
  std::ofstream(design)
      << "[tentacle]\ntaper = 1\nspacing_ratio = 1\nbeta_deg = 90\n[tendon]\nfriction = 0.01\n";
  const auto angles = [&](std::vector<std::string> more) {
    std::vector<std::string> call = {"fold", design, "--pull", "0.15", "--law", "exact", "--json"};
    call.insert(call.end(), more.begin(), more.end());
    const ProgramRun run = RunProgram(call);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const auto json = nlohmann::json::parse(run.out);
    EXPECT_GT(json.at("base_tension_N").get<double>(), 0);
    return json.at("fold_angle_rad").get<std::vector<double>>();
  };
  const auto pulled = angles({});
  const auto released = angles({"--path", "0.1,0.3"});
  EXPECT_GT(pulled.front(), pulled.back());
  EXPECT_LT(released.front(), released.back());
  const ProgramRun smooth =
      RunProgram({"fold", kDesigns + "paper.toml", "--pull", "0.1", "--law", "exact", "--path", "0.3"});
  EXPECT_EQ(smooth.exit_code, 2);
}

TEST(FoldCommand, EveryExampleDesignFolds) {
  for (const auto& entry : std::filesystem::directory_iterator(kDesigns)) {
    const ProgramRun run = RunProgram({"fold", entry.path().string(), "--pull", "0.3"});
    EXPECT_EQ(run.exit_code, 0) << entry.path() << run.err;
    EXPECT_NE(run.out.find("504.00 mm"), std::string::npos) << run.out;
  }
}

TEST(FoldCommand, AWrongCallIsOneLineAndExit2) {
  const TemporaryFolder folder;
  WriteText(folder / "bad.toml", "[tentacle]\nlength = -1\n");
  WriteText(folder / "crowded.toml", "[tentacle]\nholes = 80\n");
  WriteText(folder / "empty.toml", "");
  const std::vector<std::pair<std::vector<std::string>, std::string>> calls = {
      {{"fold", folder / "bad.toml", "--pull", "0.3"}, "length"},
      {{"fold", folder / "crowded.toml", "--pull", "0.3"}, "holes = 80"},
      {{"fold", folder / "none.toml", "--pull", "0.3"}, "none.toml"},
      {{"fold", folder / "empty.toml", "--pull", "-0.3"}, "pull = -0.3"},
      {{"fold", folder / "empty.toml", "--pull", "nan"}, "pull = nan"},
      {{"fold", folder / "empty.toml", "--pull", "much"}, "pull"},
      {{"fold", folder / "empty.toml", "--pull", "0.3", "--law", "guess"}, "paper"},
      {{"fold", folder / "empty.toml"}, "--pull"},
      {{"design", "cut", folder / "empty.toml"}, "--svg"},
      {{"design", "cut", folder / "empty.toml", "--svg", folder / "a.svg", "--gap-mm", "0"}, "gap = 0 mm"},
  };
  for (const auto& [call, expected] : calls) {
    const ProgramRun run = RunProgram(call);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(expected), std::string::npos) << run.err;
    EXPECT_EQ(run.out, "");
  }
  const ProgramRun beyond = RunProgram({"fold", folder / "empty.toml", "--pull", "1.1"});
  EXPECT_EQ(beyond.exit_code, 1);  // well-formed, but no solution exists
  EXPECT_NE(beyond.err.find("pull = 1.1 is beyond reach"), std::string::npos) << beyond.err;
}

TEST(DesignCommands, ShowWarnsAndCutRefusesWhatCannotBeCut) {
  const TemporaryFolder folder;
  WriteText(folder / "crossing.toml", "[tentacle]\nbeta_deg = 30\n");
  const ProgramRun show = RunProgram({"design", "show", folder / "crossing.toml", "--json"});
  EXPECT_EQ(show.exit_code, 0);
  const auto json = nlohmann::json::parse(show.out);
  EXPECT_EQ(json.at("can_be_cut"), false);
  EXPECT_EQ(json.at("creases"), 48);
  EXPECT_NE(json.at("warnings").at(0).get<std::string>().find("creases 0 and 1"), std::string::npos);

  const ProgramRun cut = RunProgram(
      {"design", "cut", folder / "crossing.toml", "--svg", folder / "a.svg", "--dxf", folder / "a.dxf"});
  EXPECT_EQ(cut.exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(folder / "a.svg"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.dxf"));
}

TEST(DesignCommands, CutWritesBothDrawings) {
  const TemporaryFolder folder;
  const ProgramRun run = RunProgram({"design", "cut", kDesigns + "paper.toml", "--svg", folder / "a.svg",
                                     "--dxf", folder / "a.dxf", "--dash-mm", "2", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(nlohmann::json::parse(run.out).at("dash_m"), 2e-3);
  EXPECT_NE(ReadText(folder / "a.svg").find("<svg"), std::string::npos);
  EXPECT_NE(ReadText(folder / "a.dxf").find("AC1009"), std::string::npos);
}

TEST(FoldCommand, WritesFilesForProgramsThatFoldPaper) {
  const TemporaryFolder folder;
  const std::string fold = folder / "a.fold", svg = folder / "a.svg";
  const ProgramRun run = RunProgram({"fold", kDesigns + "coiling.toml", "--pull", "0.3", "--fold", fold,
                                     "--frames", "3", "--origami-svg", svg, "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto answer = nlohmann::json::parse(run.out);
  EXPECT_EQ(answer.at("fold"), fold);
  const auto file = nlohmann::json::parse(ReadText(fold));
  ASSERT_EQ(file.at("file_frames").size(), 3u);
  EXPECT_EQ(file["file_frames"][2]["frame_title"], "pull 0.3");
  // The last folded form is this pull's shape: degrees of the whole outer angle.
  for (size_t i = 0; i < 48; ++i) {
    const double phi = answer["fold_angle_rad"][i];
    EXPECT_NEAR(std::abs(file["file_frames"][2]["edges_foldAngle"][i].get<double>()), phi * 360 / M_PI, 1e-9);
  }
  EXPECT_NE(ReadText(svg).find("<line "), std::string::npos);

  const std::string narrow = folder / "crossing.toml";
  WriteText(narrow, "[tentacle]\nbeta_deg = 15\n");
  const ProgramRun refused = RunProgram({"fold", narrow, "--pull", "0.1", "--fold", folder / "b.fold"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("creases 0 and 1 cross or meet"), std::string::npos) << refused.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "b.fold"));
}

TEST(PlotShapesCommand, DrawsEveryDesignByBothLaws) {
  const TemporaryFolder folder;
  const std::string svg = folder / "strip.svg";
  const ProgramRun run = RunProgram({"plot", "shapes", kDesigns + "uniform.toml", kDesigns + "coiling.toml",
                                     "--pulls", "0,0.3,0.97", "--out", svg});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::string text = ReadText(svg);
  for (const char* title : {"uniform, law paper", "uniform, law exact", "coiling, law paper",
                            "coiling, law exact", "0.97: beyond reach"}) {
    EXPECT_NE(text.find(title), std::string::npos) << title;
  }
  EXPECT_EQ(RunProgram({"plot", "shapes", folder / "none.toml", "--out", svg}).exit_code, 2);
}

}  // namespace
}  // namespace tendril
