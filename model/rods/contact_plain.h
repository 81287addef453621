#pragma once
// Contact of all that touches, with friction, in the plain form: the oracle of contact_list.h.

#include <Eigen/Core>
#include <map>
#include <span>
#include <tuple>

#include "model/rods/contact.h"
#include "model/rods/friction.h"
#include "model/rods/rod.h"
#include "model/rods/solid.h"

namespace tendril {

struct ContactPairs {
  bool rods = true;    // rod with rod
  bool selves = true;  // a rod with itself
  bool bodies = true;  // rods with objects
};

// What contact does to a rod.
struct RodLoads {
  Eigen::Matrix3Xd force;   // on nodes, N                    (3, N+1)
  Eigen::Matrix3Xd couple;  // on elements, lab, N m          (3, N)
};

class PlainContact {
 public:
  PlainContact(const Contact& contact, const ContactPairs& pairs) : contact_(contact), pairs_(pairs) {}

  // Loads of the present state, added to what is there; springs of what sticks move on by a step.
  //   loads, wrenches  one for each rod and solid
  void Add(std::span<const Rod> rods, std::span<const Solid> solids, double time_step,
           std::span<RodLoads> loads, std::span<Wrench> wrenches);

  // What the springs of what sticks store, J.
  double StoredBySprings() const;

 private:
  struct Spring {
    Stick stick;
    double stiffness = 0;
    bool touched = false;
  };
  // Of the one element: rod and number; of the other: rod, or the solid behind the rods, and element or part.
  using Key = std::tuple<std::size_t, Eigen::Index, std::size_t, Eigen::Index>;

  void AddPair(std::span<const Rod> rods, const Key& key, double time_step, std::span<RodLoads> loads);
  void AddSolid(std::span<const Rod> rods, std::span<const Solid> solids, const Key& key, double time_step,
                std::span<RodLoads> loads, std::span<Wrench> wrenches);

  Contact contact_;
  ContactPairs pairs_;
  std::map<Key, Spring> springs_;
};

}  // namespace tendril
