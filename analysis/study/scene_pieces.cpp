#include "analysis/study/scene_pieces.h"

#include <algorithm>
#include <cmath>

#include "analysis/study/scene_picture.h"

namespace tendril {
namespace {

constexpr double kSharp = 0.5;  // cosine of the bend from which a joint is round

constexpr double kOverlap = 0.03;  // of the radius

// Consecutive nodes that are finite, with what one of them shares with the next left out.
struct Run {
  std::vector<Eigen::Vector3d> points;
  std::vector<double> radii;
};

// Directions at the run's nodes: half-way between the elements', and at ends and sharp bends that of the
// element, which begins or ends there.
struct ElementEnds {
  Eigen::Vector3d begins, ends;
};

std::vector<ElementEnds> DirectionsOf(const Run& run) {
  const std::size_t elements = run.points.size() - 1;
  std::vector<Eigen::Vector3d> along(elements);
  for (std::size_t i = 0; i < elements; ++i) along[i] = (run.points[i + 1] - run.points[i]).normalized();
  std::vector<ElementEnds> directions(elements);
  for (std::size_t i = 0; i < elements; ++i) {
    const auto toward = [&](std::size_t other) {
      return along[i].dot(along[other]) > kSharp ? Eigen::Vector3d((along[i] + along[other]).normalized())
                                                 : along[i];
    };
    directions[i] = {i > 0 ? toward(i - 1) : along[i], i + 1 < elements ? toward(i + 1) : along[i]};
  }
  return directions;
}

void AddRun(const Run& run, int body, std::vector<ScenePiece>& pieces) {
  const std::size_t nodes = run.points.size();
  if (nodes == 0) return;
  const auto ball = [&](std::size_t i) {
    pieces.push_back({.kind = ScenePiece::Kind::kBall,
                      .body = body,
                      .a = run.points[i],
                      .b = run.points[i],
                      .radius_a = run.radii[i],
                      .radius_b = run.radii[i]});
  };
  ball(0);
  if (nodes == 1) return;
  ball(nodes - 1);
  const std::vector<ElementEnds> directions = DirectionsOf(run);
  for (std::size_t i = 0; i + 1 < nodes; ++i) {
    const bool joined_before = i > 0 && directions[i - 1].ends == directions[i].begins;
    const bool joined_after = i + 2 < nodes && directions[i].ends == directions[i + 1].begins;
    pieces.push_back({.kind = ScenePiece::Kind::kCone,
                      .body = body,
                      .a = run.points[i],
                      .b = run.points[i + 1],
                      .radius_a = run.radii[i],
                      .radius_b = run.radii[i + 1],
                      .tangent_a = directions[i].begins,
                      .tangent_b = directions[i].ends,
                      .cut_a = joined_before,
                      .cut_b = joined_after,
                      .overlap = kOverlap * std::max(run.radii[i], run.radii[i + 1])});
    if (i + 2 < nodes && !joined_after) ball(i + 1);
  }
}

// The run with nodes put between its own, on the cubic through them, where the outline of a bend would show
// corners.
Run Smoothed(const Run& run, const SceneView& view) {
  constexpr double kCorner = 0.25;  // px between an outline and its chord that nobody sees
  constexpr int kMost = 8;          // parts of an element
  if (run.points.size() < 2) return run;
  const std::vector<ElementEnds> directions = DirectionsOf(run);
  Run smooth;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const Eigen::Vector3d &from = run.points[i], &to = run.points[i + 1];
    const auto& [begins, ends] = directions[i];
    const double length = (to - from).norm();
    const double bend = std::acos(std::clamp(begins.dot(ends), -1.0, 1.0));
    // The outer side of a bend of this radius leaves its chord by (R + r) bend^2 / 8 with R = length / bend.
    const double off = (length + run.radii[i] * bend) * bend / 8;
    const double off_px = off * view.focal_px / std::max(DepthOf(view, from), 1e-9 * view.reach);
    const int parts =
        std::clamp(static_cast<int>(std::ceil(std::sqrt(std::min(off_px / kCorner, 1e6)))), 1, kMost);
    for (int part = 0; part < parts; ++part) {
      const double t = static_cast<double>(part) / parts, u = 1 - t;
      smooth.points.emplace_back((1 + 2 * t) * u * u * from + t * u * u * length * begins +
                                 t * t * (3 - 2 * t) * to - t * t * u * length * ends);
      smooth.radii.push_back(u * run.radii[i] + t * run.radii[i + 1]);
    }
  }
  smooth.points.push_back(run.points.back());
  smooth.radii.push_back(run.radii.back());
  return smooth;
}

double Visible(double radius, const Eigen::Vector3d& point, const SceneView& view, double least_px) {
  const double least = least_px * std::max(0.0, DepthOf(view, point)) / view.focal_px;
  return radius > least && std::isfinite(radius) ? radius : least;
}

void AddBall(const Eigen::Vector3d& center, double radius, int body, std::vector<ScenePiece>& pieces) {
  AddRun({{center}, {radius}}, body, pieces);
}

void AddCylinder(const Eigen::Isometry3d& pose, double radius, double half_length, int body,
                 std::vector<ScenePiece>& pieces) {
  const Eigen::Vector3d along = pose.linear().col(2);
  const Eigen::Vector3d ends[2] = {pose.translation() - half_length * along,
                                   pose.translation() + half_length * along};
  pieces.push_back({.kind = ScenePiece::Kind::kCone,
                    .body = body,
                    .a = ends[0],
                    .b = ends[1],
                    .radius_a = radius,
                    .radius_b = radius,
                    .tangent_a = along,
                    .tangent_b = along,
                    .cut_a = true,
                    .cut_b = true});
  for (const int end : {0, 1}) {
    const Eigen::Vector3d out = end == 0 ? Eigen::Vector3d(-along) : along;
    pieces.push_back({.kind = ScenePiece::Kind::kDisc,
                      .body = body,
                      .a = ends[end],
                      .b = ends[end],
                      .radius_a = radius,
                      .radius_b = radius,
                      .tangent_a = out,
                      .tangent_b = out});
  }
}

void AddFace(const Eigen::Vector3d& center, const Eigen::Vector3d& out, const Eigen::Vector3d& to_edge,
             double half_edge, int body, std::vector<ScenePiece>& pieces) {
  pieces.push_back({.kind = ScenePiece::Kind::kFace,
                    .body = body,
                    .a = center,
                    .b = center + to_edge,
                    .radius_a = half_edge,
                    .radius_b = half_edge,
                    .tangent_a = out,
                    .tangent_b = out});
}

void AddBox(const Eigen::Isometry3d& pose, const Eigen::Vector3d& half, int body,
            std::vector<ScenePiece>& pieces) {
  for (int axis = 0; axis < 3; ++axis) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    for (const int side : {-1, 1}) {
      const Eigen::Vector3d out = side * pose.linear().col(axis);
      AddFace(pose.translation() + half[axis] * out, out, half[next] * pose.linear().col(next), half[last],
              body, pieces);
    }
  }
}

