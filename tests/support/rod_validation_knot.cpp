// An overhand knot that is pulled tight.
#include <cmath>
#include <numbers>

#include "model/check.h"
#include "model/rods/press.h"
#include "model/scene/stepper.h"
#include "tests/support/rod_validation.h"

namespace tendril::testing_support {
namespace {

using Eigen::Index;
using std::numbers::pi;

// Means over the last two seconds.
struct Knot {
  double tension = 0;   // of both ends, N
  double pressing = 0;  // what strands press on each other with, in all, N
  double radius = 0;    // of the loop, opposite of the braid, m
};

double PressingIn(const Contact& contact, const Rod& rod) {
  double sum = 0;
  const auto side = [&](Index i) {
    return PressSide{rod.position.col(i), rod.position.col(i + 1), rod.radius[i], rod.rest_length[i]};
  };
  for (Index i = 0; i < rod.elements(); ++i) {
    for (Index j = FirstThatMayTouch(rod, i, contact.law); j < rod.elements(); ++j) {
      sum += PressOf(contact.stiffness, contact.points, side(i), side(j)).normal_force.norm();
    }
  }
  return sum;
}

Knot Tightened(double friction) {
  const Scene scene = ValidationScene("overhand", SimulationLevel::kStandard, 1,
                                      {"contact.friction=" + ShortNumber(friction)});
  const SimulationPlan plan = PlanScene(scene).value();
  Contact contact = scene.contact;
  contact.points = plan.contact_points;
  Stepper stepper(scene, plan, MakeRods(scene, 0).value(), plan.time_step);
  Knot mean;
  constexpr int kFrames = 20;
  for (int f = 0; f <= kFrames; ++f) {
    const double time = scene.duration - 2 + 2.0 * f / kFrames;
    TENDRIL_CHECK(!stepper.AdvanceTo(std::llround(time / plan.time_step)));
    const Rod rod = stepper.At(static_cast<double>(stepper.kicks()) * plan.time_step)[0];
    const Index n = rod.elements();
    constexpr double kShare = 1.0 / (kFrames + 1);
    // A few elements off either end, where it is straight.
    for (Index i = 2; i < 14; ++i) {
      for (const Index k : {i, n - 1 - i}) {
        mean.tension += kShare / 24 * rod.shear_stiffness(2, k) * StrainOf(rod, k).z();
      }
    }
    mean.pressing += kShare * PressingIn(contact, rod);
    double curvature = 0;
    const Index half = n / 24;
    for (Index i = n / 2 - half; i <= n / 2 + half; ++i) curvature += CurvatureOf(rod, i).norm();
    mean.radius += kShare * static_cast<double>(2 * half + 1) / curvature;
  }
  return mean;
}

}  // namespace

std::vector<Figure> OverhandFigures(bool quick) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (quick) return {};
  const Scene scene = ValidationScene("overhand", SimulationLevel::kStandard);
  const RodDesign& rod = scene.rods[0].design;
  const double h = rod.base_radius, bending = rod.youngs_modulus * pi / 4 * std::pow(h, 4);
  const Knot smooth = Tightened(0);
  const auto sigma = [&](const Knot& knot) {
    return knot.pressing * h * h / bending / std::pow(h / knot.radius, 1.5);
  };
  const int n = rod.elements;
  std::vector<Figure> figures = {
      {"eps", std::sqrt(h / smooth.radius), kNone, "standard", n},
      {"T h^2/B / (eps^4/2), mu 0", 2 * smooth.tension * std::pow(smooth.radius, 2) / bending, kNone,
       "standard", n},
      {"P h^2/B / eps^3, mu 0", sigma(smooth), kNone, "standard", n}};
  for (const double friction : {0.1, 0.3}) {
    const Knot knot = Tightened(friction);
    const double without = smooth.tension * std::pow(smooth.radius / knot.radius, 2);
    const std::string of = ", mu " + ShortNumber(friction);
    figures.push_back({"P h^2/B / eps^3" + of, sigma(knot), kNone, "standard", n});
    figures.push_back({"(T - T of mu 0) / (mu P)" + of, (knot.tension - without) / (friction * knot.pressing),
                       1, "standard", n});
  }
  return figures;
}

}  // namespace tendril::testing_support
