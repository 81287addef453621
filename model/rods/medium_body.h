// A node's kick in a medium, in registers: KickInMedium of medium.h. Included by rod_lanes_body.h.

namespace tendril::rod_kernel {
namespace {

// K: the kernel, with its vectors. `medium` is what a node's Job::medium points at; edge, velocity, force: as
// there.
template <class K, class S>
TENDRIL_INLINE typename K::Vector KickInMedium(const S* medium, const S* flow, typename K::Real inverse_mass,
                                               typename K::Real keep, typename K::Real gain,
                                               const typename K::Vector& edge,
                                               const typename K::Vector& velocity,
                                               const typename K::Vector& force,
                                               const typename K::Vector& gravity) {
  typedef typename K::Real Real;
  typedef typename K::Vector Vector;
  const Real weighed = K::Get(medium), inverse_across = K::Get(medium + 8);
  const Real across_drag = K::Get(medium + 16), along_drag = K::Get(medium + 24);
  const Vector current{K::All(flow[0]), K::All(flow[1]), K::All(flow[2])};
  // What is along is a multiple of the edge, without its length's root. The little number is for edges of 0.
  const Real inverse_square = 1 / (K::Dot(edge, edge) + S(1e-30));

  const Vector load = K::PlusTimes(force, weighed, gravity);
  const Vector before = K::Sub(velocity, current), damped = K::Sub(K::Times(keep, velocity), current);
  const Real before_dot = K::Dot(before, edge);
  const Real before_along = before_dot * inverse_square;
  const Vector before_across = K::PlusTimes(before, -before_along, edge);
  const Real slow_along = 1 + gain * along_drag * Sqrt(before_dot * before_along);
  const Real slow_across = 1 + gain * across_drag * Sqrt(K::Dot(before_across, before_across));
  const Real inverse_slow = 1 / (slow_along * slow_across);

  const Vector freely = K::PlusTimes(damped, gain * inverse_across, load);
  const Vector across = K::PlusTimes(freely, -K::Dot(freely, edge) * inverse_square, edge);
  const Real along = (K::Dot(damped, edge) + gain * inverse_mass * K::Dot(load, edge)) * inverse_square;
  const Vector kicked = K::PlusTimes(current, along * slow_across * inverse_slow, edge);
  return K::PlusTimes(kicked, slow_along * inverse_slow, across);
}

}  // namespace
}  // namespace tendril::rod_kernel
