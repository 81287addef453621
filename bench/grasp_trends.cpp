// The trends of the paper's grasping experiments, simulated: success against distance, pairs of tentacles and
// medium for both designs, what the grasps are made of, and how all that depends on what had to be assumed.
// docs/grasping.md.
//   bench_grasp_trends [--series NAME]... [--trials N] [--threads N] [--csv FILE] [--figures FOLDER]
//   [--report]
// A trial takes tens of seconds of one core. Each is added to the
// CSV file when it is done; those that are there are not run again. --report runs none.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cstring>
#include <map>
#include <mutex>
#include <set>
#include <thread>

#include "bench/grasp_trends/grasp_outcome.h"
#include "bench/grasp_trends/grasp_points.h"
#include "bench/grasp_trends/grasp_questions.h"
#include "bench/grasp_trends/grasp_report.h"

namespace tendril {
namespace {

namespace fs = std::filesystem;

struct Call {
  std::vector<std::string> series;  // none: all
  int trials = 0, threads = 2;      // 0: as many as the series says
  fs::path csv = "grasp_trends.csv", figures;
  bool report_only = false;
};

struct Job {
  const GraspPoint* point;
  std::string inputs;
  std::uint64_t trial;
};

int Fail(const std::string& message) {
  fmt::print(stderr, "{}\n", message);
  return 2;
}

bool ReadCount(const char* text, int& count) {
  const char* const end = text + std::strlen(text);
  const auto read = std::from_chars(text, end, count);
  return read.ec == std::errc() && read.ptr == end && count >= 1 && count <= 100000;
}

Result<Call> ReadCall(const std::vector<std::string>& words) {
  Call call;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "--report") {
      call.report_only = true;
      continue;
    }
    const bool known = word == "--series" || word == "--trials" || word == "--threads" || word == "--csv" ||
                       word == "--figures";
    if (!known || i + 1 == words.size()) {
      return Error{ErrorKind::kBadInput,
                   word +
                       ": expected --series NAME, --trials N, --threads N, --csv FILE, --figures FOLDER or "
                       "--report"};
    }
    const std::string& value = words[++i];
    if (word == "--series") call.series.push_back(value);
    if (word == "--csv") call.csv = value;
    if (word == "--figures") call.figures = value;
    int* const count = word == "--trials" ? &call.trials : word == "--threads" ? &call.threads : nullptr;
    if (count != nullptr && !ReadCount(value.c_str(), *count)) {
      return Error{ErrorKind::kBadInput, word + " " + value + ": expected 1 or more"};
    }
  }
  return call;
}

Result<std::vector<GraspSeries>> Wanted(const std::vector<std::string>& names) {
  std::vector<GraspSeries> all = AllGraspSeries();
  if (names.empty()) return all;
  std::vector<GraspSeries> wanted;
  for (const std::string& name : names) {
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const GraspSeries& s) { return s.name == name; });
    if (found == all.end()) {
      return Error{ErrorKind::kBadInput,
                   "--series " + name + ": expected distance, pairs, water or sensitivity"};
    }
    wanted.push_back(*found);
  }
  return wanted;
}

std::string KeyOf(const std::string& scene, const std::string& settings, const std::string& inputs,
                  std::uint64_t trial) {
  return fmt::format("{},{},{},{}", scene, settings, inputs, trial);
}

