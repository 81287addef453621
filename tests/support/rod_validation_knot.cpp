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
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

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

Knot Tightened(const std::vector<std::string>& settings) {
  const Scene scene = ValidationScene("overhand", SimulationLevel::kStandard, 1, settings);
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

// What a knot's figures are divided by.
struct Scales {
  double radius, bending;  // m, N m^2
  int elements;

  double Eps(const Knot& knot) const { return std::sqrt(radius / knot.radius); }
  double Sigma(const Knot& knot) const {
    return knot.pressing * radius * radius / bending / std::pow(Eps(knot), 3);
  }
  std::vector<Figure> OfSmooth(const Knot& knot) const {
    return {{"eps", Eps(knot), kNone, "standard", elements},
            {"T h^2/B / (eps^4/2), mu 0", 2 * knot.tension * std::pow(knot.radius, 2) / bending, kNone,
             "standard", elements},
            {"P h^2/B / eps^3, mu 0", Sigma(knot), kNone, "standard", elements}};
  }
};
Scales ScalesOf(const std::vector<std::string>& settings) {
  const RodDesign rod = ValidationScene("overhand", SimulationLevel::kStandard, 1, settings).rods[0].design;
  return {rod.base_radius, rod.youngs_modulus * pi / 4 * std::pow(rod.base_radius, 4), rod.elements};
}

}  // namespace

std::vector<Figure> OverhandFigures(bool quick) {
  if (quick) return {};
  const Scales scales = ScalesOf({});
  const Knot smooth = Tightened({});
  std::vector<Figure> figures = scales.OfSmooth(smooth);
  const int n = scales.elements;
  for (const double friction : {0.1, 0.3}) {
    const Knot knot = Tightened({"contact.friction=" + ShortNumber(friction)});
    const double without = smooth.tension * std::pow(smooth.radius / knot.radius, 2);
    const std::string of = ", mu " + ShortNumber(friction);
    figures.push_back({"P h^2/B / eps^3" + of, scales.Sigma(knot), kNone, "standard", n});
    figures.push_back({"(T - T of mu 0) / (mu P)" + of, (knot.tension - without) / (friction * knot.pressing),
                       1, "standard", n});
  }
  return figures;
}

// Half as thick, as fast and as finely divided for its thickness.
std::vector<Figure> ThinnerOverhandFigures(bool quick) {
  if (quick) return {};
  const std::vector<std::string> thinner = {"rod.0.base_radius=0.001", "rod.0.elements=640",
                                            "rod.0.youngs_modulus=4e7", "rod.0.shear_modulus=1.333333e7",
                                            "contact.stiffness=4e5"};
  return ScalesOf(thinner).OfSmooth(Tightened(thinner));
}

}  // namespace tendril::testing_support
