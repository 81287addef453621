#pragma once
// Tags drawn over the picture that shows them.

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "model/result.h"

namespace tendril::cli {

struct DrawnTag {
  int id = 0;
  Eigen::Matrix<double, 2, 4> corners_px;  // in the detector's order
};

// Outlines and ids in colour over a gray picture (CV_8UC1); the tag's lower edge in another colour.
cv::Mat DrawTags(const cv::Mat& gray, const std::vector<DrawnTag>& tags);

// Replaces the file whole or not at all; its extension says the format.
//   errors  kIo: no such folder, a format that is not known, disk full
Status WritePicture(const cv::Mat& picture, const std::string& file);

}  // namespace tendril::cli
