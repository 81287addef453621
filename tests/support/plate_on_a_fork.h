#pragma once
// A scene that runs in a second and in which an object is lifted, and what to say to run it.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/program.h"

namespace tendril::testing_support {

// Three stiff tentacles that reach inward from a carrier like a fork's prongs, and a plate that lies on them.
inline std::string PlateOnAFork(const TemporaryFolder& folder) {
  WriteText(folder / "prong.toml", "[tentacle]\nlength = 0.18\nholes = 13\n");
  WriteText(folder / "plate.toml",
            "name = \"plate on a fork\"\nduration = 0.2\nlevel = \"fast\"\n"
            "[gripper]\ndesign = \"prong.toml\"\ntentacles = 3\ncarrier_radius = 0.2\ntilt_deg = 90\n"
            "pull = 0\npull_rate = 0.1\ndelay = [0, 0]\nrate_perturbation = 0\n"
            "[gripper.rod]\nbase_radius = 0.005\nyoungs_modulus = 1e7\nshear_modulus = 4e6\n"
            "density = 1000\nelements = 8\ndamping = 20\n"
            "[[object]]\nname = \"plate\"\nkind = \"box\"\nsize = [0.12, 0.12, 0.01]\n"
            "position = [0, 0, 0.0102]\nmotion = \"free\"\nmass = 0.01\n"
            "[contact]\nstiffness = 1e4\nfriction = 0.4\ndamping = 0.05\n");
  return folder / "plate.toml";
}

// So far away that nothing touches it: it falls.
inline const std::vector<std::string> kFalling = {"--set", "object.0.position.2=-1"};

// So that it hangs away from all else.
inline const std::vector<std::string> kAway = {"--set", "object.0.motion=hanging",
                                               "--set", "object.0.string_length=0.1",
                                               "--set", "object.0.position.2=-0.5"};

// Too soft to be believed: rods sink into the plate by more than half a radius.
inline const std::vector<std::string> kSoftContact = {"--set", "contact.stiffness=1500"};

inline std::vector<std::string> Call(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

inline nlohmann::json Json(const ProgramRun& run) {
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return nlohmann::json::parse(run.out, nullptr, false);
}

}  // namespace tendril::testing_support
