// db/files/design_toml.h, trial_toml.h and the reader behind them: keys of the format, every slip in one
// line, round trips to the last bit.
#include "db/files/design_toml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <tuple>

#include "db/files/toml_read.h"
#include "db/files/toml_write.h"
#include "db/files/trial_toml.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using testing_support::TemporaryFolder;

std::string MessageFor(const std::string& toml) {
  const auto design = ParseDesign(toml, "d.toml");
  return design.ok() ? "" : design.error().message;
}

TEST(DesignToml, AnEmptyFileIsThePapersDesign) {
  const auto design = ParseDesign("", "d.toml");
  ASSERT_TRUE(design.ok());
  EXPECT_EQ(design.value().length, 0.750);
  EXPECT_EQ(design.value().holes, 49);
  EXPECT_EQ(design.value().beta, 75 * std::numbers::pi / 180);
}

TEST(DesignToml, EveryKeyOfTheFormatReachesItsField) {
  const auto read = ParseDesign(R"(
[tentacle]
length = 1            # a whole number is a number
base_width = 0.03
taper = 0.4
unit_length = 0.04
spacing_ratio = 0.6
alpha_deg = 80
beta_deg = 70
holes = 21
hole_diameter = 0.003
thickness = 2e-4
youngs_modulus = 3e9
closed_angle_deg = 85
[crease]
crease_length = 2e-3
rest_angle_deg = 3
stiffness_exponent = 2
stiffness_ratio = 1.5
[tendon]
friction = 0.1
wrap_angle_deg = 6
)",
                                "d.toml");
  ASSERT_TRUE(read.ok()) << read.error().message;
  const TentacleDesign& d = read.value();
  const double degree = std::acos(-1.0) / 180;
  EXPECT_EQ(d.length, 1);
  EXPECT_EQ(d.base_width, 0.03);
  EXPECT_EQ(d.taper, 0.4);
  EXPECT_EQ(d.unit_length, 0.04);
  EXPECT_EQ(d.spacing_ratio, 0.6);
  EXPECT_NEAR(d.alpha, 80 * degree, 1e-15);
  EXPECT_NEAR(d.beta, 70 * degree, 1e-15);
  EXPECT_EQ(d.holes, 21);
  EXPECT_EQ(d.hole_diameter, 0.003);
  EXPECT_EQ(d.thickness, 2e-4);
  EXPECT_EQ(d.youngs_modulus, 3e9);
  EXPECT_NEAR(d.closed_angle, 85 * degree, 1e-15);
  EXPECT_EQ(d.crease_length, 2e-3);
  EXPECT_NEAR(d.rest_angle, 3 * degree, 1e-15);
  EXPECT_EQ(d.stiffness_exponent, 2);
  EXPECT_EQ(d.stiffness_ratio, 1.5);
  EXPECT_EQ(d.tendon_friction, 0.1);
  EXPECT_NEAR(d.wrap_angle, 6 * degree, 1e-15);
}

TEST(DesignToml, EachSlipIsOneLineWithPlaceFieldValueAndWhatWasExpected) {
  EXPECT_EQ(MessageFor("[tentacle]\nlength = -0.75\n"),
            "d.toml:2: tentacle.length = -0.75: expected a number > 0 m");
  EXPECT_EQ(MessageFor("[tentacle]\nholes = 4.5\n"),
            "d.toml:2: tentacle.holes = 4.5: expected a whole number >= 2 and <= 2147483647");
  EXPECT_EQ(MessageFor("[tentacle]\nlength = \"long\"\n"),
            "d.toml:2: tentacle.length = 'long': expected a number > 0 m");
  EXPECT_EQ(MessageFor("[tentacle]\nlenght = 0.75\n"),
            "d.toml:2: tentacle.lenght: unknown key; did you mean tentacle.length?");
  EXPECT_EQ(MessageFor("\n[tentacel]\n"), "d.toml:2: tentacel: unknown key; did you mean tentacle?");
  EXPECT_THAT(MessageFor("[tentacle]\nlength = nan\n"), HasSubstr("length = nan: expected a number"));
  EXPECT_THAT(MessageFor("[tentacle]\nlength = inf\n"), HasSubstr("length = inf: expected a number"));
  EXPECT_THAT(MessageFor("tentacle = 3\n"), HasSubstr("tentacle = 3: expected a table, [tentacle]"));
  EXPECT_THAT(MessageFor("[tentacle]\nalpha_deg = 180\n"), HasSubstr("> 0 and < 180 deg"));
  EXPECT_THAT(MessageFor("[tentacle]\nclosed_angle_deg = 90.1\n"), HasSubstr("<= 90 deg"));
  EXPECT_THAT(MessageFor("[tentacle\n"), StartsWith("d.toml:1: not TOML: "));
  EXPECT_THAT(MessageFor("[tentacle]\nlength = [1, [2, 3]]\n"), HasSubstr("expected a number"));
}

