#include "calibrate/cameras/board_pictures.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <optional>
#include <set>

#include "calibrate/cameras/frame_stamps.h"
#include "capture/record/picture_file.h"
#include "capture/record/video_file.h"

namespace tendril {
namespace {

namespace fs = std::filesystem;

std::string Lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool IsVideo(const fs::path& file) {
  static const std::set<std::string> kinds{".mkv", ".mp4", ".avi", ".mov", ".webm", ".m4v"};
  return kinds.contains(Lower(file.extension().string()));
}

// The files that a camera's sources stand for, each source's by name.
Result<std::vector<fs::path>> FilesOf(const CameraPictures& camera) {
  std::vector<fs::path> files;
  for (const std::string& source : camera.sources) {
    const fs::path path(source);
    std::error_code ignored;
    std::vector<fs::path> some;
    if (fs::is_directory(path, ignored)) {
      for (const auto& entry : fs::directory_iterator(path, ignored)) {
        if (IsPictureFile(entry.path())) some.push_back(entry.path());
      }
    } else if (fs::exists(path, ignored)) {
      some.push_back(path);
    } else if (source.find_first_of("*?[") != std::string::npos) {
      const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
      for (const auto& entry : fs::directory_iterator(folder, ignored)) {
        if (fnmatch(path.filename().c_str(), entry.path().filename().c_str(), 0) == 0)
          some.push_back(entry.path());
      }
    } else {
      return Error{ErrorKind::kNotFound, source + ": no such file"};
    }
    if (some.empty()) {
      return Error{ErrorKind::kNotFound,
                   fmt::format("{}: no picture of camera {} there; expected png, jpg, bmp, pgm or tif",
                               source, camera.name)};
    }
    std::sort(some.begin(), some.end());
    files.insert(files.end(), some.begin(), some.end());
  }
  const bool video = std::any_of(files.begin(), files.end(), IsVideo);
  if (video && files.size() != 1) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("camera {} has {} files with a video among them; expected one video or pictures",
                             camera.name, files.size())};
  }
  return files;
}

std::optional<std::int64_t> LastNumber(const fs::path& file) {
  const std::string stem = file.stem().string();
  const size_t end = stem.find_last_of("0123456789");
  if (end == std::string::npos) return std::nullopt;
  const size_t before = stem.find_last_not_of("0123456789", end);
  const size_t begin = before == std::string::npos ? 0 : before + 1;
  if (end + 1 - begin > 18) return std::nullopt;
  return std::stoll(stem.substr(begin, end + 1 - begin));
}

// The last number in each name; none where a name has none or two are equal.
std::optional<std::vector<std::int64_t>> Numbers(const std::vector<fs::path>& files) {
  std::vector<std::int64_t> numbers;
  for (const fs::path& file : files) {
    const auto number = LastNumber(file);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  if (std::set<std::int64_t>(numbers.begin(), numbers.end()).size() != numbers.size()) return std::nullopt;
  return numbers;
}

// Of videos only, if each has its frame log beside it; no stamps where not.
Result<FrameStamps> StampsOfVideos(const std::vector<std::vector<fs::path>>& files, BoardsSeen& seen) {
  std::vector<fs::path> logs;
  std::string without;
  for (const auto& own : files) {
    if (!IsVideo(own.front())) return FrameStamps{};
    logs.push_back(fs::path(own.front()).replace_extension(".csv"));
    std::error_code ignored;
    if (without.empty() && !fs::exists(logs.back(), ignored)) without = own.front().string();
  }
  if (files.size() < 2) return FrameStamps{};
  if (!without.empty()) {
    seen.notes.push_back(
        fmt::format("frames are paired by their number: {} has no frame log beside it", without));
    return FrameStamps{};
  }
  auto stamps = StampsByClock(logs);
  if (!stamps.ok()) return stamps.error();
  seen.notes.push_back(
      fmt::format("frames are paired by the clock: {} of {} are in camera {} and another, "
                  "at most {:.2f} ms apart",
                  stamps.value().together, stamps.value().stamps.front().size(), seen.cameras.front().name,
                  1e3 * stamps.value().farthest_apart));
  return stamps;
}

// Looks for the board in one picture and keeps what it shows.
Status Look(const cv::Mat& gray, const Board& board, std::int64_t stamp, int index, const std::string& name,
            BoardsSeen& seen) {
  Camera& camera = seen.cameras[static_cast<size_t>(index)];
  if (camera.width_px == 0) {
    camera.width_px = gray.cols;
    camera.height_px = gray.rows;
  }
  if (camera.width_px != gray.cols || camera.height_px != gray.rows) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("{}: {} x {} px, where camera {}'s first picture has {} x {}", name, gray.cols,
                             gray.rows, camera.name, camera.width_px, camera.height_px)};
  }
  auto corners = DetectBoard({gray.data, gray.cols, gray.rows, static_cast<int>(gray.step)}, board);
  if (!corners.ok()) return Error(corners.error()).Within(name);
  ++seen.pictures[static_cast<size_t>(index)];
  constexpr size_t kLeastCorners = 4;
  if (corners.value().ids.size() < kLeastCorners) return Ok{};
  seen.views.push_back({stamp, 0, index, std::move(corners).value()});
  return Ok{};
}

}  // namespace

