#pragma once
// What a blurred pattern shows, in a table: for tags that are fitted again and again under nearly the same
// blur (tag_look.h's TagSeer is the same without one).

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "capture/track/tag_fit_kernel.h"
#include "capture/track/tag_look.h"

namespace tendril {

// Places half a blur apart, from half a module before the pattern to half a module behind; between them to
// the second order: 0.01 of the contrast at most.
class TagTable {
 public:
  // Whether a table serves a blur at all: so sharp a picture of so large a tag would make it too large.
  static bool CanServe(const Eigen::Matrix2d& covariance);

  //   covariance  of the blur, modules^2; CanServe
  void Make(const TagLook& look, const Eigen::Matrix2d& covariance);
  // Whether this table is near enough to one of this covariance.
  bool Serves(const Eigen::Matrix2d& covariance) const;
  tag_fit::TableView View() const;

 private:
  Eigen::Matrix2d covariance_ = Eigen::Matrix2d::Zero();
  int side_ = 0, per_module_ = 0;
  std::vector<std::int16_t> seen_;  // [v][u][kSeenParts]
  std::array<float, tag_fit::kSeenParts> scale_{};
  std::vector<float> sides_u_, sides_v_;  // [place][kSideParts]
};

}  // namespace tendril
