#pragma once
// What the kernels of contact_list.cpp are given; compiled once per instruction set (contact_body.h).

namespace tendril::contact_kernel {

enum Law { kSegments, kEqual, kCenters };

// Rods one after the other, each with padding of a node before and ten behind it; a rod's node i and element
// i stand at the same place. Padding nodes repeat the rod's end, padding elements have a radius of NaN and
// so touch nothing. Arrays [nodes or elements].
struct Job {
  Law law;
  double stiffness, damping;
  int size;  // places that Prepare looks at: the rods'; bodies stand behind them and stay as they are
  double *x, *y, *z;
  const double *vx, *vy, *vz;     // null: no damping
  double *old_x, *old_y, *old_z;  // where nodes were when Prepare last ran
  const double* rest_radius;
  const double* rest_length;
  const double* node_share;  // of nodes: 1 / the elements that share it
  const double* end_share;   // of elements: force on its end node, where the law shares by rule
  // Of elements, by Prepare; bound: radius + half length; inverse_square: 1 / length^2, 0 for a point.
  double *radius, *bound, *inverse_square, *center_x, *center_y, *center_z;
  double *fx, *fy, *fz;              // on elements' start nodes; added to
  double *end_fx, *end_fy, *end_fz;  // and on their end nodes
  // Elements against runs of eight elements.
  int elements;
  const int* element;  // place
  const int* first;    // in runs, elements + 1
  const int* runs;     // place of the first of eight
  const unsigned char* is_body;
  // Out.
  double moved;           // by Prepare: the farthest that a node went, m
  double least_distance;  // between axes of what touches, m
  double least_share;     // and as a share of the radii's sum
};

using Kernel = void (*)(Job&);

struct Kernels {
  Kernel prepare;  // radii, bounds and centres of the present positions
  Kernel touch;    // forces of all pairs in the list
};

Kernels BaseKernels();
Kernels Avx2Kernels();
Kernels Avx512Kernels();

}  // namespace tendril::contact_kernel
