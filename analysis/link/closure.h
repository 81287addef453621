#pragma once
// Open curves made fit for a linking number: how a curve goes on beyond its two ends.
//
// A link is a number only for closed curves. An open one is closed toward infinity by straight ends: exactly,
// by infinite rays along the end tangents (`rays`), or by long finite segments as the paper and PyElastica
// do. Metres, any right-handed frame; directions point outward, away from the curve.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/link/solid_angle.h"
#include "model/result.h"

namespace tendril {

enum class ClosureKind {
  kRays,         // infinite rays along the end tangents
  kNextTangent,  // finite segments along the end tangents
  kEndToEnd,     // finite segments along last minus first node, both ends
  kNetTangent,   // finite segments along the mean of the unit tangents, both ends
  kNone,         // the curve as it is
};

struct Closure {
  ClosureKind kind = ClosureKind::kRays;
  double arc_lengths = 0;  // length of each finite segment, in arc lengths of the curve; > 0 where finite
};

// "rays", "none", or "next_tangent:K", "end_to_end:K", "net_tangent:K" with K > 0 in arc lengths.
//   errors  kBadInput  another word, or K missing, not a number or not positive
Result<Closure> ParseClosure(std::string_view text);
std::string ClosureText(const Closure& closure);

struct Ray {
  Vec3<double> direction;  // unit, outward
  double error = 0;        // how far rounding of the nodes may turn it, rad
};

// A polyline with what closes it, as arrays that the vector kernels read.
struct Strand {
  std::vector<double> x, y, z;         // m, nodes from base to tip; those of finite ends included
  std::optional<Ray> base_ray;         // from the first node
  std::optional<Ray> tip_ray;          // from the last node
  Vec3<double> base_end{}, tip_end{};  // finite ends: the vectors from body to extension's far node, m
  size_t body_first = 0;               // nodes [body_first, body_last] are the curve's own
  size_t body_last = 0;
  double arc_length = 0;  // of the body, m

  size_t nodes() const { return x.size(); }
  Vec3<double> node(size_t i) const { return {x[i], y[i], z[i]}; }
};

// The curve closed.
//   points   >= 2 nodes, m                                                       (3, nodes)
//   errors   kBadInput  fewer than 2 nodes, a coordinate that is not finite, all nodes in one place, a length
//                       outside 1e-40 .. 1e30, or end_to_end or net_tangent where that direction is zero
Result<Strand> CloseCurve(const Eigen::Ref<const Eigen::Matrix3Xd>& points, const Closure& closure);

// Other points, closed by the same vectors as `like`: the offset curve of a self-link keeps its centerline's
// straight ends. points: as many nodes as like's body.
Strand CloseLike(const Strand& like, const Eigen::Ref<const Eigen::Matrix3Xd>& points);

// Its body alone, open.
Strand BodyOf(const Strand& strand);

}  // namespace tendril
