// tendril calibrate cameras: a rig file from pictures of a board.
#include "cli/calibrate_cameras_command.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "calibrate/cameras/board_pictures.h"
#include "calibrate/cameras/calibrate_cameras.h"
#include "calibrate/cameras/calibrate_from_tags.h"
#include "calibrate/cameras/frame_stamps.h"
#include "capture/rig/rig.h"
#include "cli/calibrate_cameras_answer.h"
#include "db/files/recording_logs.h"
#include "db/files/safe_file.h"

namespace tendril::cli {
namespace {

struct CalibrateCamerasCall {
  std::string board;
  std::vector<std::string> cameras;  // name=source
  std::string model = "brown";
  std::string lenses;
  std::string rig_file;
  std::string map_file;
  int every = 1;
  CalibrateCamerasOptions options;
  double board_error_mm = 0;
  std::int64_t lab_board = -1;
  std::vector<double> lab_place;  // m
  std::string tags;               // detections.csv
  CalibrateFromTagsOptions from_tags;
};

// left=left*.jpg; the same name again adds to its pictures.
Result<std::vector<CameraPictures>> SplitCameras(const std::vector<std::string>& texts) {
  std::vector<CameraPictures> cameras;
  for (const std::string& text : texts) {
    const size_t at = text.find('=');
    if (at == std::string::npos || at == 0 || at + 1 == text.size()) {
      return Error{
          ErrorKind::kBadInput,
          fmt::format("--camera {}; expected NAME=PICTURES, as left='left*.jpg' or cam0=cam0.mkv", text)};
    }
    const std::string name = text.substr(0, at);
    auto known =
        std::find_if(cameras.begin(), cameras.end(), [&](const CameraPictures& c) { return c.name == name; });
    if (known == cameras.end()) known = cameras.insert(cameras.end(), {name, {}});
    known->sources.push_back(text.substr(at + 1));
  }
  return cameras;
}

// Seen from its face a board has x right, y down, z into it; the lab's z comes out of it.
BoardInLab LyingInLab(const CalibrateCamerasCall& call) {
  BoardInLab lab{.stamp = call.lab_board};
  lab.lab_from_board.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
  if (!call.lab_place.empty())
    lab.lab_from_board.translation() = Eigen::Map<const Eigen::Vector3d>(call.lab_place.data());
  return lab;
}

// The lenses of a rig file, by the cameras' names.
Result<std::vector<Camera>> KnownLenses(const std::string& file, const std::vector<Camera>& cameras) {
  const auto rig = ReadRig(file);
  if (!rig.ok()) return rig.error();
  std::vector<Camera> lenses;
  for (const Camera& camera : cameras) {
    const auto& all = rig.value().cameras;
    const auto known =
        std::find_if(all.begin(), all.end(), [&](const Camera& c) { return c.name == camera.name; });
    if (known == all.end()) {
      return Error{ErrorKind::kBadInput, fmt::format("{}: no camera named {}", file, camera.name)};
    }
    if (known->width_px != camera.width_px || known->height_px != camera.height_px) {
      return Error{
          ErrorKind::kBadInput,
          fmt::format("{}: camera {} has pictures of {} x {} px, those given have {} x {}", file, camera.name,
                      known->width_px, known->height_px, camera.width_px, camera.height_px)};
    }
    lenses.push_back(*known);
    lenses.back().camera_from_lab.setIdentity();
  }
  return lenses;
}

// What the two ways in come to.
struct Calibrated {
  CameraCalibration fit;
  std::vector<BoardView> views;
  Eigen::Matrix3Xd layout;  // of the board; empty: tags that move
};

Status CheckWays(const CalibrateCamerasCall& call) {
  const auto bad = [](const std::string& message) { return Error{ErrorKind::kBadInput, message}; };
  if (!call.lab_place.empty() && call.lab_board < 0)
    return bad("--lab-place goes with --lab-board, the picture in which the board lies there");
  if (call.tags.empty()) {
    if (call.board.empty() || call.cameras.empty())
      return bad("expected --board and --camera (pictures of a board), or --tags (recorded detections)");
    if (call.from_tags.border > 0 || call.from_tags.tags_move || call.from_tags.still_px > 0)
      return bad("--tag-size, --tags-move and --still go with --tags");
    return Ok{};
  }
  if (!call.board.empty() || !call.cameras.empty())
    return bad("--tags takes the place of --board and --camera; expected one or the other");
  if (call.lab_board >= 0)
    return bad("--lab-board goes with --board; with --tags the lab is camera 0's frame");
  if (!(call.from_tags.border > 0)) return bad("--tags needs --tag-size, the side of the black border (m)");
  if (call.lenses.empty())
    return bad("--tags needs --lenses: a rig file whose cameras are those of the detections, in their order");
  return Ok{};
}

// Stamps by the clock of the frame logs beside the detections, (cameras) x (frames); none without logs.
Result<std::vector<std::vector<std::int64_t>>> ClockOf(const std::string& tags, size_t cameras, double share,
                                                       Output& out) {
  std::vector<std::filesystem::path> logs;
  for (size_t c = 0; c < cameras; ++c) {
    logs.push_back(std::filesystem::path(tags).parent_path() / fmt::format("cam{}.csv", c));
    std::error_code ignored;
    if (std::filesystem::exists(logs.back(), ignored)) continue;
    out.Warn(fmt::format("frames are paired by their number: there is no {}", logs.back().string()));
    return std::vector<std::vector<std::int64_t>>{};
  }
  auto clock = StampsByClock(logs, share);
  if (!clock.ok()) return clock.error();
  return std::move(clock).value().stamps;
}

Result<Calibrated> FromTags(const CalibrateCamerasCall& call, Output& out) {
  const auto rig = ReadRig(call.lenses);
  if (!rig.ok()) return rig.error();
  const auto rows = ReadDetections(call.tags);
  if (!rows.ok()) return rows.error();
  const auto clock = ClockOf(call.tags, rig.value().cameras.size(),
                             call.from_tags.still_px > 0 ? kFreeRunning : kTriggered, out);
  if (!clock.ok()) return clock.error();
  std::vector<TagInPicture> tags;
  for (const DetectionRow& row : rows.value()) {
    if (row.camera < 0 || static_cast<size_t>(row.camera) >= rig.value().cameras.size()) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("{}: camera {}, but {} has cameras 0 to {}", call.tags, row.camera,
                               call.lenses, rig.value().cameras.size() - 1)};
    }
    std::int64_t stamp = row.frame;
    if (!clock.value().empty()) {
      const auto& frames = clock.value()[static_cast<size_t>(row.camera)];
      if (row.frame < 0 || static_cast<size_t>(row.frame) >= frames.size()) {
        return Error{ErrorKind::kBadInput,
                     fmt::format("{}: frame {} of camera {}, but its frame log has {} rows", call.tags,
                                 row.frame, row.camera, frames.size())};
      }
      stamp = frames[static_cast<size_t>(row.frame)];
    }
    if (row.corners_px.col(0) == row.corners_px.col(2)) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("{}: tag {} of camera {}, frame {} has a centre only; expected four corners",
                               call.tags, row.tag, row.camera, row.frame)};
    }
    tags.push_back({stamp, row.tag, row.camera, row.corners_px});
  }
  CalibrateFromTagsOptions options = call.from_tags;
  options.cameras = call.options;
  options.cameras.board_sigma = options.tags_move ? 0 : 1e-3 * call.board_error_mm;
  auto found = CalibrateFromTags(rig.value().cameras, tags, options, out.ShowProgress("fit"));
  if (!found.ok()) return Error(found.error()).Within(call.tags);
  RigFromTags& from = found.value();
  if (!options.tags_move) {
    out.Print("{} tags that are fixed to each other, from {} pictures ({:.4f} px)", from.body.tags.size(),
              from.body.pictures, from.body.rms_px);
    auto& places = out.fields()["tags"] = nlohmann::ordered_json::array();
    for (size_t i = 0; i < from.body.tags.size(); ++i) {
      nlohmann::ordered_json corners = nlohmann::ordered_json::array();
      for (Eigen::Index k = 0; k < 4; ++k) {
        const Eigen::Vector3d p = from.body.points.col(4 * static_cast<Eigen::Index>(i) + k);
        corners.push_back({p.x(), p.y(), p.z()});
      }
      places.push_back({{"tag", from.body.tags[i]}, {"corners_m", std::move(corners)}});
    }
  }
  return Calibrated{std::move(from.calibration), std::move(from.views), {}};
}

