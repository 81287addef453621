#pragma once
// Writing what a lab learns: trials, their files, what was derived from them, and what people say about them.
//
// Each call is one transaction. Derived rows (track, link, fit) replace the ones made before for the same
// trial, except fits, which accumulate; outcomes, notes, labels and voids are events and accumulate. NaN is
// stored as NULL. Trials are named by their full id (db/trial_query.h finds it from a label or a prefix).

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "db/files/trial_toml.h"
#include "db/lab.h"
#include "db/provenance.h"
#include "db/trial_id.h"
#include "model/result.h"

namespace tendril {

// Makes the trial's folder with trial.toml and its row in state `recording`. Fills in an empty id, started_ns
// 0 (now) and an empty label ("trial-12").
//   errors  kBadInput a label that is taken; a design, object or number that cannot be; kIo
Result<TrialSpec> BeginTrial(Lab& lab, TrialSpec spec);

// Any state from `recording`; `degraded` also from `recorded`.
//   errors  kNotFound no such trial; kBadInput a step that the states do not allow (names both)
Status SetTrialState(Lab& lab, const std::string& id, TrialState state, const std::string& reason = "");

//   role  "cam0", "servo", "detections", "curves", ...; recorded again, it replaces the row of that role
//   file  relative to the trial's folder
Status AddRecordingFile(Lab& lab, const std::string& id, const std::string& role, const std::string& file,
                        const std::string& sha256, std::optional<std::int64_t> frames = std::nullopt,
                        std::optional<std::int64_t> dropped = std::nullopt);

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

struct TrackRow {
  int frames = 0;
  int tentacles = 0;
  double rms_reprojection_px = kNotKnown;
  double seen_fraction = kNotKnown;  // of all nodes and frames
  double rms_sigma_m = kNotKnown;
};
Status StoreTrack(Lab& lab, const std::string& id, const TrackRow& row, const Provenance& provenance);

struct TentacleLinkRow {
  int frame = 0;
  double time_s = 0;
  int tentacle = 0;
  double self_link = kNotKnown;
  double object_link = kNotKnown;
  double object_gauss = kNotKnown;  // Gauss integral of the open curve
  std::string flags{};              // comma-separated; empty: none
};

struct PairLinkRow {
  int frame = 0;
  double time_s = 0;
  int a = 0;  // tentacles, a < b
  int b = 0;
  double link = kNotKnown;
  double gauss = kNotKnown;
  std::string flags{};
};

struct LinkRows {
  std::vector<TentacleLinkRow> tentacles{};
  std::vector<PairLinkRow> pairs{};
  // Of the trial: means of |Lk|, at its end and at pull 0. performance = mutual + object.
  double mutual_link = kNotKnown;
  double object_link = kNotKnown;
  double performance = kNotKnown;
  double mutual_link_at_zero = kNotKnown;
  double object_link_at_zero = kNotKnown;
  double performance_at_zero = kNotKnown;
};
Status StoreLink(Lab& lab, const std::string& id, const LinkRows& rows, const Provenance& provenance);

struct FitParameter {
  std::string name{};
  double value = 0;
  double standard_error = kNotKnown;
  bool identified = true;
  double true_value = kNotKnown;  // where a virtual rig knows it
};

struct FitRow {
  std::string model = "fold";
  std::string scope{};                   // what was fitted, for people: "trial t-3", "design paper"
  std::vector<std::string> trial_ids{};  // one or more
  std::vector<FitParameter> parameters{};
  double residual_rms_m = kNotKnown;
};
Status StoreFit(Lab& lab, const FitRow& row, const Provenance& provenance);

struct Outcome {
  bool grasped = false;
  std::string judged_by{};  // a person's name, or the program's
  bool by_person = true;    // the newest by a person counts, else the newest
  std::string method{};     // "by eye", "pull test", "mean |object link| >= 0.5", ...
  std::string notes{};
  double load_N = kNotKnown;  // pull-out force, where it was measured
};
Status AddOutcome(Lab& lab, const std::string& id, const Outcome& outcome);
Status AddNote(Lab& lab, const std::string& id, const std::string& text, const std::string& author);
Status AddLabel(Lab& lab, const std::string& id, const std::string& label, const std::string& author);

// Takes the trial out of every rate, for good.
Status VoidTrial(Lab& lab, const std::string& id, const std::string& reason, const std::string& author);

}  // namespace tendril
