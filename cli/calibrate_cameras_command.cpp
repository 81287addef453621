// tendril calibrate cameras: a rig file from pictures of a board.
#include "cli/calibrate_cameras_command.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "calibrate/cameras/board_pictures.h"
#include "calibrate/cameras/calibrate_cameras.h"
#include "calibrate/cameras/calibrate_from_tags.h"
#include "calibrate/cameras/projection_uncertainty.h"
#include "capture/rig/rig.h"
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
  std::string tags;  // detections.csv
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

std::vector<UncertaintyPanel> Panels(const CameraCalibration& fit, const std::vector<BoardView>& views) {
  std::vector<UncertaintyPanel> panels;
  for (size_t c = 0; c < fit.cameras.size(); ++c) {
    UncertaintyPanel panel{fit.cameras[c].name,
                           fit.cameras[c].width_px,
                           fit.cameras[c].height_px,
                           UncertaintyOf(fit.cameras[c], fit.reports[c].lens_covariance),
                           {}};
    for (const BoardView& view : views) {
      if (view.camera != static_cast<int>(c)) continue;
      for (Eigen::Index k = 0; k < view.corners.pixels.cols(); ++k)
        panel.corners_px.push_back(view.corners.pixels.col(k));
    }
    panels.push_back(std::move(panel));
  }
  return panels;
}

void Show(Output& out, const CameraCalibration& fit, const std::vector<UncertaintyPanel>& panels,
          double confidence) {
  const bool held = std::isfinite(fit.held_out_rms_px);
  out.Print("{} camera{}, {} moments, {} views, {} corners", fit.cameras.size(),
            fit.cameras.size() == 1 ? "" : "s", fit.stamps, fit.views, fit.corners);
  out.Print("reprojection RMS {:.4f} px{}", fit.rms_px,
            held
                ? fmt::format(", held-out pictures {:.4f} px ({} folds)", fit.held_out_rms_px, fit.folds_used)
                : "");
  auto& cameras = out.fields()["cameras"] = nlohmann::ordered_json::array();
  for (size_t c = 0; c < fit.cameras.size(); ++c) {
    const CalibratedCamera& report = fit.reports[c];
    const ProjectionUncertainty& sure = panels[c].uncertainty;
    out.Print(
        "camera {}: {} views, RMS {:.4f} px{}; projection known to {:.3f} px (median), {:.3f} px (worst)",
        fit.cameras[c].name, report.views, report.rms_px,
        held ? fmt::format(", held out {:.4f}", report.held_out_rms_px) : "", sure.median_px,
        sure.largest_px);
    nlohmann::ordered_json parameters = nlohmann::ordered_json::array();
    for (const CalibratedParameter& p : report.parameters) {
      if (p.standard_error == 0) {
        out.Print("  {:15} {:12.5f}   (given)", p.name, p.value);
      } else if (std::isfinite(p.standard_error)) {
        out.Print("  {:15} {:12.5f} +- {:.5f}   {:.0f} %: {:.5f} .. {:.5f}", p.name, p.value,
                  p.standard_error, 100 * confidence, p.low, p.high);
      } else {
        out.Print("  {:15} {:12.5f}   not determined", p.name, p.value);
      }
      parameters.push_back({{"name", p.name},
                            {"value", p.value},
                            {"standard_error", NumberOrNull(p.standard_error)},
                            {"interval", {NumberOrNull(p.low), NumberOrNull(p.high)}}});
    }
    cameras.push_back({{"name", fit.cameras[c].name},
                       {"image_size_px", {fit.cameras[c].width_px, fit.cameras[c].height_px}},
                       {"views", report.views},
                       {"corners", report.corners},
                       {"rms_px", report.rms_px},
                       {"held_out_rms_px", NumberOrNull(report.held_out_rms_px)},
                       {"projection_sigma_median_px", NumberOrNull(sure.median_px)},
                       {"projection_sigma_largest_px", NumberOrNull(sure.largest_px)},
                       {"parameters", std::move(parameters)}});
  }
  out.fields()["rms_px"] = fit.rms_px;
  out.fields()["held_out_rms_px"] = NumberOrNull(fit.held_out_rms_px);
  out.fields()["folds"] = fit.folds_used;
  out.fields()["refit_ratio"] = NumberOrNull(fit.refit_ratio);
  out.fields()["confidence"] = confidence;
  out.fields()["stamps"] = fit.stamps;
  out.fields()["views"] = fit.views;
  out.fields()["corners"] = fit.corners;
  out.fields()["corners_beyond_outlier"] = fit.down_weighted;
  out.fields()["converged"] = fit.converged;
  out.fields()["iterations"] = fit.iterations;
  out.fields()["seconds"] = fit.seconds;
  out.fields()["weaknesses"] = fit.weaknesses;
  if (!fit.weaknesses.empty()) out.Print("what these pictures are too weak for:");
  for (const std::string& sentence : fit.weaknesses) out.Print("  - {}", sentence);
}

