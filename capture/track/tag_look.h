#pragma once
// What a tag looks like through a camera's blur: the share of white at any place of its printed pattern.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "capture/rig/tag_family.h"
#include "model/result.h"

namespace tendril {

// A printed pattern, prepared; 1 is white.
struct TagLook {
  int modules = 0;       // along a side, with the outermost ring
  int border_width = 0;  // modules between the corners that the detector reports
  struct Step {
    double at;    // modules from the left
    double rise;  // +1 or -1
  };
  std::vector<std::vector<Step>> steps;  // of each row; the pattern's surround counts as black
};

//   errors  kBadInput: unknown family, no such id
Result<TagLook> LookOf(const std::string& family, int id);

// The shares of white and of the surround that a camera sees at a place in the pattern, and
// their derivatives.
struct SeenTag {
  double white, by_u, by_v;  // u: modules from the left, v: from the top
  double by_blur;            // by the logarithm of the blur's standard deviation
  double surround, surround_by_u, surround_by_v;
};
// Rows of a pattern blurred along u, at a fixed spacing: value, slope and curvature.
struct TagProfiles {
  int per_module = 0, beyond = 0;  // modules on either side
  int length = 0, rows = 0;
  std::vector<double> value, slope, curvature;  // [row][length]
  struct At {
    double value, slope, curvature;
  };

  void Make(const TagLook& look, double sigma, int per_module, int beyond);
  At Look(int row, double u) const;
};

// By the definition, but that blur leaning against the rows is taken by its middle in each row: 0.01 of the
// contrast at most, seen 45 degrees from the side.
class TagSeer {
 public:
  //   covariance  of the blur, modules^2; positive
  TagSeer(const TagLook& look, const Eigen::Matrix2d& covariance);
  SeenTag See(double u, double v) const;

 private:
  void Surround(double u, double v, SeenTag& seen) const;

  int rows_;
  double along_, both_, across_, sigma_, lean_;
  TagProfiles profiles_;
};

}  // namespace tendril
