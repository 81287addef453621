#include "calibrate/rig_from_tags.h"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "capture/track/tag_pose.h"

namespace tendril {
namespace {

// All views of one tag at one moment, by two cameras or more.
struct Shared {
  std::vector<const TagView*> views;
  std::vector<std::vector<TagPose>> poses;  // of each view, one or two
};

std::vector<Shared> SharedTags(std::span<const TagView> views, int most) {
  std::map<std::pair<std::int64_t, int>, std::map<int, const TagView*>> groups;
  for (const TagView& view : views) groups[{view.stamp, view.tag}][view.camera] = &view;
  std::vector<Shared> shared;
  for (const auto& [key, group] : groups) {
    if (group.size() < 2) continue;
    shared.emplace_back();
    for (const auto& [camera, view] : group) shared.back().views.push_back(view);
  }
  if (static_cast<int>(shared.size()) <= most) return shared;
  std::vector<Shared> some;
  for (int i = 0; i < most; ++i) {
    some.push_back(
        shared[static_cast<size_t>(static_cast<double>(i) * static_cast<double>(shared.size()) / most)]);
  }
  return some;
}

bool Near(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double angle, double distance) {
  const Eigen::Isometry3d between = a.inverse() * b;
  return between.translation().norm() < distance &&
         std::acos(std::clamp(0.5 * (between.linear().trace() - 1), -1.0, 1.0)) < angle;
}

// What most tags that two cameras share say about their relative pose. A tag's two poses give up to four
// answers each; the wrong ones scatter, the right ones agree.
struct PairPose {
  Eigen::Isometry3d a_from_b = Eigen::Isometry3d::Identity();
  int support = 0;
};

PairPose AgreedPose(const std::vector<Shared>& tags, int a, int b, double border) {
  constexpr size_t kMost = 120;
  std::vector<std::vector<Eigen::Isometry3d>> answers;
  for (const Shared& tag : tags) {
    const std::vector<TagPose>* in_a = nullptr;
    const std::vector<TagPose>* in_b = nullptr;
    for (size_t i = 0; i < tag.views.size(); ++i) {
      if (tag.views[i]->camera == a) in_a = &tag.poses[i];
      if (tag.views[i]->camera == b) in_b = &tag.poses[i];
    }
    if (in_a == nullptr || in_b == nullptr) continue;
    answers.emplace_back();
    for (const TagPose& pa : *in_a) {
      for (const TagPose& pb : *in_b)
        answers.back().push_back(pa.camera_from_tag * pb.camera_from_tag.inverse());
    }
  }
  if (answers.size() > kMost) {  // spread evenly
    std::vector<std::vector<Eigen::Isometry3d>> some;
    for (size_t i = 0; i < kMost; ++i) some.push_back(answers[i * answers.size() / kMost]);
    answers = std::move(some);
  }
  PairPose best;
  for (const auto& tried : answers) {
    for (const Eigen::Isometry3d& pose : tried) {
      int support = 0;
      for (const auto& others : answers) {
        support += std::any_of(others.begin(), others.end(), [&](const Eigen::Isometry3d& other) {
          return Near(pose, other, 0.05, border);
        });
      }
      if (support > best.support) best = {pose, support};
    }
  }
  return best;
}

struct CornersResidual {
  const Camera* camera;
  Eigen::Matrix<double, 2, 4> seen;
  Eigen::Matrix<double, 3, 4> in_tag;