TEST(DesignToml, AMisspeltKeyComesBeforeTheOtherSlips) {
  const std::string message = MessageFor("[tentacle]\ntaper = -1\nholse = 3\nlength = -1\n");
  EXPECT_THAT(message,
              AllOf(StartsWith("d.toml:3: tentacle.holse"), HasSubstr("(and 2 more)"), Not(HasSubstr("\n"))));
}

TEST(DesignToml, RoundTripsToTheLastBit) {
  std::mt19937_64 random(20240607);
  std::uniform_real_distribution<double> unit(0.01, 1);
  for (int i = 0; i < 1000; ++i) {
    TentacleDesign d;
    d.length = unit(random);
    d.taper = unit(random);
    d.youngs_modulus = 1e10 * unit(random);
    d.alpha = RadiansOfDegrees(179 * unit(random));
    d.beta = RadiansOfDegrees(179 * unit(random));
    d.holes = 2 + static_cast<int>(random() % 2000);
    const auto back = ParseDesign(DesignToml(d), "d.toml");
    ASSERT_TRUE(back.ok()) << back.error().message;
    const TentacleDesign& b = back.value();
    ASSERT_EQ(
        std::tie(b.length, b.taper, b.youngs_modulus, b.alpha, b.beta, b.holes, b.wrap_angle, b.closed_angle),
        std::tie(d.length, d.taper, d.youngs_modulus, d.alpha, d.beta, d.holes, d.wrap_angle, d.closed_angle))
        << "seed 20240607, case " << i;
  }
}

TEST(DesignToml, AnyAngleComesBackWithinTwoUnitsInItsLastPlace) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> angle(1e-3, 3.14);
  for (int i = 0; i < 1000; ++i) {
    const double a = angle(random);
    const double back = RadiansOfDegrees(std::stod(TomlDegrees(a)));
    EXPECT_LE(std::abs(back - a), 2 * (std::nextafter(a, 4) - a)) << a;
  }
  EXPECT_EQ(TomlDegrees(75 * std::numbers::pi / 180), "75");
  EXPECT_EQ(TomlDegrees(5.7 * std::numbers::pi / 180), "5.7");
  EXPECT_EQ(RadiansOfDegrees(90), std::numbers::pi / 2);
}

TEST(DesignToml, AFileThatIsNotThereIsNotFound) {
  EXPECT_EQ(ReadDesign("/nowhere/d.toml").error().kind, ErrorKind::kNotFound);
  EXPECT_THAT(ReadDesign("/nowhere/d.toml").error().message, HasSubstr("/nowhere/d.toml"));
}

TEST(TrialToml, RoundTripsEveryFieldAlsoTextThatLooksLikeToml) {
  TrialSpec t;
  t.id = "017f22e2-79b0-7cc3-98c4-dc0c0c07398f";
  t.label = "it's \"one\" \\ [x] # no comment";
  t.kind = TrialKind::kSimulated;
  t.started_ns = 1'700'000'000'123'456'789;
  t.design_name = "paper";
  t.design.taper = 0.1 + 0.2;
  t.gripper.handedness = Handedness::kNormals;
  t.gripper.tentacles = 4;
  t.gripper.pair_spacing = 0.1 + 0.022;
  t.tags.footprint = 0.0075;
  t.rig_name = "bench";
  t.rig_toml = "name = \"bench\"\n[[camera]]\n  path = 'C:\\new'\n\"\"\"\ntab\there\n";
  t.object.position = {1e-300, -0.1, 1.0 / 3};
  t.object_distance = 0.2;
  t.medium = "water";
  t.notes = "line one\nline two \xC3\xA9\x01\r\n";
  const TemporaryFolder folder;
  testing_support::WriteText(folder / "trial.toml", TrialToml(t));
  const auto read = ReadTrialToml(folder / "trial.toml");
  ASSERT_TRUE(read.ok()) << read.error().message;
  const TrialSpec& b = read.value();
  EXPECT_EQ(b.label, t.label);
  EXPECT_EQ(b.kind, t.kind);
  EXPECT_EQ(b.started_ns, t.started_ns);
  EXPECT_EQ(b.design.taper, t.design.taper);
  EXPECT_EQ(b.gripper.handedness, t.gripper.handedness);
  EXPECT_EQ(b.gripper.first_azimuth, t.gripper.first_azimuth);
  EXPECT_EQ(b.gripper.pair_spacing, t.gripper.pair_spacing);
  EXPECT_EQ(b.rig_toml, t.rig_toml);
  EXPECT_EQ(b.object.position, t.object.position);
  EXPECT_EQ(b.notes, t.notes);
  EXPECT_EQ(b.medium, t.medium);
  EXPECT_EQ(TrialToml(b), TrialToml(t));
}

