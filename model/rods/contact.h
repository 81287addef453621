#pragma once
// Forces between rods that touch, in the plain form: every element against every other. With objects:
// model/contact_bodies.h; fast: contact_list.h.

#include <Eigen/Core>

#include "model/rods/rod.h"

namespace tendril {

enum class ContactLaw {
  // An energy between every two elements, integrated along both (docs/rods.md, "Contact"): rods that cross at
  // a
  // right angle press with stiffness eps^(3/2), rods side by side in proportion to depth and length.
  kHertzSegments,
  kHertzEqual,  // the closest points of every pair, half on either node (an end element: a third on the rod's
                // end)
  kHertzCenters,  // between the elements' centres, as the paper says
};

// The published laws: |F| = stiffness eps^(3/2) + damping * (speed of approach) along the normal, where eps =
// the radii's sum minus the distance is above 0; damping may pull, while bodies part. kHertzSegments never
// pulls, and it alone has friction.
struct Contact {
  ContactLaw law = ContactLaw::kHertzSegments;
  double stiffness = 1e4;       // N/m^(3/2)
  double damping = 0;           // N s/m; kHertzSegments: of a crossing as deep as 5 % of the radii's sum
  double friction = 0;          // mu of what slides
  double static_friction = 0;   // mu of what sticks; 0: as friction
  double tangential_ratio = 1;  // stiffness of a stick along the surface / that across it
  int points = 1;               // of an element, where its energy is reckoned
};

// All that is nearer to the segment than the radius: a capsule, or a sphere where the ends are one.
struct FixedBody {
  Eigen::Vector3d start = Eigen::Vector3d::Zero();  // m
  Eigen::Vector3d end = Eigen::Vector3d::Zero();
  double radius = 0;
};

// The first element after element i of a rod (from i + 1 on) that may touch it; the number of elements if
// none. kHertzSegments: what lies nearer along the rod than half a turn as tight as the rod is thick, pi/2 of
// the radii's sum, cannot touch from side to side.
Eigen::Index FirstThatMayTouch(const Rod& rod, Eigen::Index i, ContactLaw law);

// An element's radius as its stretch leaves it, at constant volume, m; kHertzSegments takes it at rest.
double PresentRadius(const Rod& rod, Eigen::Index element);

// The published laws; add to forces on nodes, N (3, N+1)
void AddRodContact(const Contact& contact, const Rod& a, const Rod& b, Eigen::Matrix3Xd& force_a,
                   Eigen::Matrix3Xd& force_b);

// Elements of one rod, from FirstThatMayTouch on.
void AddSelfContact(const Contact& contact, const Rod& rod, Eigen::Matrix3Xd& force);

void AddBodyContact(const Contact& contact, const Rod& rod, const FixedBody& body, Eigen::Matrix3Xd& force);

}  // namespace tendril
