#include "analysis/study/scene_pieces.h"

#include <algorithm>
#include <cmath>

#include "analysis/study/scene_picture.h"

namespace tendril {
namespace {

constexpr double kSharp = 0.8;  // cosine of the bend from which a joint is round

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

void AddSolid(const Solid& solid, int body, const SceneView& view, double least_px,
              std::vector<ScenePiece>& pieces) {
  if (!CanBeDrawn(solid.start)) return;
  const double radius = Visible(solid.radius, solid.start, view, least_px);
  const Eigen::Vector3d axis = solid.end - solid.start;
  const double length = axis.norm();
  const bool round = solid.kind == Solid::Kind::kSphere || !(length > 1e-6 * radius);
  if (round) return AddBall(solid.start, radius, body, pieces);
  if (!CanBeDrawn(solid.end)) return;
  if (solid.kind == Solid::Kind::kCapsule) {
    return AddRun({{solid.start, solid.end}, {radius, radius}}, body, pieces);
  }
  const Eigen::Vector3d along = axis / length;
  pieces.push_back({.kind = ScenePiece::Kind::kCone,
                    .body = body,
                    .a = solid.start,
                    .b = solid.end,
                    .radius_a = radius,
                    .radius_b = radius,
                    .tangent_a = along,
                    .tangent_b = along,
                    .cut_a = true,
                    .cut_b = true});
  for (const int side : {-1, 1}) {
    const Eigen::Vector3d& at = side < 0 ? solid.start : solid.end;
    pieces.push_back({.kind = ScenePiece::Kind::kDisc,
                      .body = body,
                      .a = at,
                      .b = at,
                      .radius_a = radius,
                      .radius_b = radius,
                      .tangent_a = side * along,
                      .tangent_b = side * along});
  }
}

Eigen::Vector3d NormalAt(const ScenePiece& piece, const Eigen::Vector3d& point) {
  if (piece.kind == ScenePiece::Kind::kDisc) return piece.tangent_a;
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
