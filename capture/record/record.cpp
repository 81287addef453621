#include "capture/record/record.h"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <fstream>
#include <mutex>
#include <thread>
#include <utility>

#include "capture/record/frame_queue.h"
#include "capture/record/video_file.h"
#include "db/files/safe_file.h"
#include "db/trial_store.h"

namespace tendril {
namespace {

namespace fs = std::filesystem;

// A log that grows line by line, each on its way to the disk before the next.
class GrowingLog {
 public:
  Status Open(const fs::path& file, const std::string& header) {
    file_ = file;
    out_.open(file, std::ios::binary | std::ios::trunc);
    return Append(header);
  }
  Status Append(const std::string& line) {
    out_ << line << std::flush;
    if (!out_)
      return Error{ErrorKind::kIo,
                   fmt::format("{}: could not be written; is the disk full?", file_.string())};
    return Ok{};
  }

 private:
  fs::path file_;
  std::ofstream out_;
};

struct CameraRun {
  explicit CameraRun(std::size_t queue_frames) : queue(queue_frames) {}
  FrameQueue queue;
  std::atomic<std::int64_t> frames{0};
  std::int64_t dropped = 0;  // of the taking thread until it has ended
};

// What all threads of one recording share.
struct Run {
  RecordPlan* plan = nullptr;
  fs::path folder;
  std::int64_t started_ns = 0;
  std::vector<std::unique_ptr<CameraRun>> cameras;
  std::atomic<bool> stop{false};
  std::int64_t servo_rows = 0;

  std::mutex mutex;
  std::condition_variable changed;
  int working = 0;
  std::optional<Error> error;  // the first

