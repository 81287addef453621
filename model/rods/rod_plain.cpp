#include "model/rods/rod_plain.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "model/geometry/rotation.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

// c in the inverse Jacobian of the rotation vector, I +- [v] / 2 + c [v]^2: 1/theta^2 - cot(theta/2) /
// (2 theta).
double InverseJacobianFactor(double theta) {
  if (theta < 1e-2) return 1.0 / 12 + theta * theta / 720 + theta * theta * theta * theta / 30240;
  return (1 - 0.5 * theta / std::tan(0.5 * theta)) / (theta * theta);
}

void AddShear(const Rod& rod, RodForm form, Matrix3Xd& force, Matrix3Xd& couple) {
  for (Index i = 0; i < rod.elements(); ++i) {
    const Eigen::Matrix3d& q = rod.directors[static_cast<std::size_t>(i)];
    const Vector3d edge = rod.position.col(i + 1) - rod.position.col(i);
    const double stretch = edge.norm() / rod.rest_length[i];
    const Vector3d along = q * edge / rod.rest_length[i];  // e Q t
    const Vector3d strain = along - Vector3d::UnitZ() - rod.rest_strain.col(i);
    const Vector3d stress = rod.shear_stiffness.col(i).cwiseProduct(strain);
    const double dilatation = form == RodForm::kPaper ? 1 / stretch : 1.0;
    const Vector3d pull = dilatation * (q.transpose() * stress);
    force.col(i) += pull;
    force.col(i + 1) -= pull;
    couple.col(i) += dilatation * rod.rest_length[i] * along.cross(stress);
  }
}

// Couples of bend and twist between two frames that are `rest` apart: on the first, and on the second.
struct BendCouples {
  Vector3d before, behind;
};

BendCouples CouplesOf(const Vector3d& curvature, const Vector3d& rest_curvature, const Vector3d& stiffness,
                      double rest) {
  const Vector3d turning = rest * curvature;
  const Vector3d moment = stiffness.cwiseProduct(Vector3d(curvature - rest_curvature));
  const Vector3d half = 0.5 * turning.cross(moment);
  const Vector3d rest_of_it =
      InverseJacobianFactor(turning.norm()) * turning.cross(Vector3d(turning.cross(moment)));
  return {moment + half + rest_of_it, half - moment - rest_of_it};
}

void AddBend(const Rod& rod, RodForm form, Matrix3Xd& couple) {
  for (Index i = 0; i + 1 < rod.elements(); ++i) {
    const double rest = RestVoronoi(rod, i);
    const Vector3d curvature = CurvatureOf(rod, i);
    if (form == RodForm::kPaper) {
      const Vector3d moment =
          rod.bend_stiffness.col(i).cwiseProduct(Vector3d(curvature - rod.rest_curvature.col(i)));
      const double present = 0.5 * ((rod.position.col(i + 1) - rod.position.col(i)).norm() +
                                    (rod.position.col(i + 2) - rod.position.col(i + 1)).norm());
      const double share = std::pow(rest / present, 3);
      const Vector3d half = 0.5 * share * rest * curvature.cross(moment);
      couple.col(i) += share * moment + half;
      couple.col(i + 1) += half - share * moment;
      continue;
    }
    const BendCouples pair = CouplesOf(curvature, rod.rest_curvature.col(i), rod.bend_stiffness.col(i), rest);
    couple.col(i) += pair.before;
    couple.col(i + 1) += pair.behind;
  }
  const Index last = rod.elements() - 1;
  if (rod.base.hold == EndHold::kFrame) {
    couple.col(0) += CouplesOf(BaseCurvature(rod), rod.base.rest_curvature, rod.base.bend_stiffness,
                               0.5 * rod.rest_length[0])
                         .behind;
  }
  if (rod.tip.hold == EndHold::kFrame) {
    couple.col(last) += CouplesOf(TipCurvature(rod), rod.tip.rest_curvature, rod.tip.bend_stiffness,
                                  0.5 * rod.rest_length[last])
                            .before;
  }
}

// The paper's terms in the spin: (J w / e) x w, and that of an element that is being stretched.
void AddSpinTerms(const Rod& rod, Matrix3Xd& couple) {
  for (Index i = 0; i < rod.elements(); ++i) {
    const Vector3d spin = rod.spin.col(i);
    const Vector3d edge = rod.position.col(i + 1) - rod.position.col(i);
    const Vector3d apart = rod.velocity.col(i + 1) - rod.velocity.col(i);
    const double length = edge.norm();
    const Vector3d momentum = rod.rest_length[i] / length * rod.inertia.col(i).cwiseProduct(spin);
    couple.col(i) += momentum.cross(spin) + momentum * edge.dot(apart) / (length * length);
  }
}

