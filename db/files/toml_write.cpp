#include "db/files/toml_write.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>

namespace tendril {
namespace {

// An integral double such as 90 is written so: TOML's readers here take whole numbers where a number is
// asked.
std::string Plain(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value < 0 ? "-inf" : "inf";
  if (value == 0 && std::signbit(value)) return "-0.0";
  return fmt::format("{}", value);
}

}  // namespace

std::string TomlText(const std::string& text) {
  const bool lines = text.find('\n') != std::string::npos;
  std::string out = lines ? "\"\"\"\n" : "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if ((code < 0x20 || code == 0x7f) && !(c == '\n' && lines)) {
      out += fmt::format("\\u{:04X}", code);
    } else {
      out += c;
    }
  }
  return out + (lines ? "\"\"\"" : "\"");
}

std::string TomlNumber(double value) { return Plain(value); }

std::string TomlVector(const Eigen::Vector3d& value) {
  return fmt::format("[{}, {}, {}]", Plain(value.x()), Plain(value.y()), Plain(value.z()));
}

double RadiansOfDegrees(double degrees) { return degrees * std::numbers::pi / 180; }

std::string TomlDegrees(double radians) {
  // Degrees near the quotient that read back as these radians: the quotient itself or a neighbour, and of
  // these the shortest decimal.
  const double quotient = radians * 180 / std::numbers::pi;
  if (!std::isfinite(quotient)) return Plain(quotient);
  std::array<char, 40> text{};
  for (int digits = 1; digits <= 17; ++digits) {
    std::snprintf(text.data(), text.size(), "%.*g", digits, quotient);
    const double degrees = std::strtod(text.data(), nullptr);
    if (RadiansOfDegrees(degrees) == radians) return Plain(degrees);
  }
  for (const double to : {-INFINITY, INFINITY}) {
    double degrees = quotient;
    for (int step = 0; step < 4; ++step) {
      degrees = std::nextafter(degrees, to);
      if (RadiansOfDegrees(degrees) == radians) return Plain(degrees);
    }
  }
  return Plain(quotient);
}

}  // namespace tendril
