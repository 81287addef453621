#include "capture/track/live_tags.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "model/median.h"

namespace tendril {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

// What happened in the last second.
class LastSecond {
 public:
  void Add(Clock::time_point at, double ms) {
    entries_.push_back({at, ms});
    Forget(at);
  }
  void Forget(Clock::time_point now) {
    while (!entries_.empty() && now - entries_.front().at > std::chrono::seconds(1)) entries_.pop_front();
  }
  // A camera that began less than a second ago is counted over what there is.
  double Rate(Clock::time_point now, Clock::time_point began) const {
    const double window = std::clamp(Seconds(now - began).count(), 0.2, 1.0);
    return static_cast<double>(entries_.size()) / window;
  }
  double MeanMs() const {
    double sum = 0;
    for (const Entry& entry : entries_) sum += entry.ms;
    return entries_.empty() ? 0 : sum / static_cast<double>(entries_.size());
  }

 private:
  struct Entry {
    Clock::time_point at;
    double ms;
  };
  std::deque<Entry> entries_;
};

double MedianBlur(const std::vector<TrackedTag>& tags) {
  std::vector<double> blurs;
  for (const TrackedTag& tag : tags) blurs.push_back(tag.blur_px);
  return blurs.empty() ? 0 : Median(std::move(blurs));
}

}  // namespace

const char* NameOf(LiveState state) {
  switch (state) {
    case LiveState::kOpening:
      return "opening";
    case LiveState::kRunning:
      return "running";
    case LiveState::kLost:
      return "lost";
    case LiveState::kEnded:
      return "ended";
    case LiveState::kFailed:
      return "failed";
  }
  return "failed";
}

// Two threads: one reads so that nothing old piles up on the way, one tracks what is newest.
class LiveTags::Camera {
 public:
  Camera(std::string source, LiveTagsOptions options, TagTracker tracker)
      : options_(std::move(options)), tracker_(std::move(tracker)) {
    now_.source = std::move(source);
    reading_ = std::thread([this] { Read(); });
    tracking_ = std::thread([this] { Track(); });
  }
  Camera(const Camera&) = delete;
  Camera& operator=(const Camera&) = delete;
  ~Camera() {
    Stop();
    reading_.join();
    tracking_.join();
  }

  void Stop() {
    stopped_ = true;
    const std::lock_guard lock(mutex_);
    changed_.notify_all();
  }

  LiveCamera Look(bool with_picture) {
    const std::lock_guard lock(mutex_);
    const Clock::time_point now = Clock::now();
    arrivals_.Forget(now);
    trackings_.Forget(now);
    LiveCamera camera = now_;
    if (!with_picture) camera.picture = cv::Mat();
    camera.arriving_fps = arrivals_.Rate(now, began_);
    camera.fps = trackings_.Rate(now, began_);
    camera.ms_per_frame = trackings_.MeanMs();
    for (const auto& [id, at] : last_seen_) {
      (Seconds(now - at).count() <= options_.now ? camera.seen : camera.lost).push_back(id);
    }
    return camera;
  }

 private:
  void Read() {
    const LiveSourceOptions reading{.open_wait = options_.open_wait,
                                    .silence = options_.silence,
                                    .stopped = [this] { return stopped_.load(); }};
    while (!stopped_) {
      Result<std::unique_ptr<LiveSource>> source = OpenLiveSource(now_.source, reading);
      if (!source.ok()) {
        Tell(source.error());
      } else {
        Play(*source.value());
      }
      std::unique_lock lock(mutex_);
      if (now_.state == LiveState::kFailed || now_.state == LiveState::kEnded) break;
      changed_.wait_for(lock, Seconds(options_.retry), [this] { return stopped_.load(); });
    }
    const std::lock_guard lock(mutex_);
    no_more_ = true;
    changed_.notify_all();
  }

