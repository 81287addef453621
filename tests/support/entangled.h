#pragma once
// Tentacles that tangle: simulated as rods, put on the virtual rig, filmed by cameras all around and given to
// the tracker. Truth comes from the simulator and the virtual rig alone.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "capture/rig/portable_random.h"
#include "capture/rig/rod_truth.h"
#include "capture/rig/tag_choice.h"
#include "capture/rig/tag_layout.h"
#include "capture/track/chain_solve.h"
#include "db/files/scene_toml.h"
#include "model/fold/fold.h"
#include "model/geometry/rotation.h"
#include "model/scene/actuation.h"
#include "model/scene/simulate.h"
#include "tests/support/tag_film.h"
#include "tests/support/virtual_views.h"

namespace tendril::testing_support {

struct EntangledOptions {
  std::string scene;            // examples/scenes/entangled.toml
  std::vector<double> times;    // s; ascending
  double pull_scale = 0.95;     // effective pull / the one that the tracker is told
  double calibration_px = 0.2;  // by which cameras are not what the tracker thinks, per coordinate
  double distance = 1.0;        // of the cameras, m
  double elevation = 35 * std::numbers::pi / 180;  // up and down in turn
  int width_px = 1280, height_px = 1024;
  int every = 2;  // facets with tags
  TruthRanges ranges;
};

struct EntangledTrial {
  Gripper gripper;
  TentacleDesign design;
  TagLayout tags;                           // as the tracker has them
  TagLayout glued_tags;                     // where they really are on their facets
  std::vector<Camera> cameras;              // as they are
  std::vector<Camera> known_cameras;        // as the tracker has them
  std::vector<std::vector<RodShape>> rods;  // (times) x (tentacles)
  std::vector<TrueShape> shapes;            // (times)
  std::vector<std::string> doubts;          // of the simulation
  double simulate_seconds = 0;
};

// Of each hole from the rod's axis, m. Rods are shorter between carrier and hole 0 too, by the pull's share
// of it; that shift, the same for all holes, is taken off.
inline Eigen::VectorXd DistancesFromRod(const TentacleLayout& layout, const Eigen::Matrix3Xd& rod,
                                        const Eigen::Matrix3Xd& holes) {
  const double place = static_cast<double>(rod.cols() - 1) * -layout.base_z / (layout.tip_z - layout.base_z);
  const auto piece = static_cast<Eigen::Index>(place);
  const Eigen::Vector3d start =
      rod.col(piece) + (place - static_cast<double>(piece)) * (rod.col(piece + 1) - rod.col(piece));
  Eigen::VectorXd distance(holes.cols());
  for (Eigen::Index i = 0; i < holes.cols(); ++i) {
    const Eigen::Vector3d hole = holes.col(i) - holes.col(0) + start;
    double nearest = INFINITY;
    for (Eigen::Index j = 0; j + 1 < rod.cols(); ++j) {
      const Eigen::Vector3d along = rod.col(j + 1) - rod.col(j);
      const double t = std::clamp((hole - rod.col(j)).dot(along) / along.squaredNorm(), 0.0, 1.0);
      nearest = std::min(nearest, (hole - rod.col(j) - t * along).norm());
    }
    distance[i] = nearest;
  }
  return distance;
}

// Looks from around at a box that holds all points, so that they fill the picture; its long side is upright.
inline Camera CameraThatHolds(const std::vector<Eigen::Vector3d>& points, double azimuth,
                              const EntangledOptions& options, double sign) {
  Eigen::Vector3d low = points.front();
  Eigen::Vector3d high = low;
  for (const Eigen::Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Eigen::Vector3d middle = 0.5 * (low + high);
  const double up = sign * options.elevation;
  const Eigen::Vector3d away(std::cos(up) * std::cos(azimuth), std::cos(up) * std::sin(azimuth),
                             std::sin(up));
  const Eigen::Vector3d forward = -away;
  const Eigen::Vector3d level = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Camera camera;
  camera.name = "view";
  camera.width_px = options.width_px;
  camera.height_px = options.height_px;
  camera.distortion = Distortion::kBrown;
  camera.coefficients = {-0.10, 0.04, 2e-4, -1e-4, 0};
  Eigen::Isometry3d lab_from_camera = Eigen::Isometry3d::Identity();
  lab_from_camera.linear() << forward.cross(level), -level, forward;  // the picture's x runs down in the lab
  lab_from_camera.translation() = middle + options.distance * away;
  camera.camera_from_lab = lab_from_camera.inverse();
  Eigen::Vector2d first(INFINITY, INFINITY);
  Eigen::Vector2d last(-INFINITY, -INFINITY);
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d q = camera.camera_from_lab * p;
    first = first.cwiseMin(q.head<2>() / q.z());
    last = last.cwiseMax(q.head<2>() / q.z());
  }
  const Eigen::Vector2d span = last - first;
  const double focal = std::min((camera.width_px - 40) / span.x(), (camera.height_px - 40) / span.y());
  camera.focal_x_px = camera.focal_y_px = std::round(focal);
  camera.center_x_px = 0.5 * camera.width_px - 0.5 * focal * (first.x() + last.x());
  camera.center_y_px = 0.5 * camera.height_px - 0.5 * focal * (first.y() + last.y());
  return camera;
}

// Seeds draw where tentacles hang (carrier radius 60 to 85 mm, tilt -3 to 2.5 degrees), when each is drawn
// in, and all that the virtual rig draws.
inline Result<EntangledTrial> MakeEntangledTrial(std::uint64_t seed, const EntangledOptions& options) {
  std::mt19937_64 random(seed);
  Result<Scene> read = ReadScene(options.scene);
  if (!read.ok()) return read.error();
  Scene scene = std::move(read).value();
  scene.seed = seed;
  scene.duration = std::max(options.times.back(), 0.01);
  SceneGripper& hand = *scene.gripper;
  hand.gripper.carrier_radius = DrawUniform(random, 0.060, 0.085);
  hand.gripper.tilt = DrawUniform(random, -3, 2.5) * std::numbers::pi / 180;
  hand.design.stiffness_ratio = 1;
  EntangledTrial trial;
  trial.gripper = hand.gripper;
  trial.design = hand.design;

  const auto start = std::chrono::steady_clock::now();
  const Result<SimulationPlan> plan = PlanScene(scene);
  if (!plan.ok()) return plan.error();
  const Result<Simulated> run = Simulate(scene, plan.value(), options.times);
  if (!run.ok()) return run.error();
  trial.doubts = run.value().doubts;
  trial.simulate_seconds = SecondsOf(start);

  VirtualCylinder nothing;
  nothing.radius = 0;
  TruthRanges ranges = options.ranges;
  ranges.largest_sag_compliance = 0;
  const Result<VirtualTruth> truth =
      DrawTruth(hand.design, hand.gripper, {options.pull_scale, 1, hand.design.stiffness_exponent},
                {hand.pull, hand.pull_rate}, nothing, ranges, random);
  if (!truth.ok()) return truth.error();
  std::vector<TentacleActuation> pulls;
  for (int i = 0; i < hand.gripper.tentacles; ++i) {
    Result<TentacleActuation> pull = TentacleActuation::Make(hand, true, scene.seed, 0, i);
    if (!pull.ok()) return pull.error();
    pulls.push_back(std::move(pull).value());
  }
  std::vector<Eigen::Vector3d> points;
  for (std::size_t f = 0; f < options.times.size(); ++f) {
    std::vector<RodShape> rods;
    for (std::size_t i = 0; i < pulls.size(); ++i) {
      const double pull = pulls[i].PullAt(options.times[f]);
      if (f >= run.value().curves[i].curves.size()) {
        return Error{ErrorKind::kDiverged, run.value().diverged ? run.value().diverged->Sentence()
                                                                : "the simulation stopped early"};
      }
      rods.push_back({pull / options.pull_scale, pull, run.value().curves[i].curves[f]});
    }
    Result<TrueShape> shape = TrueShapeOnRods(truth.value(), hand.gripper, rods, options.times[f]);
    if (!shape.ok()) return shape.error();
    for (const TrueTentacle& one : shape.value().tentacles) {
      for (Eigen::Index k = 0; k < one.centerline.points.cols(); ++k) {
        points.push_back(one.centerline.points.col(k));
      }
    }
    trial.shapes.push_back(std::move(shape).value());
    trial.rods.push_back(std::move(rods));
  }
  TagLayoutOptions tags;
  tags.every = options.every;
  tags.each = true;
  const Result<FamilyChoice> family = ChooseFamily(trial.design, trial.gripper, tags, 0.4e-3);
  if (!family.ok()) return family.error();
  tags.family = family.value().family;
  Result<TagLayout> layout = LayOutTags(trial.design, trial.gripper, tags);
  if (!layout.ok()) return layout.error();
  trial.tags = std::move(layout).value();
  trial.glued_tags = GlueTags(trial.tags, options.ranges, random);
  for (int c = 0; c < 4; ++c) {
    trial.cameras.push_back(
        CameraThatHolds(points, (0.25 + 0.5 * c) * std::numbers::pi, options, c % 2 == 0 ? 1 : -1));
    trial.known_cameras.push_back(
        MiscalibratedCamera(trial.cameras.back(), points, options.calibration_px, random));
  }
  return trial;
}

// Films a trial and finds its tags, moment after moment.
class EntangledFilm : public TagFilm {
 public:
  EntangledFilm(const EntangledTrial& trial, std::uint64_t seed, TagTrackLevel level = TagTrackLevel::kBest)
      : TagFilm(trial.cameras, trial.tags, trial.glued_tags, trial.design.hole_diameter, seed + 1000003,
                level) {}
};

// All tentacles of a moment; `solutions` are the ones of the moment before, or empty.
inline void SolveTentacles(const EntangledTrial& trial, const TrueShape& shape, const FilmedMoment& frame,
                           const ChainOptions& options, std::vector<ChainSolution>& solutions) {
  const bool first = solutions.size() != frame.views.size();
  std::vector<ChainSolution> now;
  for (std::size_t t = 0; t < frame.views.size(); ++t) {
    now.push_back(SolveChain(KnownOf(trial.gripper, trial.design, shape, static_cast<int>(t)),
                             trial.known_cameras, frame.views[t], options, first ? nullptr : &solutions[t]));
  }
  solutions = std::move(now);
}

}  // namespace tendril::testing_support
