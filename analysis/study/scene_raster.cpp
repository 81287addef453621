#include "analysis/study/scene_raster.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tendril {
namespace {

struct PixelBox {
  int left = 0, right = 0, top = 0, bottom = 0;  // [left, right) x [top, bottom)
};

// A slanted strip of rays: least <= across . (x_slope, y_slope) <= most.
struct Strip {
  Eigen::Vector2d across = Eigen::Vector2d::UnitX();
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
};

// A piece in camera axes.
struct Target {
  ScenePiece piece;
  PixelBox box;
  Strip strip;
  int number = 0;     // of the piece
  float nearest = 0;  // no part of it is nearer, m
};

// Extent of the end of a piece along the camera's axes, m.
Eigen::Vector3d ExtentOf(double radius, const Eigen::Vector3d& tangent, const Eigen::Vector3d& axis,
                         bool flat, double overlap) {
  if (!flat) return Eigen::Vector3d::Constant(radius);
  // The cut is a slanted ellipse; where the tube widens, the overlap does so too.
  const double slanted = (radius + overlap) / std::max(0.3, tangent.dot(axis));
  return slanted * (1 - tangent.array().square()).max(0).sqrt() + overlap;
}

// From the middle of a face's edge to its end.
Eigen::Vector3d AlongEdge(const ScenePiece& face) {
  return face.radius_a * face.tangent_a.cross(face.b - face.a).normalized();
}

// Pixels whose rays may meet the box; none if part of it is behind the camera.
PixelBox BoxOf(const Eigen::AlignedBox3d& space, const SceneView& view) {
  PixelBox box;
  const Eigen::Vector3d& low = space.min();
  const Eigen::Vector3d& high = space.max();
  if (!(low.z() > 1e-6 * high.z()) || !space.min().allFinite() || !space.max().allFinite()) return box;
  const auto bounds = [&](double first, double last, double center, int size, int& from, int& to) {
    const double least = view.focal_px * first / (first < 0 ? low.z() : high.z()) + center;
    const double most = view.focal_px * last / (last > 0 ? low.z() : high.z()) + center;
    from = static_cast<int>(std::ceil(std::clamp<double>(least, 0, size)));
    to = static_cast<int>(std::floor(std::clamp<double>(most, -1, size - 1))) + 1;
  };
  bounds(low.x(), high.x(), view.center_x_px, view.width_px, box.left, box.right);
  bounds(low.y(), high.y(), view.center_y_px, view.height_px, box.top, box.bottom);
  return box;
}

Target TargetOf(const ScenePiece& in_lab, const SceneView& view) {
  Target target{.piece = in_lab, .box = {}, .strip = {}};
  ScenePiece& p = target.piece;
  p.a = view.camera_from_lab * in_lab.a;
  p.b = view.camera_from_lab * in_lab.b;
  p.tangent_a = view.camera_from_lab.linear() * in_lab.tangent_a;
  p.tangent_b = view.camera_from_lab.linear() * in_lab.tangent_b;
  const bool disc = p.kind == ScenePiece::Kind::kDisc, face = p.kind == ScenePiece::Kind::kFace;
  const Eigen::Vector3d axis = p.kind == ScenePiece::Kind::kCone ? (p.b - p.a).normalized() : p.tangent_a;
  Eigen::Vector3d around_a = ExtentOf(p.radius_a, p.tangent_a, axis, p.cut_a || disc, p.overlap);
  Eigen::Vector3d around_b = ExtentOf(p.radius_b, p.tangent_b, axis, p.cut_b || disc, p.overlap);
  if (face) {
    around_b = AlongEdge(p).cwiseAbs();
    around_a = around_b + (p.b - p.a).cwiseAbs();
  }
  Eigen::AlignedBox3d space(p.a - around_a, p.a + around_a);
  space.extend(Eigen::AlignedBox3d(p.b - around_b, p.b + around_b));
  target.box = BoxOf(space, view);
  target.nearest = static_cast<float>(space.min().z());
  // Most elements of a rod are short and thick: a strip along them holds far fewer rays than the box.
  const Eigen::Vector2d drawn = p.b.head<2>() / p.b.z() - p.a.head<2>() / p.a.z();
  if (p.cut_a && p.cut_b && space.min().z() > 0 && drawn.norm() > 1e-9) {
    target.strip.across = drawn.normalized();
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (const bool end : {false, true}) {
      const Eigen::Vector3d& center = end ? p.b : p.a;
      const Eigen::Vector3d& tangent = end ? p.tangent_b : p.tangent_a;
      const double slanted = ((end ? p.radius_b : p.radius_a) + p.overlap) / std::max(0.3, tangent.dot(axis));
      const double along = tangent.head<2>().dot(target.strip.across);
      const double extent = slanted * std::sqrt(std::max(0.0, 1 - along * along)) + p.overlap;
      const double middle = center.head<2>().dot(target.strip.across);
      least = std::min(least, middle - extent);
      most = std::max(most, middle + extent);
    }
    target.strip.least = least / (least < 0 ? space.min().z() : space.max().z());
    target.strip.most = most / (most > 0 ? space.min().z() : space.max().z());
  }
  return target;
}

// Calls meet(x_slope, y_slope) for the pixels of the box; it answers with the depth, or infinity.
template <class Meet>
void Cast(const Target& target, const SceneView& view, SceneRaster& raster, const Meet& meet) {
  const double per_px = 1 / view.focal_px;
  const PixelBox& box = target.box;
  const Strip& strip = target.strip;
  const bool slanted = std::isfinite(strip.least) && std::abs(strip.across.x()) > 0.02;
  for (int y = box.top; y < box.bottom; ++y) {
    const double y_slope = (y - view.center_y_px) * per_px;
    int left = box.left, right = box.right;
    if (slanted) {
      const double one = (strip.least - strip.across.y() * y_slope) / strip.across.x();
      const double other = (strip.most - strip.across.y() * y_slope) / strip.across.x();
      const double first = std::min(one, other) * view.focal_px + view.center_x_px;
      const double last = std::max(one, other) * view.focal_px + view.center_x_px;
      left = static_cast<int>(std::clamp<double>(first, box.left, box.right));
      right = static_cast<int>(std::clamp<double>(last + 2, box.left, box.right));
      if (left >= right) continue;
    }
    std::size_t at = raster.At(left, y);
    for (int x = left; x < right; ++x, ++at) {
      if (raster.depth[at] < target.nearest) continue;
      const auto depth = static_cast<float>(meet((x - view.center_x_px) * per_px, y_slope));
      if (!(depth < raster.depth[at])) continue;
      raster.depth[at] = depth;
      raster.piece[at] = target.number;
    }
  }
}

constexpr double kNothing = std::numeric_limits<double>::infinity();

// A ray is (x_slope, y_slope, 1) z; each test moves its origin to the piece's depth, so that nothing is lost
// where a piece is small and far away.

void CastBall(const Target& target, const SceneView& view, SceneRaster& raster) {
  const Eigen::Vector3d a = target.piece.a;
  const double r_squared = target.piece.radius_a * target.piece.radius_a;
  Cast(target, view, raster, [&](double x_slope, double y_slope) {
    const double ox = x_slope * a.z() - a.x();
    const double oy = y_slope * a.z() - a.y();
    const double dd = x_slope * x_slope + y_slope * y_slope + 1;
    const double od = ox * x_slope + oy * y_slope;
    const double h = od * od - dd * (ox * ox + oy * oy - r_squared);
    return h < 0 ? kNothing : a.z() - (od + std::sqrt(h)) / dd;
  });
}

void CastDisc(const Target& target, const SceneView& view, SceneRaster& raster) {
  const Eigen::Vector3d a = target.piece.a;
  const Eigen::Vector3d n = target.piece.tangent_a;
  const double r_squared = target.piece.radius_a * target.piece.radius_a;
  Cast(target, view, raster, [&](double x_slope, double y_slope) {
    const Eigen::Vector3d d(x_slope, y_slope, 1);
    const double facing = n.dot(d);
    if (facing >= 0) return kNothing;
    const double depth = n.dot(a) / facing;
    return (d * depth - a).squaredNorm() <= r_squared ? depth : kNothing;
  });
}

void CastFace(const Target& target, const SceneView& view, SceneRaster& raster) {
  const Eigen::Vector3d a = target.piece.a;
  const Eigen::Vector3d n = target.piece.tangent_a;
  const Eigen::Vector3d to_edge = target.piece.b - a, along = AlongEdge(target.piece);
  const double edge_squared = to_edge.squaredNorm(), along_squared = along.squaredNorm();
  Cast(target, view, raster, [&](double x_slope, double y_slope) {
    const Eigen::Vector3d d(x_slope, y_slope, 1);
    const double facing = n.dot(d);
    if (facing >= 0) return kNothing;
    const double depth = n.dot(a) / facing;
    const Eigen::Vector3d from = d * depth - a;
    const bool inside =
        std::abs(from.dot(to_edge)) <= edge_squared && std::abs(from.dot(along)) <= along_squared;
    return inside ? depth : kNothing;
  });
}

// The cone that touches the balls at both ends: points p (from a) with
//   d2 |p|^2 - (ba . p)^2 + 2 (ba . p) rr ra - m0 ra^2 = 0,  m0 = |ba|^2, rr = ra - rb, d2 = m0 - rr^2
// (Quilez, "round cone - intersection"); it ends at 0 < ba . p - ra rr < d2.
void CastCone(const Target& target, const SceneView& view, SceneRaster& raster) {
  const ScenePiece& p = target.piece;
  const Eigen::Vector3d ba = p.b - p.a;
  const double ra = p.radius_a;
  const double rr = ra - p.radius_b;
  const double m0 = ba.squaredNorm();
  const double d2 = m0 - rr * rr;
  if (!(d2 > 0)) return;  // one end's ball holds the other's: only balls are seen
  const double rr_ra = rr * ra;
  const double z0 = 0.5 * (p.a.z() + p.b.z());
  const Eigen::Vector3d ta = p.tangent_a;
  const Eigen::Vector3d tb = p.tangent_b;
  const double bx = ba.x(), by = ba.y(), bz = ba.z();
  const double oz = z0 - p.a.z();
  Cast(target, view, raster, [&](double x_slope, double y_slope) {
    const double ox = x_slope * z0 - p.a.x();
    const double oy = y_slope * z0 - p.a.y();
    const double m1 = bx * ox + by * oy + bz * oz;
    const double m2 = bx * x_slope + by * y_slope + bz;
    const double m3 = ox * x_slope + oy * y_slope + oz;
    const double m5 = ox * ox + oy * oy + oz * oz;
    const double dd = x_slope * x_slope + y_slope * y_slope + 1;
    const double k2 = d2 * dd - m2 * m2;
    const double k1 = d2 * m3 - m1 * m2 + m2 * rr_ra;
    const double k0 = d2 * m5 - m1 * m1 + 2 * m1 * rr_ra - m0 * ra * ra;
    const double h = k1 * k1 - k0 * k2;
    if (h < 0 || std::abs(k2) < 1e-12 * d2 * dd) return kNothing;
    const double t = -(std::sqrt(h) + k1) / k2;
    const double px = ox + t * x_slope, py = oy + t * y_slope, pz = oz + t;
    if (p.cut_a) {
      if (px * ta.x() + py * ta.y() + pz * ta.z() < -p.overlap) return kNothing;
    } else if (m1 + t * m2 - rr_ra < 0) {
      return kNothing;
    }
    if (p.cut_b) {
      if ((px - bx) * tb.x() + (py - by) * tb.y() + (pz - bz) * tb.z() > p.overlap) return kNothing;
    } else if (m1 + t * m2 - rr_ra > d2) {
      return kNothing;
    }
    return z0 + t;
  });
}

}  // namespace

