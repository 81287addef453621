// db/files/scene_toml.h: what scene files say reaches its field, old ones mean what they meant, and each slip
// is one line.
#include "db/files/scene_toml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "db/files/toml_edit.h"
#include "model/rods/medium.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::AllOf;
using testing::HasSubstr;
using testing_support::TemporaryFolder;
using testing_support::WriteText;

Result<Scene> SceneOf(const std::string& toml, const std::vector<std::string>& settings = {}) {
  const TemporaryFolder folder;
  WriteText(folder / "scene.toml", toml);
  WriteText(folder / "design.toml", "");
  return ReadScene(folder / "scene.toml", settings);
}

std::string MessageFor(const std::string& toml) {
  const Result<Scene> scene = SceneOf(toml);
  return scene.ok() ? "" : scene.error().message;
}

SceneObject ObjectOf(const std::string& keys) {
  const Result<Scene> scene = SceneOf("[[object]]\n" + keys);
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().message);
  return scene.ok() ? scene.value().objects.at(0) : SceneObject{};
}

TEST(SceneToml, TheOldExamplesMeanWhatTheyMeant) {
  const std::string folder = std::string(TENDRIL_SOURCE_DIR) + "/examples/scenes/";
  const Result<Scene> read = ReadScene(folder + "paper.toml");
  ASSERT_TRUE(read.ok()) << read.error().message;
  const Scene& scene = read.value();
  EXPECT_EQ(scene.duration, 10);
  EXPECT_EQ(scene.level, SimulationLevel::kPaper);
  EXPECT_EQ(scene.gravity, Vector3d(0, 0, -9.80665));
  ASSERT_EQ(scene.objects.size(), 1U);
  const SceneObject& bar = scene.objects[0];
  EXPECT_EQ(bar.kind, "cylinder");
  EXPECT_EQ(bar.body.start, Vector3d(-(0.140 - 0.0225), 0, -0.15));
  EXPECT_EQ(bar.body.end, Vector3d(0.140 - 0.0225, 0, -0.15));
  EXPECT_EQ(bar.body.radius, 0.0225);
  EXPECT_EQ(bar.motion, ObjectMotion::kFixed);
  EXPECT_FALSE(bar.friction.has_value());
  EXPECT_EQ(scene.contact.law, ContactLaw::kHertzSegments);
  EXPECT_EQ(scene.contact.stiffness, 1e4);
  EXPECT_EQ(scene.contact.friction, 0);
  for (const char* name : {"dense", "helix", "paper-zero-g"}) {
    EXPECT_TRUE(ReadScene(folder + name + ".toml").ok()) << name;
  }
}

// What the call says counts, and is checked with all else.
TEST(SceneToml, TheLevelOfTheCallStandsForTheFilesOwn) {
  const TemporaryFolder folder;
  WriteText(
      folder / "scene.toml",
      "level = 'static'\n[[object]]\nkind = 'sphere'\nradius = 0.02\nmotion = 'free'\nmass = 1\n[[rod]]\n");
  EXPECT_FALSE(ReadScene(folder / "scene.toml").ok());
  const Result<Scene> fast = ReadScene(folder / "scene.toml", {}, SimulationLevel::kFast);
  ASSERT_TRUE(fast.ok()) << fast.error().message;
  EXPECT_EQ(fast.value().level, SimulationLevel::kFast);
  const Result<Scene> still = ReadScene(folder / "scene.toml", {"level=fast"}, SimulationLevel::kStatic);
  ASSERT_FALSE(still.ok());
  EXPECT_EQ(still.error().kind, ErrorKind::kBadInput);
  EXPECT_THAT(still.error().message,
              AllOf(HasSubstr("--level static: expected"), HasSubstr("an object moves")));
}

TEST(SceneToml, ACylindersShapeHasFlatEndsAndLiesAlongItsAxis) {
  const SceneObject tube =
      ObjectOf("kind = 'cylinder'\nradius = 0.02\nlength = 0.3\nposition = [0.1, 0, -0.2]\naxis = [0, 2, 0]");
  ASSERT_EQ(tube.shape.size(), 1U);
  EXPECT_EQ(tube.shape[0].kind, PrimitiveKind::kCylinder);
  EXPECT_EQ(tube.shape[0].half.z(), 0.15);
  const auto distance = [&](const Vector3d& lab) {
    return DistanceTo(tube.shape[0], tube.pose.inverse() * lab).distance;
  };
  EXPECT_NEAR(distance({0.1, 0.16, -0.2}), 0.01, 1e-15);  // beyond the flat end
  EXPECT_NEAR(distance({0.12, 0.15, -0.2}), 0, 1e-15);    // the rim
  EXPECT_NEAR(distance({0.1, 0, -0.2}), -0.02, 1e-15);    // the centre
  EXPECT_LT((tube.body.end - Vector3d(0.1, 0.13, -0.2)).norm(), 1e-15);
}

