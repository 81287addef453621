#include "cli/detect_live.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "capture/track/live_tags.h"
#include "capture/track/tags_in_video.h"
#include "cli/id_ranges.h"
#include "cli/tag_picture.h"

namespace tendril::cli {
namespace {

using Clock = std::chrono::steady_clock;

std::string NameOfCamera(std::size_t number) { return fmt::format("cam{}", number); }

// Expected tags that fewer cameras see than a position takes: two, or all there are.
struct Missing {
  std::vector<int> unseen;      // by no camera
  std::vector<int> too_seldom;  // by fewer than two, the unseen among them; of one camera: the unseen
};
Missing WhatIsMissing(const std::vector<int>& expected, const std::vector<LiveCamera>& cameras) {
  std::map<int, int> views;
  for (const LiveCamera& camera : cameras) {
    for (const int id : camera.seen) ++views[id];
  }
  Missing missing;
  for (const int id : expected) {
    const auto seen = views.find(id);
    const int count = seen == views.end() ? 0 : seen->second;
    if (count == 0) missing.unseen.push_back(id);
    if (count < std::min(2, static_cast<int>(cameras.size()))) missing.too_seldom.push_back(id);
  }
  return missing;
}

std::string MissingInWords(const Missing& missing, std::size_t cameras) {
  if (missing.too_seldom.empty()) {
    return cameras > 1 ? "expected tags: each is seen by two cameras or more" : "expected tags: all are seen";
  }
  if (cameras == 1) return fmt::format("expected but not seen: {}", IdsInWords(missing.unseen));
  return fmt::format("expected but seen by fewer than two cameras: {} (by none: {})",
                     IdsInWords(missing.too_seldom), IdsInWords(missing.unseen));
}

nlohmann::ordered_json RejectedOf(const LiveCamera& camera) {
  auto rejected = nlohmann::ordered_json::object();
  for (const auto& [cause, count] : RejectedByCause(camera.counts)) rejected[cause] = count;
  return rejected;
}

nlohmann::ordered_json JsonOf(const std::vector<LiveCamera>& cameras) {
  auto all = nlohmann::ordered_json::array();
  for (const LiveCamera& camera : cameras) {
    nlohmann::ordered_json one = {{"source", camera.source},
                                  {"state", NameOf(camera.state)},
                                  {"fps", camera.fps},
                                  {"arriving_fps", camera.arriving_fps},
                                  {"ms_per_frame", camera.ms_per_frame},
                                  {"frames", camera.tracked},
                                  {"frames_passed_over", camera.arrived - camera.tracked},
                                  {"times_lost", camera.times_lost},
                                  {"seen", camera.seen},
                                  {"lost", camera.lost},
                                  {"rejected", RejectedOf(camera)}};
    one["blur_px"] = camera.blur_px > 0 ? nlohmann::ordered_json(camera.blur_px) : nlohmann::ordered_json();
    if (!camera.problem.message.empty()) one["problem"] = camera.problem.message;
    all.push_back(std::move(one));
  }
  return all;
}

std::vector<std::string> TableOf(const std::vector<LiveCamera>& cameras) {
  std::vector<std::string> lines = {fmt::format("{:<7}{:<9}{:>7}{:>9}{:>10}{:>8}{:>10}{:>6}", "camera",
                                                "state", "fps", "arrive", "ms/frame", "passed", "blur px",
                                                "tags")};
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const LiveCamera& camera = cameras[c];
    lines.push_back(fmt::format(
        "{:<7}{:<9}{:>7.1f}{:>9.1f}{:>10.2f}{:>8}{:>10}{:>6}", NameOfCamera(c), NameOf(camera.state),
        camera.fps, camera.arriving_fps, camera.ms_per_frame, camera.arrived - camera.tracked,
        camera.blur_px > 0 ? fmt::format("{:.2f}", camera.blur_px) : "-", camera.seen.size()));
    lines.push_back("       seen now: " + IdsInWords(camera.seen));
    lines.push_back(fmt::format("       lost: {}; rejected: {}", IdsInWords(camera.lost),
                                RejectedInWords(camera.counts)));
    if (camera.state == LiveState::kLost) lines.push_back("       " + camera.problem.message);
  }
  return lines;
}

std::string LineOf(double seconds, const std::vector<LiveCamera>& cameras) {
  std::string line = fmt::format("{:.0f} s", seconds);
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const LiveCamera& camera = cameras[c];
    line += fmt::format(" | {} {}", NameOfCamera(c),
                        camera.state == LiveState::kRunning
                            ? fmt::format("{:.0f} fps, {:.1f} ms, {} tags: {}", camera.fps,
                                          camera.ms_per_frame, camera.seen.size(), IdsInWords(camera.seen))
                            : NameOf(camera.state));
    if (!camera.lost.empty()) line += fmt::format(", lost {}", IdsInWords(camera.lost));
  }
  return line;
}

