#include "model/rods/rod.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <string>

#include "model/geometry/rotation.h"

namespace tendril {
namespace {

Status CheckDesign(const RodDesign& design) {
  const auto wrong = [](const char* field, const std::string& value, const char* expected) {
    return Error{ErrorKind::kBadInput, std::string(field) + " = " + value + ": expected " + expected};
  };
  const struct {
    const char* field;
    double value;
  } positive[] = {{"length", design.length},
                  {"base_radius", design.base_radius},
                  {"density", design.density},
                  {"youngs_modulus", design.youngs_modulus},
                  {"shear_modulus", design.shear_modulus},
                  {"shear_factor", design.shear_factor},
                  {"taper", design.taper}};
  for (const auto& [field, value] : positive) {
    if (!(value > 0) || !std::isfinite(value)) {
      return wrong(field, std::to_string(value), "a finite number above 0");
    }
  }
  if (design.elements < 2) return wrong("elements", std::to_string(design.elements), "2 or more");
  if (!design.start_curvature.allFinite()) {
    return wrong("start_curvature", "not finite", "three finite numbers, 1/m");
  }
  const Eigen::Index curvatures = design.start_curvatures.cols();
  if ((curvatures != 0 && curvatures != design.elements) || !design.start_curvatures.allFinite()) {
    return wrong("start_curvatures", std::to_string(curvatures) + " columns",
                 "none, or a finite one for each element");
  }
  if (!design.start.allFinite()) return wrong("start", "not finite", "three finite numbers");
  const double along = design.direction.norm();
  if (!(along > 0) || !std::isfinite(along)) {
    return wrong("direction", "of no length", "three finite numbers, not all 0");
  }
  const double across = design.direction.cross(design.normal).norm();
  if (!(across > 1e-9 * along * design.normal.norm()) || !std::isfinite(across)) {
    return wrong("normal", "along the direction", "a vector that is not parallel to it");
  }
  return Ok{};
}

// Turns directors and lays nodes by a curvature that differs along the rod; the tip's half element is
// straight.
void Curve(const Eigen::Matrix3Xd& curvatures, Rod& rod) {
  Eigen::Matrix3d at = rod.base.frame;
  for (Eigen::Index i = 0; i < rod.elements(); ++i) {
    const double length = i == 0 ? 0.5 * rod.rest_length[0] : RestVoronoi(rod, i - 1);
    at = ExpSo3(-length * curvatures.col(i)) * at;
    rod.directors[static_cast<std::size_t>(i)] = at;
    rod.position.col(i + 1) = rod.position.col(i) + rod.rest_length[i] * at.row(2).transpose();
  }
  rod.tip.frame = at;
}

}  // namespace

Result<Rod> MakeRod(const RodDesign& design) {
  if (Status s = CheckDesign(design); !s.ok()) return s.error();
  const Eigen::Index n = design.elements;
  const double element = design.length / static_cast<double>(n);
  Rod rod;
  rod.rest_length.setConstant(n, element);
  rod.radius.resize(n);
  rod.mass.setZero(n + 1);
  rod.inertia.resize(3, n);
  rod.shear_stiffness.resize(3, n);
  Eigen::Matrix3Xd bend(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double r = design.base_radius *
                     (1 - (1 - design.taper) * (static_cast<double>(i) + 0.5) / static_cast<double>(n));
    const double area = std::numbers::pi * r * r;
    const Eigen::Vector3d second_moment = area * area / (4 * std::numbers::pi) * Eigen::Vector3d(1, 1, 2);
    rod.radius[i] = r;
    rod.mass[i] += 0.5 * design.density * area * element;
    rod.mass[i + 1] += 0.5 * design.density * area * element;
    rod.inertia.col(i) = design.density * element * second_moment;
    const double shear = design.shear_factor * design.shear_modulus * area;
    rod.shear_stiffness.col(i) << shear, shear, design.youngs_modulus * area;
    const Eigen::Vector3d modulus(design.youngs_modulus, design.youngs_modulus, design.shear_modulus);
    bend.col(i) = modulus.cwiseProduct(second_moment);
  }
  // Elements are equally long: the mean by length is the plain one. Half an element on from an end.
  const auto end_bend = [&](double radius, Eigen::Index at) {
    const double area = std::numbers::pi * radius * radius;
    const Eigen::Vector3d second_moment = area * area / (4 * std::numbers::pi) * Eigen::Vector3d(1, 1, 2);
    const Eigen::Vector3d modulus(design.youngs_modulus, design.youngs_modulus, design.shear_modulus);
    return Eigen::Vector3d(0.5 * (bend.col(at) + modulus.cwiseProduct(second_moment)));
  };
  rod.base.hold = design.base;
  rod.base.bend_stiffness = end_bend(design.base_radius, 0);
  rod.tip.hold = design.tip;
  rod.tip.bend_stiffness = end_bend(design.base_radius * design.taper, n - 1);
  rod.bend_stiffness = 0.5 * (bend.leftCols(n - 1) + bend.rightCols(n - 1));
  rod.rest_strain.setZero(3, n);
  rod.rest_curvature.setZero(3, n - 1);

  const Eigen::Vector3d d3 = design.direction.normalized();
  const Eigen::Vector3d d1 = (design.normal - design.normal.dot(d3) * d3).normalized();
  Eigen::Matrix3d q;
  q << d1.transpose(), d3.cross(d1).transpose(), d3.transpose();
  rod.directors.resize(static_cast<std::size_t>(n));
  rod.position.resize(3, n + 1);
  rod.position.col(0) = design.start;
  rod.base.frame = q;
  const bool straight = design.start_curvature.isZero(0);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double middle = (static_cast<double>(i) + 0.5) * element;
    // From each director to the next by a rotation vector of their own axes, -kappa D (docs/rods.md).
    const Eigen::Matrix3d at = straight ? q : Eigen::Matrix3d(ExpSo3(-middle * design.start_curvature) * q);
    rod.directors[static_cast<std::size_t>(i)] = at;
    const double along = static_cast<double>(i + 1) / static_cast<double>(n);
    if (straight) {
      rod.position.col(i + 1) = design.start + design.length * along * d3;
    } else {
      rod.position.col(i + 1) = rod.position.col(i) + element * at.row(2).transpose();
    }
  }
  rod.tip.frame = straight ? q : Eigen::Matrix3d(ExpSo3(-design.length * design.start_curvature) * q);
  if (design.start_curvatures.cols() > 0) Curve(design.start_curvatures, rod);
  rod.velocity.setZero(3, n + 1);
  rod.spin.setZero(3, n);
  return rod;
}