  void Stop() {
    stop = true;
    for (auto& camera : cameras) camera->queue.Close();
  }
  void Fail(Error failure) {
    {
      const std::lock_guard lock(mutex);
      if (!error) error = std::move(failure);
    }
    Stop();
  }
  void ThreadEnds() {
    const std::lock_guard lock(mutex);
    --working;
    changed.notify_all();
  }
};

void TakeFrames(Run& run, std::size_t i) {
  FrameSource& source = *run.plan->cameras[i];
  CameraRun& camera = *run.cameras[i];
  std::optional<std::int64_t> last_id;
  std::int64_t lost = 0;  // since the last picture that went into the queue
  while (!run.stop) {
    Result<std::optional<SourceFrame>> next = source.Next();
    if (!next.ok()) {
      run.Fail(std::move(next).error().Within(fmt::format("cam{}", i)));
      break;
    }
    if (!next.value()) break;
    QueuedFrame queued{std::move(*next.value()), 0};
    const std::int64_t id = queued.frame.frame_id;
    if (last_id && id > *last_id + 1) {
      lost += id - *last_id - 1;
      camera.dropped += id - *last_id - 1;
    }
    last_id = id;
    queued.dropped_before = lost;
    if (source.paced()) {
      if (!camera.queue.Push(std::move(queued))) break;
      lost = 0;
    } else if (camera.queue.TryPush(queued)) {
      lost = 0;
    } else if (!run.stop) {
      ++lost;
      ++camera.dropped;
    }
  }
  camera.queue.Close();
}

Status WriteFrames(Run& run, std::size_t i) {
  CameraRun& camera = *run.cameras[i];
  GrowingLog log;
  if (Status s = log.Open(run.folder / fmt::format("cam{}.csv", i), FrameLogHeader()); !s.ok()) return s;
  std::optional<VideoWriter> video;
  std::int64_t last_host_ns = 0;
  while (std::optional<QueuedFrame> queued = camera.queue.Pop()) {
    const SourceFrame& frame = queued->frame;
    if (run.plan->before_write) run.plan->before_write(static_cast<int>(i));
    if (!video) {
      Result<VideoWriter> opened =
          VideoWriter::Open(run.folder / fmt::format("cam{}.mkv", i), frame.image.cols, frame.image.rows);
      if (!opened.ok()) return opened.error();
      video = std::move(opened).value();
    }
    const std::int64_t host_ns = frame.host_ns.value_or(run.started_ns + std::llround(1e9 * frame.time));
    const double time = 1e-9 * static_cast<double>(host_ns - run.started_ns);
    if (Status s = video->Write(frame.image, time); !s.ok()) return s;
    last_host_ns = std::max(last_host_ns, host_ns);
    const FrameRow row{camera.frames, frame.frame_id, frame.device_ns,
                       last_host_ns,  frame.status,   queued->dropped_before};
    if (Status s = log.Append(FrameLogLine(row)); !s.ok()) return s;
    ++camera.frames;
  }
  if (video) return video->Close();
  return Ok{};
}

Status WriteServo(Run& run) {
  GrowingLog log;
  if (Status s = log.Open(run.folder / "servo.csv", ServoLogHeader()); !s.ok()) return s;
  while (!run.stop) {
    Result<std::optional<ServoSample>> next = run.plan->servo->Next();
    if (!next.ok()) return next.error();
    if (!next.value()) break;
    ServoRow& row = next.value()->row;
    if (row.host_ns == 0) row.host_ns = run.started_ns + std::llround(1e9 * next.value()->time);
    if (Status s = log.Append(ServoLogLine(row)); !s.ok()) return s;
    ++run.servo_rows;
  }
  return Ok{};
}

// Runs all threads to their end. True if `progress` asked to stop.
bool RunThreads(Run& run, const Progress& progress) {
  std::vector<std::thread> threads;
  const auto start = [&](auto work) {
    ++run.working;  // before the thread can end
    threads.emplace_back([&run, work] {
      work();
      run.ThreadEnds();
    });
  };
  {
    const std::lock_guard lock(run.mutex);
    for (std::size_t i = 0; i < run.cameras.size(); ++i) {
      start([&run, i] { TakeFrames(run, i); });
      start([&run, i] {
        if (Status s = WriteFrames(run, i); !s.ok())
          run.Fail(std::move(s).error().Within(fmt::format("cam{}", i)));
      });
    }
    if (run.plan->servo) {
      start([&run] {
        if (Status s = WriteServo(run); !s.ok()) run.Fail(std::move(s).error().Within("servo"));
      });
    }
  }

  double expected = 0;
  for (const auto& camera : run.plan->cameras) expected += static_cast<double>(camera->frames().value_or(0));
  bool stopped = false;
  std::unique_lock lock(run.mutex);
  while (run.working > 0) {
    run.changed.wait_for(lock, std::chrono::milliseconds(50));
    lock.unlock();
    double done = 0;
    for (const auto& camera : run.cameras) done += static_cast<double>(camera->frames);
    if (progress && !stopped && !progress(expected > 0 ? std::min(1.0, done / expected) : 0)) {
      stopped = true;
      run.Stop();
    }
    lock.lock();
  }
  lock.unlock();
  for (std::thread& thread : threads) thread.join();
  return stopped;
}

// The files that are there, with their hashes.
Status ListFiles(Lab& lab, const std::string& id, const Run& run) {
  const auto list = [&](const std::string& role, const std::string& file, std::int64_t rows,
                        std::optional<std::int64_t> dropped) -> Status {
    std::error_code ignored;
    if (!fs::exists(run.folder / file, ignored)) return Ok{};
    const Result<std::string> hash = Sha256OfFile(run.folder / file);
    if (!hash.ok()) return hash.error();
    return AddRecordingFile(lab, id, role, file, hash.value(), rows, dropped);
  };
  for (std::size_t i = 0; i < run.cameras.size(); ++i) {
    const CameraRun& camera = *run.cameras[i];
    const std::string name = fmt::format("cam{}", i);
    if (Status s = list(name, name + ".mkv", camera.frames, camera.dropped); !s.ok()) return s;
    if (Status s = list(name + "_frames", name + ".csv", camera.frames, std::nullopt); !s.ok()) return s;
  }
  if (run.plan->servo) return list("servo", "servo.csv", run.servo_rows, std::nullopt);
  return Ok{};
}

std::int64_t EarliestStart(const RecordPlan& plan) {
  std::optional<std::int64_t> earliest;
  const auto take = [&](std::optional<std::int64_t> ns) {
    if (ns && (!earliest || *ns < *earliest)) earliest = ns;
  };
  for (const auto& camera : plan.cameras) take(camera->first_host_ns());
  if (plan.servo) take(plan.servo->first_host_ns());
  return earliest.value_or(0);
}

}  // namespace

Result<RecordedTrial> Record(Lab& lab, RecordPlan plan, const Progress& progress) {
  if (plan.cameras.empty() && !plan.servo) {
    return Error{ErrorKind::kBadInput, "a recording without sources; expected a camera or a servo"};
  }
  if (plan.queue_frames < 1) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("a queue of {} frames; expected 1 or more", plan.queue_frames)};
  }
  if (plan.trial.started_ns == 0) plan.trial.started_ns = EarliestStart(plan);
  Result<TrialSpec> begun = BeginTrial(lab, plan.trial);
  if (!begun.ok()) return begun.error();

  RecordedTrial recorded;
  recorded.trial = std::move(begun).value();
  const std::string& id = recorded.trial.id;
  Run run;
  run.plan = &plan;
  run.folder = lab.TrialFolder(id);
  run.started_ns = recorded.trial.started_ns;
  for (std::size_t i = 0; i < plan.cameras.size(); ++i) {
    run.cameras.push_back(std::make_unique<CameraRun>(static_cast<std::size_t>(plan.queue_frames)));
  }

  bool aborted = false;
  if (plan.write_also) {
    if (Status s = plan.write_also(run.folder); !s.ok()) run.error = s.error();
  }
  if (!run.error) aborted = RunThreads(run, progress);

  std::int64_t dropped = 0;
  for (std::size_t i = 0; i < run.cameras.size(); ++i) {
    const CameraRun& camera = *run.cameras[i];
    recorded.cameras.push_back({camera.frames, camera.dropped});
    dropped += camera.dropped;
    if (camera.dropped > 0) {
      recorded.reason += fmt::format("{}cam{} lost {} of {} frames", recorded.reason.empty() ? "" : ", ", i,
                                     camera.dropped, camera.frames + camera.dropped);
    }
    if (camera.frames == 0 && !aborted && !run.error) {
      run.error = Error{ErrorKind::kBadInput, fmt::format("cam{}: the source gave no picture", i)};
    }
  }
  recorded.servo_rows = run.servo_rows;
  if (Status s = ListFiles(lab, id, run); !s.ok() && !run.error) run.error = s.error();

  const std::string name = fmt::format("trial {}", recorded.trial.label);
  if (run.error) {
    // The first error is what the caller must hear of, also if the lab cannot take it any more.
    (void)SetTrialState(lab, id, TrialState::kFailed, run.error->message);
    return std::move(*run.error).Within(name);
  }
  if (aborted) {
    recorded.state = TrialState::kAborted;
    recorded.reason = "stopped by the user";
  } else if (dropped > 0) {
    recorded.state = TrialState::kDegraded;
  }
  if (Status s = SetTrialState(lab, id, recorded.state, recorded.reason); !s.ok()) {
    return std::move(s).error().Within(name);
  }
  return recorded;
}

}  // namespace tendril
