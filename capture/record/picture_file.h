#pragma once
// Picture files as the program reads them: which they are, and one of them in gray.

#include <filesystem>
#include <opencv2/core/mat.hpp>

#include "model/result.h"

namespace tendril {

// By its name: png, jpg, jpeg, bmp, pgm, tif or tiff, in any case.
bool IsPictureFile(const std::filesystem::path& file);

// (CV_8UC1)
//   errors  kNotFound: no such file; kBadInput: not a picture
Result<cv::Mat> ReadGrayPicture(const std::filesystem::path& file);

}  // namespace tendril