double RestVoronoi(const Rod& rod, Eigen::Index i) {
  return 0.5 * (rod.rest_length[i] + rod.rest_length[i + 1]);
}

Eigen::Vector3d StrainOf(const Rod& rod, Eigen::Index element) {
  const Eigen::Vector3d edge = rod.position.col(element + 1) - rod.position.col(element);
  return rod.directors[static_cast<std::size_t>(element)] * edge / rod.rest_length[element] -
         Eigen::Vector3d::UnitZ();
}

Eigen::Vector3d CurvatureOf(const Rod& rod, Eigen::Index inner_node) {
  const auto i = static_cast<std::size_t>(inner_node);
  const Eigen::Matrix3d turn = rod.directors[i + 1] * rod.directors[i].transpose();
  return -LogSo3(turn) / RestVoronoi(rod, inner_node);
}

Eigen::Vector3d BaseCurvature(const Rod& rod) {
  return -LogSo3(rod.directors.front() * rod.base.frame.transpose()) / (0.5 * rod.rest_length[0]);
}

Eigen::Vector3d TipCurvature(const Rod& rod) {
  return -LogSo3(rod.tip.frame * rod.directors.back().transpose()) /
         (0.5 * rod.rest_length[rod.elements() - 1]);
}

FramedCurve CurveOf(const Rod& rod) {
  FramedCurve curve;
  curve.points = rod.position;
  curve.normals.resize(3, rod.position.cols());
  const Eigen::Index last = rod.elements();
  for (Eigen::Index i = 0; i <= last; ++i) {
    const bool at_base = i == 0 && rod.base.hold == EndHold::kFrame;
    const bool at_tip = i == last && rod.tip.hold == EndHold::kFrame;
    const auto before = static_cast<std::size_t>(std::max<Eigen::Index>(i - 1, 0));
    const auto behind = static_cast<std::size_t>(std::min(i, last - 1));
    const Eigen::Matrix3d sum = at_base  ? rod.base.frame
                                : at_tip ? rod.tip.frame
                                         : Eigen::Matrix3d(rod.directors[before] + rod.directors[behind]);
    const Eigen::Vector3d tangent = sum.row(2).normalized(), normal = sum.row(0);
    curve.normals.col(i) = (normal - tangent.dot(normal) * tangent).normalized();
  }
  return curve;
}

RodEnergy EnergyOf(const Rod& rod) {
  RodEnergy energy;
  for (Eigen::Index i = 0; i < rod.mass.size(); ++i) {
    energy.translation += 0.5 * rod.mass[i] * rod.velocity.col(i).squaredNorm();
  }
  for (Eigen::Index i = 0; i < rod.elements(); ++i) {
    energy.rotation += 0.5 * rod.inertia.col(i).dot(rod.spin.col(i).cwiseAbs2());
    const Eigen::Vector3d off = StrainOf(rod, i) - rod.rest_strain.col(i);
    energy.shear += 0.5 * rod.rest_length[i] * rod.shear_stiffness.col(i).dot(off.cwiseAbs2());
  }
  for (Eigen::Index i = 0; i + 1 < rod.elements(); ++i) {
    const Eigen::Vector3d off = CurvatureOf(rod, i) - rod.rest_curvature.col(i);
    energy.bend += 0.5 * RestVoronoi(rod, i) * rod.bend_stiffness.col(i).dot(off.cwiseAbs2());
  }
  const auto half_element = [](const RodEnd& end, const Eigen::Vector3d& curvature, double rest_length) {
    const Eigen::Vector3d off = curvature - end.rest_curvature;
    return 0.25 * rest_length * end.bend_stiffness.dot(off.cwiseAbs2());
  };
  if (rod.base.hold == EndHold::kFrame) {
    energy.bend += half_element(rod.base, BaseCurvature(rod), rod.rest_length[0]);
  }
  if (rod.tip.hold == EndHold::kFrame) {
    energy.bend += half_element(rod.tip, TipCurvature(rod), rod.rest_length[rod.elements() - 1]);
  }
  return energy;
}

}  // namespace tendril
