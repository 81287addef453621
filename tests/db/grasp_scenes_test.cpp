// examples/scenes/grasp: each can be read and started, also as its comments vary it, and nothing begins
// inside anything else.
#include <gtest/gtest.h>

#include <cmath>

#include "db/files/scene_toml.h"
#include "model/geometry/segment_distance.h"
#include "model/objects/object_drag.h"
#include "model/scene/driven.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

struct Variation {
  std::string file;
  std::vector<std::string> settings = {};
};

Scene Read(const Variation& variation) {
  const Result<Scene> scene =
      ReadScene(std::string(TENDRIL_SOURCE_DIR) + "/examples/scenes/grasp/" + variation.file + ".toml",
                variation.settings);
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().message);
  return scene.ok() ? scene.value() : Scene{};
}

double FreeBetween(const Rod& a, const Rod& b) {
  double least = HUGE_VAL;
  for (Index i = 0; i < a.elements(); ++i) {
    for (Index j = 0; j < b.elements(); ++j) {
      const double distance = ClosestOfSegments(a.position.col(i), a.position.col(i + 1), b.position.col(j),
                                                b.position.col(j + 1))
                                  .apart.norm();
      least = std::min(least, distance - a.radius[i] - b.radius[j]);
    }
  }
  return least;
}

double DistanceTo(const SceneObject& object, const Vector3d& in_lab) {
  double least = HUGE_VAL;
  for (const Primitive& part : object.shape) {
    least = std::min(least, DistanceTo(part, object.pose.inverse() * in_lab).distance);
  }
  return least;
}

double FreeBetween(const Rod& rod, const SceneObject& object) {
  double least = HUGE_VAL;
  for (Index i = 0; i < rod.elements(); ++i) {
    for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      const Vector3d point = (1 - share) * rod.position.col(i) + share * rod.position.col(i + 1);
      least = std::min(least, DistanceTo(object, point) - rod.radius[i]);
    }
  }
  return least;
}

double FreeBetween(const SceneObject& a, const SceneObject& b) {
  double least = HUGE_VAL;
  for (const SurfaceSphere& sphere : SurfaceSpheres(a.shape)) {
    least = std::min(least, DistanceTo(b, a.pose * sphere.centre) - sphere.radius);
  }
  return least;
}

std::vector<Variation> All() {
  std::vector<Variation> all;
  for (const char* file :
       {"tube", "balloon", "payload-crimper", "payload-level", "payload-hammer", "payload-container",
        "payload-cup", "payload-tree", "underwater", "zero-g", "deploy", "table-top"}) {
    all.push_back({file});
  }
  for (const char* height : {"-0.05", "-0.25", "-0.35"}) {
    const std::string place = std::string("object.0.position.2=") + height;
    all.push_back({"tube", {place}});
    all.push_back({"tube", {place, "gripper.design=../designs/bending.toml"}});
  }
  all.push_back({"tube", {"gripper.tentacles=4", "gripper.first_azimuth_deg=45"}});
  all.push_back({"tube", {"gripper.tentacles=8", "gripper.first_azimuth_deg=22.5"}});
  all.push_back({"balloon", {"object.0.radius=0.015"}});
  all.push_back({"balloon", {"object.0.radius=0.10"}});
  all.push_back(
      {"tube", {"object.0.position.2=-0.25", "gripper.carrier_radius=0.11", "object.1.radius=0.095"}});
  all.push_back(
      {"tube", {"object.0.position.2=-0.25", "gripper.carrier_radius=0.15", "object.1.radius=0.135"}});
  for (const char* depth : {"-0.10", "-0.20", "-0.40", "-0.50", "-0.60"}) {
    all.push_back({"underwater", {std::string("object.0.position.2=") + depth}});
  }
  return all;
}

TEST(GraspScenes, NothingBeginsInsideAnythingElse) {
  for (const Variation& variation : All()) {
    SCOPED_TRACE(variation.file + (variation.settings.empty() ? "" : " " + variation.settings[0]));
    const Scene scene = Read(variation);
    const auto rods = MakeRods(scene, 0);
    ASSERT_TRUE(rods.ok()) << rods.error().message;
    const std::vector<Driven>& all = rods.value();
    ASSERT_EQ(all.size(), static_cast<std::size_t>(scene.gripper->gripper.tentacles));
    for (std::size_t a = 0; a < all.size(); ++a) {
      EXPECT_GT(FreeBetween(all[a].rod, all[(a + 1) % all.size()].rod), 1e-3);
      for (const SceneObject& object : scene.objects) {
        // The tube of 280 mm just fits between the rods.
        EXPECT_GT(FreeBetween(all[a].rod, object), 2e-4) << all[a].name << " and " << object.name;
      }
    }
    for (const SceneObject& a : scene.objects) {
      for (const SceneObject& b : scene.objects) {
        if (&a == &b || a.kind == "table") continue;
        const double apart = FreeBetween(a, b);
        EXPECT_GT(apart, b.kind == "table" ? -1e-9 : 1e-3) << a.name << " and " << b.name;
        if (b.kind == "table") {
          EXPECT_LT(apart, 1e-6) << a.name << " stands on the table";
        }
      }
    }
  }
}

TEST(GraspScenes, TentaclesWeighAndBendPerLengthAsThePapersRods) {
  const Scene paper = ReadScene(std::string(TENDRIL_SOURCE_DIR) + "/examples/scenes/paper.toml").value();
  const RodDesign& thick = paper.gripper->rod;
  for (const Variation& variation : All()) {
    const RodDesign rod = Read(variation).gripper->rod;
    const double share = rod.base_radius / thick.base_radius, square = share * share;
    EXPECT_NEAR(rod.density * square, thick.density, 1e-5 * thick.density) << variation.file;
    EXPECT_NEAR(rod.youngs_modulus * square * square, thick.youngs_modulus, 1e-5 * thick.youngs_modulus);
    EXPECT_NEAR(rod.shear_modulus * square * square, thick.shear_modulus, 1e-5 * thick.shear_modulus);
  }
}

TEST(GraspScenes, UnderWaterTentaclesFloatAndTheTubeWeighsAsMuchAsDrawsItsStringTaut) {
  const Scene scene = Read({"underwater"});
  const double density = scene.medium.density;
  EXPECT_NEAR(scene.gripper->rod.density / (density * scene.gripper->wetted.displaced), 1, 1e-3);
  const double displaced = density * DragOf(scene.objects[0].shape).value().volume;
  EXPECT_NEAR(scene.objects[0].mass - displaced, 0.015 * (1 - density / 1040), 1e-5);
  EXPECT_GT(scene.gravity.x(), 9);
}

TEST(GraspScenes, TheRollsAreReleasedBeforeTheSatelliteIsThere) {
  const Scene scene = Read({"deploy"});
  const Stow& stow = scene.gripper->stowed.value();
  const SceneObject& satellite = scene.objects[0];
  const double there = -satellite.pose.translation().x() / satellite.velocity.x();
  EXPECT_LT(stow.release_time + stow.unroll_time + 1, there);
}

}  // namespace
}  // namespace tendril
