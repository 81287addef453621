#pragma once
// The tables of a scene file, one reader for each; what scene_toml.cpp is made of.
//
// What is wrong is kept by the document until its Finish().

#include <string>
#include <vector>

#include "db/files/toml_read.h"
#include "model/scene/scene.h"

namespace tendril {

// [[object]] and, last, [table].
//   gravity  says where up is, for what hangs
std::vector<SceneObject> ReadObjects(TomlDocument& document, const Eigen::Vector3d& gravity);

// [[rod]]
std::vector<SceneRod> ReadRods(TomlDocument& document);

// What [[rod]] and [gripper.rod] have in common.
void ReadRodKeys(TomlTable& table, RodDesign& design, double& damping);

// What stands for a rod's own cross-section in a medium: `drag_diameter` (m, at the base), `displaced`.
//   base_radius  the rod's
void ReadWetted(TomlTable& table, double base_radius, Wetted& wetted);

// [[phase]] and `cycles`, into a scene whose gripper and rods are read.
void ReadPhases(TomlDocument& document, Scene& scene);

// A pair [low, high] in ascending order, s.
void ReadSpan(TomlTable& table, const std::string& key, double& low, double& high);

// `name`: without comma, slash or control character, for curves are called so in files.
void ReadName(TomlTable& table, std::string& name);

}  // namespace tendril
