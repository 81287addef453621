#pragma once
// The forces of contact.h, fast, in three stages (docs/rods.md, "Contact, fast"):
//
//   neighbours  elements near each other, within a wide margin; remade rarely
//   pairs       neighbours that may press on each other before a node has gone as far as it is allowed to;
//   chosen
//               anew when one has, some tens of steps later
//   forces      of these pairs, eight at a time in vector registers, at every step
//
// Both lists hold more than what touches, never less, so forces do not depend on when they were made, but for
// rounding.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "model/rods/contact.h"
#include "model/rods/contact_kernel.h"
#include "model/rods/rod.h"

namespace tendril {

struct ContactPairs {
  bool rods = true;    // rod with rod
  bool selves = true;  // a rod with itself
  bool bodies = true;
};

class ContactList {
 public:
  ContactList(const Contact& contact, std::span<const Rod> rods, std::span<const FixedBody> bodies,
              const ContactPairs& pairs);

  // Nodes of a rod for the next Find: [node][component], `stride` numbers between neighbours, m and m/s.
  void Put(std::size_t rod, const double* positions, const double* velocities, std::size_t stride);
  // The same, faster, for rods side by side as in LaneRods: up to eight of equally many elements, gathered
  // in the rods' order; always by this or always by the above.
  void PutLanes(std::span<const std::size_t> rods, const double* positions, const double* velocities);
  // Forces of what was put.
  //   returns  false  a node is not finite: none were found
  bool Find();
  // Adds a rod's forces, N; laid out as above.
  void AddForces(std::size_t rod, double* forces, std::size_t stride) const;
  void AddLaneForces(std::span<const std::size_t> rods, double* forces) const;
  // Force on a body, N.
  Eigen::Vector3d ForceOnBody(std::size_t body) const;

  // The next Find makes both lists from nothing: what it and those after it find depends, to the bit, on
  // what is put from now on alone (not so the numbers below).
  void ForgetList() { forgotten_ = true; }
  // What a run goes on from after ForgetList, in numbers.
  std::vector<double> Save() const;
  void Restore(std::span<const double> saved);

  // Since the start: the least distance of what pressed (of axes, or of centres with kHertzCenters), m, and
  // as a share of their radii's sum (infinite: nothing touched); the farthest that a node went between two
  // Finds, m; how often the list of neighbours was made.
  double least_distance() const { return least_distance_; }
  double least_share() const { return least_share_; }
  double longest_move() const { return longest_move_; }
  long lists() const { return lists_; }
  // No axis passed through another: between two Finds nodes moved by less than half the least distance
  // that axes had around them. (Elements that are left out as neighbours along a rod are not looked at.)
  // Nothing is known with kHertzCenters: axes can cross between centres.
  std::optional<bool> NothingPassed() const {
    return contact_.law == ContactLaw::kHertzCenters ? std::nullopt : std::optional(nothing_passed_);
  }

 private:
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
    kNodeShare,
    kEndShare,
    kCenterX,
    kCenterY,
    kCenterZ,
    kInverseSquare,
    kDrift,
    kTurn,
    kSpan,
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
  void AddPairs(contact_kernel::Row& row, bool bodies);
  void MakeNeighbours();
  void FindPartners();
  void AddRuns(int element, int from, int to);

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
  std::vector<double> nodes_, velocities_, staged_, reference_, forces_;
  std::vector<double> allowed_, edge_allowed_;
  // Neighbours.
  std::vector<int> element_, first_, runs_;
  std::size_t rod_elements_ = 0;  // entries of element_ that are no bodies
  // Pairs, in whole eights (contact_kernel.h).
  std::vector<int> found_one_, found_other_, one_, other_;
  std::vector<double> constants_;
  std::size_t rod_pairs_ = 0;
  // While neighbours are sought: runs of eight elements from each eighth place on, and strands' boxes.
  struct Box {
    Eigen::Vector3d low, high;
  };
  std::vector<double> run_x_, run_y_, run_z_, run_reach_;
  std::vector<Box> boxes_;
  std::vector<std::size_t> order_;
  std::vector<std::vector<std::size_t>> partners_;

  double thinnest_ = 0;                              // radius of an element at rest, m
  double farthest_square_ = 0, sum_of_squares_ = 0;  // of what was put since the last Find
  bool left_ = false;                                // a node is farther off than allowed
  bool forgotten_ = true;
  int steps_ = 0;  // since pairs were chosen
  bool started_ = false;
  double least_distance_, least_share_, longest_move_ = 0, last_least_ = 0;
  long lists_ = 0;
  bool nothing_passed_ = true;
};

}  // namespace tendril
