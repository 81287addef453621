#include "analysis/link/link.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tendril {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

LinkValue NotKnown(LinkFlags why) { return {kNaN, kNaN, why}; }

// What a curve brings along, or why it can't take part.
struct Prepared {
  std::optional<Strand> strand;
  std::optional<Strand> body;
  LinkFlags flags = 0;
};

Prepared Prepare(const FramedCurve& curve, const Closure& closure) {
  Prepared prepared;
  if (auto body = CloseCurve(curve.points, {ClosureKind::kNone, 0}); body.ok()) {
    prepared.body = std::move(body).value();
  } else {
    prepared.flags = curve.points.allFinite() && curve.points.cols() >= 2 ? kNoDirection : kMissing;
    return prepared;
  }
  if (auto strand = CloseCurve(curve.points, closure); strand.ok()) {
    prepared.strand = std::move(strand).value();
  } else {
    prepared.flags = kNoDirection;
  }
  return prepared;
}

double ShortestSegment(const Eigen::Matrix3Xd& points) {
  double shortest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i + 1 < points.cols(); ++i) {
    const double length = (points.col(i + 1) - points.col(i)).norm();
    if (length > 0) shortest = std::min(shortest, length);
  }
  return shortest;
}

// The link of two strands whose bodies' part is known already.
LinkValue ClosedLink(const Strand& a, const Strand& b, const LinkValue& gauss, const LinkOptions& options) {
  if (options.closure.kind == ClosureKind::kNone) return gauss;
  if (options.closure.kind != ClosureKind::kRays) return StrandLink(a, b, options.method);
  const LinkValue rays = RayLink(a, b);
  return {gauss.value + rays.value, gauss.error + rays.error, gauss.flags | rays.flags};
}

// Writhe, twist and the link with the offset curve. Worked out about the curve's first node: far from the
// origin the offset would drown in the coordinates' rounding.
void MeasureOneself(const FramedCurve& curve, const LinkOptions& options, CurveLink& out) {
  FramedCurve local = curve;
  local.points.colwise() -= Eigen::Vector3d(curve.points.col(0));
  auto closed_curve = CloseCurve(local.points, options.closure);
  if (!closed_curve.ok()) {
    out.writhe = out.self_link = NotKnown(kNoDirection);
    return;
  }
  Strand strand = std::move(closed_curve).value();
  if (strand.base_ray) {  // what the nodes were rounded by where they stand
    const auto given = CloseCurve(curve.points, options.closure);
    strand.base_ray->error = given.value().base_ray->error;
    strand.tip_ray->error = given.value().tip_ray->error;
  }
  out.writhe = StrandWrithe(strand, options.method);
  const bool closed =
      options.closure.kind == ClosureKind::kNone && curve.points.col(0) == curve.points.rightCols(1).col(0);
  const auto normals = PerpendicularNormals(local, closed);
  if (!normals.ok()) {
    out.self_link = NotKnown(curve.normals.cols() > 0 ? kBadNormals : kNoNormals);
    return;
  }
  out.twist = Twist(local.points, normals.value(), closed);
  const double shortest = std::max(ShortestSegment(local.points), 1e-6 * strand.arc_length);
  out.self_offset = options.self_offset > 0 ? options.self_offset : 0.01 * shortest;
  const auto with_offset = [&](double offset) {
    return OffsetLink(strand, CloseLike(strand, local.points + offset * normals.value()), options.method);
  };
  out.self_link = with_offset(out.self_offset);
  out.offset_influence = std::abs(with_offset(2 * out.self_offset).value - out.self_link.value);
}

}  // namespace

std::vector<std::string> FlagNames(LinkFlags flags) {
  constexpr std::pair<LinkFlag, const char*> kFlags[] = {
      {kParallelRays, "parallel_rays"},
      {kMeetingRays, "meeting_rays"},
      {kRayOnBody, "ray_on_body"},
      {kTouching, "touching"},
      {kCoplanarCrossing, "coplanar_crossing"},
      {kRayMeetsAxis, "ray_meets_axis"},
      {kRayAlongAxis, "ray_along_axis"},
      {kTouchesAxis, "touches_axis"},
      {kMissing, "missing"},
      {kNoDirection, "no_direction"},
      {kNoNormals, "no_normals"},
      {kBadNormals, "bad_normals"},
  };
  std::vector<std::string> names;
  for (const auto& [flag, name] : kFlags) {
    if (flags & flag) names.emplace_back(name);
  }
  return names;
}

Result<LinkReport> MeasureLink(std::span<const FramedCurve> curves, const LinkOptions& options) {
  if (curves.empty()) return Error{ErrorKind::kBadInput, "there is no curve, a link needs one or more"};
  if (options.axis) {
    const Axis& axis = *options.axis;
    if (!axis.point.allFinite() || !axis.direction.allFinite() || !(axis.direction.stableNorm() > 0)) {
      return Error{ErrorKind::kBadInput,
                   "the object's axis needs a finite point and a direction longer than 0"};
    }
  }
  if (!(options.self_offset >= 0) || !std::isfinite(options.self_offset)) {
    return Error{ErrorKind::kBadInput, "the self-link's offset is " + std::to_string(options.self_offset) +
                                           " m, expected a length above 0, or 0 to choose it"};
  }
  std::vector<Prepared> prepared;
  for (const FramedCurve& curve : curves) prepared.push_back(Prepare(curve, options.closure));

  LinkReport report;
  double object_sum = 0;
  for (size_t i = 0; i < curves.size(); ++i) {
    CurveLink one;
    one.twist = one.self_offset = one.offset_influence = kNaN;
    one.writhe = one.self_link = one.object_link = one.object_gauss = NotKnown(prepared[i].flags);
    if (prepared[i].body) MeasureOneself(curves[i], options, one);
    if (options.axis && prepared[i].strand) one.object_link = AxisLink(*prepared[i].strand, *options.axis);
    if (options.axis && prepared[i].body) one.object_gauss = AxisLink(*prepared[i].body, *options.axis);
    object_sum += std::abs(one.object_link.value);
    report.curves.push_back(one);
  }
  report.object_link = object_sum / static_cast<double>(curves.size());

  double mutual_sum = 0;
  for (size_t i = 0; i < curves.size(); ++i) {
    for (size_t j = i + 1; j < curves.size(); ++j) {
      PairLink pair;
      pair.a = static_cast<int>(i);
      pair.b = static_cast<int>(j);
      const LinkFlags flags = prepared[i].flags | prepared[j].flags;
      pair.link = pair.gauss = NotKnown(flags);
      if (prepared[i].body && prepared[j].body) {
        pair.gauss = StrandLink(*prepared[i].body, *prepared[j].body, options.method);
      }
      if (prepared[i].strand && prepared[j].strand) {
        pair.link = ClosedLink(*prepared[i].strand, *prepared[j].strand, pair.gauss, options);
      }
      mutual_sum += std::abs(pair.link.value);
      report.pairs.push_back(pair);
    }
  }
  report.mutual_link = report.pairs.empty() ? kNaN : mutual_sum / static_cast<double>(report.pairs.size());
  report.performance = report.mutual_link + report.object_link;
  return report;
}

}  // namespace tendril
