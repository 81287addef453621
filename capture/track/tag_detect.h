#pragma once
// Which AprilTags a picture shows, and where their corners are.
//
// Pixels: (0, 0) is the centre of the top left pixel. (libapriltag counts from that pixel's outer corner; its
// corners are half a pixel larger in x and y, which this wrapper takes off.)

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "model/result.h"

namespace tendril {

// A view of an 8-bit gray picture that somebody else owns.
struct GrayImage {
  const unsigned char* pixels = nullptr;
  int width = 0;   // px
  int height = 0;  // px
  int stride = 0;  // bytes from one row to the next, >= width
};

enum class TagCorners {
  kLibrary,  // exactly libapriltag's, less its half pixel
  kRefined,  // moved to where an edge model fits the black border's edges best (capture/track/tag_refine.h)
};

struct TagDetectOptions {
  std::string family = "tag36h11";
  double decimate = 1;  // quads are searched in a picture this many times smaller; costs small tags
  double blur = 0;      // standard deviation of a Gaussian before the search, px
  // libapriltag's own step. On photographs it loses one tag of 25 that is found without it, and kRefined
  // makes up for what it improves (docs/detection.md).
  bool refine_edges = false;
  // Contrast below which no edge is looked for, gray levels. The library's 5 chases sensor noise.
  int min_white_black_diff = 40;
  double decode_sharpening = 0.25;
  // Code bits that may be wrong, 0 .. 2. Families of more than 10,000 ids take at most 1: the tables for 2
  // would fill a gigabyte.
  int max_hamming = 2;
  double min_margin = 0;  // decision margin below which a tag is left out, gray levels
  int threads = 1;
  TagCorners corners = TagCorners::kRefined;
};

struct TagDetection {
  int id = 0;
  int hamming = 0;    // code bits that were wrong
  double margin = 0;  // decision margin, gray levels: how far bits are from the threshold
  Eigen::Matrix<double, 2, 4>
      corners_px;  // counter-clockwise in the picture of an upright tag, from bottom left
};

// Holds libapriltag's detector; one per thread.
class TagDetector {
 public:
  //   errors  kBadInput: unknown family, a value out of its range
  static Result<TagDetector> Create(const TagDetectOptions& options = {});

  // Tags in ascending id; where a picture shows an id twice, both.
  //   errors  kBadInput: a picture without pixels or with a stride below its width
  Result<std::vector<TagDetection>> Detect(const GrayImage& image);

  const TagDetectOptions& options() const { return options_; }

  TagDetector(TagDetector&&) noexcept;
  TagDetector& operator=(TagDetector&&) noexcept;
  ~TagDetector();

 private:
  struct Library;
  TagDetector(const TagDetectOptions& options, std::unique_ptr<Library> library);

  TagDetectOptions options_;
  std::unique_ptr<Library> library_;
};

}  // namespace tendril
