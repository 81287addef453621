#include "calibrate/cameras/start_values.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/calib3d.hpp>
#include <optional>

#include "model/median.h"

namespace tendril {
namespace {

// Up to `most` of the items, spread evenly.
template <class T>
std::vector<T> SpreadOver(const std::vector<T>& items, size_t most) {
  if (items.size() <= most) return items;
  std::vector<T> some;
  for (size_t i = 0; i < most; ++i) some.push_back(items[i * items.size() / most]);
  return some;
}

double RmsOfPose(const Camera& camera, const Eigen::Matrix3Xd& points, const BoardCorners& corners,
                 const Eigen::Isometry3d& camera_from_board) {
  double sum = 0;
  for (size_t k = 0; k < corners.ids.size(); ++k) {
    const Eigen::Vector3d p = camera_from_board * Eigen::Vector3d(points.col(corners.ids[k]));
    if (!(p.z() > 0)) return std::numeric_limits<double>::infinity();
    sum +=
        (ProjectInCamera<double>(camera, p) - corners.pixels.col(static_cast<Eigen::Index>(k))).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(corners.ids.size()));
}

// The plane of a view's corners: a body with tags on several sides may show one side only.
struct PlaneOfCorners {
  Eigen::Isometry3d from_board = Eigen::Isometry3d::Identity();  // z = 0 there
  bool is_flat = true;

  explicit PlaneOfCorners(const std::vector<Eigen::Vector3d>& corners) {
    if (std::all_of(corners.begin(), corners.end(), [](const Eigen::Vector3d& p) { return p.z() == 0; }))
      return;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : corners) middle += p / static_cast<double>(corners.size());
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& p : corners) spread += (p - middle) * (p - middle).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(spread);  // ascending
    constexpr double kFlat = 0.02;                                       // of the second largest extent
    is_flat = eigen.eigenvalues()[0] < kFlat * kFlat * eigen.eigenvalues()[1];
    Eigen::Matrix3d axes = eigen.eigenvectors().rowwise().reverse();
    if (axes.determinant() < 0) axes.col(2) *= -1;
    from_board.linear() = axes.transpose();
    from_board.translation() = -axes.transpose() * middle;
  }
};

LensPrior PriorOf(const Camera& camera) {
  const double f = camera.focal_x_px;
  const double reach = 0.5 * std::hypot(camera.width_px, camera.height_px) / f;  // of the picture's corner
  const double width = camera.width_px;
  LensPrior prior;
  prior.mean = {f, f, camera.center_x_px, camera.center_y_px, 0, 0, 0, 0, 0};
  prior.sigma = {0.5 * f, 0.5 * f, 0.25 * width, 0.25 * width, 1, 1, 1, 1, 1};
  if (camera.distortion == Distortion::kBrown) {
    prior.sigma[4] = std::pow(reach, -2);
    prior.sigma[5] = std::pow(reach, -4);
    prior.sigma[6] = prior.sigma[7] = 1 / reach;
    prior.sigma[8] = std::pow(reach, -6);
  } else if (camera.distortion == Distortion::kEquidistant) {
    for (int i = 0; i < 4; ++i) {
      prior.sigma[static_cast<size_t>(4 + i)] = std::pow(std::min(reach, 1.6), -2 * (i + 1));
    }
  }
  return prior;
}

}  // namespace

