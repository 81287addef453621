#pragma once
// What `tendril simulate` was asked for, and whether it can be done.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "cli/command.h"
#include "model/scene/scene.h"

namespace tendril::cli {

struct SimulateCall {
  std::string scene;
  std::string level;
  std::string out;
  std::string video;
  std::string picture;
  std::string checkpoint;
  std::string lab;
  std::string label;
  std::vector<double> at;             // s
  std::vector<std::string> settings;  // of the scene file (db/files/toml_edit.h)
  std::string then;                   // a test of holding; empty: none
  double fps = 30;
  std::uint64_t trial = 0;
  int threads = 1;
  bool store = false;  // in a lab
  bool plan = false;
  bool full = false;
};

void DeclareSimulate(CLI::App& app, const std::shared_ptr<SimulateCall>& call);

// What cannot be done is said before the run, not after it.
//   errors  kBadInput, kNotFound  a time beyond the scene, a file that cannot be written or has another
//           ending, more frames than can be meant, a label that is taken, a scene that is no trial
Status CheckCall(const SimulateCall& call, const Scene& scene);

// Frames at the rate, the end, and what was asked for besides; s, ascending.
std::vector<double> TimesOf(const SimulateCall& call, double duration);

// What a state must have been made by to go on from it: scene, options and program, hashed.
std::string RunId(const SimulateCall& call, const std::string& scene_text, const Scene& scene,
                  const std::vector<double>& times);

}  // namespace tendril::cli
