#pragma once
// A simulated scene as a picture: rods as shaded tubes, fixed solids, a floor that catches their shadow, and
// what there is to say in words.
//
// SI units, lab frame, z up. Everything is drawn by ray casting on the processor; the same input gives the
// same bytes. Nothing depends on the order in which tubes and solids are listed: tubes are sorted and
// coloured by name (tubes of one name among themselves by their order).

#include <Eigen/Core>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "analysis/study/scene_view.h"

namespace tendril {

struct Tube {
  Eigen::Matrix3Xd points = {};  // m; a node that is not finite parts the tube        (3, nodes)
  Eigen::VectorXd radius = {};   // at nodes, m; not finite or negative: a thin line   (nodes)
  std::string name = {};
};

struct Solid {
  enum class Kind { kCapsule, kCylinder, kSphere };  // round ends, flat ends, a ball about `start`

  Kind kind = Kind::kCapsule;
  Eigen::Vector3d start = Eigen::Vector3d::Zero();  // m; of a capsule's axis, without the round ends
  Eigen::Vector3d end = Eigen::Vector3d::Zero();
  double radius = 0;  // m
};

struct ScenePicture {
  std::string title = {};
  double time = 0;  // s; NaN: not stated
  std::vector<Tube> tubes = {};
  std::vector<Solid> solids = {};
  std::vector<std::string> lines = {};  // below the time; ASCII, what is not becomes "?"
};

// The fixed view from which all of the pictures' tubes and solids can be seen, with room for the labels: the
// nearest one among the turns and heights tried in which the last picture covers most of the screen.
// Without anything to see, a view of the origin.
//   width_px, height_px  at least 64 each (checked)
SceneView FitView(const std::vector<ScenePicture>& pictures, int width_px, int height_px);

// Draws pictures of one view; keeps the floor and the working memory between them.
class ScenePainter {
 public:
  explicit ScenePainter(const SceneView& view);
  ~ScenePainter();
  ScenePainter(ScenePainter&&) noexcept;
  ScenePainter& operator=(ScenePainter&&) noexcept;

  // CV_8UC3, blue, green, red, of the view's size. What is behind the camera is left out; what would be
  // thinner than 1.5 px is drawn 1.5 px thick.
  cv::Mat Draw(const ScenePicture& picture);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// One picture.
cv::Mat DrawScene(const ScenePicture& picture, const SceneView& view);

}  // namespace tendril