// Lines that replace those written before.
class Screen {
 public:
  void Show(const std::vector<std::string>& lines) {
    winsize size{};
    const bool known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
    const std::size_t width = known ? size.ws_col : 100;
    std::string text = shown_ > 0 ? fmt::format("\x1b[{}A", shown_) : "";
    // A line that wraps would not be replaced.
    for (const std::string& line : lines) text += "\x1b[2K" + line.substr(0, width - 1) + "\n";
    text += "\x1b[J";
    fmt::print("{}", text);
    std::fflush(stdout);
    shown_ = lines.size();
  }

 private:
  std::size_t shown_ = 0;
};

// All cameras side by side, each as high as the first.
Status WriteOverlay(const std::vector<LiveCamera>& cameras, const std::string& file) {
  std::vector<cv::Mat> pictures;
  for (const LiveCamera& camera : cameras) {
    if (camera.picture.empty()) continue;
    std::vector<DrawnTag> drawn;
    for (const TrackedTag& tag : camera.tags) drawn.push_back({tag.id, tag.corners_px});
    cv::Mat picture = DrawTags(camera.picture, drawn);
    if (!pictures.empty() && picture.rows != pictures.front().rows) {
      const double scale = static_cast<double>(pictures.front().rows) / picture.rows;
      cv::resize(picture, picture,
                 {std::max(1, static_cast<int>(picture.cols * scale)), pictures.front().rows});
    }
    pictures.push_back(picture);
  }
  if (pictures.empty()) return Ok{};
  cv::Mat all;
  cv::hconcat(pictures, all);
  return WritePicture(all, file);
}

// Tells each time that a camera went away.
class Changes {
 public:
  void Tell(const std::vector<LiveCamera>& cameras, Output& out) {
    times_lost_.resize(cameras.size(), 0);
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      const LiveCamera& camera = cameras[c];
      if (camera.times_lost > times_lost_[c]) {
        out.Warn(fmt::format("{}: {}; trying again", NameOfCamera(c), camera.problem.message));
      }
      times_lost_[c] = camera.times_lost;
    }
  }

 private:
  std::vector<int> times_lost_;
};

void Summarise(double seconds, const std::vector<LiveCamera>& cameras, const std::vector<int>& expected,
               const std::set<int>& ever_twice, Output& out) {
  auto& fields = out.fields();
  fields["seconds"] = seconds;
  fields["cameras"] = nlohmann::ordered_json::array();
  out.Print("watched for {:.1f} s", seconds);
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const LiveCamera& camera = cameras[c];
    std::vector<int> ever = camera.seen;
    ever.insert(ever.end(), camera.lost.begin(), camera.lost.end());
    std::sort(ever.begin(), ever.end());
    fields["cameras"].push_back({{"source", camera.source},
                                 {"frames", camera.tracked},
                                 {"frames_passed_over", camera.arrived - camera.tracked},
                                 {"times_lost", camera.times_lost},
                                 {"ever_seen", ever},
                                 {"rejected", RejectedOf(camera)}});
    out.Print("{}: {} pictures, {} passed over, went away {} times; ids seen: {}; rejected: {}",
              NameOfCamera(c), camera.tracked, camera.arrived - camera.tracked, camera.times_lost,
              IdsInWords(ever), RejectedInWords(camera.counts));
  }
  if (expected.empty()) return;
  std::vector<int> never;
  std::copy_if(expected.begin(), expected.end(), std::back_inserter(never),
               [&](int id) { return !ever_twice.contains(id); });
  fields["never_seen_by_enough_cameras"] = never;
  out.Print("expected but at no time seen by {}: {}",
            cameras.size() > 1 ? "two cameras at once" : "the camera", IdsInWords(never));
}

}  // namespace

