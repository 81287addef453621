#include "calibrate/cameras/calibrate_from_tags.h"

#include <fmt/format.h>

#include <map>
#include <set>

#include "capture/track/tag_pose.h"

namespace tendril {
namespace {

// Tags that two cameras or more saw at once: others say nothing of where cameras stand.
std::vector<TagInPicture> Shared(const std::vector<TagInPicture>& tags) {
  std::map<std::pair<std::int64_t, int>, std::set<int>> cameras;
  for (const TagInPicture& tag : tags) cameras[{tag.stamp, tag.tag}].insert(tag.camera);
  std::vector<TagInPicture> shared;
  for (const TagInPicture& tag : tags) {
    if (cameras[{tag.stamp, tag.tag}].size() > 1) shared.push_back(tag);
  }
  return shared;
}

}  // namespace

Result<RigFromTags> CalibrateFromTags(std::vector<Camera> lenses, std::span<const TagInPicture> tags,
                                      const CalibrateFromTagsOptions& options, const Progress& progress) {
  if (!(options.border > 0)) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("the tags' border is {} m; expected more than 0", options.border)};
  }
  if (!(options.still_px >= 0)) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("still tags move up to {} px; expected 0 or more", options.still_px)};
  }
  for (Camera& lens : lenses) lens.camera_from_lab.setIdentity();
  // A tag alone says nothing about a lens, so where tags move against each other the rest is left out.
  const std::vector<TagInPicture> used =
      options.still_px > 0 ? UnlinkMoving(tags, options.still_px, options.tags_move ? 0 : 60)
                           : std::vector<TagInPicture>(tags.begin(), tags.end());
  const auto fit = [&](const std::vector<BoardView>& views, const Eigen::Matrix3Xd& points,
                       CalibrateCamerasOptions with, const Progress& report) {
    with.lenses = lenses;
    return CalibrateCameras(lenses, views, points, with, report);
  };
  RigFromTags rig;
  if (options.tags_move) {
    rig.views = ViewsOfTags(Shared(used));
    auto found = fit(rig.views, TagCorners3d(options.border), options.cameras, progress);
    if (!found.ok()) return found.error();
    rig.calibration = std::move(found).value();
    return rig;
  }
  // The tags' places come from the lenses as given; where those are refined, once more from what was found.
  for (int round = options.cameras.refine_lenses ? 0 : 1; round < 2; ++round) {
    auto body = FindTagBody(lenses, tags, {.border = options.border});
    if (!body.ok()) return body.error();
    rig.body = std::move(body).value();
    rig.views = ViewsOfBody(rig.body, used);
    CalibrateCamerasOptions with = options.cameras;
    if (round == 0) {
      with.folds = 0;
      with.board_sigma = 0;
    }
    auto found = fit(rig.views, rig.body.points, with, round == 0 ? Progress{} : progress);
    if (!found.ok()) return found.error();
    rig.calibration = std::move(found).value();
    lenses = rig.calibration.cameras;
    for (Camera& lens : lenses) lens.camera_from_lab.setIdentity();
  }
  rig.body.points = rig.calibration.points;
  return rig;
}

}  // namespace tendril
