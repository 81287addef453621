#include "model/rods/contact_list.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/check.h"
#include "model/machine.h"
#include "model/rods/contact_kernel.h"
#include "model/rods/rod_lanes.h"

namespace tendril {
namespace {

constexpr int kRun = 8;
constexpr double kNothing = std::numeric_limits<double>::infinity();

contact_kernel::Kernels KernelsOfThisMachine() {
#ifdef TENDRIL_ROD_X86
  if (RodKernelWidth() == 8) return contact_kernel::Avx512Kernels();
  if (RodKernelWidth() == 4) return contact_kernel::Avx2Kernels();
#endif
  return contact_kernel::BaseKernels();
}

}  // namespace

// A node of padding before the strand, and as many behind as a run of eight may reach past its end; strands
// start at an eighth place.
int ContactList::PlaceStrand(int elements) {
  const int place = static_cast<int>(stride_) + kRun;
  const int end = place + (elements + 2 + kRun) / kRun * kRun + kRun;
  stride_ = static_cast<std::size_t>(end);
  return place;
}

ContactList::ContactList(const Contact& contact, std::span<const Rod> rods, std::span<const FixedBody> bodies,
                         const ContactPairs& pairs)
    : contact_(contact),
      pairs_(pairs),
      rods_(rods.size()),
      least_distance_(kNothing),
      least_share_(kNothing),
      last_least_(kNothing) {
  double thinnest = kNothing;
  for (const Rod& rod : rods) {
    Strand strand;
    strand.elements = static_cast<int>(rod.elements());
    strand.place = PlaceStrand(strand.elements);
    for (Eigen::Index i = 0; pairs.selves && i < rod.elements(); ++i) {
      strand.may_touch.push_back(static_cast<int>(FirstThatMayTouch(rod, i)));
    }
    thinnest = std::min(thinnest, rod.radius.minCoeff());
    strands_.push_back(std::move(strand));
  }
  rod_places_ = static_cast<int>(stride_);
  for (std::size_t b = 0; b < bodies.size(); ++b) strands_.push_back({PlaceStrand(1), 1, {}});
  stride_ += 2 * kRun;
  // Small enough that few elements are in the list in vain, large enough that it lasts for many steps.
  margin_ = 0.12 * thinnest;
  memory_.assign(static_cast<std::size_t>(kRows) * stride_, 0.0);
  for (const Row row : {kRadius, kBound, kRestRadius}) {
    std::fill_n(At(row), stride_, std::numeric_limits<double>::quiet_NaN());
  }
  for (std::size_t r = 0; r < rods.size(); ++r) {
    const Rod& rod = rods[r];
    const int from = strands_[r].place, n = strands_[r].elements;
    for (int i = 0; i < n; ++i) {
      At(kRestRadius)[from + i] = rod.radius[i];
      At(kRestLength)[from + i] = rod.rest_length[i];
      At(kEndShare)[from + i] = i == 0 ? 2.0 / 3 : i == n - 1 ? 1.0 / 3 : 0.5;
    }
    for (int i = 0; i <= n; ++i) At(kNodeShare)[from + i] = i == 0 || i == n ? 1 : 0.5;
  }
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const FixedBody& body = bodies[b];
    const int from = strands_[rods_ + b].place;
    for (int k = 0; k < 3; ++k) {
      double* const x = At(static_cast<Row>(kX + k)) + from;
      x[-1] = x[0] = body.start[k];
      x[1] = x[2] = body.end[k];
      At(static_cast<Row>(kCenterX + k))[from] = 0.5 * (body.start[k] + body.end[k]);
    }
    At(kRadius)[from] = body.radius;
    At(kBound)[from] = body.radius + 0.5 * (body.end - body.start).norm();
    At(kNodeShare)[from] = At(kNodeShare)[from + 1] = 1;
    At(kEndShare)[from] = 0.5;
  }
}

void ContactList::Put(std::size_t rod, const double* positions, const double* velocities,
                      std::size_t stride) {
  const Strand& strand = strands_[rod];
  const int last = strand.place + strand.elements;
  for (int k = 0; k < 3; ++k) {
    double* const x = At(static_cast<Row>(kX + k));
    const double* from = positions + static_cast<std::size_t>(k) * stride;
    for (int i = strand.place; i <= last; ++i, from += 3 * stride) x[i] = *from;
    x[strand.place - 1] = x[strand.place];
    x[last + 1] = x[last];
    if (contact_.damping == 0) continue;
    double* const v = At(static_cast<Row>(kVx + k));
    from = velocities + static_cast<std::size_t>(k) * stride;
    for (int i = strand.place; i <= last; ++i, from += 3 * stride) v[i] = *from;
  }
}

