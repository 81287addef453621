#pragma once
// What a tracked trial's files say, as numbers that a page can show: nodes seen, fold angles, how far tags
// lie from where the chain has them, links with their bands.
//
// SI units, rad, px.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/link/link_bands.h"
#include "capture/rig/rig.h"
#include "db/files/trial_toml.h"
#include "db/lab.h"
#include "db/trial_details.h"
#include "model/geometry/framed_curve.h"
#include "model/progress.h"
#include "model/result.h"

namespace tendril::cli {

enum class NodeSight { kSeen, kBridged, kNotSeen };  // as the overlay colours them

struct TentacleFacts {
  std::string name;
  double seen = 0, bridged = 0, not_seen = 0;  // shares of nodes, over all frames
  std::vector<double> seen_by_frame;           // share of nodes                                  (frames)
  std::vector<double> bridged_by_frame;        // likewise                                        (frames)
  std::vector<std::vector<NodeSight>> sights;  // (frames) x (nodes)
  std::vector<double> median_sigma_at;         // over frames, m; NaN: never known                 (nodes)
  std::vector<double> worst_sigma_at;          // likewise                                        (nodes)
  double median_sigma = 0;                     // of the seen nodes, as `tendril track` gives it, m; NaN: none
  double worst_sigma = 0;                      // of all known nodes, m; NaN: none
  int worst_node = -1, worst_frame = -1;       // where that is
  std::vector<int> never_known;                // nodes whose sigma is NaN in every frame
};

struct CameraFacts {
  int number = 0;
  std::string name;
  long found = 0;     // tags in detections.csv
  long on_facet = 0;  // of these, in residuals.csv
  long used = 0, left_out = 0;
  // Of the tags that were used, each at its nominal place on its facet: root mean square and median distance
  // of a corner from where the chain has it, and the mean vector (found minus chain). NaN: none was used.
  double rms_px = 0, median_px = 0;
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();
  // 1-sigma error of that mean, as tags err alike in every frame (clustered by tag).
  Eigen::Vector2d shift_error_px = Eigen::Vector2d::Zero();
  double stated_sigma_px = 0;        // median of detections.csv's sigma_px; NaN: not stated
  std::vector<double> rms_by_frame;  // NaN: none was used                                       (frames)
  std::vector<double> tag_rms;       // of each used tag                                           (used)
  long pictures = 0, dropped = 0;    // as cam<i>.csv has them
  std::optional<std::vector<std::pair<std::string, long>>> rejected;  // by cause; none: not kept
};

struct UndecidedSpan {  // the same two strands at successive moments
  int a = 0, b = 0;     // as UndecidedCrossing
  std::vector<int> frames;
  UndecidedCrossing nearest;  // in sigmas
};

struct LinkFacts {
  std::string why_none;     // why there are no bands; empty: there are
  std::vector<int> frames;  // moments that were measured
  std::vector<LinkBands> bands;
  std::vector<UndecidedSpan> undecided;
  bool axis = false;  // the object has one
};

struct TrialFacts {
  TrialDetails details;
  TrialSpec trial;
  Rig rig;                        // no camera: the trial has none
  std::vector<std::string> gaps;  // files that are missing, and which command makes them
  std::vector<CurveSeries> curves;
  std::vector<TentacleFacts> tentacles;
  std::vector<CameraFacts> cameras;
  bool residuals_known = false;
  // Tags that several cameras saw in one frame, and of these the ones of which a sighting was left out: where
  // cameras contradict each other. Tags that one camera saw alone can hardly contradict anything.
  long shared = 0, shared_contradicted = 0;
  LinkFacts link;
  std::vector<std::string> remarks;  // what stands out, in words
};

struct ReportOptions {
  int draws = 400;        // of each moment's bands
  int most_moments = 40;  // at which links are measured: evenly spread, the first and the last among them
};

//   id      of a trial
//   errors  kNotFound the trial is not tracked (says which command does it); as the files' readers;
//           kStopped
Result<TrialFacts> CollectFacts(Lab& lab, const std::string& id, const ReportOptions& options,
                                const Progress& progress = {});

// Whether the trial has a row and curves of tracking.
//   folder  the trial's
bool IsTracked(const TrialDetails& details, const std::filesystem::path& folder);

// What stands out in the facts, as sentences. Each states the figures that it is drawn from.
std::vector<std::string> RemarksOn(const TrialFacts& facts);

}  // namespace tendril::cli
