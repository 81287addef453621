#include "calibrate/cameras/weakness.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace tendril {
namespace {

constexpr int kCells = 4;

std::string CellName(int row, int column) {
  const char* const rows[kCells] = {"top", "upper", "lower", "bottom"};
  const char* const columns[kCells] = {"left", "centre left", "centre right", "right"};
  return fmt::format("{} {}", rows[row], columns[column]);
}

struct SeenByCamera {
  std::array<int, static_cast<size_t>(kCells* kCells)> cells{};  // corners per cell, rows from the top
  std::vector<Eigen::Vector3d> normals;                          // of the board, in the camera
  std::vector<double> distances;
};

void AddLens(const Camera& camera, const CalibratedCamera& report, std::vector<std::string>& sentences) {
  for (const CalibratedParameter& p : report.parameters) {
    const bool focal = p.name.starts_with("focal");
    if (!std::isfinite(p.standard_error)) {
      sentences.push_back(
          fmt::format("camera {}: {} is not determined by these pictures", camera.name, p.name));
    } else if (focal && p.standard_error > 0.01 * p.value) {
      sentences.push_back(
          fmt::format("camera {}: {} is known to {:.1f} % only (focal length and distance "
                      "trade against each other; tilt the board more)",
                      camera.name, p.name, 100 * p.standard_error / p.value));
    } else if (p.name.starts_with("center") && p.standard_error > 0.01 * camera.width_px) {
      sentences.push_back(
          fmt::format("camera {}: {} is known to {:.0f} px only (tilt the board about both of "
                      "its axes)",
                      camera.name, p.name, p.standard_error));
    }
  }
}

void AddViews(const Camera& camera, const CalibratedCamera& report, const SeenByCamera& seen,
              std::vector<std::string>& sentences) {
  if (report.views < 10) {
    sentences.push_back(fmt::format("camera {}: {} pictures of the board are few; expected 10 or more",
                                    camera.name, report.views));
  }
  double spread = 0;
  double steepest = 0;
  for (size_t i = 0; i < seen.normals.size(); ++i) {
    steepest = std::max(steepest, std::acos(std::clamp(std::abs(seen.normals[i].z()), 0.0, 1.0)));
    for (size_t j = 0; j < i; ++j) {
      spread = std::max(spread, std::acos(std::clamp(seen.normals[i].dot(seen.normals[j]), -1.0, 1.0)));
    }
  }
  const double degrees = 180 / std::numbers::pi;
  if (spread * degrees < 15) {
    sentences.push_back(
        steepest * degrees < 15
            ? fmt::format(
                  "camera {}: the board is always frontal (within {:.0f} degrees): focal length cannot "
                  "be told from distance; tilt it by 20 to 45 degrees, about both axes",
                  camera.name, steepest * degrees)
            : fmt::format(
                  "camera {}: the board always faces the same way (within {:.0f} degrees); tilt it by "
                  "20 to 45 degrees both ways",
                  camera.name, spread * degrees));
  }
  std::vector<std::string> empty;  // the picture's own corners first: distortion is largest there
  for (const bool corners : {true, false}) {
    for (int row = 0; row < kCells; ++row) {
      for (int column = 0; column < kCells; ++column) {
        const bool corner = (row == 0 || row == kCells - 1) && (column == 0 || column == kCells - 1);
        if (corner != corners || seen.cells[static_cast<size_t>(row * kCells + column)] > 0) continue;
        empty.push_back(CellName(row, column));
      }
    }
  }
  if (empty.empty()) return;
  std::string names;
  constexpr size_t kNamed = 5;
  for (size_t i = 0; i < std::min(empty.size(), kNamed); ++i) names += (i > 0 ? ", " : "") + empty[i];
  if (empty.size() > kNamed) names += ", ...";
  sentences.push_back(
      fmt::format("camera {}: no corner of the board was seen in {} of {} parts of the picture "
                  "({}); distortion there is a guess",
                  camera.name, empty.size(), kCells * kCells, names));
}

}  // namespace

std::vector<std::string> WeaknessesOf(const CameraCalibration& calibration, const Bundle& bundle,
                                      const std::vector<CameraLink>& links) {
  const size_t n = bundle.cameras.size();
  constexpr size_t kMostNormals = 400;
  std::vector<SeenByCamera> seen(n);
  for (const BoardPlace& place : bundle.places) {
    for (const BoardView* view : place.views) {
      const auto c = static_cast<size_t>(view->camera);
      const Camera& camera = bundle.cameras[c];
      if (seen[c].normals.size() < kMostNormals) {
        seen[c].normals.emplace_back(camera.camera_from_lab.linear() * place.lab_from_board.linear().col(2));
      }
      for (Eigen::Index k = 0; k < view->corners.pixels.cols(); ++k) {
        const double across = (view->corners.pixels(0, k) + 0.5) / camera.width_px;
        const double down = (view->corners.pixels(1, k) + 0.5) / camera.height_px;
        const int column = std::clamp(static_cast<int>(kCells * across), 0, kCells - 1);
        const int row = std::clamp(static_cast<int>(kCells * down), 0, kCells - 1);
        ++seen[c].cells[static_cast<size_t>(row * kCells + column)];
      }
    }
  }
  std::vector<std::string> sentences;
  for (size_t c = 0; c < n; ++c) {
    AddViews(bundle.cameras[c], calibration.reports[c], seen[c], sentences);
    AddLens(bundle.cameras[c], calibration.reports[c], sentences);
    int moments = 0;
    for (const CameraLink& link : links) {
      if (link.a == static_cast<int>(c) || link.b == static_cast<int>(c)) moments += link.moments;
    }
    if (n > 1 && moments < 5) {
      sentences.push_back(
          fmt::format("camera {}: only {} moment{} link{} it to other cameras; expected 5 or more",
                      bundle.cameras[c].name, moments, moments == 1 ? "" : "s", moments == 1 ? "s" : ""));
    }
  }
  const double far = static_cast<double>(calibration.down_weighted) / std::max(1, calibration.corners);
  if (far > 0.05) {
    sentences.push_back(
        fmt::format("{:.0f} % of the corners lie beyond three sigmas (1 % would be chance): blur, "
                    "a bent board, or a lens that the model does not describe",
                    100 * far));
  }
  if (calibration.refit_ratio > 1.5) {
    sentences.push_back(
        fmt::format("fits without some of the pictures scatter {:.1f} times as much as the "
                    "standard errors say: errors of corners hang together; multiply by that",
                    calibration.refit_ratio));
  }
  if (calibration.held_out_rms_px > 1.5 * calibration.rms_px) {
    sentences.push_back(
        fmt::format("pictures that were left out are met to {:.2f} px, those fitted to {:.2f}: "
                    "too few for so many parameters",
                    calibration.held_out_rms_px, calibration.rms_px));
  }
  if (!calibration.converged) sentences.push_back("the fit did not converge; more iterations might move it");
  return sentences;
}

}  // namespace tendril
