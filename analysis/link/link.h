#pragma once
// How much curves wind around themselves, each other and an object: link, writhe, twist, in turns.
//
// Exact on polylines: sums of solid angles over 4 pi (solid_angle.h), infinite ends in closed form. Any unit
// of length, a right-handed frame. Sign: a right-handed helix has positive writhe; a curve that runs
// counterclockwise about an axis that points to the viewer has positive object link.
//
// Definitions: paper, Methods, "Computation of link-based quantities"; closures and flags: docs/link.md.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/link/closure.h"
#include "model/geometry/framed_curve.h"
#include "model/result.h"

namespace tendril {

// What makes a value doubtful; or-ed together.
using LinkFlags = unsigned;
enum LinkFlag : LinkFlags {
  // Rays that run parallel, or meet, within 1e-6 (rad, or of their distance): a hair decides the value by 1
  // or
  // more, so they count as the mean of both sides, 0.
  kParallelRays = 1,
  kMeetingRays = 2,
  kRayOnBody = 4,  // a ray meets a segment: the value jumps by 1 here; the mean of both sides is given
  kTouching = 8,   // segments touch at a node
  kCoplanarCrossing = 16,  // segments cross in their interiors
  kRayMeetsAxis = 32,      // a ray meets the object's axis
  kRayAlongAxis = 64,      // a ray runs along the axis: it adds no winding
  kTouchesAxis = 128,      // the curve's body meets the axis
  kMissing = 256,          // a node has no finite position: the value is NaN
  kNoDirection = 512,      // the closure has no direction on this curve: the value is NaN
  kNoNormals = 1024,       // the curve has no normals: no twist, no self-link (NaN)
  kBadNormals = 2048,      // a normal is not finite, zero or along the curve: the same
};

// "parallel_rays", "meeting_rays", ... in the order above.
std::vector<std::string> FlagNames(LinkFlags flags);

struct LinkValue {
  double value = 0;  // turns; NaN: not known, flags say why
  double error = 0;  // bound on what rounding did to it, turns; NaN: not asked for
  LinkFlags flags = 0;
};

// kFast sums bodies in vector registers (link_kernel.h; 1e-12 from kExact) and gives no error bound; kExact
// goes pair by pair and bounds the error. Both return the same flags.
enum class LinkMethod { kFast, kExact };

// The Gauss linking integral of two closed (or open, then not an integer) strands.
LinkValue StrandLink(const Strand& a, const Strand& b, LinkMethod method = LinkMethod::kFast);

// What the rays of either add to it: StrandLink = the bodies' part + RayLink.
LinkValue RayLink(const Strand& a, const Strand& b);

// StrandLink for a centerline and its offset curve made by CloseLike: their straight ends run parallel, side
// by side, by construction, which is no doubt and no contribution.
LinkValue OffsetLink(const Strand& centerline, const Strand& offset, LinkMethod method = LinkMethod::kFast);

// The Gauss integral of a strand with itself, its rays included.
LinkValue StrandWrithe(const Strand& strand, LinkMethod method = LinkMethod::kFast);

// An object's axis, as an infinite line.
struct Axis {
  Eigen::Vector3d point;      // m
  Eigen::Vector3d direction;  // any length above 0
};

// Link with the infinite axis: the strand's winding angle about it over 2 pi. O(nodes), exact.
LinkValue AxisLink(const Strand& strand, const Axis& axis);

// A curve's unit normals made perpendicular to its node tangents (the mean of the unit tangents on both
// sides).
//   closed   the last node is the first one
//   errors   kBadInput  not one normal per node, one that is not finite or lies along the tangent
Result<Eigen::Matrix3Xd> PerpendicularNormals(const FramedCurve& curve, bool closed);

// Turns of the normals about the curve: on each segment the angle between the normals of its two nodes,
// carried to the segment without twist. On a closed curve writhe + twist is the link with the offset curve.
//   normals  perpendicular ones, from the above                                                  (3, nodes)
double Twist(const Eigen::Matrix3Xd& points, const Eigen::Matrix3Xd& normals, bool closed);

struct LinkOptions {
  Closure closure;
  std::optional<Axis> axis;
  LinkMethod method = LinkMethod::kFast;
  double self_offset = 0;  // of the self-link's second curve, m; 0: 1 % of the curve's shortest segment
};

struct CurveLink {
  LinkValue writhe;
  double twist = 0;             // NaN: no normals
  LinkValue self_link;          // with the curve offset along the normals; NaN: no normals
  double self_offset = 0;       // the offset used, m
  double offset_influence = 0;  // |self_link at twice the offset - self_link|
  LinkValue object_link;        // as closed, with the infinite axis; NaN: no axis
  LinkValue object_gauss;       // the body alone
};

struct PairLink {
  int a = 0, b = 0;  // numbers of the curves, a < b
  LinkValue link;    // as closed
  LinkValue gauss;   // the bodies alone
};

struct LinkReport {
  std::vector<CurveLink> curves;
  std::vector<PairLink> pairs;  // (0,1), (0,2), ..., (1,2), ...
  double mutual_link = 0;       // mean |link| over pairs; NaN: no pair, or one is not known
  double object_link = 0;       // mean |object link| over curves; NaN: no axis, or one is not known
  double performance = 0;       // mutual + object link
};

// All of the above for the curves of one moment. A curve that can't be closed (see CloseCurve) gives NaN with
// a flag wherever it takes part, never an error.
//   errors  kBadInput  no curve; an axis without a direction; an offset < 0 or not finite
Result<LinkReport> MeasureLink(std::span<const FramedCurve> curves, const LinkOptions& options);

}  // namespace tendril
