#include "analysis/link/closure.h"

#include <fmt/core.h>

#include <charconv>
#include <utility>

#include "model/check.h"

namespace tendril {
namespace {

constexpr std::pair<ClosureKind, std::string_view> kNames[] = {
    {ClosureKind::kRays, "rays"},           {ClosureKind::kNextTangent, "next_tangent"},
    {ClosureKind::kEndToEnd, "end_to_end"}, {ClosureKind::kNetTangent, "net_tangent"},
    {ClosureKind::kNone, "none"},
};

bool IsFinite(ClosureKind kind) { return kind != ClosureKind::kRays && kind != ClosureKind::kNone; }

Vec3<double> Vec(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

void Append(Strand& strand, const Vec3<double>& p) {
  strand.x.push_back(p.x);
  strand.y.push_back(p.y);
  strand.z.push_back(p.z);
}

Vec3<double> Plus(const Vec3<double>& a, const Vec3<double>& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }

// Outward unit tangent at an end, from the nearest segment that has a length; columns in the order walked.
Ray EndRay(const Eigen::Ref<const Eigen::Matrix3Xd>& points, bool at_tip) {
  const Eigen::Index last = points.cols() - 1;
  const Eigen::Index step = at_tip ? -1 : 1;
  for (Eigen::Index i = at_tip ? last : 0, n = 0; n < last; ++n, i += step) {
    const Eigen::Vector3d outward = points.col(i) - points.col(i + step);
    const double length = outward.stableNorm();
    if (!(length > 0)) continue;
    // The nodes are what the file says, each rounded by up to half a unit in its last place.
    const double rounding = std::numeric_limits<double>::epsilon() * points.col(i).lpNorm<Eigen::Infinity>();
    return {Vec(outward / length), 2 * rounding / length};
  }
  TENDRIL_CHECK(false);
}

}  // namespace

Result<Closure> ParseClosure(std::string_view text) {
  constexpr const char* kExpected =
      "rays, none, or next_tangent:K, end_to_end:K, net_tangent:K with K > 0 in arc lengths";
  const size_t colon = text.find(':');
  const std::string_view word = text.substr(0, colon);
  for (const auto& [kind, name] : kNames) {
    if (word != name) continue;
    if (!IsFinite(kind)) {
      if (colon == std::string_view::npos) return Closure{kind, 0};
      break;
    }
    if (colon == std::string_view::npos) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("closure '{}' needs a length, as in {}:1000 (arc lengths)", text, name)};
    }
    const std::string_view number = text.substr(colon + 1);
    double length = 0;
    const auto parsed = std::from_chars(number.data(), number.data() + number.size(), length);
    if (parsed.ec != std::errc{} || parsed.ptr != number.data() + number.size() || !(length > 0) ||
        !(length <= 1e12)) {
      return Error{
          ErrorKind::kBadInput,
          fmt::format("closure '{}': K is '{}', expected a number of arc lengths above 0 and up to 1e12",
                      text, number)};
    }
    return Closure{kind, length};
  }
  return Error{ErrorKind::kBadInput, fmt::format("closure '{}' is not known, expected {}", text, kExpected)};
}

std::string ClosureText(const Closure& closure) {
  for (const auto& [kind, name] : kNames) {
    if (kind != closure.kind) continue;
    return IsFinite(kind) ? fmt::format("{}:{}", name, closure.arc_lengths) : std::string(name);
  }
  TENDRIL_CHECK(false);
}

Result<Strand> CloseCurve(const Eigen::Ref<const Eigen::Matrix3Xd>& points, const Closure& closure) {
  const Eigen::Index n = points.cols();
  if (n < 2)
    return Error{ErrorKind::kBadInput, fmt::format("the curve has {} nodes, a link needs 2 or more", n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!points.col(i).allFinite()) {
      return Error{ErrorKind::kBadInput, fmt::format("node {} of the curve has no finite position", i)};
    }
  }
  Strand strand;
  Eigen::Vector3d net = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i + 1 < n; ++i) {
    const Eigen::Vector3d edge = points.col(i + 1) - points.col(i);
    const double length = edge.stableNorm();
    strand.arc_length += length;
    if (length > 0) net += edge / length;
  }
  if (!(strand.arc_length > 0)) {
    return Error{ErrorKind::kBadInput, "all nodes of the curve lie in one place, so it has no direction"};
  }
  if (!(strand.arc_length >= 1e-40 && strand.arc_length <= 1e30)) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("the curve is {:.3g} m long, expected 1e-40 to 1e30 m", strand.arc_length)};
  }

  Vec3<double> base_out{}, tip_out{};
  if (closure.kind == ClosureKind::kRays || closure.kind == ClosureKind::kNextTangent) {
    const Ray base = EndRay(points, false), tip = EndRay(points, true);
    if (closure.kind == ClosureKind::kRays) {
      strand.base_ray = base;
      strand.tip_ray = tip;
    }
    base_out = base.direction;
    tip_out = tip.direction;
  } else if (IsFinite(closure.kind)) {
    Eigen::Vector3d along = net;
    if (closure.kind == ClosureKind::kEndToEnd) along = points.col(n - 1) - points.col(0);
    const double length = along.stableNorm();
    if (!(length > 0)) {
      return Error{
          ErrorKind::kBadInput,
          fmt::format("closure {} has no direction here: the curve's ends coincide or its tangents cancel",
                      ClosureText(closure))};
    }
    tip_out = Vec(along / length);
    base_out = Vec(-along / length);
  }

  const bool finite = IsFinite(closure.kind);
  const double reach = closure.arc_lengths * strand.arc_length;
  strand.base_end = reach * base_out;
  strand.tip_end = reach * tip_out;
  strand.body_first = finite ? 1 : 0;
  strand.body_last = strand.body_first + static_cast<size_t>(n) - 1;
  if (finite) Append(strand, Plus(Vec(points.col(0)), strand.base_end));
  for (Eigen::Index i = 0; i < n; ++i) Append(strand, Vec(points.col(i)));
  if (finite) Append(strand, Plus(Vec(points.col(n - 1)), strand.tip_end));
  return strand;
}

Strand CloseLike(const Strand& like, const Eigen::Ref<const Eigen::Matrix3Xd>& points) {
  const Eigen::Index n = points.cols();
  TENDRIL_CHECK(static_cast<size_t>(n) == like.body_last - like.body_first + 1);
  Strand strand;
  strand.base_ray = like.base_ray;
  strand.tip_ray = like.tip_ray;
  strand.base_end = like.base_end;
  strand.tip_end = like.tip_end;
  strand.body_first = like.body_first;
  strand.body_last = like.body_last;
  strand.arc_length = like.arc_length;
  const bool finite = like.body_first > 0;
  if (finite) Append(strand, Plus(Vec(points.col(0)), strand.base_end));
  for (Eigen::Index i = 0; i < n; ++i) Append(strand, Vec(points.col(i)));
  if (finite) Append(strand, Plus(Vec(points.col(n - 1)), strand.tip_end));
  return strand;
}

Strand BodyOf(const Strand& strand) {
  Strand body;
  const auto first = static_cast<std::ptrdiff_t>(strand.body_first);
  const auto end = static_cast<std::ptrdiff_t>(strand.body_last) + 1;
  body.x.assign(strand.x.begin() + first, strand.x.begin() + end);
  body.y.assign(strand.y.begin() + first, strand.y.begin() + end);
  body.z.assign(strand.z.begin() + first, strand.z.begin() + end);
  body.body_last = body.x.size() - 1;
  body.arc_length = strand.arc_length;
  return body;
}

}  // namespace tendril
