#pragma once
// Which cameras saw each node of a trial, and what a camera at other places, or tags on more facets, would
// add: what the hint of another view (fold_fit.h) is made of.

#include <filesystem>
#include <string>
#include <vector>

#include "calibrate/fold/fold_data.h"
#include "capture/rig/rig.h"
#include "model/result.h"

namespace tendril {

struct ViewPlaces {
  std::vector<std::string> names;           // as a sentence says them: "another camera at (0.3, 0.4, -0.2) m"
  std::vector<std::string> relative_names;  // the same without coordinates, for trials of several rigs
  // How far the foretelling can be trusted: facets that cameras of the rig see, by tracking and as foretold.
  long seen = 0;
  long foretold = 0;
  long both = 0;
  long facets = 0;  // that were asked about, camera by camera
};

// Cameras at eight azimuths and three elevations about the gripper's middle, as far from it as the rig's are
// in the median, with the lens, the picture and the roll (upright or on its side) of its camera with the
// largest picture.
std::vector<Camera> CandidateCameras(const Rig& rig, const Eigen::Vector3d& middle_in_lab);

// Fills `cameras` of the observations from residuals.csv (tags that the tracker used), `further` for each
// place. What a place would see is foretold for at most 12 moments of a trial and taken for the moments near
// them: facets where the tracker has them, tags as rig/tag_views.h judges them, hidden ones found. Nothing is
// filled, and the places are empty, for a trial without cameras, residuals.csv or fold angles.
//   errors  kBadInput what residuals.csv or the rig says wrongly
Result<ViewPlaces> AddViews(const std::filesystem::path& trial_folder, FoldData& data);

// Adds one trial's to those of others. Trials of several rigs have the names without coordinates.
void MergePlaces(const ViewPlaces& of_trial, ViewPlaces& places);

}  // namespace tendril
