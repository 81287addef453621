// How a ContactList chooses what to look at: neighbours within a wide margin, and of these the pairs that may
// press on each other soon.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "model/rods/contact_list.h"
#include "model/rods/press.h"
#include "model/rods/rod_lanes.h"

namespace tendril {
namespace {

constexpr int kRun = 8;
constexpr int kNode = 3 * kRodLanes;  // numbers of a node of eight rods side by side
constexpr double kNothing = std::numeric_limits<double>::infinity();

// Beyond this an element's reach may grow until neighbours are sought anew, as a share of the thinnest
// radius.
constexpr double kMargin = 0.3;

}  // namespace

contact_kernel::Law ContactList::KernelsLaw() const {
  return contact_.law == ContactLaw::kHertzSegments ? contact_kernel::kSegments
         : contact_.law == ContactLaw::kHertzEqual  ? contact_kernel::kEqual
                                                    : contact_kernel::kCenters;
}

// Node's positions and what they are allowed, with padding.
void ContactList::LayInARow() {
  for (std::size_t r = 0; r < rods_; ++r) {
    const Strand& strand = strands_[r];
    const int last = strand.place + strand.elements;
    for (int k = 0; k < 3; ++k) {
      double* const x = At(static_cast<Row>(kX + k));
      const double* from = nodes_.data() + strand.lane + k * kRodLanes;
      for (int i = strand.place; i <= last; ++i, from += kNode) x[i] = *from;
      x[strand.place - 1] = x[strand.place];
      x[last + 1] = x[last];
    }
    const std::size_t lane = static_cast<std::size_t>(strand.lane);
    const std::size_t first = (lane - lane % kRodLanes) / 3 + lane % kRodLanes;
    const double *from = allowed_.data() + first, *edge_from = edge_allowed_.data() + first;
    double *const allowed = At(kAllowed), *const edge_allowed = At(kEdgeAllowed);
    for (int i = strand.place; i <= last; ++i, from += kRodLanes) allowed[i] = *from;
    for (int i = strand.place; i < last; ++i, edge_from += kRodLanes) edge_allowed[i] = *edge_from;
  }
}

// How far nodes may go, and edges change, from where they are now.
void ContactList::Allow() {
  const double most = kMostAllowed * thinnest_, least = kLeastAllowed * thinnest_;
  double farthest = 0, farthest_edge = 0;
  for (const Eight& eight : eights_) {
    if (eight.strands[0] >= rods_) continue;
    for (std::size_t rod = 0; rod < eight.strands.size(); ++rod) {
      double last[3] = {};
      for (int node = 0; node <= eight.elements; ++node) {
        const std::size_t at = static_cast<std::size_t>(eight.lane + kNode * node) + rod;
        const std::size_t to = static_cast<std::size_t>(eight.lane / 3 + kRodLanes * node) + rod;
        double square = 0, edge_square = 0;
        for (std::size_t k = 0; k < 3; ++k) {
          const double way = nodes_[at + kRodLanes * k] - reference_[at + kRodLanes * k];
          square += way * way;
          edge_square += (way - last[k]) * (way - last[k]);
          last[k] = way;
        }
        allowed_[to] = square;
        farthest = std::max(farthest, square);
        if (node == 0) continue;
        edge_allowed_[to - kRodLanes] = edge_square;
        farthest_edge = std::max(farthest_edge, edge_square);
      }
    }
  }
  std::copy(nodes_.begin(), nodes_.end(), reference_.begin());
  const double ahead = std::pow(kStepsAhead / std::max(steps_, 1), 2);
  const auto limit = [&](std::vector<double>& squares, double longest) {
    const double lowest = std::clamp(kSlowest * kSlowest * ahead * longest, least * least, most * most);
    for (double& square : squares) {
      // After ForgetList, nothing is known of steps.
      square = forgotten_ ? least * least : std::min(std::max(ahead * square, lowest), most * most);
    }
  };
  limit(allowed_, farthest);
  limit(edge_allowed_, farthest_edge);
  steps_ = 0;
}

void ContactList::ChoosePairs() {
  Allow();
  LayInARow();
  contact_kernel::Row row{};
  row.law = KernelsLaw();
  row.size = rod_places_;
  row.x = At(kX), row.y = At(kY), row.z = At(kZ);
  row.rest_radius = At(kRestRadius), row.rest_length = At(kRestLength), row.allowed = At(kAllowed);
  row.edge_allowed = At(kEdgeAllowed);
  row.old_x = At(kOldX), row.old_y = At(kOldY), row.old_z = At(kOldZ), row.old_reach = At(kOldReach);
  row.center_x = At(kCenterX), row.center_y = At(kCenterY), row.center_z = At(kCenterZ);
  row.inverse_square = At(kInverseSquare);
  row.drift = At(kDrift), row.fat = At(kFat), row.bound = At(kBound);
  contact_kernel::KernelsOfThisMachine().measure(row);
  if (forgotten_ || row.strayed > 0) MakeNeighbours();
  // What was chosen before has come as near as it was allowed, and a step nearer on either side.
  if (!KeptApart()) nothing_passed_ = false;
  longest_since_ = 0;
  row.least_gap = kNothing;
  row.element = element_.data(), row.first = first_.data(), row.runs = runs_.data();
  found_one_.resize(std::max(found_one_.size(), kRun * runs_.size()));
  found_other_.resize(found_one_.size());
  row.one = found_one_.data(), row.other = found_other_.data();
  row.to = static_cast<int>(rod_elements_);
  FindPairs(row, false, rod_pairs_);
  slack_ = 0;
  row.from = row.to, row.to = static_cast<int>(element_.size());
  FindPairs(row, true, body_pairs_);
  // What was not chosen is farther apart than the radii.
  least_gap_ = std::min(row.least_gap, thinnest_);
  ChooseOnSolids();
  forgotten_ = left_ = false;
}

// Filled up to a whole eight with copies of the last that have no radius.
void ContactList::FindPairs(contact_kernel::Row& row, bool bodies, ContactSlots& slots) {
  using namespace contact_kernel;
  row.pairs = 0;
  KernelsOfThisMachine().choose(row, bodies);
  slots.Clear();
  slots.found = row.pairs;
  const int filled = (row.pairs + kRun - 1) / kRun * kRun;
  for (int p = 0; p < filled; ++p) {
    const int from = std::min(p, row.pairs - 1), i = row.one[from], j = row.other[from];
    slots.one_place.push_back(i);
    slots.other_place.push_back(j);
    slots.one.push_back(lane_of_place_[static_cast<std::size_t>(i)]);
    slots.other.push_back(lane_of_place_[static_cast<std::size_t>(j)]);
  }
  contact_.law == ContactLaw::kHertzSegments ? PutPressConstants(slots) : PutConstants(slots);
}

namespace {

// Where the constants of a slot begin.
double* ConstantsOf(ContactSlots& slots, int count, std::size_t slot) {
  return slots.constants.data() + slot / kRun * (kRun * static_cast<std::size_t>(count)) + slot % kRun;
}

}  // namespace

// For some steps like the last, or where hardly any would be left out, until pairs are chosen anew. Pairs
// that are left out lose their springs, as what does not touch does.
void ContactList::NarrowPairs(double moved) {
  slack_ = std::clamp(2 * kStepsNarrowed * moved, kLeastAllowed * thinnest_, kMostAllowed * thinnest_);
  // As many as there may ever be of the pairs, so that nothing is allocated later.
  const std::size_t most = rod_pairs_.one.capacity();
  narrowed_.resize(most);
  contact_kernel::Narrow narrow{};
  narrow.points = contact_.points;
  narrow.margin = slack_;
  narrow.pairs = static_cast<int>(rod_pairs_.one.size());
  narrow.one = rod_pairs_.one.data();
  narrow.other = rod_pairs_.other.data();
  narrow.constants = rod_pairs_.constants.data();
  narrow.at = nodes_.data();
  narrow.slots = narrowed_.data();
  contact_kernel::KernelsOfThisMachine().narrow(narrow);
  if (narrow.found > kHardlyNarrowed * rod_pairs_.found) {
    narrow.found = rod_pairs_.found;
    std::iota(narrowed_.begin(), narrowed_.begin() + narrow.found, 0);
    slack_ = kNothing;
  }
  std::swap(old_, near_);
  near_.Reserve(most, contact_kernel::kPressConstants);
  near_.TakePairs(rod_pairs_, {narrowed_.data(), static_cast<std::size_t>(narrow.found)},
                  contact_kernel::kPressConstants);
  for (int p = narrow.found; p % kRun != 0; ++p) {
    ConstantsOf(near_, contact_kernel::kPressConstants,
                static_cast<std::size_t>(p))[kRun * contact_kernel::kRadii] =
        std::numeric_limits<double>::quiet_NaN();
  }
  if (Moves()) near_.TakeSprings(old_);
}

void ContactList::PutConstants(ContactSlots& slots) const {
  using namespace contact_kernel;
  const double *radius = At(kRestRadius), *length = At(kRestLength), *rule = At(kEndShare);
  slots.constants.resize(slots.one.size() * kConstants);
  for (std::size_t p = 0; p < slots.one.size(); ++p) {
    const int i = slots.one_place[p], j = slots.other_place[p];
    const bool filling = p >= static_cast<std::size_t>(slots.found);
    double* const constants = ConstantsOf(slots, kConstants, p);
    constants[kRun * kOneRadius] = radius[i];
    constants[kRun * kOneLength] = length[i];
    constants[kRun * kOneRule] = rule[i];
    constants[kRun * kOtherRadius] = filling ? std::numeric_limits<double>::quiet_NaN() : radius[j];
    constants[kRun * kOtherLength] = length[j];
    constants[kRun * kOtherRule] = rule[j];
  }
}

void ContactList::PutPressConstants(ContactSlots& slots) const {
  using namespace contact_kernel;
  const double *radius = At(kRestRadius), *length = At(kRestLength);
  slots.constants.resize(slots.one.size() * kPressConstants);
  for (std::size_t p = 0; p < slots.one.size(); ++p) {
    const int i = slots.one_place[p], j = slots.other_place[p];
    const bool filling = p >= static_cast<std::size_t>(slots.found);
    const double radii = radius[i] + radius[j];
    const double factor = PressFactor(contact_.stiffness, radii);
    double* const constants = ConstantsOf(slots, kPressConstants, p);
    constants[kRun * kRadii] = filling ? std::numeric_limits<double>::quiet_NaN() : radii;
    constants[kRun * kOneWeight] = factor * length[i] / contact_.points;
    constants[kRun * kOtherWeight] = factor * length[j] / contact_.points;
    constants[kRun * kOneArm] = radius[i] / radii;
    constants[kRun * kInverseReference] = 1 / ReferenceStiffness(contact_.stiffness, radii);
    constants[kRun * kStickStiffness] =
        contact_.tangential_ratio * StickStiffness(factor, radii, length[i] + length[j]);
  }
}

// Runs of a rod of which something may come to touch what lies within a ball; appended.
void ContactList::FindRuns(const Eigen::Vector3d& center, double reach, const Strand& other) {
  for (int j = other.place; j < other.place + other.elements; j += kRun) {
    const auto run = static_cast<std::size_t>(j / kRun);
    const double dx = run_x_[run] - center.x(), dy = run_y_[run] - center.y(), dz = run_z_[run] - center.z();
    const double together = reach + run_reach_[run];
    if (dx * dx + dy * dy + dz * dz < together * together) near_runs_.push_back(j);
  }
}

// Eight elements each of these runs, not before `from`, of which one at least may come to touch: they start
// where something is near, so that fewer reach what is not. (Padding is near nothing.)
void ContactList::AddRuns(int element, std::span<const int> runs, int from) {
  const double *x = At(kCenterX), *y = At(kCenterY), *z = At(kCenterZ), *others = At(kOldReach);
  const double cx = x[element], cy = y[element], cz = z[element], reach = others[element];
  for (const int start : runs) {
    const auto run = static_cast<std::size_t>(start / kRun);
    const double dx = run_x_[run] - cx, dy = run_y_[run] - cy, dz = run_z_[run] - cz;
    const double together = reach + run_reach_[run];
    if (!(dx * dx + dy * dy + dz * dz < together * together)) continue;
    for (int j = std::max(start, from); j < start + kRun; ++j) {
      const double ex = x[j] - cx, ey = y[j] - cy, ez = z[j] - cz, both = reach + others[j];
      if (!(ex * ex + ey * ey + ez * ez < both * both)) continue;
      runs_.push_back(j);
      from = j + kRun;
      break;
    }
  }
}

// Strands whose boxes meet, by the later of the two: in the order of their boxes' lower ends along x, of each
// only those are looked at that start before it ends.
void ContactList::FindPartners() {
  const auto meet = [](const Box& a, const Box& b) {
    return (a.low.array() <= b.high.array()).all() && (b.low.array() <= a.high.array()).all();
  };
  order_.resize(strands_.size());
  for (std::size_t r = 0; r < order_.size(); ++r) order_[r] = r;
  std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
    return boxes_[a].low.x() != boxes_[b].low.x() ? boxes_[a].low.x() < boxes_[b].low.x() : a < b;
  });
  for (std::vector<std::size_t>& partners : partners_) partners.clear();
  for (std::size_t m = 0; m < order_.size(); ++m) {
    for (std::size_t k = m + 1; k < order_.size() && boxes_[order_[k]].low.x() <= boxes_[order_[m]].high.x();
         ++k) {
      const std::size_t a = std::max(order_[m], order_[k]), b = std::min(order_[m], order_[k]);
      const bool body = a >= rods_;
      if (b >= rods_ || (body ? !pairs_.bodies : !pairs_.rods) || !meet(boxes_[a], boxes_[b])) continue;
      partners_[a].push_back(b);
    }
  }
  for (std::vector<std::size_t>& partners : partners_) std::sort(partners.begin(), partners.end());
}