Status WriteMap(const std::string& file, const std::vector<UncertaintyPanel>& panels) {
  const auto write = [&](const std::filesystem::path& beside) -> Status {
    try {
      if (cv::imwrite(beside.string(), DrawUncertainty(panels))) return Ok{};
    } catch (const cv::Exception& error) {
      return Error{ErrorKind::kBadInput, file + ": the map cannot be written (" + error.err + ")"};
    }
    return Error{ErrorKind::kIo, file + ": the map cannot be written"};
  };
  return WriteBeside(file, write);
}

// What the two ways in come to.
struct Calibrated {
  CameraCalibration fit;
  std::vector<BoardView> views;
  Eigen::Matrix3Xd layout;  // of the board; empty: tags that move
};

Status CheckWays(const CalibrateCamerasCall& call) {
  const auto bad = [](const std::string& message) { return Error{ErrorKind::kBadInput, message}; };
  if (call.tags.empty()) {
    if (call.board.empty() || call.cameras.empty())
      return bad("expected --board and --camera (pictures of a board), or --tags (recorded detections)");
    if (call.from_tags.border > 0 || call.from_tags.tags_move || call.from_tags.still_px > 0)
      return bad("--tag-size, --tags-move and --still go with --tags");
    return Ok{};
  }
  if (!call.board.empty() || !call.cameras.empty())
    return bad("--tags takes the place of --board and --camera; expected one or the other");
  if (!(call.from_tags.border > 0)) return bad("--tags needs --tag-size, the side of the black border (m)");
  if (call.lenses.empty())
    return bad("--tags needs --lenses: a rig file whose cameras are those of the detections, in their order");
  return Ok{};
}

Result<Calibrated> FromTags(const CalibrateCamerasCall& call, Output& out) {
  const auto rig = ReadRig(call.lenses);
  if (!rig.ok()) return rig.error();
  const auto rows = ReadDetections(call.tags);
  if (!rows.ok()) return rows.error();
  std::vector<TagInPicture> tags;
  for (const DetectionRow& row : rows.value()) {
    if (row.camera < 0 || static_cast<size_t>(row.camera) >= rig.value().cameras.size()) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("{}: camera {}, but {} has cameras 0 to {}", call.tags, row.camera,
                               call.lenses, rig.value().cameras.size() - 1)};
    }
    if (row.corners_px.col(0) == row.corners_px.col(2)) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("{}: tag {} of camera {}, frame {} has a centre only; expected four corners",
                               call.tags, row.tag, row.camera, row.frame)};
    }
    tags.push_back({row.frame, row.tag, row.camera, row.corners_px});
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

Result<Calibrated> FromBoard(const CalibrateCamerasCall& call, Output& out) {
  const auto board = ParseBoard(call.board);
  if (!board.ok()) return board.error();
  const auto pictures = SplitCameras(call.cameras);
  if (!pictures.ok()) return pictures.error();
  auto seen = FindBoards(pictures.value(), board.value(), call.every, out.ShowProgress("boards"));
  if (!seen.ok()) return seen.error();
  for (const std::string& note : seen.value().notes) out.Warn(note);
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
  const std::vector<UncertaintyPanel> panels = Panels(fit, views);
  Show(out, fit, panels, call.options.confidence);
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
    if (auto s = WriteMap(call.map_file, panels); !s.ok()) return s;
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
                "frame. Equal numbers in names (or frames) were taken at once");
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