// What most likely is wrong if no picture at all shows the board that was named.
Error BoardNotFound(const Board& board, const BoardsSeen& seen) {
  int pictures = 0;
  for (const int count : seen.pictures) pictures += count;
  if (pictures == 0) return {ErrorKind::kBadInput, "no camera has a picture to look for boards in"};
  const char* counted =
      "inner corners across x down, one less than the squares each way, and all of them in the picture";
  if (board.kind == BoardKind::kCharuco)
    counted = "squares across x down; the dictionary is that of its markers";
  if (board.kind == BoardKind::kAprilGrid) counted = "tags across x down; the border is 1 or 2 bits wide";
  return {ErrorKind::kBadInput,
          fmt::format("--board {}: found in none of {} pictures; expected its counts to be {}",
                      BoardText(board), pictures, counted)};
}

Result<Calibrated> FromBoard(const CalibrateCamerasCall& call, Output& out) {
  const auto board = ParseBoard(call.board);
  if (!board.ok()) return board.error();
  const auto pictures = SplitCameras(call.cameras);
  if (!pictures.ok()) return pictures.error();
  if (call.lab_board > 0 && call.lab_board % call.every != 0 && AreVideos(pictures.value())) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("--lab-board {} is not looked at with --every {}; expected a multiple of {}",
                             call.lab_board, call.every, call.every)};
  }
  auto seen = FindBoards(pictures.value(), board.value(), call.every, out.ShowProgress("boards"));
  if (!seen.ok()) return seen.error();
  for (const std::string& note : seen.value().notes) out.Warn(note);
  if (seen.value().views.empty()) return BoardNotFound(board.value(), seen.value());
  if (LooksSameTurned(board.value()) && pictures.value().size() > 1) {
    out.Warn(
        fmt::format("a chessboard of {} x {} corners looks the same turned by half a turn: every camera must "
                    "see it the same way up; one even and one odd count would tell",
                    board.value().columns, board.value().rows));
  }
  for (Camera& camera : seen.value().cameras) {
    camera.distortion = call.model == "equidistant" ? Distortion::kEquidistant
                        : call.model == "none"      ? Distortion::kNone
                                                    : Distortion::kBrown;
  }
  CalibrateCamerasOptions options = call.options;
  if (call.lab_board >= 0) options.lab = LyingInLab(call);
  options.board_sigma = 1e-3 * call.board_error_mm;
  if (!call.lenses.empty()) {
    auto lenses = KnownLenses(call.lenses, seen.value().cameras);
    if (!lenses.ok()) return lenses.error();
    options.lenses = std::move(lenses).value();
  }
  auto fit = CalibrateCameras(seen.value().cameras, seen.value().views, BoardPoints(board.value()), options,
                              out.ShowProgress("fit"));
  if (!fit.ok()) return fit.error();
  out.fields()["board"] = BoardText(board.value());
  return Calibrated{std::move(fit).value(), std::move(seen.value().views), BoardPoints(board.value())};
}