void CastRays(const std::vector<ScenePiece>& pieces, const SceneView& view, SceneRaster& raster) {
  std::vector<Target> targets;
  targets.reserve(pieces.size());
  PixelBox all{.left = view.width_px, .right = 0, .top = view.height_px, .bottom = 0};
  for (const ScenePiece& piece : pieces) {
    Target target = TargetOf(piece, view);
    target.number = static_cast<int>(&piece - pieces.data());
    const PixelBox& box = target.box;
    if (box.left >= box.right || box.top >= box.bottom) continue;
    targets.push_back(target);
    all.left = std::min(all.left, box.left);
    all.right = std::max(all.right, box.right);
    all.top = std::min(all.top, box.top);
    all.bottom = std::max(all.bottom, box.bottom);
  }
  if (all.left >= all.right || all.top >= all.bottom) all = {};
  raster.left = all.left;
  raster.right = all.right;
  raster.top = all.top;
  raster.bottom = all.bottom;
  const auto size =
      static_cast<std::size_t>(all.right - all.left) * static_cast<std::size_t>(all.bottom - all.top);
  raster.depth.assign(size, std::numeric_limits<float>::infinity());
  raster.piece.assign(size, -1);
  // Near ones first: what they hide need not be cast at.
  std::stable_sort(targets.begin(), targets.end(),
                   [](const Target& a, const Target& b) { return a.nearest < b.nearest; });
  for (const Target& target : targets) {
    if (target.piece.kind == ScenePiece::Kind::kBall) CastBall(target, view, raster);
    if (target.piece.kind == ScenePiece::Kind::kDisc) CastDisc(target, view, raster);
    if (target.piece.kind == ScenePiece::Kind::kFace) CastFace(target, view, raster);
    if (target.piece.kind == ScenePiece::Kind::kCone) CastCone(target, view, raster);
  }
}

}  // namespace tendril
