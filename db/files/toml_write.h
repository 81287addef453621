#pragma once
// TOML text of values, such that reading it back gives the same value to the last bit.

#include <Eigen/Core>
#include <string>

namespace tendril {

std::string TomlText(const std::string& text);  // in quotes; over several lines if it has them
std::string TomlNumber(double value);           // the shortest decimal
std::string TomlVector(const Eigen::Vector3d& value);
std::string TomlDegrees(double radians);  // the shortest degrees

double RadiansOfDegrees(double degrees);  // as every file reads its *_deg keys

}  // namespace tendril