void ContactList::MakeNeighbours() {
  ++lists_;
  const std::size_t runs = static_cast<std::size_t>(rod_places_) / kRun;
  run_x_.assign(runs, 0.0);
  run_y_.assign(runs, 0.0);
  run_z_.assign(runs, 0.0);
  run_reach_.assign(runs, -kNothing);
  const double *x = At(kCenterX), *y = At(kCenterY), *z = At(kCenterZ);
  std::copy_n(x, 3 * stride_, At(kOldX));
  double* const reach = At(kOldReach);
  for (std::size_t i = 0; i < stride_; ++i) reach[i] = At(kBound)[i] + kMargin * thinnest_;
  for (std::size_t r = 0; r < strands_.size(); ++r) {
    const Strand& strand = strands_[r];
    const int end = strand.place + strand.elements;
    Box& box = boxes_[r];
    box.low.setConstant(kNothing);
    box.high.setConstant(-kNothing);
    for (int i = strand.place; i < end; ++i) {
      const Eigen::Vector3d center(x[i], y[i], z[i]);
      box.low = box.low.cwiseMin((center.array() - reach[i]).matrix());
      box.high = box.high.cwiseMax((center.array() + reach[i]).matrix());
    }
    if (r >= rods_) continue;
    for (int i = strand.place; i < end; i += kRun) {
      const auto run = static_cast<std::size_t>(i / kRun);
      const int last = std::min(i + kRun, end), middle = (i + last) / 2;
      run_x_[run] = x[middle];
      run_y_[run] = y[middle];
      run_z_[run] = z[middle];
      for (int j = i; j < last; ++j) {
        const double dx = x[j] - x[middle], dy = y[j] - y[middle], dz = z[j] - z[middle];
        run_reach_[run] = std::max(run_reach_[run], std::sqrt(dx * dx + dy * dy + dz * dz) + reach[j]);
      }
    }
  }
  FindPartners();
  element_.clear();
  first_.clear();
  runs_.clear();
  for (std::size_t a = 0; a < strands_.size(); ++a) {
    const Strand& strand = strands_[a];
    if (a == rods_) rod_elements_ = element_.size();
    const bool self = a < rods_ && pairs_.selves;
    for (int first = 0; first < strand.elements; first += kRun) {
      const int end = std::min(first + kRun, strand.elements);
      const int middle = strand.place + (first + end) / 2;
      const Eigen::Vector3d center(x[middle], y[middle], z[middle]);
      double ball = 0;
      for (int i = strand.place + first; i < strand.place + end; ++i) {
        ball = std::max(ball, (Eigen::Vector3d(x[i], y[i], z[i]) - center).norm() + reach[i]);
      }
      near_runs_.clear();
      for (const std::size_t b : partners_[a]) FindRuns(center, ball, strands_[b]);
      const std::size_t others = near_runs_.size();
      if (self) FindRuns(center, ball, strand);
      const std::span<const int> all(near_runs_);
      for (int i = first; i < end && !all.empty(); ++i) {
        const std::size_t before = runs_.size();
        AddRuns(strand.place + i, all.first(others), 0);
        if (self) {
          AddRuns(strand.place + i, all.subspan(others),
                  strand.place + strand.may_touch[static_cast<std::size_t>(i)]);
        }
        if (runs_.size() == before) continue;
        element_.push_back(strand.place + i);
        first_.push_back(static_cast<int>(before));
      }
    }
  }
  if (strands_.size() == rods_) rod_elements_ = element_.size();
  first_.push_back(static_cast<int>(runs_.size()));
}

}  // namespace tendril
