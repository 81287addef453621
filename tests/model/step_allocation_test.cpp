// model/scene/stepper.h: once warm, steps allocate nothing, whatever a scene switches on.
#include <gtest/gtest.h>

#include "model/scene/stepper.h"
#include "tests/support/allocation_count.h"

namespace tendril {
namespace {

using testing_support::allocations;

TEST(Stepper, AllocatesNothingPerStep) {
  Scene scene;
  scene.gripper.emplace();
  scene.gripper->gripper.tentacles = 10;  // more than one part
  scene.gripper->rod.elements = 40;
  scene.gripper->damping = 20;
  scene.gripper->pull_rate = 0.5;
  SceneObject bar;
  bar.body = {{-0.1, 0, -0.15}, {0.1, 0, -0.15}, 0.02};
  bar.shape = {{PrimitiveKind::kCapsule, 0.02, {0, 0, 0.1}}};
  bar.pose.translation() = Eigen::Vector3d(0, 0, -0.15);
  bar.pose.linear() << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  scene.objects = {bar};
  for (const SimulationLevel level : {SimulationLevel::kPaper, SimulationLevel::kStandard}) {
    scene.level = level;
    scene.contact.damping = 0.01;
    scene.contact.friction = 0.3;
    const SimulationPlan plan = PlanScene(scene).value();
    ASSERT_TRUE(plan.rod_contact && plan.object_contact && plan.self_contact);
    for (const int threads : {1, 2}) {
      Stepper stepper(scene, plan, MakeRods(scene, 0).value(), plan.time_step, threads);
      // Two threads on a machine that is busy elsewhere wait for each other at every step.
      const int warm = threads == 1 ? 10000 : 500, steps = threads == 1 ? 1000 : 100;
      ASSERT_FALSE(stepper.AdvanceTo(warm));
      if (threads == 1) {
        EXPECT_LT(stepper.contacts()->least_share(), 1) << "nothing touched";
      }
      const long lists = stepper.contacts()->lists();
      const long before = allocations;
      ASSERT_FALSE(stepper.AdvanceTo(warm + steps));
      // Lists of contacts may still grow; steps between do not allocate.
      EXPECT_LT(allocations - before, 20)
          << "in " << steps << " steps and " << stepper.contacts()->lists() - lists << " lists";
    }
  }
}

}  // namespace
}  // namespace tendril
