#include "capture/track/tag_pose.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "model/check.h"

namespace tendril {
namespace {

double RmsPx(const Camera& camera, const Eigen::Isometry3d& camera_from_tag,
             const Eigen::Matrix<double, 2, 4>& seen, const Eigen::Matrix<double, 3, 4>& corners) {
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d p = camera_from_tag * corners.col(i);
    if (!(p.z() > 0)) return INFINITY;
    sum += (ProjectInCamera<double>(camera, p) - seen.col(i)).squaredNorm();
  }
  return std::sqrt(sum / 4);
}

}  // namespace

Eigen::Matrix<double, 3, 4> TagCorners3d(double border) {
  const double h = 0.5 * border;
  Eigen::Matrix<double, 3, 4> corners;
  corners << -h, h, h, -h,  //
      h, h, -h, -h,         //
      0, 0, 0, 0;
  return corners;
}

std::vector<TagPose> TagPoses(const Camera& camera, const Eigen::Matrix<double, 2, 4>& corners_px,
                              double border) {
  TENDRIL_CHECK(border > 0);
  // In units of the border, so that OpenCV's absolute tolerances do not see millimetres.
  const Eigen::Matrix<double, 3, 4> unit = TagCorners3d(1);
  std::vector<cv::Point3d> object;
  std::vector<cv::Point2d> image;
  for (int i = 0; i < 4; ++i) {
    const auto ray = RayOfPixel(camera, corners_px.col(i));
    if (!ray || !(ray->z() > 1e-3)) return {};
    object.emplace_back(unit(0, i), unit(1, i), 0);
    image.emplace_back(ray->x() / ray->z(), ray->y() / ray->z());
  }
  std::vector<TagPose> poses;
  try {
    const cv::Matx33d identity = cv::Matx33d::eye();
    std::vector<cv::Mat> turns;
    std::vector<cv::Mat> shifts;
    cv::solvePnPGeneric(object, image, identity, cv::noArray(), turns, shifts, false,
                        cv::SOLVEPNP_IPPE_SQUARE);
    for (size_t i = 0; i < turns.size(); ++i) {
      cv::solvePnPRefineLM(object, image, identity, cv::noArray(), turns[i], shifts[i]);
      cv::Matx33d turn;
      cv::Rodrigues(turns[i], turn);
      TagPose pose;
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
          pose.camera_from_tag.linear()(row, column) = turn(row, column);
        pose.camera_from_tag.translation()[row] = border * shifts[i].at<double>(row);
      }
      if (!pose.camera_from_tag.matrix().allFinite()) continue;
      pose.rms_px = RmsPx(camera, pose.camera_from_tag, corners_px, border * unit);
      if (std::isfinite(pose.rms_px)) poses.push_back(pose);
    }
  } catch (const cv::Exception&) {
    return {};
  }
  std::sort(poses.begin(), poses.end(),
            [](const TagPose& a, const TagPose& b) { return a.rms_px < b.rms_px; });
  return poses;
}

}  // namespace tendril