TEST(SceneToml, AMovingObjectHasTheInertiaOfItsShape) {
  const SceneObject box = ObjectOf(
      "kind = 'box'\nname = 'brick'\nsize = [0.1, 0.2, 0.3]\nrotation_deg = [0, 0, 90]\nmotion = 'free'\n"
      "mass = 2\nfriction = 0.4\nvelocity = [1, 2, 3]\nspin = [4, 5, 6]\ndrag_scale = 1.1\nposition = [1, 2, "
      "3]");
  EXPECT_EQ(box.name, "brick");
  EXPECT_EQ(box.motion, ObjectMotion::kFree);
  EXPECT_EQ(box.friction, 0.4);
  EXPECT_EQ(box.drag_scale, 1.1);
  EXPECT_EQ(box.velocity, Vector3d(1, 2, 3));
  EXPECT_EQ(box.spin, Vector3d(4, 5, 6));
  EXPECT_EQ(box.pose.translation(), Vector3d(1, 2, 3));
  const Matrix3d lab = box.pose.linear() * box.inertia.asDiagonal() * box.pose.linear().transpose();
  // m / 12 (b^2 + c^2), the box's x turned to the lab's y.
  const Vector3d expected = Vector3d(0.01 + 0.09, 0.04 + 0.09, 0.01 + 0.04) * 2 / 12;
  EXPECT_LT((lab - Matrix3d(expected.asDiagonal())).norm(), 1e-15);
}

TEST(SceneToml, RotationsAreAboutTheLabsXThenYThenZ) {
  const SceneObject box = ObjectOf("kind = 'box'\nsize = [1, 2, 3]\nrotation_deg = [90, 90, 0]");
  // x then y: z goes to -y and stays there.
  EXPECT_LT((box.pose.linear() * Vector3d::UnitZ() + Vector3d::UnitY()).norm(), 1e-15);
  const SceneObject tube = ObjectOf("kind = 'capsule'\nradius = 0.1\nlength = 1\nrotation_deg = [0, 90, 0]");
  EXPECT_LT((tube.body.end - Vector3d(0.4, 0, 0)).norm(), 1e-15);
}

TEST(SceneToml, AUnionIsBalancedAboutItsCentreOfMass) {
  // Two equal balls: the centre lies between them.
  const SceneObject pair = ObjectOf(
      "kind = 'union'\nmotion = 'free'\nmass = 3\nposition = [0, 0, 1]\nrotation_deg = [0, 90, 0]\n"
      "[[object.part]]\nkind = 'sphere'\nradius = 0.1\n"
      "[[object.part]]\nkind = 'sphere'\nradius = 0.1\nposition = [0, 0, 0.6]");
  ASSERT_EQ(pair.shape.size(), 2U);
  EXPECT_LT((pair.pose.translation() - Vector3d(0.3, 0, 1)).norm(), 1e-15);
  const double along = 3 * 0.4 * 0.01, across = along + 3 * 0.09;
  const Matrix3d lab = pair.pose.linear() * pair.inertia.asDiagonal() * pair.pose.linear().transpose();
  EXPECT_LT((lab - Matrix3d(Vector3d(along, across, across).asDiagonal())).norm(), 1e-14);
}

