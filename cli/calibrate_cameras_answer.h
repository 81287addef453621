#pragma once
// What `calibrate cameras` says of a fit: for a person, as JSON fields, as a picture.

#include <string>
#include <vector>

#include "calibrate/cameras/calibrate_cameras.h"
#include "calibrate/cameras/projection_uncertainty.h"
#include "cli/command.h"

namespace tendril::cli {

// One panel per camera, with the corners that it saw.
std::vector<UncertaintyPanel> PanelsOf(const CameraCalibration& fit, const std::vector<BoardView>& views);

void ShowCalibration(Output& out, const CameraCalibration& fit, const std::vector<UncertaintyPanel>& panels,
                     double confidence);

//   errors  kBadInput: a kind of file that pictures are not written to; kIo
Status WriteUncertaintyMap(const std::string& file, const std::vector<UncertaintyPanel>& panels);

}  // namespace tendril::cli
