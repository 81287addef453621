// Tags tracked against tags decoded in every frame: 60 tags with a footprint of 25 px move over 1280 x 1024
// px, blur 0.8 px, noise of 3 gray levels; on one thread, in turns in one run.
//   bench_tag_track [FRAMES]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "capture/track/tag_tracker.h"
#include "tests/support/moving_tags.h"

namespace tendril {
namespace {

using Corners = Eigen::Matrix<double, 2, 4>;
using Found = std::vector<std::pair<int, Corners>>;
using testing_support::MovingTags;
constexpr int kTags = MovingTags::kTags, kWidth = MovingTags::kWidth, kHeight = MovingTags::kHeight;

struct Frame {
  std::vector<unsigned char> bytes;
  std::vector<Corners> truth;  // by id
};

std::vector<Frame> DrawFrames(int count) {
  std::mt19937 random(1);
  const MovingTags tags(30, random);
  std::vector<Frame> frames;
  for (int f = 0; f < count; ++f) {
    testing_support::Picture picture = tags.Draw(f);
    testing_support::AddNoise(picture, 3, random);
    frames.push_back({picture.Bytes(), tags.CornersAt(f)});
  }
  return frames;
}

struct Contender {
  std::string name;
  std::function<Found(const GrayImage&)> find;
  std::vector<double> ms{};
  double squares = 0;
  long found = 0, wrong = 0;
};

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

Contender Decoding(const std::string& name, const TagDetectOptions& options) {
  const auto detector = std::make_shared<TagDetector>(TagDetector::Create(options).value());
  return {name, [detector](const GrayImage& image) {
            Found found;
            const auto tags = detector->Detect(image);
            for (const TagDetection& tag : tags.value()) {
              found.emplace_back(tag.id, tag.corners_px);
            }
            return found;
          }};
}
Contender Tracking(TagTrackLevel level) {
  TagTrackOptions options;
  options.level = level;
  const auto tracker = std::make_shared<TagTracker>(TagTracker::Create(options).value());
  return {std::string("tracked, ") + NameOf(level), [tracker](const GrayImage& image) {
            Found found;
            const auto tags = tracker->Next(image);
            for (const TrackedTag& tag : tags.value()) {
              found.emplace_back(tag.id, tag.corners_px);
            }
            return found;
          }};
}

int Main(int count) {
  const std::vector<Frame> frames = DrawFrames(count);
  TagDetectOptions library, coarse;
  library.corners = coarse.corners = TagCorners::kLibrary;
  coarse.decimate = 1.5;
  std::vector<Contender> contenders;
  contenders.push_back(Decoding("decoded, library's corners", library));
  contenders.push_back(Decoding("decoded, decimate 1.5", coarse));
  contenders.push_back(Decoding("decoded, edges fitted", {}));
  for (const auto level : {TagTrackLevel::kPreview, TagTrackLevel::kStandard, TagTrackLevel::kBest}) {
    contenders.push_back(Tracking(level));
  }
  for (const Frame& frame : frames) {
    const GrayImage image{frame.bytes.data(), kWidth, kHeight, kWidth};
    for (Contender& contender : contenders) {
      const auto begin = std::chrono::steady_clock::now();
      const Found found = contender.find(image);
      const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - begin;
      contender.ms.push_back(spent.count());
      for (const auto& [id, corners] : found) {
        const double off = id < kTags ? (corners - frame.truth[static_cast<std::size_t>(id)]).norm() : 99;
        contender.wrong += off < 8 ? 0 : 1;
        if (!(off < 8)) continue;
        ++contender.found;
        contender.squares += off * off / 8;
      }
    }
  }
  fmt::print("{} frames of {} tags; one thread\n", count, kTags);
  fmt::print("{:<28} {:>10} {:>8} {:>8} {:>6} {:>8}\n", "", "median, ms", "mean", "found", "wrong",
             "rms, px");
  for (const Contender& c : contenders) {
    double sum = 0;
    for (const double ms : c.ms) sum += ms;
    fmt::print("{:<28} {:10.2f} {:8.2f} {:8.4f} {:6} {:8.4f}\n", c.name, Median(c.ms), sum / count,
               static_cast<double>(c.found) / (count * kTags), c.wrong,
               std::sqrt(c.squares / static_cast<double>(c.found)));
  }
  return 0;
}

}  // namespace
}  // namespace tendril

int main(int argc, char** argv) { return tendril::Main(argc > 1 ? std::stoi(argv[1]) : 100); }