TEST(SceneToml, AStatedInertiaIsAboutTheFilesAxes) {
  const SceneObject box = ObjectOf(
      "kind = 'box'\nsize = [1, 1, 2]\nmotion = 'free'\nmass = 1\ninertia = [3, 4, 5]\n"
      "rotation_deg = [0, 0, 90]");
  EXPECT_EQ(box.inertia, Vector3d(3, 4, 5));
  EXPECT_LT((box.pose.linear() * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 1e-15);
}

TEST(SceneToml, WhatHangsHangsByItsTopFromStraightAbove) {
  const std::string ball =
      "kind = 'sphere'\nradius = 0.1\nmotion = 'hanging'\nmass = 1\nposition = [0, 0, -1]\n";
  const SceneObject plain = ObjectOf(ball + "string_length = 0.5");
  EXPECT_LT((plain.pose * plain.string.to_in_body - Vector3d(0, 0, -0.9)).norm(), 1e-8);
  EXPECT_LT((plain.string.from - Vector3d(0, 0, -0.4)).norm(), 1e-8);
  EXPECT_EQ(plain.string.length, 0.5);
  const SceneObject by_ends = ObjectOf(ball + "string_from = [0, 0, 1]\nstring_to = [0, 0, 0.05]");
  EXPECT_LT((by_ends.string.to_in_body - Vector3d(0, 0, 0.05)).norm(), 1e-15);
  EXPECT_NEAR(by_ends.string.length, 1.95, 1e-14);
  const SceneObject slack = ObjectOf(ball + "string_from = [0, 0, 1]\nstring_length = 7");
  EXPECT_EQ(slack.string.length, 7);
}

TEST(SceneToml, WhatHasNothingAboveItsCentreHangsFromTheHeightOfItsTop) {
  const SceneObject fork = ObjectOf(
      "kind = 'union'\nmotion = 'hanging'\nmass = 1\nstring_length = 1\n"
      "[[object.part]]\nkind = 'sphere'\nradius = 0.1\nposition = [0.5, 0, 0]\n"
      "[[object.part]]\nkind = 'sphere'\nradius = 0.1\nposition = [-0.5, 0, 0]");
  EXPECT_LT((fork.pose * fork.string.to_in_body - Vector3d(0, 0, 0.1)).norm(), 1e-12);
}

TEST(SceneToml, UpIsAgainstGravityForWhatHangs) {
  const Result<Scene> scene = SceneOf(
      "[medium]\ngravity = [5, 0, 0]\n[[object]]\nkind = 'cylinder'\nradius = 0.1\nlength = 2\n"
      "motion = 'hanging'\nmass = 1\nstring_length = 1");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const SceneObject& bar = scene.value().objects[0];
  EXPECT_LT((bar.pose * bar.string.to_in_body - Vector3d(-1, 0, 0)).norm(), 1e-8);
  EXPECT_LT((bar.string.from - Vector3d(-2, 0, 0)).norm(), 1e-8);
}

TEST(SceneToml, ATableIsAHalfSpaceAtItsHeight) {
  const Result<Scene> scene = SceneOf("[table]\nheight = -0.4\nfriction = 0.6");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const SceneObject& table = scene.value().objects.at(0);
  EXPECT_EQ(table.kind, "table");
  EXPECT_EQ(table.friction, 0.6);
  ASSERT_EQ(table.shape.size(), 1U);
  EXPECT_EQ(table.shape[0].kind, PrimitiveKind::kHalfSpace);
  EXPECT_EQ(table.pose.translation(), Vector3d(0, 0, -0.4));
}

TEST(SceneToml, FrictionReachesTheContact) {
  const Result<Scene> scene =
      SceneOf("[contact]\nfriction = 0.3\nfriction_static = 0.4\ntangential_stiffness_ratio = 0.8");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene.value().contact.friction, 0.3);
  EXPECT_EQ(scene.value().contact.static_friction, 0.4);
  EXPECT_EQ(scene.value().contact.tangential_ratio, 0.8);
}

TEST(SceneToml, PhasesFollowEachOtherAndMakeTheDuration) {
  const Result<Scene> scene = SceneOf(R"(
cycles = 2
[gripper]
design = "design.toml"
[[phase]]
name = "grasp"
duration = 3
pull = 0.25
pull_rate = 0.1
[[phase]]
duration = 1.5
move = [0, 0, 0.15]
turn_deg = 90
turn_axis = [1, 0, 0]
shake = { amplitude = [0.01, 0, 0], frequency = 2 }
)");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const std::vector<Phase>& phases = scene.value().phases;
  ASSERT_EQ(phases.size(), 4U);
  EXPECT_EQ(scene.value().duration, 9);
  EXPECT_EQ(phases[0].name, "grasp");
  EXPECT_EQ(phases[1].name, "phase1");
  EXPECT_EQ(phases[2].pull, 0.25);
  EXPECT_EQ(phases[2].pull_rate, 0.1);
  EXPECT_FALSE(phases[3].pull.has_value());
  EXPECT_EQ(phases[3].move, Vector3d(0, 0, 0.15));
  EXPECT_EQ(phases[3].turn, std::numbers::pi / 2);
  EXPECT_EQ(phases[3].turn_axis, Vector3d::UnitX());
  EXPECT_EQ(phases[3].shake_amplitude, Vector3d(0.01, 0, 0));
  EXPECT_EQ(phases[3].shake_frequency, 2);
}