bool AreVideos(const std::vector<CameraPictures>& cameras) {
  return std::all_of(cameras.begin(), cameras.end(), [](const CameraPictures& camera) {
    return std::all_of(camera.sources.begin(), camera.sources.end(),
                       [](const std::string& source) { return IsVideo(source); });
  });
}

Result<BoardsSeen> FindBoards(const std::vector<CameraPictures>& cameras, const Board& board, int every,
                              const Progress& progress) {
  if (every < 1)
    return Error{ErrorKind::kBadInput, fmt::format("every {} frames; expected 1 or more", every)};
  BoardsSeen seen;
  std::vector<std::vector<fs::path>> files;
  std::vector<std::optional<std::vector<std::int64_t>>> numbers;
  bool numbered = true;
  for (const CameraPictures& camera : cameras) {
    auto own = FilesOf(camera);
    if (!own.ok()) return own.error();
    seen.cameras.emplace_back();
    seen.cameras.back().name = camera.name;
    files.push_back(std::move(own).value());
    numbers.push_back(Numbers(files.back()));
    numbered = numbered && (numbers.back().has_value() || IsVideo(files.back().front()));
  }
  if (!numbered) {
    for (size_t c = 1; c < files.size(); ++c) {
      if (files[c].size() == files[0].size()) continue;
      return Error{
          ErrorKind::kBadInput,
          fmt::format("cameras {} and {} have {} and {} pictures, and no numbers in their names that say "
                      "which were taken at once",
                      cameras[0].name, cameras[c].name, files[0].size(), files[c].size())};
    }
    if (files.size() > 1)
      seen.notes.emplace_back("pictures are paired by their order, as names have no numbers");
  }
  const auto clock = StampsOfVideos(files, seen);
  if (!clock.ok()) return clock.error();
  seen.pictures.assign(cameras.size(), 0);
  for (size_t c = 0; c < files.size(); ++c) {
    const auto index = static_cast<int>(c);
    const auto share = [&](double done) {
      return !progress || progress((static_cast<double>(c) + done) / static_cast<double>(files.size()));
    };
    const size_t before = seen.views.size();
    if (IsVideo(files[c].front())) {
      const std::string name = files[c].front().string();
      auto video = VideoReader::Open(files[c].front());
      if (!video.ok()) return video.error();
      for (;;) {
        auto frame = video.value().Next();
        if (!frame.ok()) return frame.error();
        if (!frame.value()) break;
        if (!share(0.5)) return Error{ErrorKind::kStopped, "stopped"};
        std::int64_t stamp = frame.value()->index;
        if (!clock.value().stamps.empty()) {
          const auto& stamps = clock.value().stamps[c];
          if (static_cast<size_t>(stamp) >= stamps.size()) {
            return Error{ErrorKind::kBadInput, fmt::format("{}: frame {}, but its frame log has {} rows",
                                                           name, stamp, stamps.size())};
          }
          stamp = stamps[static_cast<size_t>(stamp)];
        }
        if (stamp % every != 0) continue;
        if (auto s = Look(frame.value()->image, board, stamp, index, name, seen); !s.ok()) return s.error();
      }
    } else {
      for (size_t i = 0; i < files[c].size(); ++i) {
        if (!share(static_cast<double>(i) / static_cast<double>(files[c].size()))) {
          return Error{ErrorKind::kStopped, "stopped"};
        }
        const auto gray = ReadGrayPicture(files[c][i]);
        if (!gray.ok()) return gray.error();
        const std::int64_t stamp = numbered ? (*numbers[c])[i] : static_cast<std::int64_t>(i);
        if (auto s = Look(gray.value(), board, stamp, index, files[c][i].string(), seen); !s.ok())
          return s.error();
      }
    }
    const size_t found = seen.views.size() - before;
    if (found < static_cast<size_t>(seen.pictures[c])) {
      seen.notes.push_back(fmt::format("camera {}: the board was found in {} of {} pictures", cameras[c].name,
                                       found, seen.pictures[c]));
    }
  }
  return seen;
}

}  // namespace tendril
