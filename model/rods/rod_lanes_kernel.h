#pragma once
// What the kernels of rod_lanes.cpp are given; compiled once per instruction set (rod_lanes_body.h).

namespace tendril::rod_kernel {

template <class S>
struct Job {
  int elements;
  int rods;  // lanes beyond them hold no rod: what becomes of those is nobody's trouble
  bool energy_form;
  S gravity[3];  // m/s^2
  // [node or element][component][8]
  S* position;              // 3, nodes
  S* velocity;              // 3, nodes
  S* turn;                  // w, x, y, z of lab_from_body, elements
  S* spin;                  // 3, elements
  const S* force;           // 3, nodes; null: none
  const S* couple;          // 3, elements, along the lab's axes; null: none
  const S* inverse_mass;    // nodes
  const S* rest_length;     // elements: l, 1 / l, and 2 over the sum of l and that of the element before
  const S* shear;           // along d1 and d2; along d3
  const S* inertia;         // about d1 and d2, about d3, and their inverses
  const S* bend;            // about d1 and d2, about d3; inner nodes
  const S* rest_strain;     // 3, elements
  const S* rest_curvature;  // 3, inner nodes
  const S* medium;  // WettedNodes: weighed, inverse_across, across_drag, along_drag, nodes; null: none
  S flow[3];        // m/s
  const S* mobile;  // node 0, element 0, node N, element N-1: 1, or 0 where held
  const S* damped;  // keep and gain of a kick (DampedKick)
  // Of the base, then of the tip, where the very end's directors are held; else stiffnesses of 0.
  const S* end_turn;       // w, x, y, z
  const S* end_bend;       // about d1 and d2, about d3, half the end element's length and its inverse
  const S* end_curvature;  // 3, at rest
  const S* tip_couple;     // 3, on the last element
  bool turned_too_far, not_finite;  // out; never reset
};

// x += time v, directors turn for `time`.
template <class S>
using Drift = void (*)(Job<S>&, S time);
// Loads of the present positions, then velocities and spins; damped kicks take the place of time steps.
template <class S>
using Kick = void (*)(Job<S>&);

// Spins along the lab's axes: 3, elements.
template <class S>
using LabSpins = void (*)(const Job<S>&, S* to);

template <class S>
struct Kernels {
  Drift<S> drift;
  Kick<S> kick;
  LabSpins<S> lab_spins;
};

template <class S>
Kernels<S> BaseKernels();
template <class S>
Kernels<S> Avx2Kernels();
template <class S>
Kernels<S> Avx512Kernels();

}  // namespace tendril::rod_kernel
