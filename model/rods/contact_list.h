#pragma once
// The forces of contact.h, fast: elements near each other are kept in a list that is made anew only when
// something has moved by half a margin, and an element meets eight others at a time in vector registers
// (docs/rods.md, "Contact, fast").

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "model/rods/contact.h"
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
  // Forces of what was put.
  //   returns  false  a node is not finite or moved by more than the margin in one go: none were found
  bool Find();
  // The next Find makes its list anew: what it finds depends on what was put, not on what was before.
  void ForgetList() { slack_ = -1; }
  // What a run goes on from after ForgetList, in numbers.
  std::vector<double> Save() const;
  void Restore(std::span<const double> saved);
  // Adds a rod's forces, N; laid out as above.
  void AddForces(std::size_t rod, double* forces, std::size_t stride) const;
  // Force on a body, N.
  Eigen::Vector3d ForceOnBody(std::size_t body) const;

  // Since the start: the least distance of what touched (of axes, or of centres with kHertzCenters), m, and
  // as a share of their radii's sum (infinite: nothing touched); the farthest that a node went between two
  // Finds, m; how often the list was made.
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
  struct Strand {
    int place = 0, elements = 0;
    std::vector<int> may_touch;  // FirstThatMayTouch
  };
  enum Row {
    kX,
    kY,
    kZ,
    kVx,
    kVy,
    kVz,
    kOldX,
    kOldY,
    kOldZ,
    kRestRadius,
    kRestLength,
    kNodeShare,
    kEndShare,
    kRadius,
    kBound,
    kCenterX,
    kCenterY,
    kCenterZ,
    kFx,
    kFy,
    kFz,
    kEndFx,
    kEndFy,
    kEndFz,
    kInverseSquare,
    kRows
  };
  double* At(Row row) { return memory_.data() + static_cast<std::size_t>(row) * stride_; }
  const double* At(Row row) const { return memory_.data() + static_cast<std::size_t>(row) * stride_; }
  int PlaceStrand(int elements);
  void MakeList();
  void AddRuns(int element, int from, int to);

  Contact contact_;
  ContactPairs pairs_;
  std::size_t rods_ = 0;
  std::vector<Strand> strands_;  // rods, then bodies
  std::size_t stride_ = 0;
  int rod_places_ = 0;
  std::vector<double> memory_;
  std::vector<int> element_, first_, runs_;
  std::vector<unsigned char> is_body_;
  std::vector<double> run_x_, run_y_, run_z_, run_bound_;  // of eight elements from each eighth place on
  double margin_ = 0, slack_ = 0;
  bool started_ = false;
  double least_distance_, least_share_, longest_move_ = 0, last_least_ = 0;
  long lists_ = 0;
  bool nothing_passed_ = true;
};

}  // namespace tendril
