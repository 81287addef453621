#include "model/rods/rod_static.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "model/geometry/rotation.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

Matrix3d Hat(const Vector3d& v) {
  Matrix3d hat;
  hat << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return hat;
}

// c in the inverse Jacobian of the rotation vector, and its derivative by t / t.
struct JacobianFactor {
  double value, slope;
};
JacobianFactor FactorOf(double t) {
  const double y = t * t;
  if (t < 0.05) {
    return {1.0 / 12 + y * (1.0 / 720 + y * (1.0 / 30240 + y / 1209600)),
            1.0 / 360 + y * (1.0 / 7560 + y / 201600)};
  }
  const double half = 0.5 * t, cotangent = half / std::tan(half), sine = std::sin(half);
  const double value = (1 - cotangent) / y;
  // d(cotangent)/dt = cotangent / t - t / (4 sin^2)
  const double turn = cotangent / t - t / (4 * sine * sine);
  return {value, (-turn / y - 2 * value / t) / t};
}

// One hinge between two frames: the energy of a turning v, and couple and stiffness on either side.
struct Hinge {
  double energy;
  Vector3d before, behind;                                              // couples
  Matrix3d before_before, before_behind, behind_before, behind_behind;  // their derivatives by theta
};

Hinge HingeOf(const Matrix3d& before, const Matrix3d& behind, const Vector3d& stiffness, const Vector3d& rest,
              double length) {
  const Vector3d v = -LogSo3(Matrix3d(behind * before.transpose()));
  const Vector3d off = v / length - rest;
  const Vector3d m = stiffness.cwiseProduct(off);
  Hinge hinge;
  hinge.energy = 0.5 * length * off.dot(m);
  const JacobianFactor c = FactorOf(v.norm());
  const Vector3d across = v.cross(m), twice = v.cross(across);
  hinge.before = m + 0.5 * across + c.value * twice;
  hinge.behind = 0.5 * across - m - c.value * twice;
  const Matrix3d by = (stiffness / length).asDiagonal();
  const Matrix3d hat = Hat(v), hat_m = Hat(m);
  const Matrix3d of_across = hat * by - hat_m;
  const Matrix3d of_twice = hat * of_across - Hat(across);
  const Matrix3d odd = 0.5 * of_across;
  const Matrix3d even = by + c.value * of_twice + c.slope * twice * v.transpose();
  const Matrix3d square = hat * hat;
  const Matrix3d left = Matrix3d::Identity() - 0.5 * hat + c.value * square;
  const Matrix3d right = Matrix3d::Identity() + 0.5 * hat + c.value * square;
  hinge.before_before = (odd + even) * -left;
  hinge.before_behind = (odd + even) * right;
  hinge.behind_before = (odd - even) * -left;
  hinge.behind_behind = (odd - even) * right;
  return hinge;
}

// As a share of what bending makes: curvature of the energy that counts as none, not as falling.
constexpr double kNeutral = 1e-9;

class Settler {
 public:
  Settler(Rod& rod, const Eigen::Ref<const Matrix3Xd>& force)
      : rod_(rod), n_(rod.elements()), carried_(3, n_) {
    Vector3d sum = Vector3d::Zero();
    for (Index i = n_; i-- > 0;) {
      sum += force.col(i + 1);
      carried_.col(i) = sum;
    }
    scale_ = rod.bend_stiffness.maxCoeff() / rod.rest_length.sum();
    hinge_ = rod.bend_stiffness.maxCoeff() / rod.rest_length.mean();
    // Below it, rounding of the couples of hinges.
    enough_ = kStaticResidual + 1e-15 * static_cast<double>(n_ * n_);
    gradient_.resize(3, n_);
    diagonal_.resize(static_cast<std::size_t>(n_));
    above_.resize(static_cast<std::size_t>(n_));
    below_.resize(static_cast<std::size_t>(n_));
    conservative_ = rod.tip_couple.isZero(0);
    bends_at_base_ = rod.base.hold == EndHold::kFrame;
    turn_.resize(3, n_);
  }

