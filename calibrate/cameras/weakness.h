#pragma once
// What the pictures of a calibration are too weak to tell, in sentences for people.

#include <string>
#include <vector>

#include "calibrate/cameras/calibrate_cameras.h"
#include "calibrate/cameras/start_values.h"

namespace tendril {

// Few views, a board that is always frontal or always in one plane, parts of the picture where no corner was
// seen (of 4 x 4), cameras linked by few moments, parameters that the data hardly determine.
std::vector<std::string> WeaknessesOf(const CameraCalibration& calibration, const Bundle& bundle,
                                      const std::vector<CameraLink>& links);

}  // namespace tendril