Status RunCalibrateCameras(const CalibrateCamerasCall& call, Output& out) {
  if (auto s = CheckWays(call); !s.ok()) return s;
  auto calibrated = call.tags.empty() ? FromBoard(call, out) : FromTags(call, out);
  if (!calibrated.ok()) return calibrated.error();
  const auto& [fit, views, layout] = calibrated.value();
  const std::vector<UncertaintyPanel> panels = PanelsOf(fit, views);
  ShowCalibration(out, fit, panels, call.options.confidence);
  if (call.board_error_mm > 0 && layout.cols() == fit.points.cols()) {
    const Eigen::Matrix3Xd off = 1e3 * (fit.points - layout);
    const double rms = std::sqrt(off.squaredNorm() / static_cast<double>(off.cols()));
    out.Print("board: corners lie {:.3f} mm (RMS) from their layout, at most {:.3f} mm off its plane", rms,
              off.row(2).cwiseAbs().maxCoeff());
    nlohmann::ordered_json corrections = nlohmann::ordered_json::array();
    for (Eigen::Index k = 0; k < off.cols(); ++k) corrections.push_back({off(0, k), off(1, k), off(2, k)});
    out.fields()["board_corrections_mm"] = std::move(corrections);
  }
  if (!call.rig_file.empty()) {
    Rig rig;
    rig.name = std::filesystem::path(call.rig_file).stem().string();
    rig.cameras = fit.cameras;
    if (auto s = WriteText(call.rig_file, RigToml(rig)); !s.ok()) return s;
    out.fields()["rig"] = call.rig_file;
    out.Print("rig: {}", call.rig_file);
  }
  if (!call.map_file.empty()) {
    if (auto s = WriteUncertaintyMap(call.map_file, panels); !s.ok()) return s;
    out.fields()["map"] = call.map_file;
    out.Print("map of uncertainty: {}", call.map_file);
  }
  return Ok{};
}

}  // namespace

