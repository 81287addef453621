// Link and writhe of strands, and the link with an axis: link.h.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "analysis/link/link.h"
#include "analysis/link/link_kernel.h"
#include "analysis/link/link_tree.h"

namespace tendril {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr size_t kTreePairs = 1 << 16;  // from here on the tree is faster (bench/link, rows Tree)
constexpr double kNearRays = 1e-6;      // rays closer than this to parallel or to meeting are flagged

struct Sum {
  double angle = 0;
  double error = 0;
  LinkFlags flags = 0;

  void Add(const SolidAngle<double>& one, double sign, LinkFlag flag_on_edge) {
    angle += sign * one.angle;
    error += one.error;
    if (one.on_edge) flags |= flag_on_edge;
  }

  LinkValue Value(LinkMethod method) const {
    const double rounding = std::numeric_limits<double>::epsilon() * 4 * std::abs(angle);
    return {angle / (4 * kPi), method == LinkMethod::kExact ? (error + rounding) / (4 * kPi) : kNaN, flags};
  }
};

NodeArrays Arrays(const Strand& s) { return {s.x.data(), s.y.data(), s.z.data(), s.nodes()}; }

// Touching at a node, or crossing inside both segments? Asked only of pairs that do one of them.
LinkFlag KindOfContact(const Vec3<double>& p1, const Vec3<double>& p2, const Vec3<double>& p3,
                       const Vec3<double>& p4) {
  const Vec3<double> r12 = p2 - p1, r34 = p4 - p3;
  const double size = Norm(r12) * Norm(r34);
  const Vec3<double> normal = Cross(r12, r34);
  if (!(Norm(normal) > 1e-12 * size)) return kTouching;  // collinear and overlapping
  // Where the lines cross, along either: strictly between the ends of both?
  const double square = Dot(normal, normal);
  const double s = Dot(Cross(p3 - p1, r34), normal) / square;
  const double t = Dot(Cross(p3 - p1, r12), normal) / square;
  constexpr double kEnd = 1e-9;
  return s > kEnd && s < 1 - kEnd && t > kEnd && t < 1 - kEnd ? kCoplanarCrossing : kTouching;
}

void AddSegmentPair(Sum& sum, const Strand& a, size_t i, const Strand& b, size_t j) {
  const Vec3<double> p1 = a.node(i), p2 = a.node(i + 1), p3 = b.node(j), p4 = b.node(j + 1);
  const SolidAngle<double> angle = SegmentSegmentAngle(p1, p2, p3, p4);
  sum.Add(angle, 1, angle.on_edge ? KindOfContact(p1, p2, p3, p4) : kTouching);
}

// A ray at one end of a strand, outward; `sign` -1 at the base, where the curve comes in along it.
struct EndRay {
  Vec3<double> start;
  const Ray* ray;
  double sign;
};

void EndRays(const Strand& s, EndRay (&rays)[2], int& count) {
  count = 0;
  if (s.base_ray) rays[count++] = {s.node(0), &*s.base_ray, -1};
  if (s.tip_ray) rays[count++] = {s.node(s.nodes() - 1), &*s.tip_ray, 1};
}

void AddRayOnSegments(Sum& sum, const EndRay& ray, const Strand& b, size_t first, size_t end) {
  for (size_t j = first; j < end; ++j) {
    sum.Add(RaySegmentAngle(ray.start, ray.ray->direction, ray.ray->error, b.node(j), b.node(j + 1)),
            ray.sign, kRayOnBody);
  }
}

// `same_ends`: both rays are the same end of a curve and of its offset, parallel by construction and no
// doubt. Rays that run parallel or meet, within kNearRays, count as the mean of both sides, 0, and are
// flagged: the nodes' own errors are larger than what would decide it.
void AddRayPair(Sum& sum, const EndRay& a, const EndRay& b, bool same_ends) {
  const Vec3<double>& u = a.ray->direction;
  const Vec3<double>& v = b.ray->direction;
  const double error = a.ray->error + b.ray->error;
  if (Dot(u, v) > 0 && Norm(Cross(u, v)) <= kNearRays + error) {
    if (same_ends) return;
    sum.Add({0, 2 * kPi, true}, 1, kParallelRays);
    return;
  }
  const SolidAngle<double> angle = RayRayAngle(a.start, u, b.start, v, error);
  // Near to meeting, seen along u: b's start and where b's ray goes lie on opposite sides, almost in one
  // line.
  const Vec3<double> apart = b.start - a.start;
  const Vec3<double> apart_across = apart - Dot(apart, u) * u, v_across = v - Dot(v, u) * u;
  const bool in_line =
      std::abs(Dot(u, Cross(apart_across, v_across))) <= kNearRays * Norm(apart_across) * Norm(v_across);
  const bool meeting = in_line && Dot(apart_across, v_across) < 0 && std::abs(angle.angle) > kPi;
  sum.Add(meeting ? SolidAngle<double>{0, 2 * kPi, true} : angle, a.sign * b.sign, kMeetingRays);
}

// A segment that runs far past the other curve on both sides, cut in two where it passes: with both ends far
// off the triangles' d would lose (length / distance)^2 of its digits, with one end near it keeps them.
Strand CutWherePassing(const Strand& s, const Strand& other) {
  Vec3<double> low = other.node(0), high = low;
  for (size_t i = 1; i < other.nodes(); ++i) {
    const Vec3<double> p = other.node(i);
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Vec3<double> centre{(low.x + high.x) / 2, (low.y + high.y) / 2, (low.z + high.z) / 2};
  constexpr double kLong = 300;
  const double size = Norm(high - low);
  Strand cut = s;
  for (size_t i = s.nodes() - 1; i-- > 0;) {
    const Vec3<double> start = s.node(i), along = s.node(i + 1) - start;
    const double length = Norm(along);
    if (!(length > kLong * size)) continue;
    const double at = Dot(centre - start, along) / (length * length);
    const Vec3<double> foot{start.x + at * along.x, start.y + at * along.y, start.z + at * along.z};
    if (!(length * std::min(at, 1 - at) > kLong * (size + Norm(foot - centre)))) continue;
    const auto after = static_cast<std::ptrdiff_t>(i) + 1;
    cut.x.insert(cut.x.begin() + after, foot.x);
    cut.y.insert(cut.y.begin() + after, foot.y);
    cut.z.insert(cut.z.begin() + after, foot.z);
  }
  return cut;
}

// Two rows of distances from neighbouring nodes of a to b's nodes serve all pairs of a row.
void AddBlock(Sum& sum, const Strand& a, const SegmentRange& a_range, const Strand& b,
              const SegmentRange& b_range) {
  const size_t nodes = b_range.end - b_range.first + 1;
  std::vector<double> here(nodes), next(nodes), b_length(nodes);
  const auto distances = [&](const Vec3<double>& from, std::vector<double>& row) {
    for (size_t j = 0; j < nodes; ++j) row[j] = Norm(b.node(b_range.first + j) - from);
  };
  for (size_t j = 0; j + 1 < nodes; ++j) {
    b_length[j] = Norm(b.node(b_range.first + j + 1) - b.node(b_range.first + j));
  }
  distances(a.node(a_range.first), next);
  for (size_t i = a_range.first; i < a_range.end; ++i) {
    here.swap(next);
    const Vec3<double> p1 = a.node(i), p2 = a.node(i + 1);
    distances(p2, next);
    const double a_length = Norm(p2 - p1);
    for (size_t j = 0; j + 1 < nodes; ++j) {
      const Vec3<double> p3 = b.node(b_range.first + j), p4 = b.node(b_range.first + j + 1);
      const SolidAngle<double> angle = SegmentSegmentAngle(
          p1, p2, p3, p4, {here[j], here[j + 1], next[j + 1], next[j], a_length, b_length[j]});
      sum.Add(angle, 1, angle.on_edge ? KindOfContact(p1, p2, p3, p4) : kTouching);
    }
  }
}

void AddBodies(Sum& sum, const Strand& a_given, const Strand& b_given, LinkMethod method) {
  const Strand a = CutWherePassing(a_given, b_given), b = CutWherePassing(b_given, a_given);
  if (method == LinkMethod::kFast) {
    if ((a.nodes() - 1) * (b.nodes() - 1) >= kTreePairs) {
      const TreeSum tree = SumByTree(a, b);
      sum.angle += tree.angle;
      for (const TreeSum::Block& block : tree.doubtful) AddBlock(sum, a, block.a, b, block.b);
      return;
    }
    const AngleSum fast = SumSegmentAngles(Arrays(a), Arrays(b));
    if (!fast.suspicious) {
      sum.angle += fast.angle;
      return;
    }
  }
  AddBlock(sum, a, {0, a.nodes() - 1}, b, {0, b.nodes() - 1});
}

bool IsClosed(const Strand& s) {
  const size_t last = s.nodes() - 1;
  return !s.base_ray && s.x[0] == s.x[last] && s.y[0] == s.y[last] && s.z[0] == s.z[last];
}

// Without neighbours; each pair once.
void AddOwnBlock(Sum& sum, const Strand& s, const SegmentRange& a, const SegmentRange& b, bool closed) {
  const size_t last = s.nodes() - 2;
  for (size_t i = a.first; i < a.end; ++i) {
    for (size_t j = std::max(b.first, i + 2); j < b.end; ++j) {
      // The first and the last segment of a closed curve share a node, too.
      if (!(closed && i == 0 && j == last)) AddSegmentPair(sum, s, i, s, j);
    }
  }
}

void AddRays(Sum& sum, const Strand& a, const Strand& b, bool offset_of_a) {
  EndRay a_rays[2], b_rays[2];
  int a_count = 0, b_count = 0;
  EndRays(a, a_rays, a_count);
  EndRays(b, b_rays, b_count);
  for (int k = 0; k < a_count; ++k) AddRayOnSegments(sum, a_rays[k], b, 0, b.nodes() - 1);
  for (int k = 0; k < b_count; ++k) AddRayOnSegments(sum, b_rays[k], a, 0, a.nodes() - 1);
  for (int k = 0; k < a_count; ++k) {
    for (int m = 0; m < b_count; ++m) AddRayPair(sum, a_rays[k], b_rays[m], offset_of_a && k == m);
  }
}

// Without nodes that repeat the one before: their neighbours would count as touching.
Strand WithoutRepeats(const Strand& s) {
  Strand compact = s;
  size_t kept = 0;
  for (size_t i = 0; i < s.nodes(); ++i) {
    if (i > 0 && s.x[i] == s.x[i - 1] && s.y[i] == s.y[i - 1] && s.z[i] == s.z[i - 1]) continue;
    compact.x[kept] = s.x[i];
    compact.y[kept] = s.y[i];
    compact.z[kept] = s.z[i];
    ++kept;
  }
  compact.x.resize(kept);
  compact.y.resize(kept);
  compact.z.resize(kept);
  return compact;
}

}  // namespace

LinkValue StrandLink(const Strand& a, const Strand& b, LinkMethod method) {
  Sum sum;
  AddBodies(sum, a, b, method);
  AddRays(sum, a, b, false);
  return sum.Value(method);
}

LinkValue RayLink(const Strand& a, const Strand& b) {
  Sum sum;
  AddRays(sum, a, b, false);
  return sum.Value(LinkMethod::kExact);
}

LinkValue OffsetLink(const Strand& centerline, const Strand& offset, LinkMethod method) {
  Sum sum;
  AddBodies(sum, centerline, offset, method);
  AddRays(sum, centerline, offset, true);
  return sum.Value(method);
}

LinkValue StrandWrithe(const Strand& strand, LinkMethod method) {
  Sum sum;
  const Strand s = WithoutRepeats(strand);
  const size_t segments = s.nodes() - 1;
  const bool closed = IsClosed(s);
  bool scalar = method == LinkMethod::kExact;
  if (!scalar) {
    if (segments * segments >= 2 * kTreePairs) {
      const TreeSum tree = SumOwnByTree(s, closed);
      sum.angle = tree.angle;
      for (const TreeSum::Block& block : tree.doubtful) AddOwnBlock(sum, s, block.a, block.b, closed);
    } else {
      const AngleSum fast = SumOwnSegmentAngles(Arrays(s));
      scalar = fast.suspicious;
      if (!scalar) sum.angle = fast.angle;
    }
  }
  if (scalar) AddOwnBlock(sum, s, {0, segments}, {0, segments}, closed);
  EndRay rays[2];
  int count = 0;
  EndRays(s, rays, count);
  for (int k = 0; k < count; ++k) {
    // Not against the segment that the ray continues.
    if (rays[k].sign < 0) AddRayOnSegments(sum, rays[k], s, 1, segments);
    if (rays[k].sign > 0) AddRayOnSegments(sum, rays[k], s, 0, segments - 1);
  }
  if (count == 2) AddRayPair(sum, rays[0], rays[1], false);
  sum.angle *= 2;
  sum.error *= 2;
  return sum.Value(method);
}

}  // namespace tendril
