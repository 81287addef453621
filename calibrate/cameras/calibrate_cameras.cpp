#include "calibrate/cameras/calibrate_cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "calibrate/cameras/start_values.h"
#include "calibrate/cameras/weakness.h"
#include "calibrate/student_t.h"

namespace tendril {
namespace {

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

Status Check(const std::vector<Camera>& cameras, const std::vector<BoardView>& views,
             const Eigen::Matrix3Xd& points, const CalibrateCamerasOptions& options) {
  const auto bad = [](const std::string& message) { return Error{ErrorKind::kBadInput, message}; };
  if (cameras.empty()) return bad("no cameras; expected one or more");
  if (points.cols() < 4) return bad(fmt::format("a board of {} corners; expected 4 or more", points.cols()));
  if (!(options.board_sigma >= 0)) {
    return bad(fmt::format("the board's sigma is {} m; expected 0 or more", options.board_sigma));
  }
  if (!(options.outlier > 0)) return bad(fmt::format("outlier is {}; expected more than 0", options.outlier));
  if (!(options.confidence > 0 && options.confidence < 1)) {
    return bad(fmt::format("confidence is {}; expected between 0 and 1", options.confidence));
  }
  if (!options.lenses.empty() && options.lenses.size() != cameras.size()) {
    return bad(fmt::format("{} known lenses for {} cameras", options.lenses.size(), cameras.size()));
  }
  if (cameras.size() == 1 && !options.lenses.empty() && !options.refine_lenses) {
    return bad(
        "one camera, whose lens is given, leaves nothing to fit; expected more cameras, or a lens to refine");
  }
  for (const Camera& camera : cameras) {
    if (camera.width_px > 0 && camera.height_px > 0) continue;
    return bad(
        fmt::format("camera {} has pictures of {} x {} px", camera.name, camera.width_px, camera.height_px));
  }
  for (const BoardView& view : views) {
    if (view.camera < 0 || static_cast<size_t>(view.camera) >= cameras.size()) {
      return bad(fmt::format("a view by camera {}; expected 0 to {}", view.camera, cameras.size() - 1));
    }
    if (view.corners.pixels.cols() != static_cast<Eigen::Index>(view.corners.ids.size()) ||
        !view.corners.pixels.allFinite()) {
      return bad(fmt::format("a view by camera {} with corners that have no place", view.camera));
    }
    for (const int id : view.corners.ids) {
      if (id < 0 || id >= points.cols())
        return bad(fmt::format("corner {} on a board of {}", id, points.cols()));
    }
  }
  return Ok{};
}

BundleOptions OptionsOf(const CalibrateCamerasOptions& options) {
  return {.fit_intrinsics = options.lenses.empty() || options.refine_lenses,
          .fit_distortion = true,
          .fit_cameras = true,
          .point_sigma = options.board_sigma,
          .outlier = options.outlier};
}

// Moves cameras and boards together, so that the board of lab.stamp lies where it was.
Status MoveToLab(const BoardInLab& lab, Bundle& bundle) {
  const auto there = std::find_if(bundle.places.begin(), bundle.places.end(),
                                  [&](const BoardPlace& p) { return p.stamp == lab.stamp; });
  if (there == bundle.places.end()) {
    return Error{
        ErrorKind::kBadInput,
        fmt::format("the lab's frame is to be the board's in picture {}, but no camera saw it there; "
                    "expected a picture that shows the board",
                    lab.stamp)};
  }
  const Eigen::Isometry3d moved = lab.lab_from_board * there->lab_from_board.inverse();
  for (Camera& camera : bundle.cameras) camera.camera_from_lab = camera.camera_from_lab * moved.inverse();
  for (BoardPlace& place : bundle.places) place.lab_from_board = moved * place.lab_from_board;
  return Ok{};
}

// What each parameter of the covariance has in `a` more than in `b`.
Eigen::VectorXd Difference(const std::vector<Camera>& a, const std::vector<Camera>& b,
                           const BundleCovariance& order) {
  Eigen::VectorXd difference = Eigen::VectorXd::Zero(order.covariance.rows());
  for (size_t c = 0; c < a.size(); ++c) {
    const Eigen::Index end = order.pose_at[c] >= 0 ? order.pose_at[c]
                             : c + 1 < a.size()    ? order.intrinsics_at[c + 1]
                                                   : difference.size();
    for (Eigen::Index i = order.intrinsics_at[c]; i < end; ++i) {
      const auto k = static_cast<size_t>(i - order.intrinsics_at[c]);
      const auto value = [k](const Camera& camera) {
        const double first[4] = {camera.focal_x_px, camera.focal_y_px, camera.center_x_px,
                                 camera.center_y_px};
        return k < 4 ? first[k] : camera.coefficients[k - 4];
      };
      difference[i] = value(a[c]) - value(b[c]);
    }
    if (order.pose_at[c] < 0) continue;
    const Eigen::Isometry3d lab_from_a = a[c].camera_from_lab.inverse();
    const Eigen::Isometry3d lab_from_b = b[c].camera_from_lab.inverse();
    const Eigen::AngleAxisd turn(lab_from_a.linear() * lab_from_b.linear().transpose());
    difference.segment<3>(order.pose_at[c]) = lab_from_a.translation() - lab_from_b.translation();
    difference.segment<3>(order.pose_at[c] + 3) = turn.angle() * turn.axis();
  }
  return difference;
}

// Whether each camera still has three views or more and all hang together.
bool CanBeFitted(const Bundle& bundle) {
  const size_t n = bundle.cameras.size();
  std::vector<int> views(n, 0);
  std::vector<size_t> group(n);
  std::iota(group.begin(), group.end(), size_t{0});
  for (const BoardPlace& place : bundle.places) {
    for (const BoardView* view : place.views) {
      const auto c = static_cast<size_t>(view->camera);
      ++views[c];
      const size_t joined = group[static_cast<size_t>(place.views[0]->camera)];
      const size_t from = group[c];
      for (size_t& g : group) {
        if (g == from) g = joined;
      }
    }
  }
  return std::all_of(views.begin(), views.end(), [](int count) { return count >= 3; }) &&
         std::all_of(group.begin(), group.end(), [&](size_t g) { return g == group[0]; });
}

Status CrossValidate(const Bundle& fitted, const CalibrateCamerasOptions& options, const Progress& progress,
                     CameraCalibration& answer) {
  std::map<std::int64_t, int> rank;
  for (const BoardPlace& place : fitted.places) rank.emplace(place.stamp, 0);
  int next = 0;
  for (auto& [stamp, number] : rank) number = next++;
  const int folds = std::min(options.folds, next);
  const size_t n = fitted.cameras.size();
  std::vector<double> sum2(n, 0);
  std::vector<double> count(n, 0);
  std::vector<Eigen::VectorXd> differences;
  for (int fold = 0; fold < folds && folds > 1; ++fold) {
    if (progress && !progress(0.4 + 0.6 * fold / folds)) return Error{ErrorKind::kStopped, "stopped"};
    Bundle kept = fitted;
    std::erase_if(kept.places, [&](const BoardPlace& p) { return rank[p.stamp] % folds == fold; });
    if (!CanBeFitted(kept)) continue;
    const auto fit = AdjustBundle(kept, OptionsOf(options));
    if (!fit.ok()) continue;
    differences.push_back(Difference(kept.cameras, fitted.cameras, answer.covariance));
    std::vector<const BoardView*> held;
    for (const BoardPlace& place : fitted.places) {
      if (rank[place.stamp] % folds == fold) held.insert(held.end(), place.views.begin(), place.views.end());
    }
    std::vector<double> corners(n, 0);
    for (const BoardView* view : held) {
      corners[static_cast<size_t>(view->camera)] += static_cast<double>(view->corners.ids.size());
    }
    const BundleRms rms = RmsWithPosesFitted(kept.cameras, held, kept.points);
    for (size_t c = 0; c < n; ++c) {
      if (corners[c] == 0) continue;
      sum2[c] += corners[c] * rms.by_camera_px[c] * rms.by_camera_px[c];
      count[c] += corners[c];
    }
  }
  double all2 = 0;
  double all = 0;
  for (size_t c = 0; c < n; ++c) {
    answer.reports[c].held_out_rms_px = count[c] > 0 ? std::sqrt(sum2[c] / count[c]) : kNotKnown;
    all2 += sum2[c];
    all += count[c];
  }
  answer.held_out_rms_px = all > 0 ? std::sqrt(all2 / all) : kNotKnown;
  answer.folds_used = static_cast<int>(differences.size());
  answer.refit_ratio = kNotKnown;
  if (differences.size() < 2) return Ok{};
  const auto k = static_cast<double>(differences.size());
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(differences[0].size());
  for (const Eigen::VectorXd& d : differences) mean += d / k;
  double ratio2 = 0;
  double known = 0;
  for (Eigen::Index i = 0; i < mean.size(); ++i) {
    const double variance = (options.independent_corners ? answer.covariance.independent_covariance
                                                         : answer.covariance.covariance)(i, i);
    if (!std::isfinite(variance) || !(variance > 0)) continue;
    double scatter = 0;
    for (const Eigen::VectorXd& d : differences) scatter += std::pow(d[i] - mean[i], 2);
    ratio2 += (k - 1) / k * scatter / variance;
    ++known;
  }
  if (known > 0) answer.refit_ratio = std::sqrt(ratio2 / known);
  return Ok{};
}

void Report(const Bundle& bundle, const CalibrateCamerasOptions& options, CameraCalibration& answer) {
  const BundleRms rms = RmsOf(bundle);
  answer.rms_px = rms.all_px;
  answer.corners = rms.corners;
  answer.reports.resize(bundle.cameras.size());
  const bool independent = options.independent_corners;
  const Eigen::MatrixXd& covariance =
      independent ? answer.covariance.independent_covariance : answer.covariance.covariance;
  for (size_t c = 0; c < bundle.cameras.size(); ++c) {
    const Camera& camera = bundle.cameras[c];
    CalibratedCamera& report = answer.reports[c];
    report.rms_px = rms.by_camera_px[c];
    report.sigma_px = bundle.sigma_px[c];
    const auto add = [&](const std::string& name, double value, Eigen::Index at) {
      const double error = at < 0 ? 0 : std::sqrt(covariance(at, at));
      const double dof = at < 0        ? 1
                         : independent ? answer.covariance.independent_degrees_of_freedom
                                       : answer.covariance.degrees_of_freedom[at];
      const double t = dof > 0 ? StudentTQuantile(0.5 + 0.5 * options.confidence, dof) : kNotKnown;
      report.parameters.push_back({name, value, error, value - t * error, value + t * error});
    };
    const int lens = IntrinsicsOf(camera.distortion);
    const bool fitted = options.lenses.empty() || options.refine_lenses;
    const Eigen::Index at = answer.covariance.intrinsics_at[c];
    const auto place = [&](int i) { return fitted ? at + i : Eigen::Index{-1}; };
    add("focal_x_px", camera.focal_x_px, place(0));
    add("focal_y_px", camera.focal_y_px, place(1));
    add("center_x_px", camera.center_x_px, place(2));
    add("center_y_px", camera.center_y_px, place(3));
    const char* const brown[5] = {"k1", "k2", "p1", "p2", "k3"};
    const char* const fisheye[5] = {"k1", "k2", "k3", "k4", ""};
    for (int i = 4; i < lens; ++i) {
      add((camera.distortion == Distortion::kBrown ? brown : fisheye)[i - 4],
          camera.coefficients[static_cast<size_t>(i - 4)], place(i));
    }
    report.lens_covariance =
        fitted ? Eigen::MatrixXd(covariance.block(at, at, lens, lens)) : Eigen::MatrixXd::Zero(lens, lens);
    if (answer.covariance.pose_at[c] < 0) continue;
    const Eigen::Isometry3d lab_from_camera = camera.camera_from_lab.inverse();
    const Eigen::AngleAxisd turn(lab_from_camera.linear());
    const char* const axes[3] = {"x", "y", "z"};
    for (int i = 0; i < 3; ++i) {
      add(fmt::format("position_{}_m", axes[i]), lab_from_camera.translation()[i],
          answer.covariance.pose_at[c] + i);
    }
    for (int i = 0; i < 3; ++i) {
      add(fmt::format("rotation_{}_rad", axes[i]), turn.angle() * turn.axis()[i],
          answer.covariance.pose_at[c] + 3 + i);
    }
  }
  std::set<std::int64_t> stamps;
  for (const BoardPlace& place : bundle.places) {
    stamps.insert(place.stamp);
    for (const BoardView* view : place.views) {
      CalibratedCamera& report = answer.reports[static_cast<size_t>(view->camera)];
      ++report.views;
      ++answer.views;
      report.corners += static_cast<int>(view->corners.ids.size());
    }
  }
  answer.stamps = static_cast<int>(stamps.size());
}

}  // namespace

BundleRms RmsWithPosesFitted(const std::vector<Camera>& cameras, const std::vector<const BoardView*>& views,
                             const Eigen::Matrix3Xd& points) {
  Bundle bundle{.cameras = cameras,
                .sigma_px = std::vector<double>(cameras.size(), 1),
                .points = points,
                .places = PlaceBoards(cameras, views, points)};
  const BundleOptions poses_only{.fit_intrinsics = false, .fit_cameras = false, .outlier = 1e9};
  if (const auto fit = AdjustBundle(bundle, poses_only); !fit.ok()) {
    return {std::vector<double>(cameras.size(), kNotKnown), kNotKnown, 0};
  }
  return RmsOf(bundle);
}

Result<CameraCalibration> CalibrateCameras(const std::vector<Camera>& cameras,
                                           const std::vector<BoardView>& views,
                                           const Eigen::Matrix3Xd& points,
                                           const CalibrateCamerasOptions& options, const Progress& progress) {
  const auto began = std::chrono::steady_clock::now();
  if (auto s = Check(cameras, views, points, options); !s.ok()) return s.error();
  std::vector<Camera> started;
  std::vector<LensPrior> priors;
  for (size_t c = 0; c < cameras.size(); ++c) {
    if (progress && !progress(0.3 * static_cast<double>(c) / static_cast<double>(cameras.size()))) {
      return Error{ErrorKind::kStopped, "stopped"};
    }
    if (!options.lenses.empty()) {
      started.push_back(options.lenses[c]);
      continue;
    }
    std::vector<const BoardView*> own;
    for (const BoardView& view : views) {
      if (view.camera == static_cast<int>(c)) own.push_back(&view);
    }
    auto lens = StartLens(cameras[c], own, points);
    if (!lens.ok()) return lens.error();
    started.push_back(lens.value().camera);
    priors.push_back(lens.value().prior);
  }
  auto rig = StartRig(std::move(started), views, points);
  if (!rig.ok()) return rig.error();
  Bundle& bundle = rig.value().bundle;
  bundle.layout = points;
  bundle.lens_priors = priors;
  if (bundle.places.empty()) {
    return Error{ErrorKind::kUnreachable, "no picture shows 4 corners of the board or more"};
  }

  CameraCalibration answer;
  answer.start_rms_px = RmsOf(bundle).all_px;
  MeasureSigma(bundle);
  // Weights follow the residuals; a board that bends comes last, when all else is near its place.
  BundleOptions fit_options = OptionsOf(options);
  for (int round = 0; round < 5; ++round) {
    fit_options.point_sigma = round < 2 ? 0 : options.board_sigma;
    const auto fit = AdjustBundle(bundle, fit_options);
    if (!fit.ok()) return fit.error();
    answer.iterations += fit.value().iterations;
    answer.converged = fit.value().converged;
    const std::vector<double> before = bundle.sigma_px;
    if (round == 4) break;
    MeasureSigma(bundle);
    double change = 0;
    for (size_t c = 0; c < before.size(); ++c) {
      change = std::max(change, std::abs(bundle.sigma_px[c] / before[c] - 1));
    }
    if (round >= 2 && change < 0.01) break;
  }
  if (progress && !progress(0.4)) return Error{ErrorKind::kStopped, "stopped"};
  if (options.lab) {
    if (auto s = MoveToLab(*options.lab, bundle); !s.ok()) return s.error();
  }
  answer.covariance = CovarianceOf(bundle, fit_options);
  Report(bundle, options, answer);
  for (const BoardPlace& place : bundle.places) {
    for (const BoardView* view : place.views) {
      const auto c = static_cast<size_t>(view->camera);
      for (size_t k = 0; k < view->corners.ids.size(); ++k) {
        const Eigen::Vector3d on_board = bundle.points.col(view->corners.ids[k]);
        const Eigen::Vector3d p = bundle.cameras[c].camera_from_lab * (place.lab_from_board * on_board);
        const Eigen::Vector2d off = ProjectInCamera<double>(bundle.cameras[c], p) -
                                    view->corners.pixels.col(static_cast<Eigen::Index>(k));
        answer.down_weighted += off.norm() > options.outlier * bundle.sigma_px[c];
      }
    }
  }
  if (auto s = CrossValidate(bundle, options, progress, answer); !s.ok()) return s.error();
  answer.cameras = bundle.cameras;
  answer.points = bundle.points;
  answer.weaknesses = WeaknessesOf(answer, bundle, rig.value().links);
  answer.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return answer;
}

}  // namespace tendril
