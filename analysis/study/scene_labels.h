#pragma once
// The words in a scene's picture: where they go and how large.

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "analysis/study/scene_view.h"

namespace tendril {

struct ScenePicture;

struct SceneLabel {
  enum class Kind { kText, kTitle, kSwatch, kBar };  // a swatch is a dot before its text; a bar has it above

  Kind kind = Kind::kText;
  std::string text = {};
  cv::Rect box = {};      // all that is drawn, px
  double size_px = 16;    // height of capitals
  double bar_px = 0;      // length of the bar
  cv::Scalar color = {};  // of the swatch: blue, green, red
};

// Down the left side: title, time, lines, a legend where there are 2 .. 12 names, and a bar as long as its
// text says at the depth of what is looked at. Boxes are inside the picture and apart from each other: texts
// are broken at blanks, words too wide are cut, and what finds no place is left out, lines before the legend.
//   names, colors  of the legend, in its order
//   grid_step      between the floor's lines, m
std::vector<SceneLabel> LayOutLabels(const ScenePicture& picture, const SceneView& view,
                                     const std::vector<std::string>& names,
                                     const std::vector<cv::Scalar>& colors, double grid_step);

void DrawLabels(const std::vector<SceneLabel>& labels, cv::Mat& picture);

// What is left for the scene beside the column of labels.
PictureRoom RoomBesideLabels(int width_px, int height_px);

}  // namespace tendril
