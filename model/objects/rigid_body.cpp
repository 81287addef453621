#include "model/objects/rigid_body.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/geometry/rotation.h"

namespace tendril {
namespace {

// Turns by `angle` about a principal axis: the body, and with it how it sees its angular momentum.
void TurnAbout(int axis, double angle, Eigen::Quaterniond& turn, Eigen::Vector3d& momentum) {
  const double half_cosine = std::cos(angle / 2);
  const double half_sine = std::sin(angle / 2);
  turn = turn * Eigen::Quaterniond(half_cosine, axis == 0 ? half_sine : 0, axis == 1 ? half_sine : 0,
                                   axis == 2 ? half_sine : 0);
  const double cosine = (half_cosine - half_sine) * (half_cosine + half_sine);
  const double sine = 2 * half_sine * half_cosine;
  const int b = (axis + 1) % 3;
  const int c = (axis + 2) % 3;
  const double along_b = momentum[b];
  momentum[b] = cosine * along_b + sine * momentum[c];
  momentum[c] = cosine * momentum[c] - sine * along_b;
}

int MiddleOf(const Eigen::Vector3d& v) {
  int most = 0;
  int least = 0;
  v.maxCoeff(&most);
  v.minCoeff(&least);
  return most == least ? 0 : 3 - most - least;
}

// How a free body turns in a time, in its own axes at the start; `momentum` becomes that in its axes at the
// end. The energy is |L|^2 / (2 I_m) and, for the other two axes, L_i^2 (1 / I_i - 1 / I_m) / 2: the first
// part commutes with all, and the middle m makes the error, a product of the two differences, the least.
Eigen::Quaterniond FreeTurn(const Eigen::Vector3d& inertia, double time, Eigen::Vector3d& momentum) {
  const int m = MiddleOf(inertia);
  int a = (m + 1) % 3;
  int b = (m + 2) % 3;
  const double middle = 1 / inertia[m];
  const auto rate = [&](int axis) { return 1 / inertia[axis] - middle; };
  if (rate(a) == 0) std::swap(a, b);  // then b's turns are none, and a's is one
  Eigen::Quaterniond turn = ExpSo3Quaternion(Eigen::Vector3d(time * middle * momentum));
  if (rate(a) == 0) return turn;
  if (rate(b) == 0) {
    TurnAbout(a, rate(a) * momentum[a] * time, turn, momentum);
    return turn;
  }
  TurnAbout(a, rate(a) * momentum[a] * time / 2, turn, momentum);
  TurnAbout(b, rate(b) * momentum[b] * time, turn, momentum);
  TurnAbout(a, rate(a) * momentum[a] * time / 2, turn, momentum);
  return turn;
}

constexpr double kSolved = 1e-12;  // of its length
constexpr double kResolved = 0.3;
constexpr double kMostTakenIn = 1e-2;  // of a string that is too long, in one step, of its length

// A string's end on a body that will drift: how far it goes is computed as a change, because as a difference
// of two places its rounding, over the square of a small step, would be the tension's.
struct StringEnd {
  const RigidBody& body;  // kicked by all but the string
  double time;
  Eigen::Vector3d arm_in_body;
  Eigen::Matrix3d lab_from_body;
  Eigen::Vector3d offset;  // from the string's other end, now, lab

  // Inverse inertia that an impulse at the end meets: the change of the end's velocity, per N s.
  Eigen::Matrix3d Mobility() const {
    Eigen::Matrix3d cross;
    const Eigen::Vector3d& r = arm_in_body;
    cross << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
    const Eigen::Matrix3d turning = cross.transpose() * body.inertia.cwiseInverse().asDiagonal() * cross;
    return Eigen::Matrix3d::Identity() / body.mass + lab_from_body * turning * lab_from_body.transpose();
  }

  Eigen::Vector3d MomentumWith(const Eigen::Vector3d& impulse) const {
    return body.angular_momentum_in_body + arm_in_body.cross(lab_from_body.transpose() * impulse);
  }

  Eigen::Vector3d Velocity() const {
    return body.velocity +
           lab_from_body * body.angular_momentum_in_body.cwiseQuotient(body.inertia).cross(arm_in_body);
  }