TEST(SceneToml, TheMediumIsThatOfItsKindUnlessTold) {
  const Result<Scene> vacuum = SceneOf("");
  EXPECT_EQ(vacuum.value().medium.density, 0);
  const Result<Scene> water = SceneOf(R"(
[medium]
kind = "water"
flow = [0, 0.1, 0]
cross_drag = 1.2
[gripper]
design = "design.toml"
[gripper.rod]
base_radius = 0.008
drag_diameter = 0.02
displaced = 0.5
[[rod]]
displaced = 0
)");
  ASSERT_TRUE(water.ok()) << water.error().message;
  const Scene& scene = water.value();
  EXPECT_EQ(scene.medium.density, Water().density);
  EXPECT_EQ(scene.medium.flow, Vector3d(0, 0.1, 0));
  EXPECT_EQ(scene.medium.cross_drag, 1.2);
  EXPECT_EQ(scene.medium.along_drag, Water().along_drag);
  EXPECT_DOUBLE_EQ(scene.gripper->wetted.drag_diameter_scale, 1.25);
  EXPECT_EQ(scene.gripper->wetted.displaced, 0.5);
  EXPECT_EQ(scene.rods[0].wetted.displaced, 0);
  EXPECT_EQ(scene.rods[0].wetted.drag_diameter_scale, 1);
}

TEST(SceneToml, AGripperMayStartStowed) {
  const Result<Scene> scene = SceneOf(
      "[gripper]\ndesign = 'design.toml'\nstowed = { inner_radius = 0.03, gap = 0.002, release_time = 1, "
      "unroll_time = 0.6, eject_speed = 1.5 }");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const Stow& stow = scene.value().gripper->stowed.value();
  EXPECT_EQ(stow.inner_radius, 0.03);
  EXPECT_EQ(stow.gap, 0.002);
  EXPECT_EQ(stow.release_time, 1);
  EXPECT_EQ(stow.unroll_time, 0.6);
  EXPECT_EQ(stow.eject_speed, 1.5);
}

TEST(SceneToml, SettingsStandInForTheFilesValues) {
  const std::string toml =
      "[gripper]\ndesign = 'design.toml'\n[[object]]\nkind = 'sphere'\nradius = 1\nposition = [0, 0, -9]";
  const Result<Scene> scene =
      SceneOf(toml, {"object.0.position.2=-0.15", "gripper.tentacles=4", "object.0.radius=0.2", "level=fast",
                     "medium.kind=\"air\"", "gripper.delay=[0, 1]", "name=a = b"});
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene.value().objects[0].body.start, Vector3d(0, 0, -0.15));
  EXPECT_EQ(scene.value().objects[0].body.radius, 0.2);
  EXPECT_EQ(scene.value().gripper->gripper.tentacles, 4);
  EXPECT_EQ(scene.value().gripper->delay_high, 1);
  EXPECT_EQ(scene.value().level, SimulationLevel::kFast);
  EXPECT_EQ(scene.value().medium.density, Air().density);
  EXPECT_EQ(scene.value().name, "a = b");
}

TEST(SceneToml, ASettingThatCannotBeIsNamed) {
  const std::string toml = "[[object]]\nkind = 'sphere'\nradius = 1";
  const struct {
    std::string setting, expected;
  } slips[] = {
      {"object.0.radius", "expected key=value"},
      {"object..radius=1", "with a dot between two"},
      {"object.1.radius=1", "'1': expected a place in the list, 0 to 0"},
      {"object.first.radius=1", "'first': expected a place in the list"},
      {"object.0.radius.2=1", "'2' in what is neither a table nor a list"},
      {"object.0.radius=-1", "object[0].radius = -1: expected a number > 0 m"},
      {"object.0.radios=1", "object[0].radios: unknown key; did you mean object[0].radius?"},
      {"contakt.friction=1", "contakt: unknown key; did you mean contact?"},
      {"object.0.radius=big", "object[0].radius = 'big': expected a number > 0 m"},
  };
  for (const auto& [setting, expected] : slips) {
    const Result<Scene> scene = SceneOf(toml, {setting});
    ASSERT_FALSE(scene.ok()) << setting;
    EXPECT_THAT(scene.error().message, AllOf(HasSubstr("--set " + setting), HasSubstr(expected)));
  }
}

