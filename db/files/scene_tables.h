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

// A pair [low, high] in ascending order, s.
void ReadSpan(TomlTable& table, const std::string& key, double& low, double& high);

// `name`: without comma, slash or control character, for curves are called so in files.
void ReadName(TomlTable& table, std::string& name);

}  // namespace tendril
