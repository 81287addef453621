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
#include "tests/support/render_tag.h"

namespace tendril {
namespace {

using Corners = Eigen::Matrix<double, 2, 4>;
using Found = std::vector<std::pair<int, Corners>>;
constexpr int kTags = 60, kWidth = 1280, kHeight = 1024;

struct Frame {
  std::vector<unsigned char> bytes;
  std::vector<Corners> truth;  // by id
};

struct Path {
  Eigen::Vector2d middle, swing;
  double axis, roll, phase, tilt;
};

std::vector<Frame> DrawFrames(int count) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(0, 6.283185307), unit(0, 1);
  std::vector<Path> paths;
  std::vector<TagPattern> patterns;
  for (int id = 0; id < kTags; ++id) {
    const double x = 100 + 118.0 * (id % 10), y = 120 + 150.0 * static_cast<int>(id / 10);
    paths.push_back({{x + 20 * unit(random), y + 20 * unit(random)},
                     {30 * unit(random), 30 * unit(random)},
                     any(random),
                     any(random),
                     any(random),
                     0.785 * unit(random)});
    patterns.push_back(PatternOf("tag36h11", id).value());
  }
  std::vector<Frame> frames;
  for (int f = 0; f < count; ++f) {
    testing_support::Picture picture(kWidth, kHeight, 70);
    Frame frame;
    for (std::size_t id = 0; id < kTags; ++id) {
      const Path& path = paths[id];
      // Up to 2.4 px from frame to frame.
      const double turn = path.phase + 0.08 * f;
      frame.truth.push_back(testing_support::TiltedCorners(path.middle + path.swing * std::sin(turn), 20,
                                                           path.tilt * std::cos(0.5 * turn), path.axis,
                                                           path.roll + 0.2 * std::sin(turn)));
      testing_support::DrawTag(picture, patterns[id], 8, frame.truth.back());
    }
    testing_support::Blur(picture, 0.8);
    testing_support::AddNoise(picture, 3, random);
    frame.bytes = picture.Bytes();
    frames.push_back(std::move(frame));
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