// Drops what was made from other inputs, and says what is still to be run: every point's first trial, then
// every point's second, ..., so that a run that is interrupted has something of all.
Result<std::vector<Job>> JobsOf(const std::vector<GraspSeries>& series, const fs::path& scenes, int trials,
                                std::vector<GraspOutcome>& outcomes) {
  std::map<std::string, std::string> inputs_of;  // by scene and settings
  std::set<std::string> there;
  for (const GraspSeries& one : AllGraspSeries()) {
    for (const GraspPanel& panel : one.panels) {
      for (const GraspPoint& point : panel.points) {
        const Result<std::string> inputs = InputsOf(scenes, point);
        if (!inputs.ok()) return inputs.error();
        inputs_of[point.scene + "," + JoinedSettings(point.settings)] = inputs.value();
      }
    }
  }
  std::erase_if(outcomes, [&](const GraspOutcome& row) {
    const auto found = inputs_of.find(row.scene + "," + row.settings);
    return found == inputs_of.end() || found->second != row.inputs;
  });
  for (const GraspOutcome& row : outcomes)
    there.insert(KeyOf(row.scene, row.settings, row.inputs, row.trial));
  std::vector<std::pair<double, Job>> by_share;  // of the series' trials
  for (const GraspSeries& one : series) {
    const int count = trials > 0 ? trials : one.trials;
    for (int trial = 0; trial < count; ++trial) {
      for (const GraspPanel& panel : one.panels) {
        for (const GraspPoint& point : panel.points) {
          const std::string settings = JoinedSettings(point.settings);
          const std::string& inputs = inputs_of[point.scene + "," + settings];
          const auto number = static_cast<std::uint64_t>(trial);
          if (!there.insert(KeyOf(point.scene, settings, inputs, number)).second) continue;
          by_share.push_back({(trial + 0.5) / count, {&point, inputs, number}});
        }
      }
    }
  }
  std::stable_sort(by_share.begin(), by_share.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Job> jobs;
  for (auto& [share, job] : by_share) jobs.push_back(std::move(job));
  return jobs;
}

Status RunAll(const Call& call, const fs::path& scenes, const std::vector<Job>& jobs,
              std::vector<GraspOutcome>& outcomes) {
  std::atomic<std::size_t> next = 0;
  std::mutex mutex;  // of what follows, the file and stderr
  Status trouble = Ok{};
  std::size_t done = 0;
  const auto work = [&] {
    while (true) {
      const std::size_t at = next++;
      if (at >= jobs.size()) return;
      const Job& job = jobs[at];
      Result<GraspOutcome> outcome = RunGrasp(scenes, *job.point, job.inputs, job.trial);
      const std::lock_guard<std::mutex> lock(mutex);
      if (!trouble.ok()) return;
      if (!outcome.ok()) {
        trouble = Error(outcome.error()).Within(job.point->scene);
      } else if (Status s = AppendOutcome(call.csv, outcome.value()); !s.ok()) {
        trouble = s;
      }
      if (!trouble.ok()) {
        next = jobs.size();
        return;
      }
      const GraspOutcome& o = outcome.value();
      fmt::print(stderr, "{}/{} {} {} trial {}: {}, drawn in by {:.1f} mm, {:.0f} s{}\n", ++done, jobs.size(),
                 o.scene, o.settings, o.trial, Held(o) ? "held" : "not held", 1e3 * o.drawn_in, o.wall,
                 o.doubt.empty() ? "" : ", doubtful: " + o.doubt);
      outcomes.push_back(o);
    }
  };
  std::vector<std::thread> threads;
  for (int t = 0; t < call.threads; ++t) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  return trouble;
}

int Main(const std::vector<std::string>& words) {
  const Result<Call> read = ReadCall(words);
  if (!read.ok()) return Fail(read.error().message);
  const Call& call = read.value();
  const Result<std::vector<GraspSeries>> series = Wanted(call.series);
  if (!series.ok()) return Fail(series.error().message);
  const fs::path scenes = fs::path(TENDRIL_SOURCE_DIR) / "examples/scenes/grasp";
  Result<std::vector<GraspOutcome>> rows = ReadOutcomes(call.csv);
  if (!rows.ok()) return Fail(rows.error().message);
  std::vector<GraspOutcome> outcomes = std::move(rows).value();
  const std::size_t had = outcomes.size();
  const Result<std::vector<Job>> jobs = JobsOf(series.value(), scenes, call.trials, outcomes);
  if (!jobs.ok()) return Fail(jobs.error().message);
  if (outcomes.size() < had) {
    fmt::print(stderr, "{}: {} of {} trials are of other scenes or designs and do not count\n",
               call.csv.string(), had - outcomes.size(), had);
  }
  if (!call.report_only) {
    fmt::print(stderr, "{} trials to run, {} in {}\n", jobs.value().size(), outcomes.size(),
               call.csv.string());
    if (Status s = RunAll(call, scenes, jobs.value(), outcomes); !s.ok()) return Fail(s.error().message);
  }
  fmt::print("{}\n{}\n{}\n{}", GraspTable(series.value(), outcomes),
             AnswerTable(AnswersOf(series.value(), outcomes)), LinkTable(series.value(), outcomes),
             WindingTable(series.value(), outcomes));
  if (call.figures.empty()) return 0;
  if (Status s = DrawGrasps(series.value(), outcomes, call.figures); !s.ok()) return Fail(s.error().message);
  return 0;
}

}  // namespace
}  // namespace tendril

int main(int argc, char** argv) { return tendril::Main({argv + 1, argv + argc}); }
