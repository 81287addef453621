#pragma once
// What a camera of the virtual rig sees: the true shape with its tags, and the object, as an 8-bit gray
// image.
//
// Geometrically exact: for every sample of a pixel, its ray through the distorted lens is cut with the
// facet's plane and the tag's bitmap is looked up there; nearer facets hide farther ones. What is modelled
// and what is not: docs/virtual_rig.md.

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <random>

#include "capture/rig/camera_model.h"
#include "capture/rig/tag_layout.h"
#include "capture/rig/virtual_truth.h"
#include "model/result.h"

namespace tendril {

// Brightness in gray levels 0 .. 255.
struct VirtualOptics {
  double blur_px = 0.6;       // standard deviation of lens and pixel
  double read_noise = 0.5;    // standard deviation in the dark
  double shot_noise = 0.025;  // variance per gray level: 255 / full well of 10,000 electrons
  double background = 10;
  double paper = 225;    // in full light
  double ink = 22;       // in full light
  double object = 130;   // in full light
  double ambient = 0.6;  // light that reaches a face seen edge-on to the lamp, of full light
};

class VirtualCamera {
 public:
  // Prepares the rays of a camera and the bitmaps of a tag layout.
  //   errors  kBadInput: unknown tag family, an id that it lacks; an image size < 1 px; a pixel that no ray
  //           reaches (the distortion has no inverse there); an option out of its range
  static Result<VirtualCamera> Make(const Camera& camera, const TagLayout& tags, double hole_diameter,
                                    const VirtualOptics& optics = {});

  // One picture (CV_8UC1). The same generator state gives the same bytes.
  cv::Mat Render(const TrueShape& shape, std::mt19937_64& random) const;

  const Camera& camera() const;

 private:
  struct Prepared;
  explicit VirtualCamera(std::shared_ptr<const Prepared> prepared) : prepared_(std::move(prepared)) {}
  std::shared_ptr<const Prepared> prepared_;
};

}  // namespace tendril