// A plane without end, as far as it is near the scene.
void AddPlane(const Eigen::Isometry3d& pose, int body, const SceneView& view,
              std::vector<ScenePiece>& pieces) {
  const double half = 1.2 * view.reach;
  const Eigen::Vector3d out = pose.linear().col(2);
  const Eigen::Vector3d center = view.middle - out.dot(view.middle - pose.translation()) * out;
  AddFace(center, out, half * pose.linear().col(0), half, body, pieces);
}

void AddPrimitive(const Primitive& part, const Eigen::Isometry3d& pose, int body, const SceneView& view,
                  double least_px, std::vector<ScenePiece>& pieces) {
  const Eigen::Vector3d at = pose.translation();
  const double radius = Visible(part.radius, at, view, least_px);
  switch (part.kind) {
    case PrimitiveKind::kSphere:
      return AddBall(at, radius, body, pieces);
    case PrimitiveKind::kCapsule: {
      if (!(part.half.z() > 1e-6 * radius)) return AddBall(at, radius, body, pieces);
      const Eigen::Vector3d to_end = part.half.z() * pose.linear().col(2);
      return AddRun({{at - to_end, at + to_end}, {radius, radius}}, body, pieces);
    }
    case PrimitiveKind::kCylinder:
      return AddCylinder(pose, radius, Visible(part.half.z(), at, view, least_px), body, pieces);
    case PrimitiveKind::kBox: {
      Eigen::Vector3d half;
      for (int k = 0; k < 3; ++k) half[k] = Visible(part.half[k], at, view, least_px);
      return AddBox(pose, half, body, pieces);
    }
    case PrimitiveKind::kHalfSpace:
      if (!IsFloor({.kind = part.kind}, pose)) AddPlane(pose, body, view, pieces);
  }
}

}  // namespace

