#pragma once
// A simulated scene as a picture: rods as shaded tubes, objects of any shape, strings, a floor or a table's
// top that catches their shadow, and what there is to say in words.
//
// SI units, lab frame, z up. Everything is drawn by ray casting on the processor; the same input gives the
// same bytes. Nothing depends on the order in which tubes and objects are listed: both are sorted and
// coloured by name (of one name, tubes by their order and objects by where they are).

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "analysis/study/scene_view.h"
#include "model/objects/shape.h"

namespace tendril {

struct Tube {
  Eigen::Matrix3Xd points = {};  // m; a node that is not finite parts the tube        (3, nodes)
  Eigen::VectorXd radius = {};   // at nodes, m; not finite or negative: a thin line   (nodes)
  std::string name = {};
};

// A thing of any shape. A half space that faces up (to 2.5 degrees) is the floor, a table's top; another one
// shows the part of its plane that is near the scene.
struct ShownObject {
  Shape shape = {};
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  // lab_from_object; not finite: not drawn
  std::string name = {};
};

// A string, or a ring that things hang from.
struct Wire {
  Eigen::Matrix3Xd points = {};  // m                                            (3, nodes)
  double radius = 0;             // m; 0: a thin line
  bool pale = false;             // as of a string that is slack
  bool in_view = true;           // the view holds all of it; else it may run out of the picture
};

struct ScenePicture {
  std::string title = {};
  double time = 0;         // s; NaN: not stated
  std::string phase = {};  // what is being done, beside the time; empty: not stated
  std::vector<Tube> tubes = {};
  std::vector<ShownObject> objects = {};
  std::vector<Wire> wires = {};
  std::vector<std::string> lines = {};  // below the time; ASCII, what is not becomes "?"
};

// The fixed view from which all of the pictures' tubes, objects and wires can be seen, with room for the
// labels: the nearest one among the turns and heights tried in which the last picture covers most of the
// screen. Without anything to see, a view of the origin. The floor is the highest table's top, else below
// everything.
//   width_px, height_px  at least 64 each (checked)
SceneView FitView(const std::vector<ScenePicture>& pictures, int width_px, int height_px);

// A view for each picture, all in the direction of FitView's, from an eye that slowly goes where all of its
// picture is seen well: smooth over some 2 s, and nothing of a picture is ever out of view.
//   time  of each picture, ascending, s; as many (checked)
std::vector<SceneView> FollowViews(const std::vector<ScenePicture>& pictures, const Eigen::VectorXd& time,
                                   int width_px, int height_px);

// Draws pictures of one view; keeps the floor and the working memory between them.
class ScenePainter {
 public:
  explicit ScenePainter(const SceneView& view);
  ~ScenePainter();
  ScenePainter(ScenePainter&&) noexcept;
  ScenePainter& operator=(ScenePainter&&) noexcept;

  // Another view of the same scene.
  void LookFrom(const SceneView& view);

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