TEST(EditedToml, ReadsBackAsTheFileWithItsSettings) {
  const std::string text = "a = 1 # one\nlist = [1.5, 2]\n[[t]]\nx = 'y'\n";
  EXPECT_EQ(EditedToml(text, "f", {}).value(), text);
  const std::string edited = EditedToml(text, "f", {"list.1=0.25", "t.0.z=true", "new.key=\"k\""}).value();
  EXPECT_EQ(EditedToml(edited, "f", {"a=1"}).value(), edited);
  for (const char* part : {"a = 1", "list = [ 1.5, 0.25 ]", "z = true", "x = 'y'", "key = 'k'"}) {
    EXPECT_THAT(edited, HasSubstr(part));
  }
  EXPECT_THAT(EditedToml("a = ", "f", {"a=1"}).error().message, HasSubstr("f:1: not TOML"));
}

TEST(SceneToml, EachSlipIsOneLineThatSaysWhatWasExpected) {
  const std::string ball = "[[object]]\nkind = 'sphere'\nradius = 0.1\n";
  const std::string grip = "[gripper]\ndesign = 'design.toml'\n";
  const struct {
    std::string toml, field, expected;
  } slips[] = {
      {"[[object]]\nkind = 'ball'", "object[0].kind = 'ball'",
       "one of cylinder, capsule, sphere, box, union"},
      {"[[object]]\nkind = 'box'\nsize = [1, 0, 1]", "object[0].size", "each > 0 m"},
      {"[[object]]\nkind = 'union'", "object[0].part", "one [[object.part]] or more"},
      {"[[object]]\nkind = 'union'\n[[object.part]]\nkind = 'sphere'\nradius = -1",
       "object[0].part[0].radius", "a number > 0 m"},
      {ball + "axis = [1, 0, 0]", "object[0].axis", "unknown key"},
      {ball + "motion = 'free'", "object[0].mass", "missing, and there is no default"},
      {ball + "motion = 'flying'", "object[0].motion = 'flying'", "one of fixed, free, hanging"},
      {ball + "velocity = [1, 0, 0]", "object[0].velocity", "motion = free or hanging"},
      {ball + "string_length = 1", "object[0].string_length", "motion = hanging"},
      {ball + "motion = 'hanging'\nmass = 1", "object[0].string_length", "missing, expected a number > 0 m"},
      {ball + "motion = 'hanging'\nmass = 1\nstring_length = 1\nstring_from = [0, 0, 5]",
       "object[0].string_length = 1", "4.9 m or more"},
      {ball + "motion = 'free'\nmass = 1\ninertia = [1, 1, 3]", "object[0].inertia", "above the others' sum"},
      {"[[object]]\nkind = 'capsule'\nradius = 1\nlength = 1\naxis = [1, 0, 0]\nrotation_deg = [0, 0, 1]",
       "object[0].axis", "not both"},
      {"[[object]]\nkind = 'capsule'\nradius = 1\nlength = 1\naxis = [0, 0, 0]", "object[0].axis",
       "not all zeros"},
      {ball + "name = 'a'\n" + ball + "name = 'a'", "object[1].name = 'a'", "a name of its own"},
      {ball + "name = 'a/b'", "object[0].name = 'a/b'", "without comma, slash"},
      {"[table]\nfriction = 1", "table.height", "missing"},
      {"[contact]\nfriction = 0.3\nfriction_static = 0.2", "contact.friction_static = 0.2",
       "not below friction"},
      {"[contact]\nfriction = 0.3\nlaw = 'hertz_equal'", "contact.law = 'hertz_equal'",
       "hertz_segments, where there is friction"},
      {"[contact]\nlaw = 'hertz_centers'\n[table]\nheight = 0", "contact.law",
       "hertz_segments, where an object is a box"},
      {ball + "motion = 'free'\nmass = 1\n[contact]\nlaw = 'hertz_centers'", "contact.law",
       "hertz_segments, where an object moves"},
      {"level = 'static'\n" + ball + "motion = 'free'\nmass = 1", "level = 'static'",
       "paper, standard or fast, where an object moves"},
      {"level = 'static'\n[medium]\nkind = 'water'", "level = 'static'", "where there is a medium"},
      {"[medium]\ndensity = 1", "medium.density = 1", "kind = air or water beside it"},
      {"[medium]\nkind = 'oil'", "medium.kind = 'oil'", "one of vacuum, air, water"},
      {"cycles = 2", "cycles = 2", "[[phase]] tables"},
      {"cycles = 1000000\n[[phase]]\nduration = 1", "cycles = 1000000", "100000 phases in all, or fewer"},
      {"duration = 3\n[[phase]]\nduration = 1\n[[phase]]\nduration = 1.5", "duration = 3",
       "2.5 s, the sum of the phases"},
      {"[[phase]]\npull = 0.3\nduration = 1", "phase[0].pull = 0.3", "a [gripper] that pulls"},
      {grip + "[[phase]]\nduration = 1\npull = 1", "phase[0].pull = 1", "a number below 1"},
      {grip + "[[phase]]\nduration = 1\npull = 1.5", "phase[0].pull = 1.5", "<= 1"},
      {grip + "[[phase]]\nduration = 1\npull_rate = 1", "phase[0].pull_rate = 1", "a pull beside it"},
      {grip + "[[phase]]\nmove = [0, 0, 1]", "phase[0].duration", "missing"},
      {grip + "[[phase]]\nduration = 1\nmoves = [0, 0, 1]", "phase[0].moves", "did you mean phase[0].move?"},
      {grip + "[[phase]]\nduration = 1\nturn_axis = [0, 0, 0]", "phase[0].turn_axis", "not all zeros"},
      {grip + "[[phase]]\nduration = 1\nshake = { amplitude = [1, 0, 0] }", "phase[0].shake.frequency",
       "missing"},
      {"[[phase]]\nduration = 1\nmove = [0, 0, 1]\n[[rod]]\nclamp = 'none'", "phase[0].move",
       "a [[rod]] that is held"},
      {grip + "pair_spacing = 0.2", "gripper.pair_spacing = 0.2", "at most 0.1697 m"},  // 0.24 m sin 45 deg
      {grip + "tentacles = 7\npair_spacing = 0.02", "gripper.pair_spacing = 0.02", "an even number"},
      {grip + "stowed = { gap = 0.001 }", "gripper.stowed.turns", "turns or an inner_radius"},
      {grip + "stowed = { turns = 2, inner_radius = 0.1 }", "gripper.stowed.turns", "not both"},
      {grip + "stowed = { turns = 0 }", "gripper.stowed.turns = 0", "a number > 0"},
      {"[[rod]]\ndrag_diameter = -1", "rod[0].drag_diameter = -1", ">= 0 m"},
  };
  for (const auto& [toml, field, expected] : slips) {
    EXPECT_THAT(MessageFor(toml), AllOf(HasSubstr("scene.toml:"), HasSubstr(field), HasSubstr(expected)))
        << toml;
  }
}