bool CanBeDrawn(const Eigen::Vector3d& point) {
  return point.allFinite() && point.cwiseAbs().maxCoeff() < 1e7;
}

void AddTube(const Tube& tube, int body, const SceneView& view, double least_px,
             std::vector<ScenePiece>& pieces) {
  Run run;
  for (Eigen::Index i = 0; i < tube.points.cols(); ++i) {
    const Eigen::Vector3d point = tube.points.col(i);
    if (!CanBeDrawn(point)) {
      AddRun(Smoothed(run, view), body, pieces);
      run = {};
      continue;
    }
    const double radius = Visible(i < tube.radius.size() ? tube.radius[i] : 0.0, point, view, least_px);
    // An element without length has no direction; one far below a radius would only add rounding.
    if (!run.points.empty() && (point - run.points.back()).norm() <= 1e-3 * radius) continue;
    run.points.push_back(point);
    run.radii.push_back(radius);
  }
  AddRun(Smoothed(run, view), body, pieces);
}

void AddWire(const Wire& wire, int body, const SceneView& view, double least_px,
             std::vector<ScenePiece>& pieces) {
  AddTube({.points = wire.points, .radius = Eigen::VectorXd::Constant(wire.points.cols(), wire.radius)}, body,
          view, least_px, pieces);
}

bool IsFloor(const Primitive& primitive, const Eigen::Isometry3d& lab_from_object) {
  if (primitive.kind != PrimitiveKind::kHalfSpace) return false;
  constexpr double kLevel = 0.999;  // cosine
  return (lab_from_object * primitive.object_from_primitive).linear()(2, 2) > kLevel;
}

void AddObject(const ShownObject& object, int body, const SceneView& view, double least_px,
               std::vector<ScenePiece>& pieces) {
  for (const Primitive& part : object.shape) {
    const Eigen::Isometry3d pose = object.pose * part.object_from_primitive;
    if (!pose.matrix().allFinite() || !CanBeDrawn(pose.translation())) continue;
    AddPrimitive(part, pose, body, view, least_px, pieces);
  }
}

Eigen::Vector3d NormalAt(const ScenePiece& piece, const Eigen::Vector3d& point) {
  if (piece.kind == ScenePiece::Kind::kDisc || piece.kind == ScenePiece::Kind::kFace) return piece.tangent_a;
  if (piece.kind == ScenePiece::Kind::kBall) return (point - piece.a).normalized();
  // The place s on the axis whose plane, across the tangent blended between the ends, holds the point: at a
  // joint both neighbours then find the same one.
  const Eigen::Vector3d axis = piece.b - piece.a;
  double s = std::clamp((point - piece.a).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
  const Eigen::Vector3d turn = piece.tangent_b - piece.tangent_a;
  for (int newton = 0; newton < 2; ++newton) {
    const Eigen::Vector3d from_axis = point - piece.a - s * axis;
    const Eigen::Vector3d across = piece.tangent_a + s * turn;
    // Below 0 only within a bend tighter than the tube is thick, which no ray sees.
    const double slope = std::max(axis.dot(across) - from_axis.dot(turn), 0.1 * axis.dot(across));
    s = std::clamp(s + from_axis.dot(across) / slope, 0.0, 1.0);
  }
  const Eigen::Vector3d tangent = (piece.tangent_a + s * turn).normalized();
  const Eigen::Vector3d out = point - piece.a - s * axis;
  const Eigen::Vector3d radial = (out - out.dot(tangent) * tangent).normalized();
  const double taper = (piece.radius_b - piece.radius_a) / axis.norm();
  return (radial - taper * tangent).normalized();
}

}  // namespace tendril
