#pragma once
// A tentacle that is not quite its design, and the tag corners that cameras would report of it: truth for
// the tracker, made without the tracker's code.

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "capture/rig/camera_model.h"
#include "capture/rig/tag_layout.h"
#include "capture/track/chain_solve.h"
#include "model/fold/facet_chain.h"
#include "model/fold/fold.h"
#include "model/fold/gripper.h"

namespace tendril::testing_support {

inline constexpr double kDegree = std::numbers::pi / 180;

// How far truth departs from the design: standard deviations.
struct Imperfection {
  double hole = 0.15e-3;    // along the sheet, m
  double crease = 0.15e-3;  // likewise
  double crease_angle = 0.3 * kDegree;
  double fold_angle = 2 * kDegree;  // each crease by itself
  double pull = 0.01;               // of the whole tentacle
  double bend = 0.4 * kDegree;      // a facet turned against its place in the chain, about each axis
  double sag = 0.02 * kDegree;      // the same at every crease, about one axis across the chain
  double tag_turn = 0.4 * kDegree;  // of a tag on its facet, about each axis
  double tag_place = 0.10e-3;       // of a tag on its facet, each axis in the sheet, m
  double corner_px = 0.1;
};

struct Visibility {
  double largest_facing = 65 * kDegree;  // a tag seen at a larger angle is not detected
  double kept = 1;                       // share of the visible tags that are detected
  double outliers = 0;                   // share of views that are gross errors
  bool states_sigma = false;             // whether views state the noise of their corners
};

struct Truth {
  ChainModel model;  // what the tracker is told
  TagLayout tags;
  Eigen::Matrix3Xd holes;  // in the lab, m
  Eigen::Matrix3Xd normals;
  std::vector<Eigen::Isometry3d> lab_from_sheet;
  std::vector<TagView> views;  // point into `tags`
  std::vector<char> outlier;   // (views)
  std::vector<char> facet_visible;
};

inline Eigen::Matrix3d RotationFrom(const Eigen::Vector3d& vector) {
  return Eigen::AngleAxisd(vector.norm(), vector.stableNormalized()).toRotationMatrix();
}

// Looks from `position` at `target`, up is +z; the picture's long side is vertical.
inline Camera CameraAt(const Eigen::Vector3d& position, const Eigen::Vector3d& target) {
  Camera camera;
  camera.name = "camera";
  camera.width_px = 2000;
  camera.height_px = 2600;
  camera.focal_x_px = camera.focal_y_px = 3200;
  camera.center_x_px = 999.5;
  camera.center_y_px = 1299.5;
  camera.distortion = Distortion::kBrown;
  camera.coefficients = {-0.08, 0.03, 3e-4, -2e-4, 0};
  const Eigen::Vector3d forward = (target - position).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d lab_from_camera;
  lab_from_camera << right, forward.cross(right), forward;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = lab_from_camera;
  pose.translation() = position;
  camera.camera_from_lab = pose.inverse();
  return camera;
}

// One, two or four cameras 1.1 m from the tentacle's middle; the first two look at its outer face.
inline std::vector<Camera> CamerasAround(int count) {
  const Eigen::Vector3d middle(0.12, 0, -0.33);
  std::vector<Camera> cameras;
  for (const double azimuth : {20.0, -25.0, 160.0, 205.0}) {
    if (static_cast<int>(cameras.size()) == count) break;
    const Eigen::Vector3d away(std::cos(azimuth * kDegree), std::sin(azimuth * kDegree), 0.15);
    cameras.push_back(CameraAt(middle + 1.1 * away, middle));
  }
  return cameras;
}

inline TentacleDesign PlanarDesign() {
  TentacleDesign design;
  design.beta = std::numbers::pi / 2;
  return design;
}

inline Truth MakeTruth(const TentacleDesign& design, double pull, const std::vector<Camera>& cameras,
                       const Visibility& picture, const Imperfection& off, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  Truth truth;
  Gripper gripper;
  gripper.tentacles = 1;
  gripper.first_azimuth = 0;
  truth.model.layout = LayOut(design).value();
  truth.model.expected_angle = SolveFold(design, pull).value().angle;
  truth.model.closed_angle = design.closed_angle;
  truth.model.lab_from_tentacle = LabFromTentacle(gripper, 0);
  truth.tags = LayOutTags(design, gripper).value();

  TentacleLayout layout = truth.model.layout;
  for (double& z : layout.crease_z) z += off.crease * normal(random);
  for (double& angle : layout.crease_angle) angle += off.crease_angle * normal(random);
  const double pulled = std::clamp(pull + off.pull * normal(random), 0.0, 0.9);
  Eigen::VectorXd angle = SolveFold(design, pulled).value().angle;
  for (double& phi : angle) {
    phi = std::clamp(phi + off.fold_angle * normal(random), -5 * kDegree, 92 * kDegree);
  }
  const FacetChain chain = FoldChain(layout, angle);
  const int holes = static_cast<int>(layout.hole_z.size());
  truth.holes.resize(3, holes);
  Eigen::Isometry3d bent = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d sagging = off.sag * Eigen::Vector3d(normal(random), normal(random), 0);
  for (int i = 0; i < holes; ++i) {
    // Bent facets: what comes after a crease is turned about the crease's centre.
    const Eigen::Vector3d turn =
        off.bend * Eigen::Vector3d(normal(random), normal(random), normal(random)) + sagging;
    if (i > 0) {
      const Eigen::Vector3d about =
          bent * (chain.tentacle_from_sheet[i] * Eigen::Vector3d(0, 0, layout.crease_z[i - 1]));
      const Eigen::Matrix3d by = RotationFrom(turn);
      Eigen::Isometry3d step = Eigen::Isometry3d::Identity();
      step.linear() = by;
      step.translation() = about - by * about;
      bent = step * bent;
    }
    truth.lab_from_sheet.push_back(truth.model.lab_from_tentacle * bent * chain.tentacle_from_sheet[i]);
    const Eigen::Vector3d hole(0, off.hole * normal(random), layout.hole_z[i] + off.hole * normal(random));
    truth.holes.col(i) = truth.lab_from_sheet[i] * hole;
  }
  truth.facet_visible.assign(holes, 0);
  for (const TagPlace& place : truth.tags.tags) {
    Eigen::Matrix<double, 3, 4> corners = place.corners_in_sheet;
    const Eigen::Vector3d moved(0, off.tag_place * normal(random), off.tag_place * normal(random));
    const Eigen::Vector3d twist =
        off.tag_turn * Eigen::Vector3d(normal(random), normal(random), normal(random));
    const Eigen::Vector3d middle = corners.rowwise().mean();
    corners = ((RotationFrom(twist) * (corners.colwise() - middle)).colwise() + (middle + moved)).eval();
    const Eigen::Isometry3d& pose = truth.lab_from_sheet[place.facet];
    const Eigen::Vector3d center = pose * Eigen::Vector3d(corners.rowwise().mean());
    const Eigen::Vector3d outward =
        pose.linear() * Eigen::Vector3d(place.side == TagSide::kOuter ? 1 : -1, 0, 0);
    for (int c = 0; c < static_cast<int>(cameras.size()); ++c) {
      const Eigen::Vector3d eye = cameras[c].camera_from_lab.inverse().translation();
      const double facing = outward.dot((eye - center).normalized());
      if (facing < std::cos(picture.largest_facing) || uniform(random) > picture.kept) continue;
      TagView view{
          .camera = c,
          .place = &place,
          .corners_px = {},
          .sigma_px = picture.states_sigma ? off.corner_px : std::numeric_limits<double>::quiet_NaN()};
      bool inside = true;
      for (int k = 0; k < 4; ++k) {
        const std::optional<Eigen::Vector2d> pixel =
            Project(cameras[c], pose * Eigen::Vector3d(corners.col(k)));
        inside = inside && pixel && pixel->x() > 0 && pixel->y() > 0 && pixel->x() < cameras[c].width_px &&
                 pixel->y() < cameras[c].height_px;
        if (!inside) break;
        view.corners_px.col(k) = *pixel + off.corner_px * Eigen::Vector2d(normal(random), normal(random));
      }
      if (!inside) continue;
      const bool wrong = uniform(random) < picture.outliers;
      if (wrong) {
        // Half of them a tag elsewhere in the picture (a wrong identity), half one corner far off.
        if (uniform(random) < 0.5) {
          const Eigen::Vector2d shift(400 * (uniform(random) - 0.5), 1600 * (uniform(random) - 0.5));
          view.corners_px.colwise() += shift;
        } else {
          view.corners_px.col(0) += Eigen::Vector2d(12 * normal(random), 12 * normal(random));
        }
      }
      truth.views.push_back(view);
      truth.outlier.push_back(wrong ? 1 : 0);
      truth.facet_visible[place.facet] = 1;
    }
  }
  return truth;
}

}  // namespace tendril::testing_support