  // A pose is a quaternion x, y, z, w, then a translation.
  template <class T>
  bool operator()(const T* camera_pose, const T* tag_pose, T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> camera_from_lab(camera_pose);
    const Eigen::Map<const Eigen::Vector3<T>> lab_in_camera(camera_pose + 4);
    const Eigen::Map<const Eigen::Quaternion<T>> lab_from_tag(tag_pose);
    const Eigen::Map<const Eigen::Vector3<T>> tag_in_lab(tag_pose + 4);
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector3<T> in_lab = lab_from_tag * in_tag.col(i).cast<T>() + tag_in_lab;
      const Eigen::Vector3<T> in_camera = camera_from_lab * in_lab + lab_in_camera;
      if (!(in_camera.z() > T(0))) return false;
      const Eigen::Vector2<T> pixel = ProjectInCamera<T>(*camera, in_camera);
      residual[2 * i] = pixel.x() - seen(0, i);
      residual[2 * i + 1] = pixel.y() - seen(1, i);
    }
    return true;
  }
};

// One block of 7 per pose, so that Ceres can eliminate the tags: it takes blocks that share no residual, and
// of two blocks per tag it would leave one in a dense system of thousands.
struct Pose {
  std::array<double, 7> values{0, 0, 0, 1, 0, 0, 0};

  static Pose Of(const Eigen::Isometry3d& t) {
    Pose pose;
    Eigen::Map<Eigen::Quaterniond>(pose.values.data()) = Eigen::Quaterniond(t.linear());
    Eigen::Map<Eigen::Vector3d>(pose.values.data() + 4) = t.translation();
    return pose;
  }
  Eigen::Isometry3d Isometry() const {
    Eigen::Isometry3d t = Eigen::Isometry3d::Identity();
    t.linear() = Eigen::Map<const Eigen::Quaterniond>(values.data()).normalized().toRotationMatrix();
    t.translation() = Eigen::Map<const Eigen::Vector3d>(values.data() + 4);
    return t;
  }
};

double SquaredError(const std::vector<Camera>& cameras, const Shared& tag,
                    const Eigen::Isometry3d& lab_from_tag, double border) {
  const Eigen::Matrix<double, 3, 4> corners = TagCorners3d(border);
  double sum = 0;
  for (const TagView* view : tag.views) {
    const Camera& camera = cameras[static_cast<size_t>(view->camera)];
    for (int i = 0; i < 4; ++i) {
      const auto pixel = Project(camera, lab_from_tag * corners.col(i));
      if (!pixel) return INFINITY;
      sum += (*pixel - view->corners_px.col(i)).squaredNorm();
    }
  }
  return sum;
}

// Poses of all cameras, from camera 0 outward over the pairs that most tags support.
Status StartCameras(std::vector<Camera>& cameras, const std::vector<Shared>& tags, double border) {
  const size_t n = cameras.size();
  std::map<std::pair<size_t, size_t>, PairPose> pairs;
  for (size_t a = 0; a < n; ++a) {
    for (size_t b = a + 1; b < n; ++b)
      pairs[{a, b}] = AgreedPose(tags, static_cast<int>(a), static_cast<int>(b), border);
  }
  std::vector<bool> placed(n, false);
  placed[0] = true;
  for (size_t round = 1; round < n; ++round) {
    int most = 0;
    size_t next = 0;
    Eigen::Isometry3d next_from_lab;
    for (const auto& [pair, pose] : pairs) {
      const auto& [a, b] = pair;
      if (placed[a] == placed[b] || pose.support <= most) continue;
      most = pose.support;
      next = placed[a] ? b : a;
      next_from_lab = placed[a] ? pose.a_from_b.inverse() * cameras[a].camera_from_lab
                                : pose.a_from_b * cameras[b].camera_from_lab;
    }
    if (most < 3) {
      const size_t alone =
          static_cast<size_t>(std::find(placed.begin(), placed.end(), false) - placed.begin());
      return Error{
          ErrorKind::kUnreachable,
          fmt::format(
              "camera {} ({}) shares fewer than 3 tags with the others that agree on where it stands; "
              "expected moments in which both saw the same tag",
              alone, cameras[alone].name)};
    }
    cameras[next].camera_from_lab = next_from_lab;
    placed[next] = true;
  }
  return Ok{};
}

}  // namespace