TEST(SceneToml, ARodStartsAlongACurveThroughPoints) {
  // Three quarters of a circle of radius 0.1 m about z.
  std::string points;
  for (int i = 0; i <= 24; ++i) {
    const double at = 1.5 * std::numbers::pi * i / 24;
    points += std::to_string(0.1 * std::sin(at)) + ", " + std::to_string(0.1 - 0.1 * std::cos(at)) + ", 0, ";
  }
  const std::string rod = "[[rod]]\nnormal = [0, 0, 1]\nelements = 60\nstart_points = [" + points + "]\n";
  const Result<Scene> scene = SceneOf(rod);
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const RodDesign& design = scene.value().rods[0].design;
  EXPECT_NEAR(design.length, 0.15 * std::numbers::pi, 1e-4);
  const Result<Rod> made = MakeRod(design);
  ASSERT_TRUE(made.ok()) << made.error().message;
  const Eigen::Matrix3Xd& nodes = made.value().position;
  for (Eigen::Index i = 0; i < nodes.cols(); ++i) {
    EXPECT_NEAR((nodes.col(i) - Vector3d(0, 0.1, 0)).norm(), 0.1, 2e-4) << i;
    EXPECT_NEAR(nodes(2, i), 0, 1e-9) << i;
  }
  EXPECT_THAT(MessageFor(rod + "length = 1\n"), HasSubstr("length"));
  EXPECT_THAT(MessageFor("[[rod]]\nstart_points = [0, 0, 0, 1, 0, 0]\n"), HasSubstr("start_points"));
}

}  // namespace
}  // namespace tendril