TEST(TagToml, RoundTripsInATrialAndAloneAndDefaultsStayAsTheyWere) {
  const TemporaryFolder folder;
  EXPECT_EQ(TagTableToml({}),
            "[tags]\nfamily = \"tag36h11\"\nfootprint = 0  # m; 0: the largest that fits\nfirst_id = 0\n");
  for (const TagSides sides : {TagSides::kBoth, TagSides::kOuter, TagSides::kInner}) {
    const TagSpec tags{.family = "tagCustom48h12",
                       .footprint = 0.1 + 0.2,
                       .first_id = 41,
                       .sizes = TagSizes::kEach,
                       .every = 2,
                       .sides = sides,
                       .over_hole = true};
    testing_support::WriteText(folder / "tags.toml", TagTableToml(tags));
    const auto read = ReadTags(folder / "tags.toml");
    ASSERT_TRUE(read.ok()) << read.error().message;
    TrialSpec trial;
    trial.id = "x";
    trial.label = "y";
    trial.design_name = "paper";
    trial.tags = read.value();
    testing_support::WriteText(folder / "trial.toml", TrialToml(trial));
    const TagSpec b = ReadTrialToml(folder / "trial.toml").value().tags;
    EXPECT_EQ(b.family, tags.family);
    EXPECT_EQ(b.footprint, tags.footprint);
    EXPECT_EQ(b.first_id, 41);
    EXPECT_EQ(b.sizes, TagSizes::kEach);
    EXPECT_EQ(b.every, 2);
    EXPECT_EQ(b.sides, sides);
    EXPECT_TRUE(b.over_hole);
  }
  testing_support::WriteText(folder / "tags.toml", "[tags]\nevery = 0\n");
  EXPECT_THAT(ReadTags(folder / "tags.toml").error().message,
              HasSubstr("tags.every = 0: expected a whole number >= 1"));
  testing_support::WriteText(folder / "tags.toml", "[tags]\nsides = \"left\"\n");
  EXPECT_THAT(ReadTags(folder / "tags.toml").error().message, HasSubstr("both, outer, inner"));
  testing_support::WriteText(folder / "tags.toml", "family = \"tag36h11\"\n");
  EXPECT_FALSE(ReadTags(folder / "tags.toml").ok());
  EXPECT_EQ(ReadTags(folder / "none.toml").error().kind, ErrorKind::kNotFound);
}

TEST(TrialToml, WhatIsMissingIsNamed) {
  const TemporaryFolder folder;
  testing_support::WriteText(folder / "trial.toml",
                             "id = \"x\"\nlabel = \"y\"\nstarted_ns = 1\n[design]\nname = \"p\"\n");
  EXPECT_THAT(ReadTrialToml(folder / "trial.toml").error().message, HasSubstr("kind: missing"));
  testing_support::WriteText(
      folder / "trial.toml",
      "id = \"x\"\nlabel = \"y\"\nkind = \"imagined\"\nstarted_ns = 1\n[design]\nname = \"p\"\n");
  EXPECT_THAT(ReadTrialToml(folder / "trial.toml").error().message,
              HasSubstr("kind = 'imagined': expected one of real, virtual, simulated, published"));
  testing_support::WriteText(folder / "trial.toml",
                             "id = \"x\"\nlabel = \"y\"\nkind = \"real\"\nstarted_ns = 1\n");
  EXPECT_THAT(ReadTrialToml(folder / "trial.toml").error().message, HasSubstr("design: missing"));
}

TEST(TomlTable, ReadsVectorsListsAndTablesOfTables) {
  auto document = TomlDocument::Parse(
      "p = [1, 2.5, -3]\nq = [1, 2]\nflag = true\n[[camera]]\nname = \"a\"\n[[camera]]\nname = \"b\"\nextra "
      "= 1\n",
      "rig.toml");
  ASSERT_TRUE(document.ok());
  TomlTable& root = document.value().Root();
  Eigen::Vector3d p;
  EXPECT_TRUE(root.Vector("p", p));
  EXPECT_EQ(p, Eigen::Vector3d(1, 2.5, -3));
  EXPECT_FALSE(root.Vector("q", p));
  std::vector<double> list;
  EXPECT_TRUE(root.Numbers("q", list));
  EXPECT_THAT(list, testing::ElementsAre(1, 2));
  bool flag = false;
  EXPECT_TRUE(root.Flag("flag", flag) && flag);
  auto cameras = root.Tables("camera");
  ASSERT_EQ(cameras.size(), 2U);
  for (TomlTable& camera : cameras) {
    std::string name;
    EXPECT_TRUE(camera.Required().Text("name", name));
  }
  const Status done = document.value().Finish();
  ASSERT_FALSE(done.ok());
  EXPECT_THAT(done.error().message, StartsWith("rig.toml:8: camera[1].extra: unknown key"));
}

}  // namespace
}  // namespace tendril
