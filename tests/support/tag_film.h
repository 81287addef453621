#pragma once
// Cameras that film a true shape, moment after moment, and find its tags: every picture is drawn by the
// virtual rig's renderer (light, blur, noise, what hides what) and searched by TagTracker.

#include <chrono>
#include <opencv2/core/mat.hpp>
#include <random>
#include <vector>

#include "capture/rig/tag_layout.h"
#include "capture/rig/virtual_render.h"
#include "capture/track/chain_solve.h"
#include "capture/track/tag_tracker.h"

namespace tendril::testing_support {

inline double SecondsOf(const std::chrono::steady_clock::time_point& start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// What the cameras saw of one moment, and where tags were found.
struct FilmedMoment {
  std::vector<std::vector<TagView>> views;  // (tentacles); point into the tags as told
  std::vector<cv::Mat> pictures;            // (cameras)
  double render_seconds = 0, find_seconds = 0;
};

class TagFilm {
 public:
  // cameras, glued: as they are; told: the tags as the tracker has them, which outlive this.
  TagFilm(const std::vector<Camera>& cameras, const TagLayout& told, const TagLayout& glued,
          double hole_diameter, std::uint64_t seed, TagTrackLevel level)
      : told_(told), random_(seed) {
    for (const Camera& camera : cameras) {
      filming_.push_back(VirtualCamera::Make(camera, glued, hole_diameter).value());
      TagTrackOptions options;
      options.level = level;
      options.detect.family = told.family;
      trackers_.push_back(TagTracker::Create(options).value());
    }
  }

  FilmedMoment Next(const TrueShape& shape) {
    FilmedMoment moment;
    moment.views.resize(shape.tentacles.size());
    for (std::size_t c = 0; c < filming_.size(); ++c) {
      auto start = std::chrono::steady_clock::now();
      moment.pictures.push_back(filming_[c].Render(shape, random_));
      moment.render_seconds += SecondsOf(start);
      start = std::chrono::steady_clock::now();
      const cv::Mat& picture = moment.pictures.back();
      const auto tags =
          trackers_[c].Next({picture.data, picture.cols, picture.rows, static_cast<int>(picture.step)});
      for (const TrackedTag& tag : tags.value()) {
        const TagPlace* place = told_.Find(tag.id);
        if (place == nullptr) continue;
        TagView view;
        view.camera = static_cast<int>(c);
        view.place = place;
        view.corners_px = tag.corners_px;
        view.sigma_px = SigmaOfCorners(tag);
        moment.views[static_cast<std::size_t>(place->tentacle)].push_back(view);
      }
      moment.find_seconds += SecondsOf(start);
    }
    return moment;
  }

 private:
  const TagLayout& told_;
  std::mt19937_64 random_;
  std::vector<VirtualCamera> filming_;
  std::vector<TagTracker> trackers_;
};

}  // namespace tendril::testing_support
