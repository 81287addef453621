#pragma once
// The least squares behind tag_photometric.h: what a tag's pixels should be as a function of twelve unknowns,
// and the normal equations of what they are not.

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "capture/track/tag_photometric.h"

namespace tendril::tag_fit {

// Eight of the homography; black, what white and the surround are brighter; the blur's logarithm.
constexpr int kUnknowns = 12, kBlack = 8, kWhite = 9, kSurround = 10, kBlur = 11;
using Normals = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Corners = Eigen::Matrix<double, 2, 4>;

constexpr double kCornerX[4] = {-1, 1, 1, -1}, kCornerY[4] = {1, 1, -1, -1};

// From tag coordinates (corners at +-1) to pixels: h0 .. h7, with h8 = 1. None where the four are no tag
// before a camera.
std::optional<Eigen::Matrix<double, 8, 1>> HomographyTo(const Corners& corners);
Eigen::Matrix3d Matrix(const Unknowns& x);
Corners CornersOf(const Unknowns& x);

// Pixels of a tag, in arrays that are as long as the next whole sixteen.
struct Pixels {
  int count = 0;
  std::vector<float> x, y;  // from the tag's middle
  std::vector<float> gray;
};

// Sums of squared residuals and their normal equations.
class Problem {
 public:
  Problem(const TagLook& look, const Pixels& pixels, const TagFitOptions& options)
      : look_(look), pixels_(pixels), options_(options), half_(0.5 * look.border_width) {}
  virtual ~Problem() = default;

  // From now on the tag is nearly in its place, and its blur may be told. (Before, blur would make up for
  // what is out of place.)
  void ComeNear() { far_ = false; }
  bool far() const { return far_; }

  // Brightnesses that fit best where everything else is given.
  virtual void StartContrast(Unknowns& x) = 0;
  // Infinite where the tag is degenerate.
  virtual double Cost(const Unknowns& x, Normals& normals, Unknowns& gradient) = 0;

 protected:
  // A blur that is blur_spread off costs as much as a gray level's squared error.
  double Prior(const Unknowns& x, Normals& normals, Unknowns& gradient) const {
    const double weight = (far_ ? 1000 : 9) / (options_.blur_spread * options_.blur_spread);
    const double away = x[kBlur] - std::log(options_.blur_px);
    normals(kBlur, kBlur) += weight;
    gradient[kBlur] += weight * away;
    // Where no pixel sees the surround, its brightness means nothing.
    normals(kSurround, kSurround) += 1e-6;
    return weight * away * away;
  }

  const TagLook& look_;
  const Pixels& pixels_;
  const TagFitOptions& options_;
  double half_;

 private:
  bool far_ = true;
};

// By TagSeer in double precision.
std::unique_ptr<Problem> MakePlainProblem(const TagLook& look, const Pixels& pixels,
                                          const TagFitOptions& options);
// By the table of `follow` in single precision, which is made anew where it does not serve `start`; null: no
// table serves.
std::unique_ptr<Problem> MakeTableProblem(const TagLook& look, const Pixels& pixels,
                                          const TagFitOptions& options, TagFollow& follow,
                                          const Unknowns& start);

}  // namespace tendril::tag_fit
