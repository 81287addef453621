// Tags found in real pictures that others published with what is in them: the table of docs/detection.md.
// Argument: the folder with apriltag_test/, pupil_apriltags/ and aprilgrid/ (not ours to ship).
#include <fmt/core.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <set>
#include <vector>

#include "capture/track/board_detect.h"
#include "capture/track/tag_detect.h"

namespace tendril {
namespace {

namespace fs = std::filesystem;

struct Expected {
  std::string picture;
  int tags = 0;
  std::multiset<int> ids;     // empty: how many is all that is published
  bool two_bit_grid = false;  // Kalibr's
};

// The pictures in apriltag_test come with a line "id, corners" for each tag.
Expected WithListedTags(const fs::path& folder, const std::string& name) {
  Expected expected{name + ".jpg", 0, {}};
  std::ifstream in(folder / (name + ".txt"));
  for (std::string line; std::getline(in, line);) {
    int id = 0;
    if (std::sscanf(line.c_str(), "%d, (", &id) == 1) expected.ids.insert(id);
  }
  expected.tags = static_cast<int>(expected.ids.size());
  return expected;
}

std::optional<std::multiset<int>> IdsIn(const cv::Mat& gray, bool two_bit_grid) {
  const GrayImage image{gray.data, gray.cols, gray.rows, static_cast<int>(gray.step)};
  std::multiset<int> ids;
  if (two_bit_grid) {
    const auto seen = DetectBoard(image, ParseBoard("aprilgrid:6x6:0.088:0.3:2").value());
    if (!seen.ok()) return std::nullopt;
    const std::set<int> corners(seen.value().ids.begin(), seen.value().ids.end());
    for (const int corner : corners) {
      if (corner % 4 == 0) ids.insert(corner / 4);
    }
    return ids;
  }
  auto detector = TagDetector::Create({});
  if (!detector.ok()) return std::nullopt;
  const auto tags = detector.value().Detect(image);
  if (!tags.ok()) return std::nullopt;
  for (const TagDetection& tag : tags.value()) ids.insert(tag.id);
  return ids;
}

bool Row(const fs::path& folder, const Expected& expected) {
  const cv::Mat gray = cv::imread((folder / expected.picture).string(), cv::IMREAD_GRAYSCALE);
  if (gray.empty()) {
    fmt::print(stderr, "{}: no such picture\n", (folder / expected.picture).string());
    return false;
  }
  const auto began = std::chrono::steady_clock::now();
  const auto ids = IdsIn(gray, expected.two_bit_grid);
  const double ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count();
  if (!ids) return false;
  const auto found = static_cast<int>(ids->size());
  int right = expected.ids.empty() ? std::min(found, expected.tags) : 0;
  std::multiset<int> left = expected.ids;
  for (const int id : *ids) {
    const auto at = left.find(id);
    if (at == left.end()) continue;
    left.erase(at);
    ++right;
  }
  fmt::print("| {} | {} x {} | {} | {} | {} | {:.1f} |\n", expected.picture, gray.cols, gray.rows,
             expected.tags, right, found - right, ms);
  return right == expected.tags && found == right;
}

}  // namespace
}  // namespace tendril

int main(int argc, char** argv) {
  using namespace tendril;
  if (argc != 2) {
    fmt::print(stderr,
               "usage: bench_real_tags FOLDER   (with apriltag_test/, pupil_apriltags/, aprilgrid/)\n");
    return 2;
  }
  const fs::path data(argv[1]);
  fmt::print("| picture | px | expected | found | beyond those | ms |\n|---|---|---|---|---|---|\n");
  bool all = true;
  const fs::path library = data / "apriltag_test" / "test" / "data";
  for (const char* name :
       {"33369213973_9d9bb4cc96_c", "34085369442_304b6bafd9_c", "34139872896_defdb2f8d9_c"}) {
    all = Row(library, WithListedTags(library, name)) && all;
  }
  const fs::path pupil = data / "pupil_apriltags";
  all = Row(pupil, {"test_image.png", 5, {}}) && all;
  constexpr std::array<int, 5> kPublished{6, 5, 6, 6, 4};
  for (size_t i = 0; i < kPublished.size(); ++i)
    all = Row(pupil, {fmt::format("test_image_multiple_{:02}.png", i + 1), kPublished[i], {}}) && all;
  for (int turn = -70; turn <= 70; turn += 10)
    all = Row(pupil, {fmt::format("test_image_rotation_{}.png", turn), 1, {76}}) && all;
  const fs::path grid = data / "aprilgrid";
  const std::pair<const char*, int> grids[] = {
      {"000.jpg", 36}, {"001.jpg", 36}, {"003.jpg", 36}, {"EuRoC.png", 26}, {"TUM_VI.png", 29}};
  for (const auto& [name, tags] : grids) all = Row(grid, {name, tags, {}, true}) && all;
  fmt::print("{}\n", all ? "every expected tag, and none beyond" : "NOT every expected tag, or some beyond");
  return all ? 0 : 1;
}
