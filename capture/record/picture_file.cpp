#include "capture/record/picture_file.h"

#include <algorithm>
#include <cctype>
#include <opencv2/imgcodecs.hpp>
#include <string>

namespace tendril {

namespace fs = std::filesystem;

bool IsPictureFile(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const char* known : {".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".tif", ".tiff"}) {
    if (extension == known) return true;
  }
  return false;
}

Result<cv::Mat> ReadGrayPicture(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return Error{ErrorKind::kNotFound, file.string() + ": no such file"};
  try {
    cv::Mat gray = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
    if (!gray.empty()) return gray;
  } catch (const cv::Exception&) {
    // Said below.
  }
  return Error{ErrorKind::kBadInput, file.string() + ": not a picture; expected PNG, JPEG, TIFF, BMP or PGM"};
}

}  // namespace tendril
