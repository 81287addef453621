#pragma once
// The loads of contact_plain.h, fast, in four stages (docs/rods.md, "Contact, fast"):
//
//   neighbours  elements near each other, within a wide margin; remade rarely
//   pairs       neighbours that may press on each other before a node has gone as far as it is allowed to;
//   chosen
//               anew when one has, some tens of steps later
//   narrowed    pairs of which this holds for a few steps only
//   forces      of these, eight at a time in vector registers, at every step
//
// All lists hold more than what touches, never less, so forces do not depend on when they were made, but for
// rounding.

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "model/rods/contact.h"
#include "model/rods/contact_kernel.h"
#include "model/rods/contact_plain.h"
#include "model/rods/contact_slots.h"
#include "model/rods/rod.h"
#include "model/rods/roughness.h"
#include "model/rods/solid.h"

namespace tendril {

class ContactList {
 public:
  //   bodies  that do not move, of the published laws
  //   solids  of kHertzSegments, as they start; their shapes stay
  ContactList(const Contact& contact, std::span<const Rod> rods, std::span<const FixedBody> bodies,
              std::span<const Solid> solids, const ContactPairs& pairs);

  // Velocities and spins count: there is damping or friction.
  bool Moves() const { return contact_.damping != 0 || slides_; }

  // Nodes of a rod for the next Find: [node][component], `stride` numbers between neighbours, m and m/s;
  // spins of elements likewise, lab, rad/s (null: 0).
  void Put(std::size_t rod, const double* positions, const double* velocities, const double* spins,
           std::size_t stride);
  // The same, faster, for rods side by side as in LaneRods: up to eight of equally many elements, gathered
  // in the rods' order; always by this or always by the above.
  void PutLanes(std::span<const std::size_t> rods, const double* positions, const double* velocities);
  // Where their spins are to be written, [element][component][8]; where Moves().
  std::span<double> LaneSpins(std::span<const std::size_t> rods);
  // Where a solid is and how it moves.
  void PutSolid(std::size_t solid, const Eigen::Isometry3d& pose, const Eigen::Vector3d& velocity,
                const Eigen::Vector3d& spin);

  // Loads of what was put; springs of what sticks move on by a step.
  //   returns  false  a node is not finite: none were found
  bool Find(double time_step);
  // Adds a rod's forces, N, and couples, lab, N m; laid out as above.
  void AddForces(std::size_t rod, double* forces, std::size_t stride) const;
  void AddCouples(std::size_t rod, double* couples, std::size_t stride) const;
  // Side by side as PutLanes takes them: where each Find leaves its forces, and couples where Moves(), and
  // what may be added to in between.
  std::span<double> LaneForces(std::span<const std::size_t> rods);
  std::span<double> LaneCouples(std::span<const std::size_t> rods);
  Wrench OnSolid(std::size_t solid) const { return solids_[solid].wrench; }

  // The next Find makes both lists from nothing: what it and those after it find depends, to the bit, on
  // what is put from now on alone (not so the numbers below).
  void ForgetList() { forgotten_ = true; }
  // What a run goes on from after ForgetList, in numbers.
  std::vector<double> Save() const;
  //   returns  false  it is not of such a list; nothing has changed
  bool Restore(std::span<const double> saved);

  // Since the start: the least distance of axes of rods that pressed (with kHertzCenters, of centres), m, and
  // of all that pressed as a share of the radii's sum, a solid's surface standing for a rod alike (infinite:
  // nothing touched); the farthest that a node went between two Finds, m; how often the list of neighbours
  // was made.
  double least_distance() const { return least_distance_; }
  double least_share() const { return least_share_; }
  double longest_move() const { return longest_move_; }
  long lists() const { return lists_; }
  // The most that a spring of what sticks was drawn since the start, by the radii's sum.
  double longest_stick() const { return longest_stick_; }
  // No axis passed through another, nor through a solid's surface: from each choice of pairs to the next,
  // nodes went less far than axes were apart. (Elements that are left out as neighbours along a rod are not
  // looked at.) Nothing is known with kHertzCenters: axes can cross between centres.
  std::optional<bool> NothingPassed() const {
    return contact_.law == ContactLaw::kHertzCenters ? std::nullopt
                                                     : std::optional(nothing_passed_ && KeptApart());
  }

 private:
  // How far a node may go until pairs are chosen anew: as far as it would in so many steps like those since
  // they were last chosen, or a share of what the fastest may, so that choosing costs less than the steps
  // between; but, as a share of the thinnest radius, not so far that many pairs are looked at in vain. The
  // same for how much an edge may change, and for solids.
  static constexpr double kStepsAhead = 48, kSlowest = 0.25, kLeastAllowed = 1e-3, kMostAllowed = 0.06;
  // For how many steps pairs are narrowed.
  static constexpr double kStepsNarrowed = 4;
  // Pairs of which a larger share would be kept stay all.
  static constexpr double kHardlyNarrowed = 0.8;

