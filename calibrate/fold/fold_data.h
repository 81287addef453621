#pragma once
// What a lab's trials hold for the fold fit: tracked curves, each with the pull that its servo was commanded.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "calibrate/fold/fold_fit.h"
#include "db/files/trial_toml.h"
#include "model/result.h"

namespace tendril {

struct FoldData {
  TrialSpec trial;
  std::vector<FoldObservation> observations;
  std::vector<int> frames;              // of curves.h5, by observation
  std::vector<Eigen::VectorXd> angles;  // phi_i, rad, by observation; no entries: not known
  std::vector<std::pair<std::string, std::string>> input_sha256;  // (trial id/file, hash)
  std::vector<std::string> warnings;
};

// Reads trial.toml, curves.h5 (curves named tentacle0, tentacle1, ...) and servo.csv of a trial's folder.
// Tentacle i hangs on servo i; a log of a single servo pulls them all.
//   errors  kNotFound a missing file (says which command makes it); kBadInput what a file says wrongly
Result<FoldData> LoadFoldData(const std::filesystem::path& trial_folder);

}  // namespace tendril