// An element turning freely, exactly: a symmetric top. Its angular momentum stands still in the lab and goes
// round d3 in the element's axes.
void TurnFreely(Eigen::Matrix3d& q, Eigen::Ref<Vector3d> spin, const Vector3d& inertia, double time) {
  const double around = spin.z() * (1 - inertia.z() / inertia.x());
  const Eigen::Matrix3d about_d3 = ExpSo3(Vector3d(0, 0, -around * time));
  const Vector3d momentum_rate(spin.x(), spin.y(), spin.z() - around);  // L / J1
  q = about_d3 * ExpSo3(-time * momentum_rate) * q;
  spin = about_d3 * spin;
}

}  // namespace

void InternalLoads(const Rod& rod, RodForm form, Matrix3Xd& force, Matrix3Xd& couple) {
  force.setZero(3, rod.elements() + 1);
  couple.setZero(3, rod.elements());
  AddShear(rod, form, force, couple);
  AddBend(rod, form, couple);
  if (form == RodForm::kPaper) AddSpinTerms(rod, couple);
}

DampedKick KickOf(RodForm form, double time_step, double damping) {
  const double keep = std::exp(-damping * time_step);
  if (form == RodForm::kPaper) return {keep, keep * time_step};
  return {keep, damping > 0 ? -std::expm1(-damping * time_step) / damping : time_step};
}

void DriftPlain(Rod& rod, RodForm form, double time) {
  const Index last = rod.elements();
  const Vector3d base = rod.position.col(0), tip = rod.position.col(last);
  const Eigen::Matrix3d base_frame = rod.directors.front(), tip_frame = rod.directors.back();
  rod.position += time * rod.velocity;
  for (Index i = 0; i < last; ++i) {
    Eigen::Matrix3d& q = rod.directors[static_cast<std::size_t>(i)];
    if (form == RodForm::kPaper) {
      q = ExpSo3(-time * rod.spin.col(i)) * q;
    } else {
      TurnFreely(q, rod.spin.col(i), rod.inertia.col(i), time);
    }
  }
  if (rod.base.hold != EndHold::kFree) rod.position.col(0) = base;
  if (rod.base.hold == EndHold::kElement) rod.directors.front() = base_frame;
  if (rod.tip.hold != EndHold::kFree) rod.position.col(last) = tip;
  if (rod.tip.hold == EndHold::kElement) rod.directors.back() = tip_frame;
}

void KickPlain(Rod& rod, const PlainOptions& options, const Matrix3Xd& outside,
               const Matrix3Xd& outside_couples) {
  const Index last = rod.elements();
  Matrix3Xd force, couple;
  InternalLoads(rod, options.form, force, couple);
  force += outside;
  couple.col(last - 1) += rod.tip_couple;
  for (Index i = 0; i < outside_couples.cols(); ++i) {
    couple.col(i) += rod.directors[static_cast<std::size_t>(i)] * outside_couples.col(i);
  }
  const DampedKick kick = KickOf(options.form, options.time_step, options.damping);
  const bool in_medium = options.medium != nullptr && options.medium->density > 0;
  WettedNodes nodes;
  if (in_medium) nodes = WettedNodesOf(rod, *options.medium, options.wetted);
  for (Index i = 0; i < rod.mass.size(); ++i) {
    if (in_medium) {
      const Vector3d edge =
          rod.position.col(std::min(i + 1, last)) - rod.position.col(std::max<Index>(i - 1, 0));
      rod.velocity.col(i) = KickInMedium(nodes, i, options.medium->flow, kick.keep, kick.gain, edge,
                                         rod.velocity.col(i), force.col(i), options.gravity, 1 / rod.mass[i]);
      continue;
    }
    rod.velocity.col(i) =
        kick.keep * rod.velocity.col(i) + kick.gain * (force.col(i) / rod.mass[i] + options.gravity);
  }
  for (Index i = 0; i < rod.elements(); ++i) {
    double stretch = 1;
    if (options.form == RodForm::kPaper) {
      stretch = (rod.position.col(i + 1) - rod.position.col(i)).norm() / rod.rest_length[i];
    }
    rod.spin.col(i) =
        kick.keep * rod.spin.col(i) + kick.gain * stretch * couple.col(i).cwiseQuotient(rod.inertia.col(i));
  }
  if (rod.base.hold != EndHold::kFree) rod.velocity.col(0).setZero();
  if (rod.base.hold == EndHold::kElement) rod.spin.col(0).setZero();
  if (rod.tip.hold != EndHold::kFree) rod.velocity.col(last).setZero();
  if (rod.tip.hold == EndHold::kElement) rod.spin.col(last - 1).setZero();
}

void StepPlain(std::span<Rod> rods, double time, const PlainOptions& options, const MiddleOfStep& at_middle) {
  for (Rod& rod : rods) DriftPlain(rod, options.form, 0.5 * options.time_step);
  std::vector<Matrix3Xd> outside(rods.size());
  for (std::size_t r = 0; r < rods.size(); ++r) outside[r].setZero(3, rods[r].elements() + 1);
  if (at_middle) at_middle(time + 0.5 * options.time_step, rods, outside);
  for (std::size_t r = 0; r < rods.size(); ++r) {
    KickPlain(rods[r], options, outside[r]);
    DriftPlain(rods[r], options.form, 0.5 * options.time_step);
  }
}

}  // namespace tendril
