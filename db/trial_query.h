#pragma once
// Asking a lab: which trials there are, what is known about one, how often grasps succeed.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "db/files/trial_toml.h"
#include "db/lab.h"
#include "model/result.h"

namespace tendril {

// The id of a trial that a person named by its id, a unique beginning of it, or its label.
//   errors  kNotFound (suggests the nearest label); kBadInput several fit (names some)
Result<std::string> FindTrial(Lab& lab, const std::string& name);

struct TrialOverview {
  std::string id{};
  std::string label{};
  TrialKind kind = TrialKind::kReal;
  TrialState state = TrialState::kRecording;
  std::int64_t started_ns = 0;
  std::string design{};
  std::string object{};
  std::string medium{};
  double distance = 0;  // carrier to object, m
  double pull = 0;
  bool voided = false;
  std::optional<bool> grasped{};  // the outcome that counts; none: not judged
  bool trusted = true;            // false: a simulation whose contacts speak against it
};

struct TrialFilter {
  std::optional<TrialKind> kind{};  // none: all kinds, each row says which
  std::optional<TrialState> state{};
  std::optional<std::string> design{};  // as the overview shows it
};

// In order of their ids, which is that of time.
Result<std::vector<TrialOverview>> ListTrials(Lab& lab, const TrialFilter& filter = {});

// How many of these trials have curves that were tracked with the fold law as a prior.
Result<int> TrackedWithFoldLaw(Lab& lab, const std::vector<std::string>& ids);

// The trial's own trial.toml.
Result<TrialSpec> LoadTrial(Lab& lab, const std::string& id);

// One group of trials that share their keys' values.
struct RateGroup {
  std::vector<std::pair<std::string, std::string>> keys{};  // (name, value), as asked for
  std::int64_t trials = 0;                                  // judged
  std::int64_t grasped = 0;
};

struct RateQuestion {
  std::vector<std::string> by{};                             // names of RateKeys()
  std::vector<std::pair<std::string, std::string>> where{};  // (name, value)
  TrialKind kind = TrialKind::kReal;
  bool include_untrusted = false;  // count simulations that are not trusted, too
};

// A name that `by` and `where` take.
struct RateKey {
  std::string name{};
  bool is_number = false;
  std::string unit{};  // of a number; empty: none
};
const std::vector<RateKey>& RateKeys();  // design, object, medium, distance, pull, ...

// A rate is of one kind of test: of simulations that were tested differently, or not at all, `test` is added
// to what the question groups by, in front, unless it has it in `by` or `where`.
//   returns  whether it was added
//   errors   as CountGrasps
Result<bool> SplitByTest(Lab& lab, RateQuestion& question);

// Success counts over trials of that kind that are recorded or degraded, judged, not void and, unless asked
// for, not of simulations that are not trusted. A simulated run counts once, as it was stored last.
//   errors  kBadInput an unknown name (suggests the nearest), a value of `where` that is not a number
Result<std::vector<RateGroup>> CountGrasps(Lab& lab, const RateQuestion& question);

// How many trials that fit the question's `where` and kind are left out because they are not trusted: 0 where
// they are included.
//   errors  as CountGrasps
Result<std::int64_t> CountLeftOut(Lab& lab, const RateQuestion& question);

// How many trials that fit the question's `where` and kind are runs that the lab has again, stored later.
//   errors  as CountGrasps
Result<std::int64_t> CountRepeats(Lab& lab, const RateQuestion& question);

// How many trusted trials count for a rate, by kind: for "this lab has no real trial, but 12 virtual ones".
Result<std::vector<std::pair<TrialKind, std::int64_t>>> JudgedByKind(Lab& lab);

}  // namespace tendril