  void Play(LiveSource& source) {
    while (!stopped_) {
      Result<std::optional<cv::Mat>> next = source.Next();
      if (!next.ok()) return Tell(next.error());
      const std::lock_guard lock(mutex_);
      if (!next.value()) {
        now_.state = LiveState::kEnded;
        return;
      }
      const Clock::time_point now = Clock::now();
      if (now_.arrived == 0) began_ = now;
      now_.state = LiveState::kRunning;
      ++now_.arrived;
      arrivals_.Add(now, 0);
      newest_ = std::move(*next.value());
      changed_.notify_all();
    }
  }

  void Tell(const Error& problem) {
    if (problem.kind == ErrorKind::kStopped) return;
    const std::lock_guard lock(mutex_);
    now_.problem = problem;
    if (now_.state == LiveState::kRunning) ++now_.times_lost;
    now_.state = now_.arrived == 0 ? LiveState::kFailed : LiveState::kLost;
  }

  void Track() {
    while (true) {
      cv::Mat image;
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return stopped_ || no_more_ || !newest_.empty(); });
        if (stopped_ || newest_.empty()) return;
        image = std::move(newest_);
        newest_ = cv::Mat();
      }
      const Clock::time_point start = Clock::now();
      Result<std::vector<TrackedTag>> tags =
          tracker_.Next({image.data, image.cols, image.rows, static_cast<int>(image.step)});
      const Clock::time_point end = Clock::now();
      const std::lock_guard lock(mutex_);
      if (!tags.ok()) {
        now_.problem = Error(tags.error()).Within(now_.source);
        now_.state = LiveState::kFailed;
        stopped_ = true;
        return;
      }
      ++now_.tracked;
      trackings_.Add(end, 1e3 * Seconds(end - start).count());
      for (const TrackedTag& tag : tags.value()) last_seen_.insert_or_assign(tag.id, end);
      now_.width_px = image.cols;
      now_.height_px = image.rows;
      now_.blur_px = MedianBlur(tags.value());
      now_.counts = tracker_.counts();
      now_.picture = std::move(image);
      now_.tags = std::move(tags).value();
    }
  }

  LiveTagsOptions options_;
  TagTracker tracker_;  // of the tracking thread
  std::atomic<bool> stopped_ = false;
  std::mutex mutex_;  // of all that follows
  std::condition_variable changed_;
  LiveCamera now_;  // its source never changes
  cv::Mat newest_;  // not tracked yet; empty: none
  bool no_more_ = false;
  Clock::time_point began_ = Clock::now();
  LastSecond arrivals_, trackings_;
  std::map<int, Clock::time_point> last_seen_;
  std::thread reading_, tracking_;
};

LiveTags::LiveTags(std::vector<std::unique_ptr<Camera>> cameras) : cameras_(std::move(cameras)) {}
LiveTags::~LiveTags() {
  // All at once, so that one that is slow to stop is waited for once.
  for (const auto& camera : cameras_) camera->Stop();
}
LiveTags::LiveTags(LiveTags&&) noexcept = default;
LiveTags& LiveTags::operator=(LiveTags&&) noexcept = default;

Result<LiveTags> LiveTags::Start(const std::vector<std::string>& sources, const LiveTagsOptions& options) {
  if (sources.empty()) return Error{ErrorKind::kBadInput, "no camera; expected one source for each"};
  std::vector<TagTracker> trackers;
  for (std::size_t c = 0; c < sources.size(); ++c) {
    Result<TagTracker> tracker = TagTracker::Create(options.track);
    if (!tracker.ok()) return tracker.error();
    trackers.push_back(std::move(tracker).value());
  }
  std::vector<std::unique_ptr<Camera>> cameras;
  for (std::size_t c = 0; c < sources.size(); ++c) {
    cameras.push_back(std::make_unique<Camera>(sources[c], options, std::move(trackers[c])));
  }
  return LiveTags(std::move(cameras));
}

std::vector<LiveCamera> LiveTags::Look(bool with_pictures) const {
  std::vector<LiveCamera> now;
  for (const auto& camera : cameras_) now.push_back(camera->Look(with_pictures));
  return now;
}

}  // namespace tendril
