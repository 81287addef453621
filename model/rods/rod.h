#pragma once
// A Cosserat rod after Gazzola et al. 2018: its nodes, elements and what they are made of, and its energy.
//
// SI units. N elements join N+1 nodes; N-1 inner nodes carry the curvature between two elements. An
// element's directors are the rows of Q: d1 (normal), d2 = d3 x d1, d3 (along the rod); v_body = Q v_lab.
// Strains, curvatures, stiffnesses, spins and couples are in the elements' own axes (d1, d2, d3), the rest in
// the lab's.

#include <Eigen/Core>
#include <vector>

#include "model/geometry/framed_curve.h"
#include "model/result.h"

namespace tendril {

// How an end is held.
enum class EndHold {
  kFree,
  // The end node and the directors of the end element, as published. The directors sit half an element from
  // the end, so half an element does not bend: first order in its length.
  kElement,
  // The end node and the directors at the very end; between these and the end element's half an element
  // bends and twists: second order.
  kFrame,
};

struct RodDesign {
  Eigen::Vector3d start = Eigen::Vector3d::Zero();       // node 0, m
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  // d3 of the straight rod; any length
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX();     // d1; made perpendicular to the direction
  double length = 0.750;                                 // m
  double base_radius = 0.020;                            // m
  double taper = 1;                                      // tip radius / base radius, linear between
  double density = 100;                                  // kg/m^3
  double youngs_modulus = 1e5;                           // Pa
  double shear_modulus = 1e5 / 3;                        // Pa
  double shear_factor = 27.0 / 28.0;
  int elements = 100;
  EndHold base = EndHold::kElement;
  EndHold tip = EndHold::kFree;
  Eigen::Vector3d start_curvature = Eigen::Vector3d::Zero();  // of the shape at the start, 1/m
  // Instead, where it differs along the rod: of the half element at the base, then at the inner nodes, 1/m.
  Eigen::Matrix3Xd start_curvatures = {};  // (3, elements); empty: start_curvature everywhere
};

// An end of a rod: node 0 or node N, whose position the state holds.
struct RodEnd {
  EndHold hold = EndHold::kFree;
  // With kFrame: the directors there, and the half element that joins them to the end element's.
  Eigen::Matrix3d frame = Eigen::Matrix3d::Identity();
  Eigen::Vector3d bend_stiffness = Eigen::Vector3d::Zero();  // E I1, E I2, G I3, N m^2
  Eigen::Vector3d rest_curvature = Eigen::Vector3d::Zero();  // kappa^0, 1/m
};

struct Rod {
  // Made once.
  Eigen::VectorXd rest_length;       // of elements, m                                     (N)
  Eigen::VectorXd radius;            // of unstretched elements, m                         (N)
  Eigen::VectorXd mass;              // of nodes, kg                                       (N+1)
  Eigen::Matrix3Xd inertia;          // of elements about d1, d2, d3, kg m^2               (3, N)
  Eigen::Matrix3Xd shear_stiffness;  // alpha_c G A, alpha_c G A, E A; N                   (3, N)
  Eigen::Matrix3Xd bend_stiffness;   // E I1, E I2, G I3 at inner nodes, N m^2             (3, N-1)
  RodEnd base, tip;
  // Set from outside, at any time.
  Eigen::Matrix3Xd rest_strain;     // sigma^0                                             (3, N)
  Eigen::Matrix3Xd rest_curvature;  // kappa^0, 1/m                                        (3, N-1)
  Eigen::Vector3d tip_couple = Eigen::Vector3d::Zero();  // from outside on the last element, in its axes, N m
  // The state.
  Eigen::Matrix3Xd position;               // m                                           (3, N+1)
  Eigen::Matrix3Xd velocity;               // m/s                                         (3, N+1)
  std::vector<Eigen::Matrix3d> directors;  // Q                                           (N)
  Eigen::Matrix3Xd spin;                   // rad/s, in the element's axes                (3, N)

  Eigen::Index elements() const { return rest_length.size(); }
};

// A rod at rest, curved as its design says, whose strains and rest curvatures are all 0.
//   errors  kBadInput  a value out of its range, or a normal along the direction (names it)
Result<Rod> MakeRod(const RodDesign& design);

// Half the sum of the neighbours' rest lengths at inner node i (0 .. N-2), m.
double RestVoronoi(const Rod& rod, Eigen::Index i);

// sigma = Q (x_{i+1} - x_i) / l_rest - d3: shears along d1 and d2, stretch along d3.
Eigen::Vector3d StrainOf(const Rod& rod, Eigen::Index element);

// kappa = -vee(log(Q_{i+1} Q_i^T)) / D_rest at inner node i, 1/m.
Eigen::Vector3d CurvatureOf(const Rod& rod, Eigen::Index inner_node);

// The same over the half element at a held end (kFrame), whose length is half the end element's.
Eigen::Vector3d BaseCurvature(const Rod& rod);
Eigen::Vector3d TipCurvature(const Rod& rod);

// Nodes, and at each the mean of its elements' d1, made perpendicular to the mean of their d3.
FramedCurve CurveOf(const Rod& rod);

struct RodEnergy {
  double translation = 0, rotation = 0, bend = 0, shear = 0;  // J
  double total() const { return translation + rotation + bend + shear; }
};
RodEnergy EnergyOf(const Rod& rod);

}  // namespace tendril