std::vector<BoardPose> PosesOfBoard(const Camera& camera, const Eigen::Matrix3Xd& points,
                                    const BoardCorners& corners) {
  std::vector<Eigen::Vector3d> on_board;
  std::vector<cv::Point2d> rays;
  for (size_t k = 0; k < corners.ids.size(); ++k) {
    const auto ray = RayOfPixel(camera, corners.pixels.col(static_cast<Eigen::Index>(k)));
    if (!ray || ray->z() < 0.05) continue;  // beyond 87 degrees a plane at z = 1 is no place for pixels
    on_board.emplace_back(points.col(corners.ids[k]));
    rays.emplace_back(ray->x() / ray->z(), ray->y() / ray->z());
  }
  std::vector<BoardPose> poses;
  if (on_board.size() < 4 || 10 * on_board.size() < 9 * corners.ids.size()) return poses;
  const PlaneOfCorners plane(on_board);
  std::vector<cv::Point3d> flat;
  for (const Eigen::Vector3d& p : on_board) {
    const Eigen::Vector3d q = plane.from_board * p;
    flat.emplace_back(q.x(), q.y(), plane.is_flat ? 0 : q.z());
  }
  try {
    std::vector<cv::Mat> turns;
    std::vector<cv::Mat> shifts;
    cv::solvePnPGeneric(flat, rays, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), turns, shifts, false,
                        plane.is_flat ? cv::SOLVEPNP_IPPE : cv::SOLVEPNP_SQPNP);
    for (size_t i = 0; i < turns.size(); ++i) {
      const Eigen::Vector3d turn(turns[i].at<double>(0), turns[i].at<double>(1), turns[i].at<double>(2));
      BoardPose pose;
      if (turn.norm() > 0) {
        pose.camera_from_board.linear() =
            Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
      }
      pose.camera_from_board.translation() << shifts[i].at<double>(0), shifts[i].at<double>(1),
          shifts[i].at<double>(2);
      pose.camera_from_board = pose.camera_from_board * plane.from_board;
      if (!pose.camera_from_board.matrix().allFinite()) continue;
      pose.rms_px = RmsOfPose(camera, points, corners, pose.camera_from_board);
      if (std::isfinite(pose.rms_px)) poses.push_back(pose);
    }
  } catch (const cv::Exception&) {
    poses.clear();  // corners on a line
  }
  std::sort(poses.begin(), poses.end(),
            [](const BoardPose& a, const BoardPose& b) { return a.rms_px < b.rms_px; });
  return poses;
}

Result<StartedLens> StartLens(const Camera& camera, const std::vector<const BoardView*>& views,
                              const Eigen::Matrix3Xd& points) {
  constexpr size_t kLeastCorners = 6;
  constexpr size_t kMostTried = 12;
  constexpr size_t kMostFitted = 40;
  std::vector<const BoardView*> usable;
  for (const BoardView* view : views) {
    if (view->corners.ids.size() >= kLeastCorners) usable.push_back(view);
  }
  if (usable.size() < 3) {
    return Error{
        ErrorKind::kUnreachable,
        fmt::format("camera {} shows {} or more corners of the board in {} pictures; expected 3 at the "
                    "least, 10 or more to be sure",
                    camera.name, kLeastCorners, usable.size())};
  }
  Camera best = camera;
  best.center_x_px = 0.5 * (camera.width_px - 1);
  best.center_y_px = 0.5 * (camera.height_px - 1);
  best.coefficients = {};
  double least = std::numeric_limits<double>::infinity();
  Camera tried = best;
  for (double focal = 0.15 * camera.width_px; focal < 8 * camera.width_px; focal *= 1.15) {
    tried.focal_x_px = tried.focal_y_px = focal;
    std::vector<double> errors;
    for (const BoardView* view : SpreadOver(usable, kMostTried)) {
      const auto poses = PosesOfBoard(tried, points, view->corners);
      errors.push_back(poses.empty() ? std::numeric_limits<double>::infinity() : poses[0].rms_px);
    }
    const double error = Median(errors);
    if (error >= least) continue;
    least = error;
    best = tried;
  }
  if (!std::isfinite(least)) {
    return Error{
        ErrorKind::kUnreachable,
        fmt::format("no focal length explains the board in camera {}'s pictures; expected a flat board "
                    "of the stated layout",
                    camera.name)};
  }

  const LensPrior prior = PriorOf(best);
  Bundle bundle{
      .cameras = {best}, .sigma_px = {std::max(0.1, least)}, .points = points, .lens_priors = {prior}};
  std::vector<BoardView> alone;  // as camera 0 of a bundle of its own
  for (const BoardView* view : SpreadOver(usable, kMostFitted)) {
    alone.push_back(*view);
    alone.back().camera = 0;
  }
  for (const BoardView& view : alone) {
    const auto poses = PosesOfBoard(best, points, view.corners);
    if (poses.empty()) continue;
    bundle.places.push_back({view.stamp, view.target, poses[0].camera_from_board, {&view}});
  }
  BundleOptions options{.fit_distortion = false, .most_iterations = 50};
  for (int round = 0; round < 3; ++round) {
    const auto fit = AdjustBundle(bundle, options);
    if (!fit.ok()) return Error(fit.error()).Within("camera " + camera.name);
    MeasureSigma(bundle);
    options.fit_distortion = true;
  }
  Camera lens = bundle.cameras[0];
  lens.camera_from_lab = camera.camera_from_lab;
  return StartedLens{lens, prior};
}

