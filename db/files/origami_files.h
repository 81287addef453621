#pragma once
// A crease pattern and its folded shapes as files that origami programs open: FOLD 1.2 (JSON) and an SVG that
// Origami Simulator reads.

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "model/fold/crease_pattern.h"
#include "model/result.h"

namespace tendril {

struct FoldedFrame {
  std::string title;
  Eigen::VectorXd angle;      // phi of each crease, rad                                       (creases)
  Eigen::Matrix3Xd vertices;  // FoldedVertices, m                                             (3, vertices)
};

// Frame 0 is the crease pattern, in metres, with the last frame's fold angles as its targets; each of
// `frames` is a folded form that inherits from it. edges_foldAngle is 2 phi in degrees, + for valleys.
//   frames  at least one
std::string FoldText(const CreasePattern& pattern, const std::vector<FoldedFrame>& frames,
                     const std::string& title, const std::string& creator);

// Lines only, none in a group, in millimetres, seen from the outer face: mountains red, valleys blue, the
// border black; a crease's opacity times 180 degrees is its target angle 2 phi. A flat crease is yellow,
// which that program keeps flat: it takes a crease of opacity 0 for one without a target.
//   angle  phi of each crease, rad                                                            (creases)
std::string OrigamiSvg(const CreasePattern& pattern, const Eigen::VectorXd& angle);

// Written beside the target and renamed.   errors  as WriteText
Status WriteFoldText(const std::filesystem::path& file, const CreasePattern& pattern,
                     const std::vector<FoldedFrame>& frames, const std::string& title,
                     const std::string& creator);
Status WriteOrigamiSvg(const std::filesystem::path& file, const CreasePattern& pattern,
                       const Eigen::VectorXd& angle);

}  // namespace tendril
