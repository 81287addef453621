#include "model/rods/rod_lanes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "model/check.h"
#include "model/machine.h"
#include "model/rods/rod_lanes_kernel.h"

namespace tendril {
namespace {

int& ChosenWidth() {
  static int width = MachineDoubles();
  return width;
}

template <class S>
rod_kernel::Kernels<S> KernelsOfThisMachine() {
#ifdef TENDRIL_ROD_X86
  if (ChosenWidth() == 8) return rod_kernel::Avx512Kernels<S>();
  if (ChosenWidth() == 4) return rod_kernel::Avx2Kernels<S>();
#endif
  return rod_kernel::BaseKernels<S>();
}

}  // namespace

void UseRodKernel(int width) {
  TENDRIL_CHECK(width <= MachineDoubles());
  ChosenWidth() = width > 0 ? width : MachineDoubles();
}

int RodKernelWidth() { return ChosenWidth(); }

template <class S>
Result<LaneRods<S>> LaneRods<S>::Make(std::span<const Rod> rods, RodForm form) {
  if (rods.empty() || rods.size() > kRodLanes) {
    return Error{ErrorKind::kBadInput, std::to_string(rods.size()) + " rods side by side: expected 1 to " +
                                           std::to_string(kRodLanes)};
  }
  for (const Rod& rod : rods) {
    if (form == RodForm::kPaper && (rod.base.hold == EndHold::kFrame || rod.tip.hold == EndHold::kFrame)) {
      return Error{ErrorKind::kBadInput, "the published form holds ends by their elements, not by frames"};
    }
    if (rod.elements() == rods[0].elements()) continue;
    return Error{ErrorKind::kBadInput, "rods of " + std::to_string(rods[0].elements()) + " and " +
                                           std::to_string(rod.elements()) +
                                           " elements side by side: expected equally many"};
  }
  LaneRods lanes;
  lanes.form_ = form;
  lanes.rods_ = static_cast<int>(rods.size());
  lanes.elements_ = static_cast<int>(rods[0].elements());
  const size_t n = static_cast<size_t>(lanes.elements_);
  size_t end = 0;
  const auto room = [&end](size_t rows) {
    const size_t at = end;
    end += rows * kRodLanes;
    return at;
  };
  Places& at = lanes.at_;
  at.position = room(3 * (n + 1));
  at.velocity = room(3 * (n + 1));
  at.turn = room(4 * n);
  at.spin = room(3 * n);
  at.force = room(3 * (n + 1));
  at.inverse_mass = room(n + 1);
  at.rest_length = room(3 * n);
  at.shear = room(2 * n);
  at.inertia = room(4 * n);
  at.bend = room(2 * (n - 1));
  at.rest_strain = room(3 * n);
  at.rest_curvature = room(3 * (n - 1));
  at.mobile = room(4);
  at.damped = room(2);
  at.end_turn = room(8);
  at.end_bend = room(8);
  at.end_curvature = room(6);
  at.tip_couple = room(3);
  lanes.memory_.assign(end, S(0));

  for (size_t lane = 0; lane < kRodLanes; ++lane) {
    const Rod& rod = rods[lane < rods.size() ? lane : 0];  // lanes without a rod start as the first
    const auto put = [&](size_t from, size_t row, double value) {
      lanes.memory_[from + row * kRodLanes + lane] = static_cast<S>(value);
    };
    const auto put3 = [&](size_t from, size_t row, const Eigen::Vector3d& v) {
      for (size_t k = 0; k < 3; ++k) put(from, 3 * row + k, v[static_cast<Eigen::Index>(k)]);
    };
    put(at.mobile, 0, rod.base.hold == EndHold::kFree ? 1 : 0);
    put(at.mobile, 1, rod.base.hold == EndHold::kElement ? 0 : 1);
    put(at.mobile, 2, rod.tip.hold == EndHold::kFree ? 1 : 0);
    put(at.mobile, 3, rod.tip.hold == EndHold::kElement ? 0 : 1);
    for (size_t e = 0; e < 2; ++e) {
      const RodEnd& rod_end = e == 0 ? rod.base : rod.tip;
      const bool held = rod_end.hold == EndHold::kFrame;
      if (held) lanes.SetEndFrame(e, lane, rod_end.hold, rod_end.frame);
      lanes.SetEndCurvature(e, lane, rod_end.rest_curvature);
      put(at.end_bend, 4 * e, held ? rod_end.bend_stiffness.x() : 0);
      put(at.end_bend, 4 * e + 1, held ? rod_end.bend_stiffness.z() : 0);
      const double half = 0.5 * (e == 0 ? rod.rest_length[0] : rod.rest_length[rod.elements() - 1]);
      put(at.end_bend, 4 * e + 2, half);
      put(at.end_bend, 4 * e + 3, 1 / half);
    }
    put3(at.tip_couple, 0, rod.tip_couple);
    for (size_t i = 0; i <= n; ++i) {
      const auto e = static_cast<Eigen::Index>(i);
      put3(at.position, i, rod.position.col(e));
      put3(at.velocity, i, rod.velocity.col(e));
      put(at.inverse_mass, i, 1 / rod.mass[e]);
      if (i == n) break;
      const Eigen::Quaterniond q(Eigen::Matrix3d(rod.directors[i].transpose()));
      put(at.turn, 4 * i, q.w());
      put(at.turn, 4 * i + 1, q.x());
      put(at.turn, 4 * i + 2, q.y());
      put(at.turn, 4 * i + 3, q.z());
      put3(at.spin, i, rod.spin.col(e));
      put(at.rest_length, 3 * i, rod.rest_length[e]);
      put(at.rest_length, 3 * i + 1, 1 / rod.rest_length[e]);
      if (i > 0) put(at.rest_length, 3 * i + 2, 2 / (rod.rest_length[e - 1] + rod.rest_length[e]));
      put(at.shear, 2 * i, rod.shear_stiffness(0, e));
      put(at.shear, 2 * i + 1, rod.shear_stiffness(2, e));
      put(at.inertia, 4 * i, rod.inertia(0, e));
      put(at.inertia, 4 * i + 1, rod.inertia(2, e));
      put(at.inertia, 4 * i + 2, 1 / rod.inertia(0, e));
      put(at.inertia, 4 * i + 3, 1 / rod.inertia(2, e));
      put3(at.rest_strain, i, rod.rest_strain.col(e));
      if (i + 1 == n) continue;
      put(at.bend, 2 * i, rod.bend_stiffness(0, e));
      put(at.bend, 2 * i + 1, rod.bend_stiffness(2, e));
      put3(at.rest_curvature, i, rod.rest_curvature.col(e));
    }
  }
  return lanes;
}

template <class S>
rod_kernel::Job<S> LaneRods<S>::MakeJob() {
  const auto at = [&](size_t from) { return memory_.data() + from; };
  rod_kernel::Job<S> job{};
  job.elements = elements_;
  job.rods = rods_;
  job.energy_form = form_ == RodForm::kEnergy;
  job.position = at(at_.position);
  job.velocity = at(at_.velocity);
  job.turn = at(at_.turn);
  job.spin = at(at_.spin);
  job.inverse_mass = at(at_.inverse_mass);
  job.rest_length = at(at_.rest_length);
  job.shear = at(at_.shear);
  job.inertia = at(at_.inertia);
  job.bend = at(at_.bend);
  job.rest_strain = at(at_.rest_strain);
  job.rest_curvature = at(at_.rest_curvature);
  job.mobile = at(at_.mobile);
  job.damped = at(at_.damped);
  job.end_turn = at(at_.end_turn);
  job.end_bend = at(at_.end_bend);
  job.end_curvature = at(at_.end_curvature);
  job.tip_couple = at(at_.tip_couple);
  job.turned_too_far = trouble_.turned_too_far;
  job.not_finite = trouble_.not_finite;
  return job;
}

template <class S>
void LaneRods<S>::SetEndFrame(size_t end, size_t lane, EndHold hold, const Eigen::Matrix3d& frame) {
  if (hold == EndHold::kFree) return;
  const size_t element = end == 0 ? 0 : static_cast<size_t>(elements_) - 1;
  const size_t from =
      hold == EndHold::kFrame ? at_.end_turn + 4 * end * kRodLanes : at_.turn + 4 * element * kRodLanes;
  const Eigen::Quaterniond q(Eigen::Matrix3d(frame.transpose()));
  const double turn[] = {q.w(), q.x(), q.y(), q.z()};
  for (size_t k = 0; k < 4; ++k) memory_[from + k * kRodLanes + lane] = static_cast<S>(turn[k]);
}

template <class S>
void LaneRods<S>::SetEndCurvature(size_t end, size_t lane, const Eigen::Vector3d& curvature) {
  for (size_t k = 0; k < 3; ++k) {
    memory_[at_.end_curvature + (3 * end + k) * kRodLanes + lane] =
        static_cast<S>(curvature[static_cast<Eigen::Index>(k)]);
  }
}

template <class S>
void LaneRods<S>::SetDamping(std::span<const double> damping) {
  TENDRIL_CHECK(damping.size() == static_cast<size_t>(rods_));
  damping_.assign(damping.begin(), damping.end());
}

template <class S>
void LaneRods<S>::UseCouples(bool use) {
  couples_.assign(use ? static_cast<size_t>(3 * elements_) * kRodLanes : 0, S(0));
}

template <class S>
void LaneRods<S>::ShareLoads(std::span<S> forces, std::span<S> couples) {
  TENDRIL_CHECK(forces.size() == static_cast<size_t>(3 * (elements_ + 1)) * kRodLanes);
  TENDRIL_CHECK(couples.empty() || couples.size() == static_cast<size_t>(3 * elements_) * kRodLanes);
  shares_ = true;
  shared_forces_ = forces;
  shared_couples_ = couples;
}

template <class S>
void LaneRods<S>::SetMedium(const Medium& medium, std::span<const Rod> rods, std::span<const Wetted> wetted) {
  TENDRIL_CHECK(rods.size() == static_cast<size_t>(rods_) && wetted.size() == rods.size());
  flow_ = medium.flow;
  medium_.clear();
  if (medium.density == 0) return;
  medium_.resize(static_cast<size_t>(4 * (elements_ + 1)) * kRodLanes);
  for (size_t lane = 0; lane < kRodLanes; ++lane) {
    const size_t r = lane < rods.size() ? lane : 0;
    TENDRIL_CHECK(rods[r].elements() == elements_);
    const WettedNodes nodes = WettedNodesOf(rods[r], medium, wetted[r]);
    const Eigen::VectorXd* const rows[] = {&nodes.weighed, &nodes.inverse_across, &nodes.across_drag,
                                           &nodes.along_drag};
    for (size_t i = 0; i <= static_cast<size_t>(elements_); ++i) {
      for (size_t k = 0; k < 4; ++k) {
        medium_[(4 * i + k) * kRodLanes + lane] = static_cast<S>((*rows[k])[static_cast<Eigen::Index>(i)]);
      }
    }
  }
}

template <class S>
void LaneRods<S>::LabSpins(std::span<S> to) {
  TENDRIL_CHECK(to.size() == static_cast<size_t>(3 * elements_) * kRodLanes);
  KernelsOfThisMachine<S>().lab_spins(MakeJob(), to.data());
}

template <class S>
void LaneRods<S>::Drift(double time) {
  rod_kernel::Job<S> job = MakeJob();
  KernelsOfThisMachine<S>().drift(job, static_cast<S>(time));
  trouble_ = {job.turned_too_far, job.not_finite};
}

template <class S>
void LaneRods<S>::Kick(const PlainOptions& options, bool with_forces) {
  TENDRIL_CHECK(options.form == form_);
  rod_kernel::Job<S> job = MakeJob();
  for (int k = 0; k < 3; ++k) job.gravity[k] = static_cast<S>(options.gravity[k]);
  if (with_forces) job.force = forces().data();
  if (with_forces && !couples().empty()) job.couple = couples().data();
  if (!medium_.empty()) job.medium = medium_.data();
  for (int k = 0; k < 3; ++k) job.flow[k] = static_cast<S>(flow_[k]);
  for (size_t lane = 0; lane < kRodLanes; ++lane) {
    const double damping = damping_.empty() ? options.damping : damping_[lane < damping_.size() ? lane : 0];
    const DampedKick kick = KickOf(form_, options.time_step, damping);
    memory_[at_.damped + lane] = static_cast<S>(kick.keep);
    memory_[at_.damped + kRodLanes + lane] = static_cast<S>(kick.gain);
  }
  KernelsOfThisMachine<S>().kick(job);
  trouble_ = {job.turned_too_far, job.not_finite};
}

template <class S>
int LaneRods<S>::Advance(int steps, double time, const PlainOptions& options, const Middle& middle) {
  const double dt = options.time_step;
  if (steps <= 0 || trouble_.any()) return 0;
  // Half drifts of neighbouring steps are one: nothing happens to velocities between them.
  Drift(0.5 * dt);
  int made = 0;
  while (true) {
    if (middle) {
      std::ranges::fill(forces(), S(0));
      std::ranges::fill(couples(), S(0));
      middle(time + (made + 0.5) * dt, *this);
    }
    Kick(options, static_cast<bool>(middle));
    ++made;
    if (made == steps || trouble_.any()) break;
    Drift(dt);
  }
  Drift(0.5 * dt);
  return made;
}

template <class S>
void LaneRods<S>::Store(std::span<Rod> rods) const {
  TENDRIL_CHECK(rods.size() == static_cast<size_t>(rods_));
  for (size_t lane = 0; lane < rods.size(); ++lane) {
    Rod& rod = rods[lane];
    TENDRIL_CHECK(rod.elements() == elements_);
    const auto get = [&](size_t from, size_t row) -> double {
      return memory_[from + row * kRodLanes + lane];
    };
    for (size_t i = 0; i <= static_cast<size_t>(elements_); ++i) {
      const auto e = static_cast<Eigen::Index>(i);
      for (size_t k = 0; k < 3; ++k) {
        const auto row = static_cast<Eigen::Index>(k);
        rod.position(row, e) = get(at_.position, 3 * i + k);
        rod.velocity(row, e) = get(at_.velocity, 3 * i + k);
        if (e < elements_) rod.spin(row, e) = get(at_.spin, 3 * i + k);
      }
      if (e == elements_) break;
      Eigen::Quaterniond q(get(at_.turn, 4 * i), get(at_.turn, 4 * i + 1), get(at_.turn, 4 * i + 2),
                           get(at_.turn, 4 * i + 3));
      rod.directors[i] = q.normalized().toRotationMatrix().transpose();
    }
  }
}

template class LaneRods<double>;
template class LaneRods<float>;

}  // namespace tendril
