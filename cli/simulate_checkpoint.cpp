#include "cli/simulate_checkpoint.h"

#include <filesystem>

#include "cli/command.h"
#include "db/files/state_file.h"

namespace tendril::cli {

namespace fs = std::filesystem;

Result<std::optional<SimulationState>> Checkpoint::Load() const {
  if (file_.empty() || !fs::exists(file_)) return std::optional<SimulationState>();
  Result<SimulationState> state = ReadState(file_, run_);
  if (!state.ok()) return state.error();
  return std::optional(std::move(state).value());
}

std::function<void(const std::function<SimulationState()>&)> Checkpoint::Keeper() {
  if (file_.empty()) return {};
  return [this](const std::function<SimulationState()>& make) {
    const double since = std::chrono::duration<double>(Clock::now() - kept_).count();
    if (!StopRequested() && since < kEvery_s) return;
    const Status written = WriteState(file_, make(), run_);
    trouble_ = written.ok() ? "" : written.error().message;
    holds_ = holds_ || written.ok();
    kept_ = Clock::now();
  };
}

void Checkpoint::Remove() const {
  std::error_code ignored;
  if (!file_.empty()) fs::remove(file_, ignored);
}

}  // namespace tendril::cli