  Result<StaticAccount> Run() {
    StaticAccount account;
    double damping = 0;
    double energy = Assemble(rod_.directors, true);
    for (; account.iterations < 200; ++account.iterations) {
      account.residual = gradient_.colwise().norm().sum() / scale_;
      if (account.residual <= enough_) {
        if (!conservative_ || Solve(kNeutral * hinge_)) return account;
        LeaveSaddle();
        energy = Assemble(rod_.directors, true);
        continue;
      }
      if (!std::isfinite(account.residual)) break;
      if (!(conservative_ ? Solve(damping) : SolveAsItIs())) {
        damping = std::max(4 * damping, 1e-4 * hinge_);
        continue;
      }
      // An element turns by 0.6 rad at most, so that no hinge comes near half a turn unseen.
      const double largest = turn_.colwise().norm().maxCoeff();
      if (largest > 0.6) turn_ *= 0.6 / largest;
      std::vector<Matrix3d> next = Turned();
      const double reached = Assemble(next, false);
      // Rounding of the energy is no reason to turn back near the end.
      const double rounding = 1e-13 * (std::abs(energy) + std::abs(reached));
      if (conservative_ && !(reached <= energy + rounding)) {
        damping = std::max(4 * damping, 1e-4 * hinge_);
        continue;
      }
      rod_.directors = std::move(next);
      damping = damping < 1e-6 * hinge_ ? 0 : damping / 8;
      energy = Assemble(rod_.directors, true);
    }
    return Error{ErrorKind::kUnreachable, "no equilibrium: couples are left, after " +
                                              std::to_string(account.iterations) + " iterations"};
  }

  // Nodes from directors and forces.
  void PlaceNodes() {
    for (Index i = 0; i < n_; ++i) {
      const Matrix3d& q = rod_.directors[static_cast<std::size_t>(i)];
      rod_.position.col(i + 1) = rod_.position.col(i) + rod_.rest_length[i] * (q.transpose() * Along(q, i));
    }
    rod_.velocity.setZero();
    rod_.spin.setZero();
  }

 private:
  std::vector<Matrix3d> Turned() const {
    std::vector<Matrix3d> next = rod_.directors;
    for (Index i = 0; i < n_; ++i) {
      Matrix3d& q = next[static_cast<std::size_t>(i)];
      q = ExpSo3(-turn_.col(i)) * q;
    }
    return next;
  }

  // Where nothing pulls but the energy falls to some side, as of a column beyond Euler's load: a small turn
  // to that side, by what little pull there is, or else about d1.
  void LeaveSaddle() {
    if (gradient_.isZero(0)) gradient_.row(0).setConstant(kStaticResidual * scale_ / static_cast<double>(n_));
    if (!bends_at_base_) gradient_.col(0).setZero();
    double damping = kNeutral * hinge_;
    while (!Solve(damping) && damping < 1e6 * hinge_) damping *= 2;
    turn_ *= 0.01 / turn_.colwise().norm().maxCoeff();
    rod_.directors = Turned();
  }

  // e Q t: what an element's edge is in its axes, per rest length.
  Vector3d Along(const Matrix3d& q, Index i) const {
    const Vector3d stress = q * carried_.col(i);
    return Vector3d::UnitZ() + rod_.rest_strain.col(i) + stress.cwiseQuotient(rod_.shear_stiffness.col(i));
  }

  // The energy; with `slopes` also its gradient and second derivatives by each element's turning.
  double Assemble(const std::vector<Matrix3d>& q, bool slopes) {
    double energy = 0;
    if (slopes) gradient_.setZero();
    for (Index i = 0; i < n_; ++i) {
      const auto e = static_cast<std::size_t>(i);
      const double l = rod_.rest_length[i];
      const Vector3d w = q[e] * carried_.col(i);
      const Vector3d compliance = rod_.shear_stiffness.col(i).cwiseInverse();
      const Vector3d x = Along(q[e], i);
      energy -= l * w.dot(x - 0.5 * compliance.cwiseProduct(w));
      if (!slopes) continue;
      gradient_.col(i) -= l * x.cross(w);
      const Matrix3d hat = Hat(w);
      diagonal_[e] = -l * (Hat(x) - hat * compliance.asDiagonal()) * hat;
      if (i == n_ - 1) gradient_.col(i) -= rod_.tip_couple;
    }
    for (Index i = -1; i + 1 < n_; ++i) {
      const auto e = static_cast<std::size_t>(i + 1);
      const bool base = i < 0;
      if (base && !bends_at_base_) continue;
      const double length = base ? 0.5 * rod_.rest_length[0] : RestVoronoi(rod_, i);
      const Vector3d stiffness = base ? rod_.base.bend_stiffness : Vector3d(rod_.bend_stiffness.col(i));
      const Vector3d rest = base ? rod_.base.rest_curvature : Vector3d(rod_.rest_curvature.col(i));
      const Hinge hinge = HingeOf(base ? rod_.base.frame : q[e - 1], q[e], stiffness, rest, length);
      energy += hinge.energy;
      if (!slopes) continue;
      gradient_.col(i + 1) -= hinge.behind;
      diagonal_[e] -= hinge.behind_behind;
      if (base) continue;
      gradient_.col(i) -= hinge.before;
      diagonal_[e - 1] -= hinge.before_before;
      // Symmetric at an equilibrium; away from it its symmetric part makes for a descent.
      above_[e - 1] = -hinge.before_behind;
      below_[e - 1] = -hinge.behind_before;
      if (conservative_) above_[e - 1] = 0.5 * (above_[e - 1] + below_[e - 1].transpose());
    }
    if (slopes && !bends_at_base_) {
      gradient_.col(0).setZero();
      diagonal_[0].setIdentity();
      above_[0].setZero();
      below_[0].setZero();
    }
    return energy;
  }