Command MakeCalibrateCamerasCommand() {
  auto call = std::make_shared<CalibrateCamerasCall>();
  return {
      .path = "calibrate cameras",
      .help = "lenses and poses of cameras from pictures of a chessboard, ChArUco board or AprilGrid",
      .example =
          "tendril calibrate cameras --board chessboard:9x6:0.025 --camera 'left=left*.jpg' --camera "
          "'right=right*.jpg' --out rig.toml --report map.png",
      .declare =
          [call](CLI::App& app) {
            app.add_option(
                "--board", call->board,
                "chessboard:9x6:0.025 (inner corners, m), charuco:7x5:0.04:0.03:4x4_50 (squares, m, m) or "
                "aprilgrid:6x6:0.088:0.3:2 (tags, m, gap / side, border bits)");
            app.add_option(
                "--camera", call->cameras,
                "NAME=PICTURES: a file, folder, pattern or video; once per camera, the first is the lab's "
                "frame. Equal numbers in names were taken at once; frames of videos go by the clock of the "
                "logs beside them (cam0.csv), without these by their number");
            app.add_option(
                   "--lab-board", call->lab_board,
                   "number of the picture (of videos, camera 0's frame) in which the board lies flat in "
                   "the lab: x along its rows, z out of its face")
                ->check(CLI::NonNegativeNumber);
            app.add_option("--lab-place", call->lab_place,
                           "X Y Z: where the board's origin lies in the lab then (m; default 0 0 0)")
                ->expected(3);
            app.add_option("--tags", call->tags,
                           "instead of a board: recorded tags (detections.csv); --lenses has the cameras");
            app.add_option("--tag-size", call->from_tags.border, "side of the tags' black border (m)")
                ->check(CLI::PositiveNumber);
            app.add_flag("--tags-move", call->from_tags.tags_move,
                         "tags move against each other; otherwise they are fixed to each other somehow");
            app.add_option(
                   "--still", call->from_tags.still_px,
                   "cameras are not triggered together: poses come from pictures whose tags move less "
                   "than this from picture to picture (px; 0: they are)")
                ->check(CLI::NonNegativeNumber);
            app.add_option("--model", call->model, "lens: brown (radial and tangential), equidistant, none")
                ->check(CLI::IsMember({"brown", "equidistant", "none"}))
                ->capture_default_str();
            app.add_option("--lenses", call->lenses,
                           "rig file whose lenses stay: only poses are fitted (TOML)");
            app.add_flag("--refine", call->options.refine_lenses,
                         "with --lenses: start from them, and fit them too");
            app.add_option(
                   "--board-error", call->board_error_mm,
                   "fit corrections of the printed board's corners, of about this size (mm; 0: it is exact)")
                ->check(CLI::NonNegativeNumber)
                ->capture_default_str();
            app.add_option("--every", call->every, "of videos, take each so manieth frame (count)")
                ->check(CLI::PositiveNumber)
                ->capture_default_str();
            app.add_option("--folds", call->options.folds, "of the cross-validation; 0: none (count)")
                ->check(CLI::NonNegativeNumber)
                ->capture_default_str();
            app.add_option("--confidence", call->options.confidence,
                           "of the intervals, as a fraction (0 to 1)")
                ->check(CLI::Range(0.5, 0.9999))
                ->capture_default_str();
            app.add_flag("--independent-corners", call->options.independent_corners,
                         "standard errors as if no two corners of a moment erred together");
            app.add_option("--out", call->rig_file, "write the rig (TOML)");
            app.add_option("--report", call->map_file, "draw how sure each camera's projection is (PNG)");
          },
      .run = [call](Output& out) { return RunCalibrateCameras(*call, out); },
  };
}

}  // namespace tendril::cli
