// Solids in a ContactList: which elements may press on them, and what does.
#include <algorithm>
#include <cmath>
#include <limits>

#include "model/rods/contact_list.h"
#include "model/rods/press.h"

namespace tendril {
namespace {

using Eigen::Vector3d;
constexpr std::size_t kRun = 8;

contact_kernel::PartKind KindOf(PrimitiveKind kind) {
  switch (kind) {
    case PrimitiveKind::kCylinder:
      return contact_kernel::kCylinderPart;
    case PrimitiveKind::kBox:
      return contact_kernel::kBoxPart;
    case PrimitiveKind::kHalfSpace:
      return contact_kernel::kHalfSpacePart;
    case PrimitiveKind::kSphere:
    case PrimitiveKind::kCapsule:
      break;
  }
  return contact_kernel::kCapsulePart;
}

void Copy(const Vector3d& from, double* to) { std::copy_n(from.data(), 3, to); }

}  // namespace

void ContactList::PlaceSolid(const Solid& solid) {
  Placed placed;
  placed.solid = solid;
  placed.reach = ReachOf(solid.shape);
  placed.chosen_pose = solid.pose;
  slides_ = slides_ || RoughnessOf(contact_, solid).at_rest > 0;
  for (const Primitive& primitive : solid.shape) {
    Primitive centred = primitive;
    centred.object_from_primitive.setIdentity();
    Part& part = parts_.emplace_back();
    part.solid = solids_.size();
    part.primitive = primitive;
    part.reach = ReachOf({centred});
  }
  solids_.push_back(std::move(placed));
}

void ContactList::PutSolid(std::size_t solid, const Eigen::Isometry3d& pose, const Vector3d& velocity,
                           const Vector3d& spin) {
  Solid& to = solids_[solid].solid;
  to.pose = pose;
  to.velocity = velocity;
  to.spin = spin;
}

bool ContactList::KeptApart() const {
  return 2 * longest_since_ < least_gap_ &&
         std::all_of(solids_.begin(), solids_.end(),
                     [&](const Placed& placed) { return longest_since_ + placed.longest_step < placed.gap; });
}

void ContactList::FollowSolids(double time_step) {
  for (Placed& placed : solids_) {
    const Solid& solid = placed.solid;
    // What reaches everywhere does not turn.
    const double reach = std::isfinite(placed.reach) ? placed.reach : 0;
    const double turned = (placed.chosen_pose.linear() - solid.pose.linear()).norm() * reach;
    const double moved = (placed.chosen_pose.translation() - solid.pose.translation()).norm() + turned;
    placed.step = time_step * (solid.velocity.norm() + solid.spin.norm() * reach);
    left_ = left_ || moved > placed.allowed;
    placed.longest_step = std::max(placed.longest_step, placed.step);
  }
}

void ContactList::ChooseOnSolids() {
  for (Placed& placed : solids_) {
    placed.chosen_pose = placed.solid.pose;
    placed.gap = std::numeric_limits<double>::infinity();
    placed.longest_step = 0;
    placed.allowed =
        std::clamp(kStepsAhead * placed.step, kLeastAllowed * thinnest_, kMostAllowed * thinnest_);
  }
  for (std::size_t part = 0; pairs_.bodies && part < parts_.size(); ++part) ChooseOnPart(part);
}

void ContactList::ChooseOnPart(std::size_t number) {
  using namespace contact_kernel;
  Part& part = parts_[number];
  Placed& placed = solids_[part.solid];
  const Eigen::Isometry3d object_from_lab = placed.solid.pose.inverse();
  const Vector3d middle = placed.solid.pose * part.primitive.object_from_primitive.translation();
  const double *x = At(kCenterX), *y = At(kCenterY), *z = At(kCenterZ), *bound = At(kBound);
  const double *radius = At(kRestRadius), *length = At(kRestLength), *drift = At(kDrift);
  std::swap(old_, part.slots);
  ContactSlots& slots = part.slots;
  slots.Clear();
  for (std::size_t r = 0; r < rods_; ++r) {
    const Strand& strand = strands_[r];
    for (int i = strand.place; i < strand.place + strand.elements; ++i) {
      const Vector3d centre(x[i], y[i], z[i]);
      const double near = bound[i] + placed.allowed;
      const double square = (centre - middle).squaredNorm();
      if (square >= (part.reach + near) * (part.reach + near)) {
        placed.gap = std::min(placed.gap, std::sqrt(square) - part.reach - near + radius[i]);
        continue;
      }
      const double distance = DistanceTo(part.primitive, object_from_lab * centre).distance;
      if (distance >= near) {
        // What is not chosen keeps its radius off all the while.
        placed.gap = std::min(placed.gap, distance - near + radius[i]);
        continue;
      }
      slots.one_place.push_back(i);
      // How near its axis may come to the surface, between points that are looked at no farther apart than
      // half its radius.
      const Vector3d start(At(kX)[i], At(kY)[i], At(kZ)[i]), end(At(kX)[i + 1], At(kY)[i + 1], At(kZ)[i + 1]);
      const int pieces = 1 + static_cast<int>(2 * length[i] / radius[i]);
      double least = std::numeric_limits<double>::infinity();
      for (int k = 0; k <= pieces; ++k) {
        const Vector3d point = start + (static_cast<double>(k) / pieces) * (end - start);
        least = std::min(least, DistanceTo(part.primitive, object_from_lab * point).distance);
      }
      least -= 0.5 * (end - start).norm() / pieces + drift[i] + placed.allowed;
      placed.gap = std::min(placed.gap, least);
    }
  }
  slots.found = static_cast<int>(slots.one_place.size());
  while (slots.one_place.size() % kRun != 0) slots.one_place.push_back(slots.one_place.back());
  slots.other_place.assign(slots.one_place.size(), 0);
  slots.constants.resize(slots.one_place.size() * kSolidConstants);
  for (std::size_t p = 0; p < slots.one_place.size(); ++p) {
    const int i = slots.one_place[p];
    slots.one.push_back(lane_of_place_[static_cast<std::size_t>(i)]);
    const double stiffness = SurfaceStiffness(contact_.stiffness, radius[i]) * length[i];
    double* const constants = slots.constants.data() + p / kRun * (kRun * kSolidConstants) + p % kRun;
    const bool filling = p >= static_cast<std::size_t>(slots.found);
    constants[kRun * kSolidRadius] = filling ? std::numeric_limits<double>::quiet_NaN() : radius[i];
    constants[kRun * kSolidStiffness] = stiffness / contact_.points;
    constants[kRun * kSolidStick] = contact_.tangential_ratio * stiffness;
    constants[kRun * kSolidInverseReference] = 1 / ReferenceStiffness(contact_.stiffness, 2 * radius[i]);
  }
  if (Moves()) slots.TakeSprings(old_);
}

contact_kernel::Sliding ContactList::SlidingOn(const Roughness& roughness, double time_step) {
  return {roughness.kinetic, roughness.at_rest, time_step};
}

void ContactList::PressOnSolids(double time_step) {
  for (Placed& placed : solids_) placed.wrench = {};
  for (Part& part : parts_) {
    if (part.slots.one.empty()) continue;
    Placed& placed = solids_[part.solid];
    const Solid& solid = placed.solid;
    contact_kernel::PressOnSolid press{};
    const Eigen::Isometry3d pose = solid.pose * part.primitive.object_from_primitive;
    press.part.kind = KindOf(part.primitive.kind);
    press.part.radius = part.primitive.radius;
    Copy(part.primitive.half, press.part.half);
    if (part.primitive.kind == PrimitiveKind::kSphere) press.part.half[2] = 0;
    for (int k = 0; k < 3; ++k) Copy(pose.linear().col(k), press.part.axes[k]);
    Copy(pose.translation(), press.part.position);
    Copy(solid.pose.translation(), press.origin);
    Copy(solid.velocity, press.moving);
    Copy(solid.spin, press.turning);
    press.damping = contact_.damping;
    press.points = contact_.points;
    press.sliding = SlidingOn(RoughnessOf(contact_, solid), time_step);
    press.elements = static_cast<int>(part.slots.one.size());
    press.one = part.slots.one.data();
    press.constants = part.slots.constants.data();
    press.springs = part.slots.springs.data();
    press.at = nodes_.data();
    if (Moves()) press.velocity = velocities_.data(), press.spin = spins_.data();
    press.force = forces_.data();
    press.couple = couples_.data();
    press.least_share = least_share_;
    press.longest_stick_square = longest_stick_ * longest_stick_;
    contact_kernel::KernelsOfThisMachine().press_on_solid(press);
    longest_stick_ = std::sqrt(press.longest_stick_square);
    least_share_ = press.least_share;
    placed.wrench.force += Vector3d(press.on_solid[0], press.on_solid[1], press.on_solid[2]);
    placed.wrench.torque += Vector3d(press.on_solid[3], press.on_solid[4], press.on_solid[5]);
  }
}

}  // namespace tendril
