#pragma once
// trial.toml in a trial's folder: all that is needed to process the trial again, without the database.
//
// SI units, radians, lab frame; the file's keys carry their unit where it is not SI (docs/formats.md).

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "db/files/tag_toml.h"
#include "model/fold/design.h"
#include "model/fold/gripper.h"
#include "model/result.h"

namespace tendril {

enum class TrialKind { kReal, kVirtual, kSimulated, kPublished };
enum class TrialState { kRecording, kRecorded, kDegraded, kAborted, kFailed };

// "real", "virtual", "simulated", "published"; "recording", "recorded", "degraded", "aborted", "failed".
std::string NameOf(TrialKind kind);
std::string NameOf(TrialState state);
std::string NameOf(Handedness handedness);  // "mirror", "normals", "same"
std::optional<TrialKind> TrialKindOf(std::string_view name);
std::optional<TrialState> TrialStateOf(std::string_view name);
std::optional<Handedness> HandednessOf(std::string_view name);

// What the gripper is to grasp.
struct ObjectSpec {
  std::string kind = "cylinder";
  double radius = 0.0225;                  // m
  double length = 0.280;                   // m
  Eigen::Vector3d position{0, 0, -0.15};   // of its centre in the lab frame, m
  Eigen::Vector3d axis = {1.0, 0.0, 0.0};  // direction in the lab frame
  double mass = 0.015;                     // kg
};

struct TrialSpec {
  std::string id{};     // UUIDv7
  std::string label{};  // short and unique in the lab
  TrialKind kind = TrialKind::kReal;
  std::int64_t started_ns = 0;  // host clock, ns since 1970, UTC
  std::string design_name{};
  TentacleDesign design;
  Gripper gripper;
  TagSpec tags;
  std::string rig_name{};
  std::string rig_toml{};  // the rig file's text (capture/rig/rig.h parses it); empty: no cameras
  ObjectSpec object;
  double object_distance = 0.15;  // carrier to object, m
  std::string medium = "air";
  double pull = 0.3;        // commanded at the end, fraction of the flat tendon length
  double pull_rate = 0.03;  // commanded, 1/s
  std::string notes{};
};

//   errors  kNotFound no such file; kBadInput names file:line, field, value and what was expected
Result<TrialSpec> ReadTrialToml(const std::filesystem::path& file);

// The file's text; reading it back gives the same values (angles: db/files/design_toml.h).
std::string TrialToml(const TrialSpec& trial);

// Two of its tables alone: the text by whose hash the database tells objects and grippers apart.
std::string ObjectToml(const ObjectSpec& object);
std::string GripperToml(const Gripper& gripper);

}  // namespace tendril
