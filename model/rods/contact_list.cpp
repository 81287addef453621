#include "model/rods/contact_list.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/check.h"
#include "model/machine.h"
#include "model/rods/contact_kernel.h"
#include "model/rods/rod_lanes.h"

namespace tendril {
namespace contact_kernel {

Kernels KernelsOfThisMachine() {
#ifdef TENDRIL_ROD_X86
  if (RodKernelWidth() == 8) return Avx512Kernels();
  if (RodKernelWidth() == 4) return Avx2Kernels();
#endif
  return BaseKernels();
}

}  // namespace contact_kernel

namespace {

constexpr int kRun = 8;
constexpr int kNode = 3 * kRodLanes;  // numbers of a node of eight rods side by side
constexpr double kNothing = std::numeric_limits<double>::infinity();

}  // namespace

ContactList::ContactList(const Contact& contact, std::span<const Rod> rods, std::span<const FixedBody> bodies,
                         std::span<const Solid> solids, const ContactPairs& pairs)
    : contact_(contact),
      pairs_(pairs),
      rods_(rods.size()),
      thinnest_(kNothing),
      least_distance_(kNothing),
      least_share_(kNothing),
      least_gap_(kNothing) {
  slides_ = contact.law == ContactLaw::kHertzSegments && RoughnessOf(contact).at_rest > 0;
  for (const Rod& rod : rods) {
    PlaceStrand(static_cast<int>(rod.elements()), false);
    thinnest_ = std::min(thinnest_, rod.radius.minCoeff());
  }
  rod_places_ = static_cast<int>(stride_);
  for (std::size_t b = 0; b < bodies.size(); ++b) PlaceStrand(1, true);
  stride_ += 2 * kRun;
  int lanes = 0;
  for (Eight& eight : eights_) {
    eight.lane = lanes + kNode;  // behind a node of padding
    lanes += kNode * (eight.elements + 3);
    for (std::size_t k = 0; k < eight.strands.size(); ++k) {
      strands_[eight.strands[k]].lane = eight.lane + static_cast<int>(k);
    }
  }
  for (std::vector<double>* all :
       {&nodes_, &velocities_, &spins_, &staged_, &reference_, &forces_, &couples_}) {
    all->assign(static_cast<std::size_t>(lanes), 0.0);
  }
  for (std::vector<double>* all : {&allowed_, &edge_allowed_})
    all->assign(static_cast<std::size_t>(lanes / 3), 0.0);
  memory_.assign(static_cast<std::size_t>(kRows) * stride_, 0.0);
  for (const Row row : {kRestRadius, kFat, kBound}) {
    std::fill_n(At(row), stride_, std::numeric_limits<double>::quiet_NaN());
  }
  lane_of_place_.assign(stride_, 0);
  for (const Strand& strand : strands_) {
    for (int i = 0; i < strand.elements; ++i) {
      lane_of_place_[static_cast<std::size_t>(strand.place) + static_cast<std::size_t>(i)] =
          strand.lane + kNode * i;
    }
  }
  for (std::size_t r = 0; r < rods.size(); ++r) {
    PlaceRod(rods[r], strands_[r]);
    for (Eigen::Index i = 0; pairs.selves && i < rods[r].elements(); ++i) {
      strands_[r].may_touch.push_back(static_cast<int>(FirstThatMayTouch(rods[r], i, contact.law)));
    }
  }
  for (std::size_t b = 0; b < bodies.size(); ++b) PlaceBody(bodies[b], strands_[rods_ + b]);
  for (const Solid& solid : solids) PlaceSolid(solid);
  boxes_.resize(strands_.size());
  partners_.resize(strands_.size());
  near_runs_.reserve(stride_ / kRun);
  for (std::vector<std::size_t>& partners : partners_) partners.reserve(strands_.size());
}

// In a row: a node of padding before the strand, and as many behind as a run of eight may reach past its end;
// strands start at an eighth place.
void ContactList::PlaceStrand(int elements, bool body) {
  const int place = static_cast<int>(stride_) + kRun;
  const int behind = (elements + 2 + kRun) / kRun * kRun + kRun, end = place + behind;
  stride_ = static_cast<std::size_t>(end);
  const std::size_t first_of_bodies = body ? rods_ : 0;
  auto eight = std::find_if(eights_.begin(), eights_.end(), [&](const Eight& e) {
    return e.elements == elements && e.strands.size() < kRodLanes && e.strands[0] >= first_of_bodies;
  });
  if (eight == eights_.end()) eight = eights_.insert(eight, Eight{{}, elements});
  eight->strands.push_back(strands_.size());
  strands_.push_back({place, elements, 0, {}});
}

void ContactList::PlaceRod(const Rod& rod, const Strand& strand) {
  const int n = strand.elements;
  for (int i = 0; i < n; ++i) {
    At(kRestRadius)[strand.place + i] = rod.radius[i];
    At(kRestLength)[strand.place + i] = rod.rest_length[i];
    At(kEndShare)[strand.place + i] = i == 0 ? 2.0 / 3 : i == n - 1 ? 1.0 / 3 : 0.5;
  }
}

// A body drifts by nothing, so what rods have measured anew stays as it is here.
void ContactList::PlaceBody(const FixedBody& body, const Strand& strand) {
  const int from = strand.place;
  for (int k = 0; k < 3; ++k) {
    double* const x = At(static_cast<Row>(kX + k)) + from;
    x[-1] = x[0] = body.start[k];
    x[1] = x[2] = body.end[k];
    At(static_cast<Row>(kCenterX + k))[from] = 0.5 * (body.start[k] + body.end[k]);
    for (int node = -1; node <= 2; ++node) {
      const int at = strand.lane + kNode * node + kRodLanes * k;
      nodes_[static_cast<std::size_t>(at)] = x[node];
    }
  }
  const double length = (body.end - body.start).norm();
  At(kRestRadius)[from] = At(kFat)[from] = body.radius;
  At(kRestLength)[from] = length;
  At(kInverseSquare)[from] = length > 0 ? 1 / (length * length) : 0;
  At(kBound)[from] = body.radius + 0.5 * length;
  At(kEndShare)[from] = 0.5;
}

void ContactList::Put(std::size_t rod, const double* positions, const double* velocities, const double* spins,
                      std::size_t stride) {
  const Strand& strand = strands_[rod];
  for (Eight& eight : eights_) {
    if (strand.lane >= eight.lane && strand.lane < eight.lane + kRodLanes) eight.staged = true;
  }
  std::size_t to = static_cast<std::size_t>(strand.lane);
  for (int i = 0; i < 3 * (strand.elements + 1); ++i, to += kRodLanes) {
    staged_[to] = positions[static_cast<std::size_t>(i) * stride];
    if (Moves()) velocities_[to] = velocities[static_cast<std::size_t>(i) * stride];
    if (Moves() && i < 3 * strand.elements) {
      spins_[to] = spins == nullptr ? 0 : spins[static_cast<std::size_t>(i) * stride];
    }
  }
}

const ContactList::Eight& ContactList::EightOf(std::span<const std::size_t> rods) const {
  const auto eight = std::find_if(eights_.begin(), eights_.end(), [&](const Eight& e) {
    return std::equal(rods.begin(), rods.end(), e.strands.begin(), e.strands.end());
  });
  TENDRIL_CHECK(eight != eights_.end());
  return *eight;
}

void ContactList::PutLanes(std::span<const std::size_t> rods, const double* positions,
                           const double* velocities) {
  const Eight& eight = EightOf(rods);
  Follow(eight, positions);
  if (!Moves()) return;
  std::copy_n(velocities, kNode * (eight.elements + 1), velocities_.begin() + eight.lane);
}

std::span<double> ContactList::LaneSpins(std::span<const std::size_t> rods) {
  const Eight& eight = EightOf(rods);
  return {spins_.data() + eight.lane, static_cast<std::size_t>(kNode * eight.elements)};
}

void ContactList::Follow(const Eight& eight, const double* positions) {
  contact_kernel::Move move{};
  move.nodes = eight.elements + 1;
  move.rods = static_cast<int>(eight.strands.size());
  move.from = positions;
  move.at = nodes_.data() + eight.lane;
  move.reference = reference_.data() + eight.lane;
  move.allowed = allowed_.data() + eight.lane / 3;
  move.edge_allowed = edge_allowed_.data() + eight.lane / 3;
  move.farthest = farthest_square_;
  move.sum = sum_of_squares_;
  move.left = left_;
  contact_kernel::KernelsOfThisMachine().move(move);
  farthest_square_ = move.farthest;
  sum_of_squares_ = move.sum;
  left_ = move.left;
}

bool ContactList::Find(double time_step) {
  for (Eight& eight : eights_) {
    if (eight.staged) Follow(eight, staged_.data() + eight.lane);
    eight.staged = false;
  }
  // What is not a number is larger than nothing; the sum keeps it.
  double moved = std::isfinite(sum_of_squares_) ? std::sqrt(farthest_square_) : sum_of_squares_;
  if (!started_) moved = 0;
  longest_move_ = std::max(longest_move_, moved);
  longest_since_ = std::max(longest_since_, moved);
  farthest_square_ = sum_of_squares_ = 0;
  if (!std::isfinite(moved)) return false;
  ++steps_;
  FollowSolids(time_step);
  slack_ -= 2 * moved;
  if (left_ || forgotten_) ChoosePairs();
  if (contact_.law == ContactLaw::kHertzSegments && !(slack_ > 0)) NarrowPairs(moved);
  started_ = true;
  const contact_kernel::Kernels kernels = contact_kernel::KernelsOfThisMachine();
  kernels.clear(forces_.data(), static_cast<int>(forces_.size()) / kRodLanes);
  if (Moves()) kernels.clear(couples_.data(), static_cast<int>(couples_.size()) / kRodLanes);
  if (contact_.law == ContactLaw::kHertzSegments) {
    PressRods(time_step);
    PressOnSolids(time_step);
  } else {
    TouchAsPublished();
  }
  return true;
}

void ContactList::TouchAsPublished() {
  for (ContactSlots* slots : {&rod_pairs_, &body_pairs_}) {
    contact_kernel::Touch touch{};
    touch.law = KernelsLaw();
    touch.stiffness = contact_.stiffness;
    touch.damping = contact_.damping;
    touch.bodies = slots == &body_pairs_;
    touch.pairs = static_cast<int>(slots->one.size());
    touch.one = slots->one.data();
    touch.other = slots->other.data();
    touch.constants = slots->constants.data();
    touch.at = nodes_.data();
    if (Moves()) touch.velocity = velocities_.data();
    touch.force = forces_.data();
    touch.least_distance = least_distance_;
    touch.least_share = least_share_;
    contact_kernel::KernelsOfThisMachine().touch(touch);
    least_distance_ = touch.least_distance;
    least_share_ = touch.least_share;
  }
}

void ContactList::PressRods(double time_step) {
  contact_kernel::Press press{};
  press.damping = contact_.damping;
  press.points = contact_.points;
  press.sliding = SlidingOn(RoughnessOf(contact_), time_step);
  press.pairs = static_cast<int>(near_.one.size());
  press.one = near_.one.data();
  press.other = near_.other.data();
  press.constants = near_.constants.data();
  press.springs = near_.springs.data();
  press.at = nodes_.data();
  if (Moves()) press.velocity = velocities_.data(), press.spin = spins_.data();
  press.force = forces_.data();
  press.couple = couples_.data();
  press.least_square = least_distance_ * least_distance_;
  press.least_share_square = least_share_ * least_share_;
  press.longest_stick_square = longest_stick_ * longest_stick_;
  contact_kernel::KernelsOfThisMachine().press(press);
  longest_stick_ = std::sqrt(press.longest_stick_square);
  least_distance_ = std::sqrt(press.least_square);
  least_share_ = std::sqrt(press.least_share_square);
}

void ContactList::AddForces(std::size_t rod, double* forces, std::size_t stride) const {
  const Strand& strand = strands_[rod];
  std::size_t from = static_cast<std::size_t>(strand.lane);
  for (int i = 0; i < 3 * (strand.elements + 1); ++i, from += kRodLanes) {
    forces[static_cast<std::size_t>(i) * stride] += forces_[from];
  }
}

std::span<double> ContactList::LaneForces(std::span<const std::size_t> rods) {
  const Eight& eight = EightOf(rods);
  return {forces_.data() + eight.lane, static_cast<std::size_t>(kNode * (eight.elements + 1))};
}

std::span<double> ContactList::LaneCouples(std::span<const std::size_t> rods) {
  const Eight& eight = EightOf(rods);
  return {couples_.data() + eight.lane, static_cast<std::size_t>(kNode * eight.elements)};
}

void ContactList::AddCouples(std::size_t rod, double* couples, std::size_t stride) const {
  const Strand& strand = strands_[rod];
  std::size_t from = static_cast<std::size_t>(strand.lane);
  for (int i = 0; i < 3 * strand.elements; ++i, from += kRodLanes) {
    couples[static_cast<std::size_t>(i) * stride] += couples_[from];
  }
}

std::vector<double> ContactList::Save() const {
  std::vector<double> saved{least_distance_,
                            least_share_,
                            longest_move_,
                            least_gap_,
                            longest_since_,
                            static_cast<double>(lists_),
                            nothing_passed_ ? 1.0 : 0.0,
                            started_ ? 1.0 : 0.0,
                            longest_stick_};
  for (std::size_t r = 0; r < rods_; ++r) {
    for (int i = 0; i < 3 * (strands_[r].elements + 1); ++i) {
      const int at = strands_[r].lane + kRodLanes * i;
      saved.push_back(nodes_[static_cast<std::size_t>(at)]);
    }
  }
  for (const Placed& placed : solids_) saved.insert(saved.end(), {placed.gap, placed.longest_step});
  near_.SaveSprings(saved);
  for (const Part& part : parts_) part.slots.SaveSprings(saved);
  return saved;
}

bool ContactList::Restore(std::span<const double> saved) {
  // Springs' numbers come and go: their lists are looked through before anything changes.
  std::size_t from = 9;
  for (std::size_t r = 0; r < rods_; ++r) from += 3 * (static_cast<std::size_t>(strands_[r].elements) + 1);
  from += 2 * solids_.size();
  const std::size_t springs = from;
  for (std::size_t list = 0; list <= parts_.size(); ++list) {
    if (from >= saved.size() || !(saved[from] >= 0 && saved[from] < 1e9)) return false;
    from += 1 + static_cast<std::size_t>(saved[from]) * (2 + contact_kernel::kSpring);
  }
  if (from != saved.size()) return false;
  least_distance_ = saved[0];
  least_share_ = saved[1];
  longest_move_ = saved[2];
  least_gap_ = saved[3];
  longest_since_ = saved[4];
  lists_ = static_cast<long>(saved[5]);
  nothing_passed_ = saved[6] != 0;
  started_ = saved[7] != 0;
  longest_stick_ = saved[8];
  from = 9;
  for (std::size_t r = 0; r < rods_; ++r) {
    for (int i = 0; i < 3 * (strands_[r].elements + 1); ++i) {
      const int at = strands_[r].lane + kRodLanes * i;
      nodes_[static_cast<std::size_t>(at)] = saved[from++];
    }
  }
  for (Placed& placed : solids_) {
    placed.gap = saved[from++];
    placed.longest_step = saved[from++];
  }
  TENDRIL_CHECK(from == springs);
  from += near_.RestoreSprings(saved.data() + from);
  for (Part& part : parts_) from += part.slots.RestoreSprings(saved.data() + from);
  ForgetList();
  return true;
}

}  // namespace tendril