namespace {

struct SeenBoard {
  std::map<int, const BoardView*> views;  // by camera
  std::map<int, std::vector<BoardPose>> poses;
};

using Moments = std::map<std::pair<std::int64_t, int>, SeenBoard>;

Moments GroupByMoment(const std::vector<Camera>& cameras, const std::vector<const BoardView*>& views,
                      const Eigen::Matrix3Xd& points) {
  Moments moments;
  for (const BoardView* view : views) {
    auto poses = PosesOfBoard(cameras[static_cast<size_t>(view->camera)], points, view->corners);
    if (poses.empty()) continue;
    // The second pose is of use only where it is nearly as good.
    if (poses.size() > 1 && poses[1].rms_px > 3 * poses[0].rms_px + 0.1) poses.resize(1);
    SeenBoard& board = moments[{view->stamp, view->target}];
    board.views[view->camera] = view;
    board.poses[view->camera] = std::move(poses);
  }
  return moments;
}

// What most boards that two cameras share say about their relative pose.
struct PairPose {
  Eigen::Isometry3d a_from_b = Eigen::Isometry3d::Identity();
  int support = 0;
  int moments = 0;
};

PairPose AgreedPose(const std::vector<SeenBoard>& boards, int a, int b) {
  struct Answer {
    Eigen::Isometry3d a_from_b;
    double near = 0;  // m: answers that differ less agree
  };
  std::vector<std::vector<Answer>> answers;
  for (const SeenBoard& board : boards) {
    const auto in_a = board.poses.find(a);
    const auto in_b = board.poses.find(b);
    if (in_a == board.poses.end() || in_b == board.poses.end()) continue;
    answers.emplace_back();
    for (const BoardPose& pa : in_a->second) {
      for (const BoardPose& pb : in_b->second) {
        const double distance =
            pa.camera_from_board.translation().norm() + pb.camera_from_board.translation().norm();
        answers.back().push_back({pa.camera_from_board * pb.camera_from_board.inverse(), 0.05 * distance});
      }
    }
  }
  PairPose best;
  best.moments = static_cast<int>(answers.size());
  constexpr size_t kMost = 120;
  answers = SpreadOver(answers, kMost);
  for (const auto& tried : answers) {
    for (const Answer& answer : tried) {
      int support = 0;
      for (const auto& others : answers) {
        support += std::any_of(others.begin(), others.end(), [&](const Answer& other) {
          const Eigen::Isometry3d between = answer.a_from_b.inverse() * other.a_from_b;
          return between.translation().norm() < answer.near &&
                 Eigen::AngleAxisd(between.linear()).angle() < 0.08;
        });
      }
      if (support > best.support) {
        best.a_from_b = answer.a_from_b;
        best.support = support;
      }
    }
  }
  return best;
}

std::string Names(const std::vector<Camera>& cameras, const std::vector<bool>& in, bool which) {
  std::string names;
  for (size_t c = 0; c < cameras.size(); ++c) {
    if (in[c] == which) names += (names.empty() ? "" : ", ") + cameras[c].name;
  }
  return names;
}

}  // namespace

