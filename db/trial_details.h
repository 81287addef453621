#pragma once
// All that the database knows about one trial: its files, what was derived from them, what was said about it.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "db/lab.h"
#include "db/simulation_store.h"
#include "db/trial_query.h"
#include "model/result.h"

namespace tendril {

struct RecordedFile {
  std::string role;
  std::string file;  // relative to the trial's folder
  std::string sha256;
  std::optional<std::int64_t> frames;
  std::optional<std::int64_t> dropped;
};

struct DerivedResult {
  std::string what;  // "track", "link", "fit 3 (design paper)"
  std::vector<std::pair<std::string, std::optional<double>>> values;  // none: not known
  std::int64_t made_ns = 0;
  std::string program_version;
  std::string parameters_json;                                    // the options that it depends on
  std::vector<std::pair<std::string, std::string>> input_sha256;  // (file or role, SHA-256); not of fits
};

struct TrialEvent {
  std::int64_t at_ns = 0;
  std::string what;  // "success", "failure", "note", "label", "void"
  std::string by;
  bool by_person = true;
  bool counts = false;  // the outcome that rates use
  std::string text;
  std::optional<double> load_N;
};

struct TrialDetails {
  TrialOverview overview;
  std::string state_reason;
  std::string notes;
  std::vector<RecordedFile> files;
  std::vector<DerivedResult> results;
  std::vector<TrialEvent> events;  // oldest first
  std::optional<StoredSimulation> simulation;
};

//   errors  kNotFound no such trial
Result<TrialDetails> TrialDetailsOf(Lab& lab, const std::string& id);

// "2026-11-22 23:18:46", UTC.
std::string UtcText(std::int64_t ns);

}  // namespace tendril
