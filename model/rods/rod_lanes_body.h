// The body of the rod kernels, compiled once per instruction set by the rod_lanes_*.cpp that define
// TENDRIL_ROD_KERNELS and include this; C alone, as registers_body.h says.
//
// Every variable is as many numbers as a register holds, one per rod; eight rods take one to four goes.
// Sources of the equations: rod_plain.h.
#include "model/rods/registers_body.h"
#include "model/rods/rod_lanes_kernel.h"

#include "model/rods/medium_body.h"  // needs the registers

namespace tendril::rod_kernel {
namespace {

template <class S>
struct Kernel {
  typedef typename Types<S>::Real Real;
  typedef typename Types<S>::Mask Mask;

  struct Vector {
    Real x, y, z;
  };
  struct Quaternion {
    Real w, x, y, z;
  };

  static TENDRIL_INLINE Real All(S v) { return v - Real{}; }
  static TENDRIL_INLINE Real Get(const S* from) {
    Real r;
    __builtin_memcpy(&r, from, sizeof r);
    return r;
  }
  static TENDRIL_INLINE void Put(S* to, Real v) { __builtin_memcpy(to, &v, sizeof v); }
  static TENDRIL_INLINE Vector GetVector(const S* from) { return {Get(from), Get(from + 8), Get(from + 16)}; }
  static TENDRIL_INLINE void PutVector(S* to, const Vector& v) {
    Put(to, v.x);
    Put(to + 8, v.y);
    Put(to + 16, v.z);
  }
  static TENDRIL_INLINE Quaternion GetTurn(const S* from) {
    return {Get(from), Get(from + 8), Get(from + 16), Get(from + 24)};
  }