  // Where the end goes in the step if the string gives an impulse (lab, N s).
  Eigen::Vector3d ChangeWith(const Eigen::Vector3d& impulse) const {
    Eigen::Vector3d momentum = MomentumWith(impulse);
    const Eigen::Quaterniond turn = FreeTurn(body.inertia, time, momentum);
    const Eigen::Vector3d across = 2 * turn.vec().cross(arm_in_body);
    return time * (body.velocity + impulse / body.mass) +
           lab_from_body * (turn.w() * across + turn.vec().cross(across));
  }
};

// How much of an excess of the present length a step takes in: of rounding a part, because at once it would
// be a jerk of eps x / time.
double TakenIn(double excess, double rounding) { return std::abs(excess) <= rounding ? excess / 64 : excess; }

double RoundingOf(const RigidBody& body, const BodyString& string) {
  return 16 * std::numeric_limits<double>::epsilon() *
         (body.position.norm() + string.from.norm() + string.to_in_body.norm() + string.length);
}

// The impulse of a string of no length: the end meets the lab's point.
Eigen::Vector3d JointImpulse(const StringEnd& end, double rounding) {
  const Eigen::Matrix3d impulse_per_way = (end.time * end.Mobility()).inverse();
  const double excess = end.offset.norm();
  const Eigen::Vector3d way = excess > 0 ? Eigen::Vector3d(-TakenIn(excess, rounding) / excess * end.offset)
                                         : Eigen::Vector3d(Eigen::Vector3d::Zero());
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();
  double left = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d miss = way - end.ChangeWith(impulse);
    if (!(miss.norm() < left)) break;  // to the last digit
    left = miss.norm();
    impulse += impulse_per_way * miss;
  }
  return impulse;
}

// The impulse along the string that brings its ends to `length` apart, N s; 0: it is slack.
double TautImpulse(const StringEnd& end, const Eigen::Vector3d& inward, double length, double rounding) {
  const double now = end.offset.norm();
  const double excess = std::min(TakenIn(now - length, rounding), kMostTakenIn * length);
  // (|offset + change|^2 - length^2) / (2 length), whose zero is sought.
  const auto stretch = [&](const Eigen::Vector3d& change) {
    return (excess * (now + length) + (2 * end.offset + change).dot(change)) / (2 * length);
  };
  const Eigen::Vector3d free_change = end.ChangeWith(Eigen::Vector3d::Zero());
  const double free_stretch = stretch(free_change);
  if (!(free_stretch > 0)) return 0;
  // One step of Newton's method, then secants, in a bracket once there is one. But for the body's turn the
  // stretch is convex, so both come to the first zero from below, and not to the second, where the body has
  // passed to the string's other side.
  const Eigen::Vector3d mobility = end.Mobility() * inward;
  const Eigen::Vector3d per_impulse = end.time * mobility;
  double slope = -(end.offset + free_change).dot(per_impulse) / length;
  if (!(slope > 0)) slope = inward.dot(per_impulse);
  // What rounding of the end's way leaves of its part along the string.
  const double enough =
      2 * std::numeric_limits<double>::epsilon() * std::max(free_stretch, free_change.norm());
  double low = 0;
  double high = std::numeric_limits<double>::infinity();
  double before = low;
  double at_before = free_stretch;
  double impulse = free_stretch / slope;
  const double most = 4 * impulse;
  double best = 0;
  Eigen::Vector3d best_change = free_change;
  double least = free_stretch;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d change = end.ChangeWith(impulse * inward);
    const double here = stretch(change);
    if (std::abs(here) < least) {
      least = std::abs(here);
      best = impulse;
      best_change = change;
    }
    if (least <= enough || impulse == before || impulse > most) break;
    if (here > 0) {
      low = impulse;
    } else {
      high = impulse;
    }
    double next = impulse - here * (impulse - before) / (here - at_before);
    if (!(next > low && next < high)) next = std::isinf(high) ? 2 * impulse : 0.5 * (low + high);
    before = impulse;
    at_before = here;
    impulse = next;
  }
  // A step that moves the end by much of the string's length or far from straight is no longer the equation
  // of motion's: its impulse may throw the body inward and give it energy. Then, and where none does it, the
  // string takes the motion outward, which costs energy, and stays a little too long.
  const Eigen::Vector3d velocity = end.Velocity();
  const double outward_speed = -inward.dot(velocity);
  const double response = inward.dot(mobility);
  const double straight = end.time * velocity.norm();
  const double bent = (best_change - end.time * velocity - best * per_impulse).norm();
  const bool resolved = straight <= kResolved * length && bent <= kResolved * straight;
  const bool gains = best * response > 2 * outward_speed;
  if (least <= kSolved * length && best <= most && (resolved || !gains)) return best;
  return std::max(0.0, outward_speed / response);
}

}  // namespace

Eigen::Vector3d RigidBody::Spin() const {
  return lab_from_body * angular_momentum_in_body.cwiseQuotient(inertia);
}

Eigen::Isometry3d RigidBody::Pose() const {
  Eigen::Isometry3d pose(lab_from_body);
  pose.translation() = position;
  return pose;
}

void DriftBody(RigidBody& body, double time) {
  body.position += time * body.velocity;
  const Eigen::Quaterniond turn = FreeTurn(body.inertia, time, body.angular_momentum_in_body);
  body.lab_from_body = (body.lab_from_body * turn).normalized();
}

void KickBody(RigidBody& body, double time, const Eigen::Vector3d& force, const Eigen::Vector3d& torque) {
  body.velocity += time / body.mass * force;
  body.angular_momentum_in_body += time * (body.lab_from_body.conjugate() * torque);
}

double KickOnString(RigidBody& body, const BodyString& string, double time, const Eigen::Vector3d& force,
                    const Eigen::Vector3d& torque) {
  KickBody(body, time, force, torque);
  const Eigen::Matrix3d lab_from_body = body.lab_from_body.toRotationMatrix();
  StringEnd end{body, time, string.to_in_body, lab_from_body,
                body.position - string.from + lab_from_body * string.to_in_body};
  const double rounding = RoundingOf(body, string);
  Eigen::Vector3d impulse;
  if (string.length > 0) {
    // A string whose ends lie on each other has the direction in which they part.
    const Eigen::Vector3d outward =
        end.offset.norm() > rounding ? end.offset : end.ChangeWith(Eigen::Vector3d::Zero());
    const double apart = outward.norm();
    if (!(apart > 0)) return 0;
    const Eigen::Vector3d inward = -outward / apart;
    impulse = TautImpulse(end, inward, string.length, rounding) * inward;
  } else {
    impulse = JointImpulse(end, rounding);
  }
  body.angular_momentum_in_body = end.MomentumWith(impulse);
  body.velocity += impulse / body.mass;
  return impulse.norm() / time;
}

}  // namespace tendril
