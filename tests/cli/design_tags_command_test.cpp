// tendril design tags: the fields that programs rely on, its warnings, its files, and one line for what is
// wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/program.h"

namespace tendril {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing_support::ReadText;
using testing_support::RunProgram;
using testing_support::TemporaryFolder;

const std::string kPaper = TENDRIL_SOURCE_DIR "/examples/designs/paper.toml";
const std::string kRig = TENDRIL_SOURCE_DIR "/examples/rigs/two_cameras.toml";

json Ask(std::vector<std::string> more) {
  std::vector<std::string> call = {"design", "tags", kPaper, "--json"};
  call.insert(call.end(), more.begin(), more.end());
  const auto run = RunProgram(call);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return json::parse(run.out, nullptr, false);
}

std::string Warnings(const json& answer) {
  return answer.contains("warnings") ? answer["warnings"].dump() : std::string();
}

TEST(DesignTagsCommand, MapsIdsAndWritesPages) {
  const TemporaryFolder folder;
  const json answer = Ask({"--tentacles", "3", "--first-id", "10", "--svg", folder / "tags.svg", "--pdf",
                           folder / "tags.pdf", "--out", folder / "tags.toml"});
  EXPECT_EQ(answer["family"], "tag36h11");
  ASSERT_EQ(answer["tags"].size(), 3u * 49u * 2u);
  EXPECT_EQ(answer["tags"][0]["id"], 10);
  EXPECT_EQ(answer["tags"][0]["side"], "outer");
  EXPECT_EQ(answer["tags"][1]["side"], "inner");
  EXPECT_NEAR(answer["footprint_m"].get<double>(), 0.008, 1e-12);
  for (const auto& page : answer["svg"]) EXPECT_TRUE(std::filesystem::exists(page.get<std::string>()));
  EXPECT_EQ(answer["svg"].size(), 2u);
  EXPECT_THAT(ReadText(folder / "tags.pdf"), testing::StartsWith("%PDF-"));
  EXPECT_THAT(ReadText(folder / "tags.toml"), HasSubstr("first_id = 10"));
  EXPECT_FALSE(answer.contains("cameras"));
}

// 20 of b, 10 of c: facets of 15 mm whose holes lie 5 and 10 mm from their creases.
TEST(DesignTagsCommand, TellsEachFacetsRoom) {
  const json answer = Ask({"--every", "2", "--sides", "inner"});
  ASSERT_EQ(answer["facets"].size(), 49u);
  const json& facet = answer["facets"][20];
  EXPECT_NEAR(facet["length_m"].get<double>(), 0.015, 1e-12);
  EXPECT_NEAR(facet["hole_to_base_crease_m"].get<double>(), 0.005, 1e-12);
  EXPECT_NEAR(facet["hole_to_tip_crease_m"].get<double>(), 0.010, 1e-12);
  EXPECT_NEAR(facet["largest_beside_hole_m"].get<double>(), 0.0084, 1e-9);
  EXPECT_NEAR(facet["tag_m"].get<double>(), 0.008, 1e-12);
  EXPECT_TRUE(answer["facets"][21]["tag_m"].is_null());
  EXPECT_EQ(answer["tags"].size(), 2u * 25u);
  EXPECT_NEAR(answer["weight"]["tag_mass_g"].get<double>(), 25 * 6.4e-3,
              1e-9);  // 8 mm square of 100 g/m^2: 6.4 mg
  EXPECT_NEAR(answer["weight"]["film_mass_g"].get<double>(), 1.56375, 1e-9);
  EXPECT_THAT(Warnings(answer), HasSubstr("--out FILE"));
}

TEST(DesignTagsCommand, SaysWhatCamerasSeeAndWhatThatIsGoodFor) {
  const json answer = Ask({"--rig", kRig});
  ASSERT_EQ(answer["cameras"].size(), 2u);
  EXPECT_EQ(answer["views"].size(), 2u * 196u);
  for (const json& camera : answer["cameras"]) {
    EXPECT_NEAR(camera["farthest_mm_per_px"].get<double>(), 0.30, 0.01);  // as the rig was made
    EXPECT_NEAR(camera["least_px_per_module"].get<double>(), 0.8 / camera["farthest_mm_per_px"].get<double>(),
                1e-9);
    EXPECT_EQ(camera["use_frontal"], "decoded");
    EXPECT_EQ(camera["use_at_45_deg"], "tracked");
    int tags = 0;
    for (const auto& [use, count] : camera["tags"].items()) tags += count.get<int>();
    EXPECT_EQ(tags, 196);
  }
  EXPECT_THAT(Warnings(answer), testing::Not(HasSubstr("decode limit")));
  const json small = Ask({"--rig", kRig, "--size-mm", "5.6", "--family", "tag36h11"});
  EXPECT_THAT(Warnings(small), HasSubstr("below the decode limit"));
  // 5.6 mm at 0.299 mm per px: 1.87 px for each of 10 modules, 2.08 for each of 9.
  EXPECT_EQ(Ask({"--rig", kRig, "--size-mm", "5.6"})["family"], "tagStandard41h12");
  const json half = Ask({"--rig", kRig, "--sides", "outer"});
  EXPECT_THAT(Warnings(half), HasSubstr("neither decoded nor tracked"));
}

// docs/lab-setup.md: 20 mm lens, 3.45 um pixels, 1.5 m.
TEST(DesignTagsCommand, TheWorkedExampleOfTheDocumentation) {
  const json answer = Ask({"--rig", TENDRIL_SOURCE_DIR "/examples/rigs/lab_pair.toml", "--tentacles", "1",
                           "--first-azimuth-deg", "0", "--tilt-deg", "0"});
  const double mm_per_px = 1500 / (20 / 0.00345);
  for (const json& camera : answer["cameras"]) {
    EXPECT_NEAR(camera["farthest_mm_per_px"].get<double>(), mm_per_px, 0.002 * mm_per_px);
    EXPECT_NEAR(camera["least_px_per_module"].get<double>(), 0.8 / mm_per_px, 0.01);
    EXPECT_EQ(camera["use_at_45_deg"], "decoded");
    EXPECT_EQ(camera["tags"]["decoded"], 49);
    EXPECT_EQ(camera["tags"]["turned away"], 49);
  }
  EXPECT_NEAR(answer["widest_angle_deg"].get<double>(), 60, 0.1);
}

TEST(DesignTagsCommand, MoreTentaclesTakeAFamilyWithMoreIds) {
  const json answer = Ask({"--tentacles", "16"});
  EXPECT_EQ(answer["tags"].size(), 16u * 98u);
  EXPECT_EQ(answer["family"], "tag36h10");
  EXPECT_THAT(answer["family_why"].get<std::string>(), HasSubstr("tag36h11 587"));
  const json few = Ask({"--family", "tag36h11", "--tentacles", "5", "--label-gsm", "20"});
  EXPECT_THAT(Warnings(few), HasSubstr("97 ids of tag36h11 are left"));
  EXPECT_THAT(Warnings(few), testing::Not(HasSubstr("weigh")));
}

TEST(DesignTagsCommand, BadInputIsOneLineAndExitTwo) {
  const TemporaryFolder folder;
  testing_support::WriteText(folder / "none.toml", "name = \"none\"\n");
  const std::vector<std::pair<std::vector<std::string>, std::string>> bad = {
      {{"--tentacles", "8", "--family", "tag36h11"}, "587"},
      {{"--size-mm", "12"}, "at most 8.4 mm"},
      {{"--every", "0"}, "every 0th"},
      {{"--label-gsm", "-1"}, "grammage"},
      {{"--family", "tag9"}, "tag36h11"},
      {{"--rig", folder / "no.toml"}, "no.toml"},
      {{"--rig", folder / "none.toml"}, "[[camera]]"},
  };
  for (const auto& [more, says] : bad) {
    std::vector<std::string> call = {"design", "tags", kPaper, "--pdf", folder / "t.pdf"};
    call.insert(call.end(), more.begin(), more.end());
    const auto run = RunProgram(call);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_THAT(run.err, HasSubstr(says));
    EXPECT_EQ(run.out, "");
    EXPECT_FALSE(std::filesystem::exists(folder / "t.pdf"));
  }
}

}  // namespace
}  // namespace tendril
