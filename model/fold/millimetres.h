#pragma once
// A length in a message, "12.5 mm".

#include <charconv>
#include <string>

namespace tendril {

inline std::string Millimetres(double metres) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, 1e3 * metres, std::chars_format::general, 6);
  return std::string(text, end.ptr) + " mm";
}

}  // namespace tendril