  // A rod or body; in a row from `place` on, side by side with others from `lane` on (contact_kernel.h).
  struct Strand {
    int place = 0, elements = 0, lane = 0;
    std::vector<int> may_touch;  // FirstThatMayTouch
  };
  // Rods side by side, or bodies.
  struct Eight {
    std::vector<std::size_t> strands;
    int elements = 0, lane = 0;  // `lane` of the first
    bool staged = false;         // its rods were put one by one
  };
  // Arrays in a row.
  enum Row {
    kX,
    kY,
    kZ,
    kAllowed,
    kEdgeAllowed,
    kRestRadius,
    kRestLength,
    kEndShare,
    kCenterX,
    kCenterY,
    kCenterZ,
    kInverseSquare,
    kDrift,
    kFat,
    kBound,
    kOldX,
    kOldY,
    kOldZ,
    kOldReach,
    kRows
  };
  double* At(Row row) { return memory_.data() + static_cast<std::size_t>(row) * stride_; }
  const double* At(Row row) const { return memory_.data() + static_cast<std::size_t>(row) * stride_; }
  void PlaceStrand(int elements, bool body);
  void PlaceRod(const Rod& rod, const Strand& strand);
  void PlaceBody(const FixedBody& body, const Strand& strand);
  const Eight& EightOf(std::span<const std::size_t> rods) const;
  void Follow(const Eight& eight, const double* positions);
  contact_kernel::Law KernelsLaw() const;
  void Allow();
  void ChoosePairs();
  void LayInARow();
  void FindPairs(contact_kernel::Row& row, bool bodies, ContactSlots& slots);
  void NarrowPairs(double moved);
  void PutConstants(ContactSlots& slots) const;
  void PutPressConstants(ContactSlots& slots) const;
  void PlaceSolid(const Solid& solid);
  // Since pairs were chosen, nothing went as far as it was apart.
  bool KeptApart() const;
  void FollowSolids(double time_step);
  void ChooseOnSolids();
  void ChooseOnPart(std::size_t part);
  static contact_kernel::Sliding SlidingOn(const Roughness& roughness, double time_step);
  void PressRods(double time_step);
  void PressOnSolids(double time_step);
  void TouchAsPublished();
  void MakeNeighbours();
  void FindPartners();
  void FindRuns(const Eigen::Vector3d& center, double reach, const Strand& other);
  void AddRuns(int element, std::span<const int> runs, int from);

  Contact contact_;
  ContactPairs pairs_;
  std::size_t rods_ = 0;
  std::vector<Strand> strands_;  // rods, then bodies
  std::vector<Eight> eights_;    // of rods, then of bodies
  // In a row.
  std::size_t stride_ = 0;
  int rod_places_ = 0;
  std::vector<double> memory_;
  std::vector<int> lane_of_place_;
  // Side by side: [node][component][8]; squares of lengths [node or element][8].
  std::vector<double> nodes_, velocities_, spins_, staged_, reference_, forces_, couples_;
  std::vector<double> allowed_, edge_allowed_;
  // Neighbours.
  std::vector<int> element_, first_, runs_;
  std::size_t rod_elements_ = 0;  // entries of element_ that are no bodies
  // Pairs, in whole eights (contact_kernel.h).
  std::vector<int> found_one_, found_other_;
  ContactSlots rod_pairs_, body_pairs_, near_, old_;  // `near_` of the rods' are narrowed, and keep springs
  std::vector<int> narrowed_;                         // slots of rod_pairs_
  double slack_ = 0;                                  // by which others than near_ may still come nearer, m
  // Solids, and their parts in the order of solids.
  struct Placed {
    Solid solid;
    double reach = 0;                                               // of its surface from its origin, m
    Eigen::Isometry3d chosen_pose = Eigen::Isometry3d::Identity();  // when pairs were last chosen
    double allowed = 0;  // how far its surface may go from there, m
    double step = 0;     // by how much it moved just now, at most, m
    // Since pairs were chosen: how near its surface may have come to an axis, but for the last step; its
    // longest step.
    double gap = std::numeric_limits<double>::infinity(), longest_step = 0;
    Wrench wrench;
  };
  struct Part {
    std::size_t solid = 0;
    Primitive primitive;
    double reach = 0;  // from the primitive's centre
    ContactSlots slots;
  };
  std::vector<Placed> solids_;
  std::vector<Part> parts_;
  bool slides_ = false;  // there is friction
  // While neighbours are sought: runs of eight elements from each eighth place on, and strands' boxes.
  struct Box {
    Eigen::Vector3d low, high;
  };
  std::vector<double> run_x_, run_y_, run_z_, run_reach_;
  std::vector<int> near_runs_;
  std::vector<Box> boxes_;
  std::vector<std::size_t> order_;
  std::vector<std::vector<std::size_t>> partners_;

  double thinnest_ = 0;                              // radius of an element at rest, m
  double farthest_square_ = 0, sum_of_squares_ = 0;  // of what was put since the last Find
  bool left_ = false;                                // a node is farther off than allowed
  bool forgotten_ = true;
  int steps_ = 0;  // since pairs were chosen
  bool started_ = false;
  double least_distance_, least_share_, longest_move_ = 0, longest_stick_ = 0;
  // Since pairs were chosen: how near axes may have come, but for the step in which a node left what it was
  // allowed; the farthest that anything went in a step, m.
  double least_gap_, longest_since_ = 0;
  long lists_ = 0;
  bool nothing_passed_ = true;
};

}  // namespace tendril
