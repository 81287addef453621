#include "capture/track/tag_detect.h"

#include <apriltag/apriltag.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "capture/rig/tag_family.h"
#include "capture/track/tag_refine.h"

namespace tendril {

struct TagDetector::Library {
  apriltag_family* family = nullptr;
  apriltag_detector* detector = nullptr;

  Library() = default;
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
  ~Library() {
    if (detector != nullptr) apriltag_detector_destroy(detector);
    DestroyFamily(family);
  }
};

TagDetector::TagDetector(const TagDetectOptions& options, std::unique_ptr<Library> library)
    : options_(options), library_(std::move(library)) {}
TagDetector::TagDetector(TagDetector&&) noexcept = default;
TagDetector& TagDetector::operator=(TagDetector&&) noexcept = default;
TagDetector::~TagDetector() = default;

namespace {

Status CheckOptions(const TagDetectOptions& options) {
  const auto bad = [](const char* what, double value, const char* expected) {
    return Error{ErrorKind::kBadInput, fmt::format("{} is {}; expected {}", what, value, expected)};
  };
  if (!(options.decimate >= 1 && options.decimate <= 16)) return bad("decimate", options.decimate, "1 to 16");
  if (!(options.blur >= 0 && options.blur <= 10)) return bad("blur", options.blur, "0 to 10 px");
  if (options.min_white_black_diff < 0 || options.min_white_black_diff > 255) {
    return bad("smallest contrast", options.min_white_black_diff, "0 to 255 gray levels");
  }
  if (options.max_hamming < 0 || options.max_hamming > 2) {
    return bad("largest number of wrong bits", options.max_hamming, "0 to 2");
  }
  if (options.threads < 1 || options.threads > 256) return bad("threads", options.threads, "1 to 256");
  return Ok{};
}

}  // namespace

Result<TagDetector> TagDetector::Create(const TagDetectOptions& options) {
  if (auto s = CheckOptions(options); !s.ok()) return s.error();
  if (const auto known = FamilyOf(options.family); !known.ok()) return known.error();

  auto library = std::make_unique<Library>();
  library->family = CreateFamily(options.family);
  library->detector = apriltag_detector_create();
  apriltag_detector* detector = library->detector;
  const int bits = library->family->ncodes > 10000 ? std::min(options.max_hamming, 1) : options.max_hamming;
  apriltag_detector_add_family_bits(detector, library->family, bits);
  if (library->family->impl == nullptr) {
    return Error{ErrorKind::kIo,
                 "no memory for the tables of " + options.family + "; expected fewer wrong bits"};
  }
  detector->nthreads = options.threads;
  detector->quad_decimate = static_cast<float>(options.decimate);
  detector->quad_sigma = static_cast<float>(options.blur);
  detector->refine_edges = options.refine_edges;
  detector->decode_sharpening = options.decode_sharpening;
  detector->qtp.min_white_black_diff = options.min_white_black_diff;
  return TagDetector(options, std::move(library));
}

Result<std::vector<TagDetection>> TagDetector::Detect(const GrayImage& image) {
  if (image.pixels == nullptr || image.width < 1 || image.height < 1 || image.stride < image.width) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("a picture of {} x {} px with {} bytes a row; expected pixels, and "
                             "at least as many bytes a row as pixels",
                             image.width, image.height, image.stride)};
  }
  std::vector<TagDetection> found;
  if (image.width < 8 || image.height < 8) return found;  // no room for a tag; the library assumes some

  // The library only reads its input, but takes it as writable.
  image_u8_t view{.width = image.width,
                  .height = image.height,
                  .stride = image.stride,
                  .buf = const_cast<unsigned char*>(image.pixels)};
  zarray_t* detections = apriltag_detector_detect(library_->detector, &view);
  for (int i = 0; i < zarray_size(detections); ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(detections, i, &detection);
    if (detection->hamming > options_.max_hamming || detection->decision_margin < options_.min_margin)
      continue;
    TagDetection tag{.id = detection->id,
                     .hamming = detection->hamming,
                     .margin = detection->decision_margin,
                     .corners_px = {}};
    for (int corner = 0; corner < 4; ++corner) {
      tag.corners_px(0, corner) = detection->p[corner][0] - 0.5;
      tag.corners_px(1, corner) = detection->p[corner][1] - 0.5;
    }
    // Families with a reversed border print data just outside of it: no clean edge to fit.
    if (options_.corners == TagCorners::kRefined && !library_->family->reversed_border) {
      if (const auto better = RefineTagCorners(image, tag.corners_px, library_->family->width_at_border)) {
        tag.corners_px = *better;
      }
    }
    found.push_back(tag);
  }
  apriltag_detections_destroy(detections);
  std::sort(found.begin(), found.end(), [](const TagDetection& a, const TagDetection& b) {
    return a.id != b.id ? a.id < b.id : a.corners_px(0, 0) < b.corners_px(0, 0);
  });
  return found;
}

}  // namespace tendril
