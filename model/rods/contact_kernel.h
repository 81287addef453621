#pragma once
// What the kernels of contact_list.cpp are given; compiled once per instruction set (contact_body.h).
//
// Nodes stand in two layouts. Side by side: [node][component][8 rods], as rod_lanes.h has them, where an
// element is known by the place of its first node's x. In a row: rods one after the other, each with padding
// of a node before and ten behind it, a rod's node i and element i at the same place. In both, padding nodes
// repeat the rod's end; in a row, padding elements have a radius of NaN and so are near nothing.

namespace tendril::contact_kernel {

enum Law { kSegments, kEqual, kCenters };

// Up to eight rods side by side that have moved.
struct Move {
  int nodes, rods;
  const double* from;       // where nodes are now
  double* at;               // where they were; taken from `from`, and padding with them
  const double* reference;  // where they were when pairs were last chosen
  const double* allowed;    // [node][8]: square of how far from there they may go
  // [element][8]: square of how much an element's edge may change from there.
  const double* edge_allowed;
  // Out, added to what is there.
  double farthest;  // square of the farthest that a node went just now
  double sum;       // of these squares: not finite where a node is not
  bool left;        // a node or edge is farther from its reference than it may go
};

// All elements in a row, and which of them are near each other.
struct Row {
  Law law;
  int size;  // places that Measure looks at: the rods'; bodies stand behind them and stay as they are
  const double *x, *y, *z;
  const double* rest_radius;
  const double* rest_length;
  const double *allowed, *edge_allowed;             // as in Move
  const double *old_x, *old_y, *old_z, *old_reach;  // centres and reach when the list of neighbours was made
  // Of elements, by Measure. Until pairs are chosen anew, no node of the element may go farther than `drift`,
  // nor its edge or those beside it change by more than `turn`. Until then:
  double *center_x, *center_y, *center_z, *inverse_square;  // now; 1 / length^2
  double *drift, *turn;
  double* span;   // length, of the longest of this element and those beside it, now
  double* fat;    // radius, at most, plus drift
  double* bound;  // the element lies nearer than this to its present centre
  double
      strayed;  // out: the most that an element may come to lie outside its old reach, m; above 0: remake it
  // Neighbours: elements against runs of eight elements.
  int from, to;        // those to look at now: entries of `element`
  const int* element;  // place
  const int* first;    // in runs, elements + 1
  const int* runs;     // place of the first of eight
  // Pairs that may press on each other until pairs are chosen anew, by Choose; added to.
  int pairs;
  int *one, *other;  // places
};

// What does not change about a pair, eight pairs at a time: [pair / 8][Constant][pair % 8].
enum Constant {
  kOneRadius,  // at rest; of a body: as it is
  kOneLength,  // at rest
  kOneStart,   // 1 / the elements that share the start node
  kOneEnd,     // and the end node
  kOneRule,    // force on the end node, where the law shares by rule
  kOtherRadius,
  kOtherLength,
  kOtherStart,
  kOtherEnd,
  kOtherRule,
  kConstants
};

struct Touch {
  Law law;
  double stiffness, damping;
  int rod_pairs, pairs;    // pairs of rods, then of bodies with rods; whole eights
  const int *one, *other;  // places side by side
  const double* constants;
  const double* at;        // nodes side by side
  const double* velocity;  // null: no damping
  double* force;           // added to
  // Out.
  double least_distance;  // between axes of what presses, m
  double least_share;     // and as a share of the radii's sum
};

struct Kernels {
  void (*move)(Move&);
  void (*measure)(Row&);
  void (*choose)(Row&, bool bodies);
  void (*touch)(Touch&);
  // Arrays' whole eights.
  void (*clear)(double* to, int eights);
  void (*add)(double* to, const double* more, int eights);
};

Kernels BaseKernels();
Kernels Avx2Kernels();
Kernels Avx512Kernels();
// Of RodKernelWidth().
Kernels KernelsOfThisMachine();

}  // namespace tendril::contact_kernel
