// Four cameras at once: 1280 x 1024 px, 60 tags of 25 px each, one tracker and one thread to a camera, as
// `tendril track` and `detect --live` use them. Speed, error and memory at each level.
//   bench_stream_track [FRAMES] [CAMERAS]        2000 and 4: 10 s of 200 frames/s
// A camera's pictures are 40 drawn ones, played forth and back (so that motion has no jump); each of the 78
// of a cycle has its own noise of 3 gray levels. They are made before anything is timed. The seeds are 100 +
// camera; tuning used others.
#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "capture/track/tags_in_video.h"
#include "tests/support/moving_tags.h"

namespace tendril {
namespace {

using Corners = Eigen::Matrix<double, 2, 4>;
using Clock = std::chrono::steady_clock;
using testing_support::MovingTags;
constexpr int kTags = MovingTags::kTags, kWidth = MovingTags::kWidth, kHeight = MovingTags::kHeight;
constexpr int kDrawn = 40;
constexpr double kRate = 200;  // frames/s of the cameras that are meant

struct Drawn {
  std::vector<unsigned char> bytes;
  std::vector<Corners> truth;  // by id
};

// Tags swing by up to 2 px from frame to frame.
std::vector<Drawn> DrawCycle(unsigned seed) {
  std::mt19937 random(seed);
  const MovingTags tags(25, random);
  // 0 1 .. 39 38 .. 1
  std::vector<Drawn> cycle(2 * kDrawn - 2);
  for (std::size_t f = 0; f < kDrawn; ++f) {
    const testing_support::Picture clean = tags.Draw(static_cast<int>(f));
    for (const std::size_t at : {f, cycle.size() - f}) {
      if (at >= cycle.size() || !cycle[at].bytes.empty()) continue;
      testing_support::Picture picture = clean;
      testing_support::AddNoise(picture, 3, random);
      cycle[at] = {picture.Bytes(), tags.CornersAt(static_cast<int>(f))};
    }
  }
  return cycle;
}

long PeakMemoryKb() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stol(line.substr(6));
  }
  return 0;
}

struct CameraRun {
  std::vector<double> ms;
  double cpu_ms = 0;
  long found = 0, wrong = 0;
  double squares = 0;
  TagTrackCounts counts;
};

// Of the calling thread, ms: what others do on this machine does not count.
double CpuMs() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

void Track(const std::vector<Drawn>& cycle, TagTrackLevel level, int frames,
           const std::function<void()>& done, CameraRun& run) {
  TagTrackOptions options;
  options.level = level;
  TagTracker tracker = TagTracker::Create(options).value();
  for (int f = 0; f < frames; ++f) {
    const Drawn& drawn = cycle[static_cast<std::size_t>(f) % cycle.size()];
    const Clock::time_point start = Clock::now();
    const double cpu = CpuMs();
    const auto tags = tracker.Next({drawn.bytes.data(), kWidth, kHeight, kWidth});
    run.cpu_ms += CpuMs() - cpu;
    run.ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
    for (const TrackedTag& tag : tags.value()) {
      const double off =
          tag.id < kTags
              ? (tag.corners_px - drawn.truth[static_cast<std::size_t>(tag.id)]).colwise().norm().maxCoeff()
              : 99;
      if (off > 1) {
        ++run.wrong;
        continue;
      }
      ++run.found;
      run.squares += (tag.corners_px - drawn.truth[static_cast<std::size_t>(tag.id)]).squaredNorm() / 8;
    }
    done();
  }
  run.counts = tracker.counts();
}

double Quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(q * static_cast<double>(values.size())))];
}

int Main(int frames, int cameras) {
  std::vector<std::vector<Drawn>> cycles(static_cast<std::size_t>(cameras));
  for (int c = 0; c < cameras; ++c) {
    cycles[static_cast<std::size_t>(c)] = DrawCycle(100 + static_cast<unsigned>(c));
  }
  fmt::print("{} cameras of {} x {} px, {} frames of {} tags each; {} processors\n", cameras, kWidth, kHeight,
             frames, kTags, std::thread::hardware_concurrency());
  fmt::print("{:<9} {:>10} {:>11} {:>7} {:>9} {:>11} {:>7} {:>6} {:>8} {:>22}  {}\n", "level", "fps/camera",
             "x real time", "ms/fr.", "p99", "cpu ms/fr.", "found", "> 1 px", "rms, px",
             "peak MB 25/50/100 %", "rejected");
  for (const auto level : {TagTrackLevel::kPreview, TagTrackLevel::kStandard, TagTrackLevel::kBest}) {
    std::vector<CameraRun> runs(static_cast<std::size_t>(cameras));
    std::mutex mutex;
    long done = 0;
    std::vector<long> peaks;
    const Clock::time_point start = Clock::now();
    std::vector<std::thread> workers;
    for (int c = 0; c < cameras; ++c) {
      workers.emplace_back([&, c] {
        Track(
            cycles[static_cast<std::size_t>(c)], level, frames,
            [&] {
              const std::lock_guard lock(mutex);
              ++done;
              for (const double share : {0.25, 0.5, 1.0}) {
                if (done == std::lround(share * frames * cameras)) peaks.push_back(PeakMemoryKb());
              }
            },
            runs[static_cast<std::size_t>(c)]);
      });
    }
    for (std::thread& worker : workers) worker.join();
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    std::vector<double> ms;
    long found = 0, wrong = 0;
    double squares = 0, cpu_ms = 0;
    TagTrackCounts all;
    for (const CameraRun& run : runs) {
      ms.insert(ms.end(), run.ms.begin(), run.ms.end());
      found += run.found;
      wrong += run.wrong;
      squares += run.squares;
      cpu_ms += run.cpu_ms;
      for (std::size_t i = 0; i < all.faults.size(); ++i) all.faults[i] += run.counts.faults[i];
      all.changed += run.counts.changed;
    }
    std::string rejected, memory;
    for (const auto& [cause, count] : RejectedByCause(all)) {
      rejected += fmt::format("{}{} {}", rejected.empty() ? "" : ", ", count, cause);
    }
    for (const long kb : peaks)
      memory += fmt::format("{}{:.1f}", memory.empty() ? "" : " ", 1e-3 * static_cast<double>(kb));
    const double fps = frames / seconds;
    const double all_frames = static_cast<double>(frames) * cameras;
    fmt::print("{:<9} {:>10.1f} {:>11.2f} {:>7.2f} {:>9.2f} {:>11.2f} {:>7.4f} {:>6} {:>8.4f} {:>22}  {}\n",
               NameOf(level), fps, fps / kRate, Quantile(ms, 0.5), Quantile(ms, 0.99), cpu_ms / all_frames,
               static_cast<double>(found) / (all_frames * kTags), wrong,
               std::sqrt(squares / static_cast<double>(std::max(1L, found))), memory,
               rejected.empty() ? "none" : rejected);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace tendril

int main(int argc, char** argv) {
  return tendril::Main(argc > 1 ? std::max(4, std::stoi(argv[1])) : 2000,
                       argc > 2 ? std::max(1, std::stoi(argv[2])) : 4);
}
