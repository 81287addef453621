// Objects and rods that sink, swing, collide and hold.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/check.h"
#include "model/scene/stepper.h"
#include "tests/support/rod_validation.h"

namespace tendril::testing_support {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr SimulationLevel kStandard = SimulationLevel::kStandard;

// Momentum, and angular momentum about the origin, of all that moves.
struct Momenta {
  Vector3d linear = Vector3d::Zero(), angular = Vector3d::Zero();
};
Momenta MomentaOf(const Scene& scene, const Stepper& stepper) {
  Momenta sum;
  const double time = static_cast<double>(stepper.kicks()) * stepper.time_step();
  for (const Rod& rod : stepper.At(time)) {
    for (Index i = 0; i < rod.mass.size(); ++i) {
      const Vector3d push = rod.mass[i] * rod.velocity.col(i);
      sum.linear += push;
      sum.angular += Vector3d(rod.position.col(i)).cross(push);
    }
    for (Index i = 0; i < rod.elements(); ++i) {
      sum.angular += rod.directors[static_cast<std::size_t>(i)].transpose() *
                     rod.inertia.col(i).cwiseProduct(rod.spin.col(i));
    }
  }
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    if (scene.objects[o].motion == ObjectMotion::kFixed) continue;
    const RigidBody& body = stepper.bodies().body(o);
    sum.linear += body.mass * body.velocity;
    sum.angular +=
        body.mass * body.position.cross(body.velocity) + body.lab_from_body * body.angular_momentum_in_body;
  }
  return sum;
}

}  // namespace

std::vector<Figure> SinkingFigures(bool /*quick*/) {
  const Scene scene = ValidationScene("sinking", kStandard);
  const double late = 0.95 * scene.duration, g = scene.gravity.norm(), fluid = scene.medium.density;
  const Simulated run = RunScene(scene, {late, scene.duration});
  const int n = scene.rods[0].design.elements;
  std::vector<Figure> figures;
  // Where weight less buoyancy is carried by a drag of rho/2 C A v^2.
  const auto add = [&](const std::string& of, double z, double heavier, double drag_area) {
    figures.push_back({of + ": speed, m/s", z / (scene.duration - late),
                       std::sqrt(2 * heavier * g / (fluid * drag_area)), "standard", n});
  };
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const SceneObject& object = scene.objects[o];
    const Primitive& part = object.shape[0];
    const auto& poses = run.objects[o].poses;
    const double r = part.radius, length = 2 * part.half.z();
    const double volume = object.kind == "sphere" ? 4. / 3 * pi * r * r * r : pi * r * r * length;
    // docs/media.md
    const double area = object.kind == "sphere"             ? 0.47 * pi * r * r
                        : object.name == "cylinder upright" ? 0.82 * pi * r * r
                                                            : 1.1 * 2 * r * length;
    add(object.name, poses[0].translation().z() - poses[1].translation().z(), object.mass - fluid * volume,
        area);
  }
  for (std::size_t r = 0; r < scene.rods.size(); ++r) {
    const RodDesign& rod = scene.rods[r].design;
    const auto& curves = run.curves[r].curves;
    const double radius = rod.base_radius, length = rod.length;
    const double drag = scene.rods[r].name == "upright" ? scene.medium.along_drag * pi * 2 * radius * length
                                                        : scene.medium.cross_drag * 2 * radius * length;
    add("rod " + scene.rods[r].name, curves[0].points.row(2).mean() - curves[1].points.row(2).mean(),
        (rod.density - fluid) * pi * radius * radius * length, drag);
  }
  return figures;
}

std::vector<Figure> PendulumFigures(bool /*quick*/) {
  const Scene scene = ValidationScene("pendulum", kStandard);
  const int count = 6000;
  std::vector<double> times;
  for (int i = 0; i <= count; ++i) times.push_back(scene.duration * i / count);
  const Simulated run = RunScene(scene, times);
  std::vector<Figure> figures;
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const BodyString& string = scene.objects[o].string;
    const auto x = [&](int i) { return run.objects[o].poses[static_cast<std::size_t>(i)].translation().x(); };
    std::vector<double> crossings;
    for (int i = 1; i <= count; ++i) {
      if (!(x(i - 1) > 0 && x(i) <= 0)) continue;
      crossings.push_back(scene.duration / count * (i - 1 + x(i - 1) / (x(i - 1) - x(i))));
    }
    TENDRIL_CHECK(crossings.size() > 2);
    const double period = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
    const double angle = std::asin(x(0) / string.length);
    const double reference =
        4 * std::sqrt(string.length / scene.gravity.norm()) * std::comp_ellint_1(std::sin(angle / 2));
    figures.push_back({scene.objects[o].name + " swing: period, s", period, reference, "standard", 0});
  }
  return figures;
}

std::vector<Figure> CollisionFigures(bool /*quick*/) {
  const Scene scene = ValidationScene("collision", kStandard);
  const SimulationPlan plan = PlanScene(scene).value();
  Stepper stepper(scene, plan, MakeRods(scene, 0).value(), plan.time_step);
  const Momenta start = MomentaOf(scene, stepper);
  double linear = 0, angular = 0, pressed = 0;
  while (static_cast<double>(stepper.kicks()) * plan.time_step < scene.duration) {
    TENDRIL_CHECK(!stepper.AdvanceTo(stepper.kicks() + 50));
    const Momenta now = MomentaOf(scene, stepper);
    linear = std::max(linear, (now.linear - start.linear).norm() / start.linear.norm());
    angular = std::max(angular, (now.angular - start.angular).norm() / start.angular.norm());
    for (std::size_t o = 0; o < scene.objects.size(); ++o) {
      pressed = std::max(pressed, stepper.ForceOn(o).norm());
    }
  }
  TENDRIL_CHECK(pressed > 0);
  const int n = scene.rods[0].design.elements;
  return {{"momentum drift", linear, 0, "standard", n},
          {"angular momentum drift", angular, 0, "standard", n}};
}

std::vector<Figure> HeldFigures(bool /*quick*/) {
  const Scene scene = ValidationScene("held", kStandard);
  const Simulated run = RunScene(scene, {scene.duration - 60, scene.duration});
  const auto& poses = run.objects[0].poses;
  const int n = scene.rods[0].design.elements;
  const Eigen::AngleAxisd turned(poses[0].linear().transpose() * poses[1].linear());
  return {{"way in 60 s, m", (poses[1].translation() - poses[0].translation()).norm(), 0, "standard", n},
          {"turn in 60 s, rad", std::abs(turned.angle()), 0, "standard", n}};
}

}  // namespace tendril::testing_support
