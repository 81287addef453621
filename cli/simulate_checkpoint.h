#pragma once
// The state of an interrupted run: kept now and then, and gone once the run is through.

#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "model/result.h"
#include "model/scene/simulate.h"

namespace tendril::cli {

class Checkpoint {
 public:
  static constexpr double kEvery_s = 10;

  //   file  empty: nothing is kept
  //   run   as RunId gives it
  Checkpoint(std::string file, std::string run) : file_(std::move(file)), run_(std::move(run)) {}

  // The state to go on from, if there is one.
  //   errors  as ReadState
  Result<std::optional<SimulationState>> Load() const;

  // For SimulateHooks::keep; this outlives it.
  std::function<void(const std::function<SimulationState()>&)> Keeper();

  bool holds() const { return holds_; }  // a state of this run
  // A state that could not be written is no reason to lose the run.
  const std::string& trouble() const { return trouble_; }
  void Remove() const;

 private:
  using Clock = std::chrono::steady_clock;

  std::string file_, run_, trouble_;
  bool holds_ = false;
  Clock::time_point kept_ = Clock::now();
};

}  // namespace tendril::cli