  static TENDRIL_INLINE Vector Add(const Vector& a, const Vector& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  static TENDRIL_INLINE Vector Sub(const Vector& a, const Vector& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  static TENDRIL_INLINE Vector Times(Real s, const Vector& a) { return {s * a.x, s * a.y, s * a.z}; }
  static TENDRIL_INLINE Vector PlusTimes(const Vector& a, Real s, const Vector& b) {
    return {a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
  }
  static TENDRIL_INLINE Real Dot(const Vector& a, const Vector& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
  }
  static TENDRIL_INLINE Vector Cross(const Vector& a, const Vector& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  }

  static TENDRIL_INLINE Quaternion Product(const Quaternion& a, const Quaternion& b) {
    return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
  }
  // q v q^-1, and q^-1 v q.
  static TENDRIL_INLINE Vector ToLab(const Quaternion& q, const Vector& v) {
    const Vector u{q.x, q.y, q.z};
    const Vector c = Cross(u, v), t = Add(c, c);
    return Add(PlusTimes(v, q.w, t), Cross(u, t));
  }
  static TENDRIL_INLINE Vector ToBody(const Quaternion& q, const Vector& v) {
    const Vector u{q.x, q.y, q.z};
    const Vector c = Cross(v, u), t = Add(c, c);
    return Add(PlusTimes(v, q.w, t), Cross(t, u));
  }

  // The quaternion of a rotation vector 2 h, to rounding for |h| up to 0.5.
  static TENDRIL_INLINE Quaternion Exp(const Vector& h) {
    const Real y = Dot(h, h);
    const Real cosine =
        1 + y * (S(-1. / 2) +
                 y * (S(1. / 24) +
                      y * (S(-1. / 720) +
                           y * (S(1. / 40320) + y * (S(-1. / 3628800) +
                                                     y * (S(1. / 479001600) + y * S(-1. / 87178291200.)))))));
    const Real sinc =
        1 + y * (S(-1. / 6) + y * (S(1. / 120) + y * (S(-1. / 5040) +
                                                      y * (S(1. / 362880) + y * (S(-1. / 39916800) +
                                                                                 y * S(1. / 6227020800.))))));
    return {cosine, sinc * h.x, sinc * h.y, sinc * h.z};
  }

  // The rotation vector of a unit quaternion, 4 atan(tau) / tau v / (1 + w), tau = |v| / (1 + w) = tan(angle
  // / 4); the polynomial is atan's on tau^2 up to 0.2 (interpolated in Chebyshev points), 1.68 rad.
  static TENDRIL_INLINE Vector Log(Quaternion q, Real& tau2) {
    const Mask back = q.w < 0;
    const Real sign = back ? All(-1) : All(1);
    const Real scale = sign / (1 + sign * q.w);
    const Vector t{scale * q.x, scale * q.y, scale * q.z};
    const Real y = Dot(t, t);
    tau2 = y;
    // By halves, which wait less for each other than one after the other.
    const Real y2 = y * y, y4 = y2 * y2;
    const Real p0 = S(1) + y * S(-0.33333333333332338),
               p2 = S(0.19999999999761667) + y * S(-0.14285714263336027);
    const Real p4 = S(0.11111110022135758) + y * S(-0.090908776990191315);
    const Real p6 = S(0.076917308596825953) + y * S(-0.06659632591850656);
    const Real p8 = S(0.058243931405155075) + y * S(-0.04940578572579412);
    const Real p10 = S(0.035720500583970395) + y * S(-0.015503704816782964);
    const Real low = (p0 + y2 * p2) + y4 * (p4 + y2 * p6), high = p8 + y2 * p10;
    const Real p = low + (y4 * y4) * high;
    return Times(4 * p, t);
  }

  // (1 - (t/2) cot(t/2)) / t^2 for y = t^2 up to 3 (interpolated in Chebyshev points).
  static TENDRIL_INLINE Real InverseJacobianFactor(Real y) {
    const Real y2 = y * y, y4 = y2 * y2;
    const Real p0 = S(0.083333333333333329) + y * S(0.0013888888888889501);
    const Real p2 = S(3.3068783068111665e-05) + y * S(8.2671957957372849e-07);
    const Real p4 = S(2.0876750839452123e-08) + y * S(5.2842659935465701e-10);
    const Real p6 = S(1.3376864161833401e-11) + y * S(3.4157398915225531e-13);
    const Real p8 = S(7.8730105230311629e-15) + y * S(3.2163024914471431e-16);
    return (p0 + y2 * p2) + y4 * ((p4 + y2 * p6) + y4 * p8);
  }

  static TENDRIL_INLINE void DriftGroup(Job<S>& job, S time) {
    const Real t = All(time), half = All(S(0.5) * time);
    for (int i = 0; i <= job.elements; ++i) {
      PutVector(job.position + 24 * i,
                PlusTimes(GetVector(job.position + 24 * i), t, GetVector(job.velocity + 24 * i)));
    }
    Real largest = Real{};
    for (int i = 0; i < job.elements; ++i) {
      S* const turn = job.turn + 32 * i;
      Quaternion q = GetTurn(turn);
      const Vector spin = GetVector(job.spin + 24 * i);
      if (job.energy_form) {
        // A symmetric top: it turns about L / J1, and goes round d3 in its own axes.
        const S* const inertia = job.inertia + 32 * i;
        const Real around = spin.z * (1 - Get(inertia + 8) * Get(inertia + 16));
        const Vector h{half * spin.x, half * spin.y, half * (spin.z - around)};
        const Real y = Dot(h, h) + half * around * half * around;
        largest = y > largest ? y : largest;
        const Quaternion about = Exp({Real{}, Real{}, half * around});
        q = Product(Product(q, Exp(h)), about);
        // spin <- exp(-around t z) spin
        const Real c = about.w * about.w - about.z * about.z, s = 2 * about.w * about.z;
        PutVector(job.spin + 24 * i, {c * spin.x + s * spin.y, c * spin.y - s * spin.x, spin.z});
      } else {
        const Vector h = Times(half, spin);
        const Real y = Dot(h, h);
        largest = y > largest ? y : largest;
        q = Product(q, Exp(h));
      }
      // One Newton step back to length 1.
      const Real scale = S(1.5) - S(0.5) * (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
      Put(turn, scale * q.w);
      Put(turn + 8, scale * q.x);
      Put(turn + 16, scale * q.y);
      Put(turn + 24, scale * q.z);
    }
    for (int k = 0; k < Types<S>::kWidth && k < job.rods; ++k) {
      // Half the angle of this drift.
      if (!(largest[k] <= S(0.25))) job.turned_too_far = true;
    }
  }

  // On the frame before, and on the one behind, that a turning lies between.
  struct Couples {
    Vector before, behind;
  };
  static TENDRIL_INLINE Couples CouplesOf(const Vector& turning, const Vector& moment) {
    const Vector across = Cross(turning, moment);
    const Vector more = Times(InverseJacobianFactor(Dot(turning, turning)), Cross(turning, across));
    const Vector straight = Add(moment, more), half = Times(All(S(0.5)), across);
    return {Add(half, straight), Sub(half, straight)};
  }

  // Between an end element and the held directors at its end.
  static TENDRIL_INLINE Couples EndCouples(const Job<S>& job, int end, const Quaternion& turn,
                                           Real& largest) {
    const Quaternion held = GetTurn(job.end_turn + 32 * end);
    const Quaternion before = end == 0 ? held : turn, behind = end == 0 ? turn : held;
    Real tau2;
    const Vector turning = Log(Product({before.w, -before.x, -before.y, -before.z}, behind), tau2);
    const S* const bend = job.end_bend + 32 * end;
    const Real stiff = Get(bend), twist = Get(bend + 8), inverse = Get(bend + 24);
    const Mask is_held = stiff > 0;
    largest = is_held & (tau2 > largest) ? tau2 : largest;
    const Vector rest = GetVector(job.end_curvature + 24 * end);
    const Couples pair =
        CouplesOf(turning, {stiff * (turning.x * inverse - rest.x), stiff * (turning.y * inverse - rest.y),
                            twist * (turning.z * inverse - rest.z)});
    // Where nothing is held, what lies between means nothing and may be beyond the polynomials.
    const Real none = Real{};
    return {{is_held ? pair.before.x : none, is_held ? pair.before.y : none, is_held ? pair.before.z : none},
            {is_held ? pair.behind.x : none, is_held ? pair.behind.y : none, is_held ? pair.behind.z : none}};
  }

  template <bool kEnergy, bool kCouples, bool kMedium>
  static TENDRIL_INLINE void KickGroup(Job<S>& job) {
    const Real keep = Get(job.damped), gain = Get(job.damped + 8);
    const Vector gravity{All(job.gravity[0]), All(job.gravity[1]), All(job.gravity[2])};
    Real largest = Real{}, sum = Real{};

    Vector node = GetVector(job.position), velocity = GetVector(job.velocity);
    Vector carried{Real{}, Real{}, Real{}};  // force on the node from the element before
    Vector before_edge{Real{}, Real{}, Real{}};
    // Of the element before.
    Quaternion before_turn{};
    Vector before_couple{}, before_spin{};
    Real before_length = Real{}, before_stretch = Real{}, before_l = Real{};

    // The edge is that between the node's neighbours.
    const auto kick_node = [&](int i, const Vector& internal, const Vector& edge, Real mobile)
        __attribute__((always_inline)) {
      Vector force = internal;
      if (job.force != nullptr) force = Add(force, GetVector(job.force + 24 * i));
      const Real inverse_mass = Get(job.inverse_mass + 8 * i);
      Vector v;
      if constexpr (kMedium) {
        v = KickInMedium<Kernel, S>(job.medium + 32 * i, job.flow, inverse_mass, keep, gain, edge, velocity,
                                    force, gravity);
      } else {
        v = PlusTimes(Times(keep, velocity), gain, PlusTimes(gravity, inverse_mass, force));
      }
      v = Times(mobile, v);
      PutVector(job.velocity + 24 * i, v);
      sum += v.x + v.y + v.z;
    };
    const auto kick_element = [&](int i, const Vector& couple, Real mobile) __attribute__((always_inline)) {
      const S* const inertia = job.inertia + 32 * i;
      const Real step = kEnergy ? gain : gain * before_stretch;
      const Real a = step * Get(inertia + 16), b = step * Get(inertia + 24);
      const Vector w{mobile * (keep * before_spin.x + a * couple.x),
                     mobile * (keep * before_spin.y + a * couple.y),
                     mobile * (keep * before_spin.z + b * couple.z)};
      PutVector(job.spin + 24 * i, w);
      sum += w.x + w.y + w.z;
    };

    const Real one = All(1), first_node = Get(job.mobile), first_element = Get(job.mobile + 8);
    const Real last_node = Get(job.mobile + 16), last_element = Get(job.mobile + 24);
    for (int i = 0; i < job.elements; ++i) {
      const Vector next = GetVector(job.position + 24 * (i + 1));
      const Vector next_velocity = GetVector(job.velocity + 24 * (i + 1));
      const Quaternion turn = GetTurn(job.turn + 32 * i);
      const Vector spin = GetVector(job.spin + 24 * i);
      const Real l = Get(job.rest_length + 24 * i), inverse_l = Get(job.rest_length + 24 * i + 8);
      const Vector edge = Sub(next, node);
      // Shear and stretch.
      const Vector along = Times(inverse_l, ToBody(turn, edge));
      const Vector rest = GetVector(job.rest_strain + 24 * i);
      const Real across_stiffness = Get(job.shear + 16 * i), along_stiffness = Get(job.shear + 16 * i + 8);
      const Vector stress{across_stiffness * (along.x - rest.x), across_stiffness * (along.y - rest.y),
                          along_stiffness * (along.z - 1 - rest.z)};
      Vector couple = Times(l, Cross(along, stress)), pull = stress;
      Real length = Real{}, stretch = Real{};
      if (!kEnergy) {
        const Real square = Dot(edge, edge);
        length = Sqrt(square);
        const Real inverse = 1 / length;
        stretch = length * inverse_l;
        const Real dilatation = l * inverse;
        couple = Times(dilatation, couple);
        pull = Times(dilatation, pull);
        // The terms in the spin.
        const S* const inertia = job.inertia + 32 * i;
        const Real j1 = dilatation * Get(inertia), j3 = dilatation * Get(inertia + 8);
        const Real round = (j1 - j3) * spin.z;
        const Real lengthens = Dot(edge, Sub(next_velocity, velocity)) * inverse * inverse;
        couple.x += round * spin.y + lengthens * j1 * spin.x;
        couple.y += lengthens * j1 * spin.y - round * spin.x;
        couple.z += lengthens * j3 * spin.z;
      }
      if constexpr (kCouples) couple = Add(couple, ToBody(turn, GetVector(job.couple + 24 * i)));
      const Vector force = ToLab(turn, pull);
      kick_node(i, Sub(force, carried), Add(before_edge, edge), i == 0 ? first_node : one);
      carried = force;
      before_edge = edge;
      if (kEnergy && i == 0) couple = Add(couple, EndCouples(job, 0, turn, largest).behind);
      // Bend and twist at the node between the element before and this one.
      if (i > 0) {
        const Quaternion inverse{before_turn.w, -before_turn.x, -before_turn.y, -before_turn.z};
        Real tau2;
        const Vector turning = Log(Product(inverse, turn), tau2);
        largest = tau2 > largest ? tau2 : largest;
        const Real inverse_voronoi = Get(job.rest_length + 24 * i + 16);
        const Vector rest_curvature = GetVector(job.rest_curvature + 24 * (i - 1));
        const Real bend = Get(job.bend + 16 * (i - 1)), twist = Get(job.bend + 16 * (i - 1) + 8);
        Vector moment{bend * (turning.x * inverse_voronoi - rest_curvature.x),
                      bend * (turning.y * inverse_voronoi - rest_curvature.y),
                      twist * (turning.z * inverse_voronoi - rest_curvature.z)};
        if (kEnergy) {
          const Couples pair = CouplesOf(turning, moment);
          before_couple = Add(before_couple, pair.before);
          couple = Add(couple, pair.behind);
        } else {
          const Real ratio = (before_l + l) / (before_length + length);
          moment = Times(ratio * ratio * ratio, moment);
          const Vector across = Cross(turning, moment);
          before_couple = Add(PlusTimes(before_couple, All(S(0.5)), across), moment);
          couple = Sub(PlusTimes(couple, All(S(0.5)), across), moment);
        }
        kick_element(i - 1, before_couple, i == 1 ? first_element : one);
      }
      before_turn = turn;
      before_couple = couple;
      before_spin = spin;
      before_length = length;
      before_stretch = stretch;
      before_l = l;
      node = next;
      velocity = next_velocity;
    }
    kick_node(job.elements, Vector{-carried.x, -carried.y, -carried.z}, before_edge, last_node);
    before_couple = Add(before_couple, GetVector(job.tip_couple));
    if (kEnergy) before_couple = Add(before_couple, EndCouples(job, 1, before_turn, largest).before);
    kick_element(job.elements - 1, before_couple, last_element);
    for (int k = 0; k < Types<S>::kWidth && k < job.rods; ++k) {
      if (!(largest[k] <= S(0.2))) job.turned_too_far = true;
      if (!(sum[k] * 0 == 0)) job.not_finite = true;
    }
  }

  // The rods from `first` on; what they report goes back to the whole job.
  struct Group {
    Job<S> job;
    Job<S>& whole;

    TENDRIL_INLINE Group(Job<S>& of, int first) : job(of), whole(of) {
      job.rods -= first;
      job.position += first;
      job.velocity += first;
      job.turn += first;
      job.spin += first;
      if (job.force != nullptr) job.force += first;
      if (job.couple != nullptr) job.couple += first;
      job.inverse_mass += first;
      job.rest_length += first;
      job.shear += first;
      job.inertia += first;
      job.bend += first;
      job.rest_strain += first;
      job.rest_curvature += first;
      if (job.medium != nullptr) job.medium += first;
      job.mobile += first;
      job.damped += first;
      job.end_turn += first;
      job.end_bend += first;
      job.end_curvature += first;
      job.tip_couple += first;
    }
    TENDRIL_INLINE ~Group() {
      whole.turned_too_far = whole.turned_too_far || job.turned_too_far;
      whole.not_finite = whole.not_finite || job.not_finite;
    }
  };

  static void Drift(Job<S>& job, S time) {
    for (int first = 0; first < 8; first += Types<S>::kWidth) {
      Group group(job, first);
      DriftGroup(group.job, time);
    }
  }

  // Rods without couples or medium do not pay for them.
  template <bool kEnergy>
  static void KickWith(Job<S>& job) {
    if (job.medium != nullptr) {
      job.couple != nullptr ? KickGroup<kEnergy, true, true>(job) : KickGroup<kEnergy, false, true>(job);
    } else {
      job.couple != nullptr ? KickGroup<kEnergy, true, false>(job) : KickGroup<kEnergy, false, false>(job);
    }
  }

  static void Kick(Job<S>& job) {
    for (int first = 0; first < 8; first += Types<S>::kWidth) {
      Group group(job, first);
      job.energy_form ? KickWith<true>(group.job) : KickWith<false>(group.job);
    }
  }

  static void LabSpins(const Job<S>& job, S* to) {
    for (int first = 0; first < 8; first += Types<S>::kWidth) {
      for (int i = 0; i < job.elements; ++i) {
        PutVector(to + 24 * i + first,
                  ToLab(GetTurn(job.turn + 32 * i + first), GetVector(job.spin + 24 * i + first)));
      }
    }
  }
};

}  // namespace

template <>
Kernels<double> TENDRIL_ROD_KERNELS<double>() {
  return {&Kernel<double>::Drift, &Kernel<double>::Kick, &Kernel<double>::LabSpins};
}
template <>
Kernels<float> TENDRIL_ROD_KERNELS<float>() {
  return {&Kernel<float>::Drift, &Kernel<float>::Kick, &Kernel<float>::LabSpins};
}

}  // namespace tendril::rod_kernel
