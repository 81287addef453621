#pragma once
// Where real recordings from elsewhere may lie: beside the checkout (never in it), or where the environment
// variable TENDRIL_SHARED says. Tests that need them skip where they are absent.

#include <cstdlib>
#include <filesystem>

namespace tendril::testing_support {

inline std::filesystem::path SharedFolder() {
  if (const char* named = std::getenv("TENDRIL_SHARED")) return named;
  return std::filesystem::path(TENDRIL_SOURCE_DIR).parent_path() / "shared";
}

}  // namespace tendril::testing_support

#define TENDRIL_SKIP_WITHOUT(path) \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "not on this machine: " << (path)
