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
  // Of elements, by Measure. Until pairs are chosen anew, no node of the element may go farther than `drift`.
  // Until then:
  double *center_x, *center_y, *center_z, *inverse_square;  // now; 1 / length^2
  double* drift;
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
  double least_gap;  // of axes, less what their nodes may go: taken down to what is seen, m
};

// What does not change about a pair, eight pairs at a time: [pair / 8][Constant][pair % 8]. Of the published
// laws:
enum Constant {
  kOneRadius,  // at rest; of a body: as it is
  kOneLength,  // at rest
  kOneRule,    // force on the end node
  kOtherRadius,
  kOtherLength,
  kOtherRule,
  kConstants
};
// Of kSegments (press.h):
enum PressConstant {
  kRadii,      // their sum
  kOneWeight,  // factor of half the energy, for each point of the one
  kOtherWeight,
  kOneArm,            // the one's radius as a share of the sum
  kInverseReference,  // 1 / ReferenceStiffness
  kStickStiffness,
  kPressConstants
};
// Of an element on a solid:
enum SolidConstant { kSolidRadius, kSolidStiffness, kSolidStick, kSolidInverseReference, kSolidConstants };
// Of what sticks, likewise: its stretch, 3, and whether it slides.
constexpr int kSpring = 4;

struct Sliding {
  double kinetic, at_rest;  // mu
  double time_step;
};

// Of chosen pairs those of which a point may come within both radii of the other's axis (press.h) before axes
// have come nearer to each other by `margin`.
struct Narrow {
  int points;
  double margin;           // m
  int pairs;               // whole eights
  const int *one, *other;  // places side by side
  const double* constants;
  const double* at;  // nodes side by side
  // Out.
  int found;
  int* slots;  // which of the pairs
};

struct Press {
  double damping;
  int points;
  Sliding sliding;
  int pairs;               // whole eights
  const int *one, *other;  // places side by side
  const double* constants;
  double* springs;
  const double* at;               // nodes side by side
  const double *velocity, *spin;  // null: neither damping nor friction; of elements, lab
  double *force, *couple;         // added to; of elements, lab
  // Out.
  double least_square, least_share_square;  // of distances of axes where they press; by the radii's sum
  double longest_stick_square;              // of springs, by the radii's sum
};

enum PartKind { kCapsulePart, kCylinderPart, kBoxPart, kHalfSpacePart };  // a sphere is a capsule
struct SolidPart {
  PartKind kind;
  double radius, half[3];
  double axes[3][3], position[3];  // lab
};
struct PressOnSolid {
  SolidPart part;
  double origin[3], moving[3], turning[3];  // of the solid: m, m/s, rad/s
  double damping;
  int points;
  Sliding sliding;
  int elements;  // whole eights
  const int* one;
  const double* constants;
  double* springs;
  const double* at;
  const double *velocity, *spin;
  double *force, *couple;
  // Out, added to: force and torque about the origin.
  double on_solid[6];
  double least_share;           // 1 - depth / (2 radius), as between two rods alike
  double longest_stick_square;  // by twice the radius
};

struct Touch {
  Law law;
  double stiffness, damping;
  bool bodies;             // the ones are bodies
  int pairs;               // whole eights
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
  void (*touch)(Touch&);  // the published laws
  void (*narrow)(Narrow&);
  void (*press)(Press&);
  void (*press_on_solid)(PressOnSolid&);
  void (*clear)(double* to, int eights);  // whole eights
};

Kernels BaseKernels();
Kernels Avx2Kernels();
Kernels Avx512Kernels();
// Of RodKernelWidth().
Kernels KernelsOfThisMachine();

}  // namespace tendril::contact_kernel