bool ContactList::Find() {
  contact_kernel::Job job{};
  job.law = contact_.law == ContactLaw::kHertzSegments ? contact_kernel::kSegments
            : contact_.law == ContactLaw::kHertzEqual  ? contact_kernel::kEqual
                                                       : contact_kernel::kCenters;
  job.stiffness = contact_.stiffness;
  job.damping = contact_.damping;
  job.size = rod_places_;
  job.x = At(kX), job.y = At(kY), job.z = At(kZ);
  if (contact_.damping != 0) job.vx = At(kVx), job.vy = At(kVy), job.vz = At(kVz);
  job.old_x = At(kOldX), job.old_y = At(kOldY), job.old_z = At(kOldZ);
  job.rest_radius = At(kRestRadius), job.rest_length = At(kRestLength);
  job.node_share = At(kNodeShare), job.end_share = At(kEndShare);
  job.radius = At(kRadius), job.bound = At(kBound), job.inverse_square = At(kInverseSquare);
  job.center_x = At(kCenterX), job.center_y = At(kCenterY), job.center_z = At(kCenterZ);
  job.fx = At(kFx), job.fy = At(kFy), job.fz = At(kFz);
  job.end_fx = At(kEndFx), job.end_fy = At(kEndFy), job.end_fz = At(kEndFz);
  const contact_kernel::Kernels kernels = KernelsOfThisMachine();
  kernels.prepare(job);
  if (!started_) {
    job.moved = 0;
    slack_ = -1;
  }
  slack_ -= 2 * job.moved;
  longest_move_ = std::max(longest_move_, job.moved);
  // Elements of which none touch are farther apart than their radii.
  if (2 * job.moved >= std::min(last_least_, margin_)) nothing_passed_ = false;
  if (!std::isfinite(job.moved)) return false;
  if (slack_ <= 0) {
    MakeList();
    slack_ = margin_;
  }
  started_ = true;
  job.elements = static_cast<int>(element_.size());
  job.element = element_.data();
  job.first = first_.data();
  job.runs = runs_.data();
  job.is_body = is_body_.data();
  job.least_distance = job.least_share = kNothing;
  std::fill_n(At(kFx), 6 * stride_, 0.0);
  kernels.touch(job);
  last_least_ = job.least_distance;
  least_distance_ = std::min(least_distance_, job.least_distance);
  least_share_ = std::min(least_share_, job.least_share);
  return true;
}

void ContactList::AddForces(std::size_t rod, double* forces, std::size_t stride) const {
  const Strand& strand = strands_[rod];
  for (int k = 0; k < 3; ++k) {
    // Element -1 is padding, and its end 0.
    const double* const start = At(static_cast<Row>(kFx + k)) + strand.place;
    const double* const end = At(static_cast<Row>(kEndFx + k)) + strand.place;
    double* to = forces + static_cast<std::size_t>(k) * stride;
    for (int i = 0; i <= strand.elements; ++i, to += 3 * stride) *to += start[i] + end[i - 1];
  }
}