  // Block Cholesky of (H + damping) turn = -gradient. False: not positive definite.
  bool Solve(double damping) {
    std::vector<Matrix3d>& factor = factor_;
    factor.resize(diagonal_.size());
    std::vector<Matrix3d>& across = across_;
    across.resize(diagonal_.size());
    Matrix3d pivot;
    for (std::size_t e = 0; e < diagonal_.size(); ++e) {
      pivot = 0.5 * (diagonal_[e] + diagonal_[e].transpose()) + damping * Matrix3d::Identity();
      if (e > 0) pivot -= across[e - 1] * across[e - 1].transpose();
      const Eigen::LLT<Matrix3d> llt(pivot);
      if (llt.info() != Eigen::Success || !(llt.matrixLLT().diagonal().minCoeff() > 0)) return false;
      factor[e] = llt.matrixL();
      // across = (L^-1 above)^T, rows of the next block.
      across[e] = factor[e].triangularView<Eigen::Lower>().solve(above_[e]).transpose();
    }
    for (Index i = 0; i < n_; ++i) {
      const auto e = static_cast<std::size_t>(i);
      Vector3d b = -gradient_.col(i);
      if (i > 0) b -= across[e - 1] * turn_.col(i - 1);
      turn_.col(i) = factor[e].triangularView<Eigen::Lower>().solve(b);
    }
    for (Index i = n_; i-- > 0;) {
      const auto e = static_cast<std::size_t>(i);
      Vector3d b = turn_.col(i);
      if (i + 1 < n_) b -= across[e].transpose() * turn_.col(i + 1);
      turn_.col(i) = factor[e].transpose().triangularView<Eigen::Upper>().solve(b);
    }
    return true;
  }

  // Newton's step without symmetry, by blocks: a couple that turns with the tip has no energy to descend on.
  bool SolveAsItIs() {
    Matrix3Xd right = -gradient_;
    std::vector<Matrix3d>& pivot = factor_;
    pivot = diagonal_;
    for (Index i = 1; i < n_; ++i) {
      const auto e = static_cast<std::size_t>(i);
      const Matrix3d share = below_[e - 1] * pivot[e - 1].inverse();
      pivot[e] -= share * above_[e - 1];
      right.col(i) -= share * right.col(i - 1);
    }
    for (Index i = n_; i-- > 0;) {
      const auto e = static_cast<std::size_t>(i);
      Vector3d b = right.col(i);
      if (i + 1 < n_) b -= above_[e] * turn_.col(i + 1);
      turn_.col(i) = pivot[e].inverse() * b;
    }
    return turn_.allFinite();
  }

  Rod& rod_;
  Index n_;
  bool conservative_ = true;
  bool bends_at_base_ = true;  // else element 0 does not turn
  Matrix3Xd carried_;          // force of what is beyond, lab
  double scale_;               // B / L, N m: the couple that turns the whole rod by a radian
  double hinge_;               // B / l: and a hinge
  double enough_;              // of the residual
  Matrix3Xd gradient_, turn_;
  std::vector<Matrix3d> diagonal_, above_, below_, factor_, across_;
};

}  // namespace

Result<StaticAccount> SettleRod(Rod& rod, const Eigen::Ref<const Matrix3Xd>& force) {
  if (rod.base.hold == EndHold::kFree || rod.tip.hold != EndHold::kFree) {
    return Error{ErrorKind::kBadInput, "an equilibrium is found where the base is held and the tip is free"};
  }
  if (force.cols() != rod.elements() + 1 || !force.allFinite()) {
    return Error{ErrorKind::kBadInput, "forces: expected a finite one for each node"};
  }
  Settler settler(rod, force);
  Result<StaticAccount> account = settler.Run();
  settler.PlaceNodes();
  return account;
}

}  // namespace tendril