Result<RigFromTags> FitRigFromTags(std::vector<Camera> cameras, std::span<const TagView> views,
                                   const RigFromTagsOptions& options) {
  if (!(options.border > 0)) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("the tags' border is {} m; expected more than 0", options.border)};
  }
  if (cameras.size() < 2) {
    return Error{ErrorKind::kBadInput, fmt::format("{} camera; expected two or more", cameras.size())};
  }
  for (const TagView& view : views) {
    if (view.camera >= 0 && static_cast<size_t>(view.camera) < cameras.size()) continue;
    return Error{ErrorKind::kBadInput,
                 fmt::format("a view by camera {}; expected 0 to {}", view.camera, cameras.size() - 1)};
  }
  std::vector<Shared> tags = SharedTags(views, options.most_tags);
  for (Shared& tag : tags) {
    for (const TagView* view : tag.views) {
      tag.poses.push_back(
          TagPoses(cameras[static_cast<size_t>(view->camera)], view->corners_px, options.border));
    }
  }
  if (auto s = StartCameras(cameras, tags, options.border); !s.ok()) return s.error();

  std::vector<Pose> camera_poses;
  for (const Camera& camera : cameras) camera_poses.push_back(Pose::Of(camera.camera_from_lab));
  std::vector<Pose> tag_poses(tags.size());
  // Shared by all residuals, so not the problem's to delete.
  ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>> poses;
  ceres::HuberLoss robust(options.outlier_px);
  ceres::Problem::Options shared;
  shared.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  shared.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(shared);
  RigFromTags fit;
  const Eigen::Matrix<double, 3, 4> corners = TagCorners3d(options.border);
  for (size_t i = 0; i < tags.size(); ++i) {
    const Shared& tag = tags[i];
    std::optional<Eigen::Isometry3d> start;
    double least = INFINITY;
    for (size_t v = 0; v < tag.views.size(); ++v) {
      for (const TagPose& pose : tag.poses[v]) {
        const Eigen::Isometry3d lab_from_tag =
            cameras[static_cast<size_t>(tag.views[v]->camera)].camera_from_lab.inverse() *
            pose.camera_from_tag;
        const double error = SquaredError(cameras, tag, lab_from_tag, options.border);
        if (error < least) {
          least = error;
          start = lab_from_tag;
        }
      }
    }
    if (!start) continue;
    tag_poses[i] = Pose::Of(*start);
    for (const TagView* view : tag.views) {
      const auto c = static_cast<size_t>(view->camera);
      auto* cost = new ceres::AutoDiffCostFunction<CornersResidual, 8, 7, 7>(
          new CornersResidual{&cameras[c], view->corners_px, corners});
      problem.AddResidualBlock(cost, &robust, camera_poses[c].values.data(), tag_poses[i].values.data());
      problem.SetManifold(camera_poses[c].values.data(), &poses);
      ++fit.views;
    }
    problem.SetManifold(tag_poses[i].values.data(), &poses);
    ++fit.tags;
  }
  if (!problem.HasParameterBlock(camera_poses[0].values.data())) {
    return Error{ErrorKind::kUnreachable,
                 "no tag fits where the cameras seem to stand; expected other intrinsics or size"};
  }
  problem.SetParameterBlockConstant(camera_poses[0].values.data());

  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.max_num_iterations = options.most_iterations;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  fit.iterations = static_cast<int>(summary.iterations.size());
  fit.converged = summary.termination_type == ceres::CONVERGENCE;
  fit.stopped_because = summary.message;
  if (!summary.IsSolutionUsable()) {
    return Error{ErrorKind::kUnreachable, "the rig's fit failed: " + summary.message};
  }
  for (size_t c = 0; c < cameras.size(); ++c) cameras[c].camera_from_lab = camera_poses[c].Isometry();
  double sum = 0;
  int count = 0;
  for (size_t i = 0; i < tags.size(); ++i) {
    if (!problem.HasParameterBlock(tag_poses[i].values.data())) continue;
    const double error = SquaredError(cameras, tags[i], tag_poses[i].Isometry(), options.border);
    if (!std::isfinite(error)) continue;
    sum += error;
    count += 4 * static_cast<int>(tags[i].views.size());
  }
  fit.rms_px = std::sqrt(sum / std::max(1, count));
  fit.cameras = std::move(cameras);
  return fit;
}

}  // namespace tendril