std::vector<BoardPlace> PlaceBoards(const std::vector<Camera>& cameras,
                                    const std::vector<const BoardView*>& views,
                                    const Eigen::Matrix3Xd& points) {
  std::vector<BoardPlace> places;
  for (const auto& [moment, board] : GroupByMoment(cameras, views, points)) {
    std::optional<Eigen::Isometry3d> start;
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [camera, poses] : board.poses) {
      for (const BoardPose& pose : poses) {
        const Eigen::Isometry3d lab_from_board =
            cameras[static_cast<size_t>(camera)].camera_from_lab.inverse() * pose.camera_from_board;
        double sum = 0;
        for (const auto& [other, view] : board.views) {
          const Camera& by = cameras[static_cast<size_t>(other)];
          sum += std::pow(RmsOfPose(by, points, view->corners, by.camera_from_lab * lab_from_board), 2);
        }
        if (sum < least) {
          least = sum;
          start = lab_from_board;
        }
      }
    }
    if (!start) continue;
    BoardPlace place{moment.first, moment.second, *start, {}};
    for (const auto& [camera, view] : board.views) place.views.push_back(view);
    places.push_back(std::move(place));
  }
  return places;
}

Result<StartedRig> StartRig(std::vector<Camera> cameras, const std::vector<BoardView>& views,
                            const Eigen::Matrix3Xd& points) {
  std::vector<const BoardView*> all;
  for (const BoardView& view : views) all.push_back(&view);
  const Moments by_moment = GroupByMoment(cameras, all, points);
  std::vector<SeenBoard> boards;
  for (const auto& [moment, board] : by_moment) boards.push_back(board);

  const int n = static_cast<int>(cameras.size());
  StartedRig rig;
  std::map<std::pair<int, int>, PairPose> pairs;
  for (int a = 0; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      const PairPose pair = AgreedPose(boards, a, b);
      if (pair.moments == 0) continue;
      pairs[{a, b}] = pair;
      rig.links.push_back({a, b, pair.moments});
    }
  }
  std::vector<bool> placed(static_cast<size_t>(n), false);
  placed[0] = true;
  for (int round = 1; round < n; ++round) {
    int most = 0;
    size_t next = 0;
    Eigen::Isometry3d next_from_lab;
    for (const auto& [pair, pose] : pairs) {
      const auto a = static_cast<size_t>(pair.first);
      const auto b = static_cast<size_t>(pair.second);
      if (placed[a] == placed[b] || pose.support <= most) continue;
      most = pose.support;
      next = placed[a] ? b : a;
      next_from_lab = placed[a] ? pose.a_from_b.inverse() * cameras[a].camera_from_lab
                                : pose.a_from_b * cameras[b].camera_from_lab;
    }
    if (most == 0) {
      return Error{ErrorKind::kUnreachable,
                   fmt::format("the cameras are not linked: {} never see{} the board at a moment when {} "
                               "see{} it; expected pictures of equal stamp that show it to one of each (or a "
                               "call per group)",
                               Names(cameras, placed, false),
                               std::count(placed.begin(), placed.end(), false) > 1 ? "" : "s",
                               Names(cameras, placed, true),
                               std::count(placed.begin(), placed.end(), true) > 1 ? "" : "s")};
    }
    cameras[next].camera_from_lab = next_from_lab;
    placed[next] = true;
  }

  rig.bundle.places = PlaceBoards(cameras, all, points);
  rig.bundle.sigma_px.assign(cameras.size(), 1);
  rig.bundle.cameras = std::move(cameras);
  rig.bundle.points = points;
  return rig;
}

}  // namespace tendril
