#pragma once
// Where a tag of known pattern lies, from all of its pixels: the pattern as a camera would see it
// (homography, Gaussian blur, contrast) is fitted to the gray levels by damped Gauss-Newton. Finer than edges
// alone, and works on tags too small or too tilted to be decoded, if it starts within about a module.

#include <Eigen/Core>

#include "capture/track/tag_detect.h"
#include "capture/track/tag_look.h"
#include "capture/track/tag_table.h"

namespace tendril {

struct TagFitOptions {
  double blur_px = 0.7;       // where the fit starts, standard deviation of lens and pixel
  double blur_spread = 0.25;  // how far blur is expected from there, as its logarithm's standard deviation
  double largest_shift_px = 4;
  double least_contrast = 20;      // gray levels
  double largest_residual = 0.08;  // root mean square, of the contrast
  int most_iterations = 20;
  double settled_gain = 0.02;  // where what is left to gain is less, in units of the residual's variance
};

// Why a fit is not to be believed.
enum class TagFitFault {
  kNone,
  kOutside,     // less than 0.7 of it lies in the picture
  kTooSmall,    // fewer pixels than a fit needs, or its start is no quadrilateral
  kNoContrast,  // or its contrast is reversed
  kMoved,       // farther than largest_shift_px
  kNotThisTag,  // residual: something else, partly hidden, glare
  kNotSettled,  // no minimum within most_iterations
};
inline constexpr int kTagFitFaults = 7;
const char* NameOf(TagFitFault fault);

struct TagFit {
  TagFitFault fault = TagFitFault::kNone;
  Eigen::Matrix<double, 2, 4> corners_px = Eigen::Matrix<double, 2, 4>::Zero();  // in the detector's order
  // Of (x, y) of one corner after the other, px^2; from the residual, pixels taken as independent, and what a
  // residual beyond a sensor's noise may hide.
  Eigen::Matrix<double, 8, 8> covariance = Eigen::Matrix<double, 8, 8>::Zero();
  double white = 0, black = 0, surround = 0;  // gray levels
  double blur_px = 0;
  double residual = 0;  // root mean square, of white - black
  int pixels = 0;
  int iterations = 0;
};

//   corners_px  where it starts
TagFit FitTag(const GrayImage& image, const TagLook& look, const Eigen::Matrix<double, 2, 4>& corners_px,
              const TagFitOptions& options = {});

// What is known of a tag that is fitted in frame after frame: its look under the last fit's blur, and its
// brightness.
struct TagFollow {
  TagTable table;
  double blur_px = 0;                         // the table's
  double black = 0, white = 0, surround = 0;  // gray levels; all 0: not known
};
// The same, faster: with what is known from the frame before, and a table that is made anew where it no
// longer serves. Corners are those of the above within 0.6 of their uncertainty.
TagFit FitTag(const GrayImage& image, const TagLook& look, const Eigen::Matrix<double, 2, 4>& corners_px,
              const TagFitOptions& options, TagFollow& follow);

}  // namespace tendril
