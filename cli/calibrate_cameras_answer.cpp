#include "cli/calibrate_cameras_answer.h"

#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "db/files/safe_file.h"

namespace tendril::cli {

std::vector<UncertaintyPanel> PanelsOf(const CameraCalibration& fit, const std::vector<BoardView>& views) {
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

void ShowCalibration(Output& out, const CameraCalibration& fit, const std::vector<UncertaintyPanel>& panels,
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

Status WriteUncertaintyMap(const std::string& file, const std::vector<UncertaintyPanel>& panels) {
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

}  // namespace tendril::cli
