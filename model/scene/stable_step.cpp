// How long a step a rod allows (docs/rods.md, "Step").
#include <algorithm>
#include <cmath>

#include "model/rods/press.h"
#include "model/scene/plan.h"

namespace tendril {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

// Overlap that contact is reckoned to reach, as a share of a radius, and contacts on a node at once.
constexpr double kReckonedOverlap = 0.1, kReckonedContacts = 4;

// The largest omega^2 of the shortest wave that shifts nodes and turns elements: shear binds the one to the
// other, with the squares `shift` and `turn` alone, and hinges bind turns to turns.
double FastestBending(double shift, double turn, double hinge) {
  const double mean = 0.5 * (shift + turn + hinge);
  return mean + std::sqrt(std::max(0.0, mean * mean - shift * hinge));
}

}  // namespace

double StableSteps::Least() const { return std::min({stretch, bend, twist, shear, contact}); }

StableSteps StableStepsOf(const Rod& rod, double contact_stiffness, double contact_damping) {
  StableSteps steps{HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL};
  for (Index i = 0; i < rod.elements(); ++i) {
    const double l = rod.rest_length[i];
    const Index last = rod.elements() - 1;
    // Sums over what is on either side: in a tapered rod an element hangs between a stiffer hinge and a
    // softer.
    const Index inner = std::min<Index>(i, last - 1), before = std::max<Index>(i - 1, 0);
    const Vector3d hinges = rod.bend_stiffness.col(before) + rod.bend_stiffness.col(inner);
    const double mass = std::min(rod.mass[i] * (i == 0 ? 2 : 1), rod.mass[i + 1] * (i == last ? 2 : 1));
    const double across = rod.shear_stiffness(0, i), j1 = rod.inertia(0, i), j3 = rod.inertia(2, i);
    // omega^2 of the shortest wave of each kind; bending elements are also held by shear, and pushed nodes by
    // contact.
    const double stretch = 4 * rod.shear_stiffness(2, i) / (l * mass);
    const double hinge = 2 * hinges.x() / (l * j1);
    const double twist = 2 * hinges.z() / (l * j3);
    const double shear = FastestBending(4 * across / (l * mass), l * across / j1, 0);
    const double bend = FastestBending(4 * across / (l * mass), l * across / j1, hinge);
    const double push = 1.5 * contact_stiffness * std::sqrt(kReckonedOverlap * rod.radius[i]);
    const double contact = kReckonedContacts * push / mass + 4 * across / (l * mass);
    // A damper is stable while it takes no more than a node has: c dt / m below 2.
    if (contact_damping > 0)
      steps.contact = std::min(steps.contact, mass / (kReckonedContacts * contact_damping));
    const auto least = [](double& step, double square) { step = std::min(step, 2 / std::sqrt(square)); };
    least(steps.stretch, stretch);
    least(steps.bend, bend);
    least(steps.twist, twist);
    least(steps.shear, shear);
    if (contact_stiffness > 0) least(steps.contact, contact);
  }
  return steps;
}

double StickingStep(const Rod& rod, const Contact& contact) {
  const double bending = StableStepsOf(rod, 0).Least();
  double least = HUGE_VAL;
  for (Index i = 0; i < rod.elements(); ++i) {
    const double radius = rod.radius[i];
    const bool at_end = i == 0 || i + 1 == rod.elements();
    const double mass = std::min(rod.mass[i], rod.mass[i + 1]) * (at_end ? 2 : 1);
    const double gives = 1 / mass + radius * radius / rod.inertia.col(i).minCoeff();
    const double surface = SurfaceStiffness(contact.stiffness, radius) * rod.rest_length[i];
    const double damper =
        contact.damping * std::max(1.0, surface / ReferenceStiffness(contact.stiffness, 2 * radius));
    const double square =
        kReckonedContacts * contact.tangential_ratio * surface * gives + 4 / (bending * bending);
    // (omega h)^2 + 2 gamma h = 4: a damper takes the velocity from before the kick.
    const double gamma = kReckonedContacts * damper * gives;
    least = std::min(least, 4 / (gamma + std::sqrt(gamma * gamma + 4 * square)));
  }
  return least;
}

void ApplyRelief(const RodRelief& relief, Rod& rod) {
  rod.shear_stiffness.topRows<2>() /= relief.shear;
  rod.shear_stiffness.row(2) /= relief.stretch;
  rod.inertia *= relief.mass;
  rod.inertia.topRows<2>() *= relief.rotary_inertia;
  rod.mass *= relief.mass;
}

}  // namespace tendril