Status DetectLive(const LiveCall& call, Output& out) {
  out.AnswerInLines();
  std::vector<int> expected;
  if (!call.expect.empty()) {
    Result<std::vector<int>> ids = ParseIds(call.expect);
    if (!ids.ok()) return Error(ids.error()).Within("--expect");
    expected = std::move(ids).value();
  }
  LiveTagsOptions options;
  const Result<std::optional<TagTrackLevel>> level = TagLevelOf(call.level);
  if (!level.ok()) return Error(level.error()).Within("--level");
  options.track.level = level.value().value_or(TagTrackLevel::kPreview);
  options.track.detect = call.detect;
  const Result<LiveTags> tags = LiveTags::Start(call.sources, options);
  if (!tags.ok()) return tags.error();

  const bool in_place = isatty(STDOUT_FILENO) != 0 && !out.json();
  const Clock::time_point start = Clock::now();
  const auto since = [start] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  double next_look = 0, next_line = 1, next_picture = 0.5;
  Screen screen;
  Changes changes;
  std::set<int> ever;  // expected and seen by enough cameras at some time
  std::vector<LiveCamera> now;
  while (true) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const double seconds = since();
    const bool over = StopRequested() || (call.seconds > 0 && seconds >= call.seconds);
    if (!over && seconds < next_look) continue;
    next_look = seconds + 0.2;
    const bool draw = !call.overlay.empty() && (over || seconds >= next_picture);
    now = tags.value().Look(draw);
    for (const LiveCamera& camera : now) {
      if (camera.state == LiveState::kFailed) return camera.problem;
    }
    if (!in_place) changes.Tell(now, out);  // the table says so itself
    const Missing missing = WhatIsMissing(expected, now);
    std::set_difference(expected.begin(), expected.end(), missing.too_seldom.begin(),
                        missing.too_seldom.end(), std::inserter(ever, ever.end()));
    if (draw) {
      if (Status s = WriteOverlay(now, call.overlay); !s.ok()) return s;
      next_picture = seconds + 1;
    }
    if (in_place) {
      std::vector<std::string> lines = TableOf(now);
      if (!expected.empty()) lines.push_back(MissingInWords(missing, now.size()));
      screen.Show(lines);
    } else if (seconds >= next_line) {
      next_line = seconds + 1;
      nlohmann::ordered_json line = {{"seconds", seconds}, {"cameras", JsonOf(now)}};
      if (!expected.empty()) {
        line["expected_unseen"] = missing.unseen;
        line["expected_seen_by_too_few"] = missing.too_seldom;
      }
      out.PrintJsonLine(line);
      out.Print("{}", LineOf(seconds, now));
      if (!expected.empty()) out.Print("    {}", MissingInWords(missing, now.size()));
      std::fflush(stdout);
    }
    const bool ended =
        std::all_of(now.begin(), now.end(), [](const LiveCamera& c) { return c.state == LiveState::kEnded; });
    if (over || ended) break;
  }
  if (!call.overlay.empty()) out.fields()["overlay"] = call.overlay;
  Summarise(since(), now, expected, ever, out);
  return Ok{};
}

}  // namespace tendril::cli
