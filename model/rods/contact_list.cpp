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
                         const ContactPairs& pairs)
    : contact_(contact),
      pairs_(pairs),
      rods_(rods.size()),
      thinnest_(kNothing),
      least_distance_(kNothing),
      least_share_(kNothing),
      last_least_(kNothing) {
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
  for (std::vector<double>* all : {&nodes_, &velocities_, &staged_, &reference_, &forces_}) {
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
      strands_[r].may_touch.push_back(static_cast<int>(FirstThatMayTouch(rods[r], i)));
    }
  }
  for (std::size_t b = 0; b < bodies.size(); ++b) PlaceBody(bodies[b], strands_[rods_ + b]);
  boxes_.resize(strands_.size());
  partners_.resize(strands_.size());
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
  for (int i = 0; i <= n; ++i) At(kNodeShare)[strand.place + i] = i == 0 || i == n ? 1 : 0.5;
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
  At(kRestLength)[from] = At(kSpan)[from] = length;
  At(kInverseSquare)[from] = length > 0 ? 1 / (length * length) : 0;
  At(kBound)[from] = body.radius + 0.5 * length;
  At(kNodeShare)[from] = At(kNodeShare)[from + 1] = 1;
  At(kEndShare)[from] = 0.5;
}

void ContactList::Put(std::size_t rod, const double* positions, const double* velocities,
                      std::size_t stride) {
  const Strand& strand = strands_[rod];
  for (Eight& eight : eights_) {
    if (strand.lane >= eight.lane && strand.lane < eight.lane + kRodLanes) eight.staged = true;
  }
  std::size_t to = static_cast<std::size_t>(strand.lane);
  for (int i = 0; i < 3 * (strand.elements + 1); ++i, to += kRodLanes) {
    staged_[to] = positions[static_cast<std::size_t>(i) * stride];
    if (contact_.damping != 0) velocities_[to] = velocities[static_cast<std::size_t>(i) * stride];
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
  if (contact_.damping == 0) return;
  std::copy_n(velocities, kNode * (eight.elements + 1), velocities_.begin() + eight.lane);
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

bool ContactList::Find() {
  for (Eight& eight : eights_) {
    if (eight.staged) Follow(eight, staged_.data() + eight.lane);
    eight.staged = false;
  }
  // What is not a number is larger than nothing; the sum keeps it.
  double moved = std::isfinite(sum_of_squares_) ? std::sqrt(farthest_square_) : sum_of_squares_;
  if (!started_) moved = 0;
  longest_move_ = std::max(longest_move_, moved);
  // Elements that did not press were farther apart than their radii's sum, and so than the thinnest radius,
  // as long as none is stretched fourfold.
  if (2 * moved >= std::min(last_least_, thinnest_)) nothing_passed_ = false;
  farthest_square_ = sum_of_squares_ = 0;
  if (!std::isfinite(moved)) return false;
  ++steps_;
  if (left_ || forgotten_) ChoosePairs();
  started_ = true;
  contact_kernel::Touch touch{};
  touch.law = KernelsLaw();
  touch.stiffness = contact_.stiffness;
  touch.damping = contact_.damping;
  touch.rod_pairs = static_cast<int>(rod_pairs_);
  touch.pairs = static_cast<int>(one_.size());
  touch.one = one_.data();
  touch.other = other_.data();
  touch.constants = constants_.data();
  touch.at = nodes_.data();
  if (contact_.damping != 0) touch.velocity = velocities_.data();
  touch.force = forces_.data();
  touch.least_distance = touch.least_share = kNothing;
  const contact_kernel::Kernels kernels = contact_kernel::KernelsOfThisMachine();
  kernels.clear(forces_.data(), static_cast<int>(forces_.size()) / kRodLanes);
  kernels.touch(touch);
  last_least_ = touch.least_distance;
  least_distance_ = std::min(least_distance_, touch.least_distance);
  least_share_ = std::min(least_share_, touch.least_share);
  return true;
}

void ContactList::AddForces(std::size_t rod, double* forces, std::size_t stride) const {
  const Strand& strand = strands_[rod];
  std::size_t from = static_cast<std::size_t>(strand.lane);
  for (int i = 0; i < 3 * (strand.elements + 1); ++i, from += kRodLanes) {
    forces[static_cast<std::size_t>(i) * stride] += forces_[from];
  }
}

void ContactList::AddLaneForces(std::span<const std::size_t> rods, double* forces) const {
  const Eight& eight = EightOf(rods);
  contact_kernel::KernelsOfThisMachine().add(forces, forces_.data() + eight.lane, 3 * (eight.elements + 1));
}

Eigen::Vector3d ContactList::ForceOnBody(std::size_t body) const {
  const auto from = static_cast<std::size_t>(strands_[rods_ + body].lane);
  Eigen::Vector3d force;
  for (std::size_t k = 0; k < 3; ++k) {
    force[static_cast<Eigen::Index>(k)] =
        forces_[from + kRodLanes * k] + forces_[from + kNode + kRodLanes * k];
  }
  return force;
}

std::vector<double> ContactList::Save() const {
  std::vector<double> saved{least_distance_,
                            least_share_,
                            longest_move_,
                            last_least_,
                            static_cast<double>(lists_),
                            nothing_passed_ ? 1.0 : 0.0,
                            started_ ? 1.0 : 0.0};
  for (std::size_t r = 0; r < rods_; ++r) {
    for (int i = 0; i < 3 * (strands_[r].elements + 1); ++i) {
      const int at = strands_[r].lane + kRodLanes * i;
      saved.push_back(nodes_[static_cast<std::size_t>(at)]);
    }
  }
  return saved;
}

void ContactList::Restore(std::span<const double> saved) {
  TENDRIL_CHECK(saved.size() == Save().size());
  least_distance_ = saved[0];
  least_share_ = saved[1];
  longest_move_ = saved[2];
  last_least_ = saved[3];
  lists_ = static_cast<long>(saved[4]);
  nothing_passed_ = saved[5] != 0;
  started_ = saved[6] != 0;
  std::size_t from = 7;
  for (std::size_t r = 0; r < rods_; ++r) {
    for (int i = 0; i < 3 * (strands_[r].elements + 1); ++i) {
      const int at = strands_[r].lane + kRodLanes * i;
      nodes_[static_cast<std::size_t>(at)] = saved[from++];
    }
  }
  ForgetList();
}

}  // namespace tendril
