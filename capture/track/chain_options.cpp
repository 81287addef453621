#include "capture/track/chain_options.h"

#include <cmath>

namespace tendril {

ChainOptions LoadedTentacles() {
  ChainOptions loaded;
  loaded.sigma_swing = 0.045;
  loaded.sigma_angle = 0.05;
  loaded.sigma_opening_walk = 0.015;
  loaded.sigma_recall_walk = 0.1;
  return loaded;
}

CornerSigma SigmaOfView(double stated_px, const ChainOptions& options) {
  const bool stated = stated_px > 0 && std::isfinite(stated_px);
  return {.alone = stated ? std::hypot(stated_px, options.sigma_flatness_px) : options.sigma_corner_px,
          .shared = 0.5 * options.sigma_calibration_px};
}

TagSlop SlopOfTag(const ChainOptions& options, const Eigen::Matrix3d& lab_from_sheet_rotation) {
  const auto weight = [](double variance) { return 1 / variance; };
  const double turn = options.sigma_tag_turn * options.sigma_tag_turn;
  const double tilt = options.sigma_tag_tilt * options.sigma_tag_tilt;
  const double bend = options.sigma_facet_bend * options.sigma_facet_bend;
  const double place = options.sigma_tag_place * options.sigma_tag_place;
  const double lift = options.sigma_tag_lift * options.sigma_tag_lift;
  const Eigen::Matrix3d& r = lab_from_sheet_rotation;
  return {.turn_weight = {weight(turn), weight(tilt + bend), weight(tilt)},
          .place_weight = weight(place) * Eigen::Matrix3d::Identity() +
                          (weight(lift) - weight(place)) * r.col(0) * r.col(0).transpose()};
}

Eigen::Matrix3d HoleSlop(const ChainOptions& options, const Eigen::Matrix3d& lab_from_sheet_rotation,
                         bool facet_seen) {
  const double place = options.sigma_hole * options.sigma_hole;
  const double bridged = facet_seen ? 0 : options.sigma_bridged_lift * options.sigma_bridged_lift;
  const double lift = options.sigma_hole_lift * options.sigma_hole_lift + bridged;
  const Eigen::Vector3d normal = lab_from_sheet_rotation.col(0);
  return place * Eigen::Matrix3d::Identity() + (lift - place) * normal * normal.transpose();
}

}  // namespace tendril