Eigen::Vector3d ContactList::ForceOnBody(std::size_t body) const {
  const auto from = strands_[rods_ + body].place;
  Eigen::Vector3d force;
  for (int k = 0; k < 3; ++k) {
    force[k] = At(static_cast<Row>(kFx + k))[from] + At(static_cast<Row>(kEndFx + k))[from];
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
  for (const Row row : {kOldX, kOldY, kOldZ}) saved.insert(saved.end(), At(row), At(row) + stride_);
  return saved;
}

void ContactList::Restore(std::span<const double> saved) {
  TENDRIL_CHECK(saved.size() == 7 + 3 * stride_);
  least_distance_ = saved[0];
  least_share_ = saved[1];
  longest_move_ = saved[2];
  last_least_ = saved[3];
  lists_ = static_cast<long>(saved[4]);
  nothing_passed_ = saved[5] != 0;
  started_ = saved[6] != 0;
  std::size_t from = 7;
  for (const Row row : {kOldX, kOldY, kOldZ}) {
    std::copy_n(saved.begin() + static_cast<std::ptrdiff_t>(from), stride_, At(row));
    from += stride_;
  }
  ForgetList();
}

// Runs of eight elements of places [from, to) of which one at least may come to touch.
void ContactList::AddRuns(int element, int from, int to) {
  const double *x = At(kCenterX), *y = At(kCenterY), *z = At(kCenterZ), *bound = At(kBound);
  const double cx = x[element], cy = y[element], cz = z[element], reach = bound[element] + margin_;
  const auto near = [&](int j) {
    const double dx = x[j] - cx, dy = y[j] - cy, dz = z[j] - cz, together = reach + bound[j];
    return dx * dx + dy * dy + dz * dz < together * together;
  };
  int j = from;
  while (j < to) {
    if (j % kRun == 0) {
      const auto run = static_cast<std::size_t>(j / kRun);
      const double dx = run_x_[run] - cx, dy = run_y_[run] - cy, dz = run_z_[run] - cz;
      const double together = reach + run_bound_[run];
      if (!(dx * dx + dy * dy + dz * dz < together * together)) {
        j += kRun;
        continue;
      }
    }
    if (!near(j)) {
      ++j;
      continue;
    }
    // Runs start where something is near, so that fewer reach what is not.
    runs_.push_back(j);
    j += kRun;
  }
}

void ContactList::MakeList() {
  ++lists_;
  const std::size_t runs = static_cast<std::size_t>(rod_places_) / kRun;
  run_x_.assign(runs, 0.0);
  run_y_.assign(runs, 0.0);
  run_z_.assign(runs, 0.0);
  run_bound_.assign(runs, -kNothing);
  struct Box {
    Eigen::Vector3d low = Eigen::Vector3d::Constant(kNothing), high = Eigen::Vector3d::Constant(-kNothing);
  };
  std::vector<Box> boxes(strands_.size());
  const double *x = At(kCenterX), *y = At(kCenterY), *z = At(kCenterZ), *bound = At(kBound);
  for (std::size_t r = 0; r < strands_.size(); ++r) {
    const Strand& strand = strands_[r];
    const int end = strand.place + strand.elements;
    for (int i = strand.place; i < end; ++i) {
      const Eigen::Vector3d center(x[i], y[i], z[i]);
      boxes[r].low = boxes[r].low.cwiseMin((center.array() - bound[i] - margin_).matrix());
      boxes[r].high = boxes[r].high.cwiseMax((center.array() + bound[i] + margin_).matrix());
    }
    if (r >= rods_) continue;
    for (int i = strand.place; i < end; i += kRun) {
      const auto run = static_cast<std::size_t>(i / kRun);
      const int last = std::min(i + kRun, end), middle = (i + last) / 2;
      run_x_[run] = x[middle];
      run_y_[run] = y[middle];
      run_z_[run] = z[middle];
      for (int j = i; j < last; ++j) {
        const double distance = std::hypot(x[j] - x[middle], y[j] - y[middle], z[j] - z[middle]);
        run_bound_[run] = std::max(run_bound_[run], distance + bound[j]);
      }
    }
  }
  const auto meet = [](const Box& a, const Box& b) {
    return (a.low.array() <= b.high.array()).all() && (b.low.array() <= a.high.array()).all();
  };
  // Rods in the order of their boxes' lower ends along x: of each only those are looked at that start before
  // it ends.
  std::vector<std::vector<std::size_t>> partners(strands_.size());
  std::vector<std::size_t> order(strands_.size());
  for (std::size_t r = 0; r < order.size(); ++r) order[r] = r;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return boxes[a].low.x() != boxes[b].low.x() ? boxes[a].low.x() < boxes[b].low.x() : a < b;
  });
  for (std::size_t m = 0; m < order.size(); ++m) {
    for (std::size_t k = m + 1; k < order.size() && boxes[order[k]].low.x() <= boxes[order[m]].high.x();
         ++k) {
      const std::size_t a = std::max(order[m], order[k]), b = std::min(order[m], order[k]);
      const bool body = a >= rods_;
      if (b >= rods_ || (body ? !pairs_.bodies : !pairs_.rods) || !meet(boxes[a], boxes[b])) continue;
      partners[a].push_back(b);
    }
  }
  element_.clear();
  first_.clear();
  runs_.clear();
  is_body_.clear();
  for (std::size_t a = 0; a < strands_.size(); ++a) {
    const Strand& strand = strands_[a];
    std::sort(partners[a].begin(), partners[a].end());
    for (int i = 0; i < strand.elements; ++i) {
      const std::size_t before = runs_.size();
      for (const std::size_t b : partners[a]) {
        AddRuns(strand.place + i, strands_[b].place, strands_[b].place + strands_[b].elements);
      }
      if (a < rods_ && pairs_.selves) {
        AddRuns(strand.place + i, strand.place + strand.may_touch[static_cast<std::size_t>(i)],
                strand.place + strand.elements);
      }
      if (runs_.size() == before) continue;
      element_.push_back(strand.place + i);
      first_.push_back(static_cast<int>(before));
      is_body_.push_back(a >= rods_ ? 1 : 0);
    }
  }
  first_.push_back(static_cast<int>(runs_.size()));
}

}  // namespace tendril
