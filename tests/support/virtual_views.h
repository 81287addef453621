#pragma once
// Tag corners that cameras would report of the virtual rig's true shape: what hides what included, without
// drawing a picture. The cameras that see are not quite those that the tracker is told of.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "capture/rig/portable_random.h"
#include "capture/rig/virtual_rig.h"
#include "capture/rig/virtual_truth.h"
#include "capture/track/chain_solve.h"

namespace tendril::testing_support {

// Whether a strip other than those of the point's own facet lies between it and the eye.
inline bool IsHidden(const TrueShape& shape, int tentacle, int facet, const Eigen::Vector3d& point,
                     const Eigen::Vector3d& eye) {
  for (int t = 0; t < static_cast<int>(shape.tentacles.size()); ++t) {
    for (const TrueStrip& strip : shape.tentacles[static_cast<std::size_t>(t)].strips) {
      if (t == tentacle && strip.facet == facet) continue;
      const Eigen::Isometry3d sheet_from_lab = strip.lab_from_sheet.inverse();
      const Eigen::Vector3d from = sheet_from_lab * point;
      const Eigen::Vector3d to = sheet_from_lab * eye;
      if ((from.x() > 0) == (to.x() > 0)) continue;
      const Eigen::Vector3d at = from + from.x() / (from.x() - to.x()) * (to - from);
      const Eigen::Index corners = strip.corners_in_sheet.cols();
      bool inside = corners >= 3;
      for (Eigen::Index k = 0; k < corners && inside; ++k) {
        const Eigen::Vector3d a = strip.corners_in_sheet.col(k);
        const Eigen::Vector3d b = strip.corners_in_sheet.col((k + 1) % corners);
        inside = (b.y() - a.y()) * (at.z() - a.z()) - (b.z() - a.z()) * (at.y() - a.y()) >= 0;
      }
      if (inside) return true;
    }
  }
  return false;
}

// A camera as it really is, where the one of the rig file is wrong by sigma_px per pixel coordinate, root
// mean square over these points: pose, focal length, centre and lens share the blame.
inline Camera MiscalibratedCamera(const Camera& told, const std::vector<Eigen::Vector3d>& points,
                                  double sigma_px, std::mt19937_64& random) {
  constexpr int kWays = 10;
  const auto changed = [](Camera camera, int way, double size) {
    if (way < 3) {
      const Eigen::Isometry3d turn(Eigen::AngleAxisd(1e-4 * size, Eigen::Vector3d::Unit(way)));
      camera.camera_from_lab = turn * camera.camera_from_lab;
    } else if (way < 6) {
      camera.camera_from_lab.translation()[way - 3] += 1e-4 * size;
    } else if (way == 6) {
      camera.focal_x_px *= 1 + 1e-4 * size;
      camera.focal_y_px *= 1 + 1e-4 * size;
    } else if (way < 9) {
      (way == 7 ? camera.center_x_px : camera.center_y_px) += 0.1 * size;
    } else {
      camera.coefficients[0] += 1e-4 * size;
    }
    return camera;
  };
  Camera camera = told;
  for (int way = 0; way < kWays; ++way) {
    const Camera other = changed(told, way, 1);
    double squares = 0;
    for (const Eigen::Vector3d& point : points) {
      squares += (*Project(other, point) - *Project(told, point)).squaredNorm() / 2;
    }
    const double effect = std::sqrt(squares / static_cast<double>(points.size()));
    camera = changed(camera, way, DrawNormal(random, sigma_px / std::sqrt(1.0 * kWays)) / effect);
  }
  return camera;
}

// What the tracker is told of a tentacle.
inline ChainModel KnownOf(const Gripper& gripper, const TentacleDesign& drawn, const TrueShape& shape,
                          int tentacle) {
  const TentacleDesign design = DesignOfTentacle(gripper, drawn, tentacle);
  const double command = shape.tentacles[static_cast<std::size_t>(tentacle)].command;
  return {.layout = LayOut(design).value(),
          .expected_angle = SolveFold(design, command).value().angle,
          .closed_angle = design.closed_angle,
          .lab_from_tentacle = LabFromTentacle(gripper, tentacle)};
}

struct SeenTentacle {
  ChainModel model;  // what the tracker is told
  std::vector<TagView> views;
  Eigen::Matrix3Xd holes;      // in the lab, m
  Eigen::VectorXd fold_angle;  // true phi_i, rad
};

struct SightOptions {
  double largest_tilt = 60 * std::numbers::pi / 180;  // rad
  double corner_px = 0.05;                            // noise of a corner seen frontally; times 1 / cos(tilt)
  int every = 1;                                      // tags on facets 0, every, 2 every, ... count
  double kept = 1;                                    // share of what could be seen that is
};

// `drawn` are the tags' places as the tracker is told (the views point into it), `glued` where they are.
inline SeenTentacle SeeTentacle(const TrueShape& shape, const Gripper& gripper, int tentacle,
                                const TagLayout& drawn, const TagLayout& glued,
                                const std::vector<Camera>& cameras, const SightOptions& options,
                                std::mt19937_64& random) {
  const TrueTentacle& one = shape.tentacles[static_cast<std::size_t>(tentacle)];
  SeenTentacle seen;
  seen.model = KnownOf(gripper, TentacleDesign{}, shape, tentacle);
  seen.holes = one.centerline.points;
  seen.fold_angle = one.fold_angle;
  for (std::size_t i = 0; i < drawn.tags.size(); ++i) {
    const TagPlace& tag = drawn.tags[i];
    if (tag.tentacle != tentacle || tag.facet % options.every != 0) continue;
    const Eigen::Matrix<double, 3, 4> corners = TrueTagCorners(shape, glued.tags[i]);
    const Eigen::Vector3d middle = corners.rowwise().mean();
    const Eigen::Vector3d normal =
        (corners.col(1) - corners.col(0)).cross(corners.col(3) - corners.col(0)).normalized();
    for (int c = 0; c < static_cast<int>(cameras.size()); ++c) {
      const Eigen::Vector3d eye =
          cameras[static_cast<std::size_t>(c)].camera_from_lab.inverse().translation();
      const double facing = normal.dot((eye - middle).normalized());
      const bool kept = DrawUnit(random) < options.kept;
      if (facing < std::cos(options.largest_tilt) || !kept) continue;
      const double sigma = options.corner_px / facing;
      TagView view{.camera = c, .place = &tag, .corners_px = {}, .sigma_px = sigma};
      bool clear = !IsHidden(shape, tentacle, tag.facet, middle, eye);
      for (int k = 0; k < 4 && clear; ++k) {
        // The white ring must be seen as well: a quarter of the way from the middle out.
        const Eigen::Vector3d corner = corners.col(k);
        clear = !IsHidden(shape, tentacle, tag.facet, corner + 0.25 * (corner - middle), eye);
        const auto pixel = Project(cameras[static_cast<std::size_t>(c)], corner);
        clear = clear && pixel.has_value();
        if (clear)
          view.corners_px.col(k) =
              *pixel + Eigen::Vector2d(DrawNormal(random, sigma), DrawNormal(random, sigma));
      }
      if (clear) seen.views.push_back(view);
    }
  }
  return seen;
}

}  // namespace tendril::testing_support
