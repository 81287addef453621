#pragma once
// Sixty tags that swing before a camera of 1280 x 1024 px, for bench/: borders of 20 px (25 with the white
// ring), tilted by up to 45 degrees, blur 0.8 px.

#include <cmath>
#include <random>
#include <vector>

#include "tests/support/render_tag.h"

namespace tendril::testing_support {

class MovingTags {
 public:
  static constexpr int kTags = 60, kWidth = 1280, kHeight = 1024;

  //   swing_px  how far they swing to either side in x and y, at most; 30: 2.4 px from frame to frame
  MovingTags(double swing_px, std::mt19937& random) {
    std::uniform_real_distribution<double> any(0, 6.283185307), unit(0, 1);
    for (int id = 0; id < kTags; ++id) {
      const double x = 100 + 118.0 * (id % 10), y = 120 + 150.0 * static_cast<int>(id / 10);
      paths_.push_back({{x + 20 * unit(random), y + 20 * unit(random)},
                        {swing_px * unit(random), swing_px * unit(random)},
                        any(random),
                        any(random),
                        any(random),
                        0.785 * unit(random)});
      patterns_.push_back(PatternOf("tag36h11", id).value());
    }
  }

  // By id.
  std::vector<Eigen::Matrix<double, 2, 4>> CornersAt(int frame) const {
    std::vector<Eigen::Matrix<double, 2, 4>> corners;
    for (const Path& path : paths_) {
      const double turn = path.phase + 0.08 * frame;
      corners.push_back(TiltedCorners(path.middle + path.swing * std::sin(turn), 20,
                                      path.tilt * std::cos(0.5 * turn), path.axis,
                                      path.roll + 0.2 * std::sin(turn)));
    }
    return corners;
  }

  // Without noise.
  Picture Draw(int frame) const {
    Picture picture(kWidth, kHeight, 70);
    const auto corners = CornersAt(frame);
    for (std::size_t id = 0; id < corners.size(); ++id) DrawTag(picture, patterns_[id], 8, corners[id]);
    Blur(picture, 0.8);
    return picture;
  }

 private:
  struct Path {
    Eigen::Vector2d middle, swing;
    double axis, roll, phase, tilt;
  };
  std::vector<Path> paths_;
  std::vector<TagPattern> patterns_;
};

}  // namespace tendril::testing_support
