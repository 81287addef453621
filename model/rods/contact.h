#pragma once
// Forces between rods that touch, and between a rod and a fixed body, in the plain form: every element
// against every other.

#include <Eigen/Core>

#include "model/rods/rod.h"

namespace tendril {

enum class ContactLaw {
  // Between the closest points of two elements, shared by where on the element they lie. Where a closest
  // point
  // is a node and the neighbouring element goes on toward the other, the contact is the neighbour's alone;
  // where
  // it does not, each element has its share, so that one contact counts once. Elements side by side, parallel
  // within 1e-7 rad, count by how much of their length does lie side by side.
  kHertzSegments,
  kHertzEqual,  // the closest points of every pair, half on either node (an end element: a third on the rod's
                // end)
  kHertzCenters,  // between the elements' centres, as the paper says
};

// |F| = stiffness eps^(3/2) + damping * (speed of approach) along the normal, where eps = the radii's sum
// minus the distance is above 0. kHertzSegments never pulls; in the two others, which are as published,
// damping may, while bodies part.
struct Contact {
  ContactLaw law = ContactLaw::kHertzSegments;
  double stiffness = 1e4;  // N/m^(3/2)
  double damping = 0;      // N s/m
};

// All that is nearer to the segment than the radius: a capsule, or a sphere where the ends are one.
struct FixedBody {
  Eigen::Vector3d start = Eigen::Vector3d::Zero();  // m
  Eigen::Vector3d end = Eigen::Vector3d::Zero();
  double radius = 0;
};

// The first element after element i of a rod (from i + 1 on) that may touch it; the number of elements if
// none.
Eigen::Index FirstThatMayTouch(const Rod& rod, Eigen::Index i);

// An element's radius as its stretch leaves it, at constant volume, m.
double PresentRadius(const Rod& rod, Eigen::Index element);

// Add to forces on nodes, N                                                               (3, N+1)
void AddRodContact(const Contact& contact, const Rod& a, const Rod& b, Eigen::Matrix3Xd& force_a,
                   Eigen::Matrix3Xd& force_b);

// Elements of one rod; those whose centres lie, along the rod, nearer than the sum of their radii and half
// lengths always overlap and are left out.
void AddSelfContact(const Contact& contact, const Rod& rod, Eigen::Matrix3Xd& force);

void AddBodyContact(const Contact& contact, const Rod& rod, const FixedBody& body, Eigen::Matrix3Xd& force);

}  // namespace tendril
