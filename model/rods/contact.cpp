#include "model/rods/contact.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/geometry/segment_distance.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

// One side of a contact: a stretched element, or a body that does not move.
struct Side {
  Vector3d start, end;
  Vector3d start_velocity = Vector3d::Zero(), end_velocity = Vector3d::Zero();
  double radius = 0;
  double share = 0.5;  // of the end node, where the law shares by rule
};

Side SideOf(const Rod& rod, Index element) {
  Side side;
  side.start = rod.position.col(element);
  side.end = rod.position.col(element + 1);
  side.start_velocity = rod.velocity.col(element);
  side.end_velocity = rod.velocity.col(element + 1);
  side.radius = PresentRadius(rod, element);
  // A rod's end nodes have half the mass of the others.
  if (element == 0) side.share = 2.0 / 3;
  if (element == rod.elements() - 1) side.share = 1.0 / 3;
  return side;
}

struct Touch {
  bool touches = false;
  Vector3d force;       // on b; a takes the opposite
  double a_end, b_end;  // share of the end node
};

// The published laws.
Touch TouchOf(const Contact& contact, const Side& a, const Side& b) {
  Touch touch;
  const Vector3d centers = 0.5 * (b.start + b.end - a.start - a.end);
  const double reach = a.radius + b.radius;
  ClosestPoints closest{0.5, 0.5, centers};
  if (contact.law != ContactLaw::kHertzCenters) {
    const double farthest = reach + 0.5 * ((a.end - a.start).norm() + (b.end - b.start).norm());
    if (centers.squaredNorm() >= farthest * farthest) return touch;
    closest = ClosestOfSegments(a.start, a.end, b.start, b.end);
  }
  const double distance = closest.apart.norm();
  const double overlap = reach - distance;
  // Axes that cross leave no normal; what lets that happen is the watchdog's to report.
  if (!(overlap > 0) || distance == 0) return touch;
  touch.touches = true;
  touch.a_end = a.share;
  touch.b_end = b.share;
  const Vector3d normal = closest.apart / distance;
  const Vector3d approach = 0.5 * (a.start_velocity + a.end_velocity - b.start_velocity - b.end_velocity);
  touch.force =
      (contact.stiffness * overlap * std::sqrt(overlap) + contact.damping * approach.dot(normal)) * normal;
  return touch;
}

void Share(const Vector3d& force, double end, Index element, Matrix3Xd& forces) {
  forces.col(element) += (1 - end) * force;
  forces.col(element + 1) += end * force;
}

}  // namespace

double PresentRadius(const Rod& rod, Index element) {
  const double length = (rod.position.col(element + 1) - rod.position.col(element)).norm();
  return rod.radius[element] * std::sqrt(rod.rest_length[element] / length);
}

void AddRodContact(const Contact& contact, const Rod& a, const Rod& b, Matrix3Xd& force_a,
                   Matrix3Xd& force_b) {
  std::vector<Side> others;
  others.reserve(static_cast<std::size_t>(b.elements()));
  for (Index j = 0; j < b.elements(); ++j) others.push_back(SideOf(b, j));
  for (Index i = 0; i < a.elements(); ++i) {
    const Side side = SideOf(a, i);
    for (Index j = 0; j < b.elements(); ++j) {
      const Touch touch = TouchOf(contact, side, others[static_cast<std::size_t>(j)]);
      if (!touch.touches) continue;
      Share(-touch.force, touch.a_end, i, force_a);
      Share(touch.force, touch.b_end, j, force_b);
    }
  }
}

Index FirstThatMayTouch(const Rod& rod, Index i, ContactLaw law) {
  const double radii = law == ContactLaw::kHertzSegments ? 0.5 * std::numbers::pi : 1;
  double along = 0.5 * rod.rest_length[i];  // to the middle of element j
  for (Index j = i + 1; j < rod.elements(); ++j) {
    along += 0.5 * (rod.rest_length[j] + (j > i + 1 ? rod.rest_length[j - 1] : 0));
    const double near =
        radii * (rod.radius[i] + rod.radius[j]) + 0.5 * (rod.rest_length[i] + rod.rest_length[j]);
    if (along > near) return j;
  }
  return rod.elements();
}

void AddSelfContact(const Contact& contact, const Rod& rod, Matrix3Xd& force) {
  for (Index i = 0; i < rod.elements(); ++i) {
    const Side side = SideOf(rod, i);
    for (Index j = FirstThatMayTouch(rod, i, contact.law); j < rod.elements(); ++j) {
      const Touch touch = TouchOf(contact, side, SideOf(rod, j));
      if (!touch.touches) continue;
      Share(-touch.force, touch.a_end, i, force);
      Share(touch.force, touch.b_end, j, force);
    }
  }
}

void AddBodyContact(const Contact& contact, const Rod& rod, const FixedBody& body, Matrix3Xd& force) {
  Side fixed;
  fixed.start = body.start;
  fixed.end = body.end;
  fixed.radius = body.radius;
  for (Index i = 0; i < rod.elements(); ++i) {
    Side side = SideOf(rod, i);
    Touch touch;
    if (contact.law == ContactLaw::kHertzCenters) {
      // The element's centre against the body's axis.
      const Vector3d center = 0.5 * (side.start + side.end);
      Side point = side;
      point.start = point.end = center;
      Contact law = contact;
      law.law = ContactLaw::kHertzEqual;
      touch = TouchOf(law, point, fixed);
    } else {
      touch = TouchOf(contact, side, fixed);
    }
    if (touch.touches) Share(-touch.force, touch.a_end, i, force);
  }
}

}  // namespace tendril
