#pragma once
// Pictures of tags with known corners, drawn by area sampling, for tests of the detector. Shares nothing with
// it but the printed pattern.

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "capture/rig/tag_family.h"

namespace tendril::testing_support {

struct Picture {
  int width = 0;
  int height = 0;
  std::vector<double> gray;  // row by row, 0 .. 255

  Picture(int w, int h, double background)
      : width(w), height(h), gray(static_cast<size_t>(w * h), background) {}

  double& At(int u, int v) { return gray[static_cast<size_t>(v * width + u)]; }

  std::vector<unsigned char> Bytes() const {
    std::vector<unsigned char> bytes(gray.size());
    for (size_t i = 0; i < gray.size(); ++i) {
      bytes[i] = static_cast<unsigned char>(std::clamp(std::lround(gray[i]), 0L, 255L));
    }
    return bytes;
  }
};

// The homography that takes tag coordinates (border corners at (-1,1), (1,1), (1,-1), (-1,-1)) to pixels.
inline Eigen::Matrix3d HomographyOf(const Eigen::Matrix<double, 2, 4>& corners_px) {
  const double x[4] = {-1, 1, 1, -1};
  const double y[4] = {1, 1, -1, -1};
  Eigen::Matrix<double, 8, 8> a;
  Eigen::Matrix<double, 8, 1> b;
  for (int i = 0; i < 4; ++i) {
    const double u = corners_px(0, i);
    const double v = corners_px(1, i);
    a.row(2 * i) << x[i], y[i], 1, 0, 0, 0, -u * x[i], -u * y[i];
    a.row(2 * i + 1) << 0, 0, 0, x[i], y[i], 1, -v * x[i], -v * y[i];
    b.segment<2>(2 * i) << u, v;
  }
  const Eigen::Matrix<double, 8, 1> h = a.partialPivLu().solve(b);
  Eigen::Matrix3d m;
  m << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1;
  return m;
}

// Draws a tag whose border corners lie at corners_px (detector's order; (0, 0) is a pixel's centre). Each
// pixel is the mean over its area, from 8 x 8 samples.
inline void DrawTag(Picture& picture, const TagPattern& pattern, int border_width,
                    const Eigen::Matrix<double, 2, 4>& corners_px, double black = 30, double white = 220) {
  const Eigen::Matrix3d tag_from_pixel = HomographyOf(corners_px).inverse();
  const Eigen::Vector2d center = corners_px.rowwise().mean();
  const double reach = 1.6 * (corners_px.colwise() - center).colwise().norm().maxCoeff();
  const int n = static_cast<int>(pattern.rows());
  for (int v = std::max(0, static_cast<int>(center.y() - reach));
       v < std::min(picture.height, static_cast<int>(center.y() + reach) + 1); ++v) {
    for (int u = std::max(0, static_cast<int>(center.x() - reach));
         u < std::min(picture.width, static_cast<int>(center.x() + reach) + 1); ++u) {
      double sum = 0;
      for (int i = 0; i < 64; ++i) {
        const Eigen::Vector3d p =
            tag_from_pixel * Eigen::Vector3d(u + (i % 8 - 3.5) / 8, v + (i / 8 - 3.5) / 8.0, 1);
        const int column = static_cast<int>(std::floor((p.x() / p.z()) * border_width / 2 + 0.5 * n));
        const int row = static_cast<int>(std::floor((p.y() / p.z()) * border_width / 2 + 0.5 * n));
        const bool on = column >= 0 && row >= 0 && column < n && row < n;
        sum += !on ? picture.At(u, v) : pattern(row, column) > 127 ? white : black;
      }
      picture.At(u, v) = sum / 64;
    }
  }
}

// Within columns left .. right and rows top .. bottom of a picture that is even beyond them; all by default.
inline void Blur(Picture& picture, double sigma, int left = 0, int top = 0, int right = 1 << 30,
                 int bottom = 1 << 30) {
  const int reach = static_cast<int>(std::ceil(4 * sigma));
  left = std::max(0, left - reach);
  top = std::max(0, top - reach);
  right = std::min(picture.width - 1, right < (1 << 30) ? right + reach : right);
  bottom = std::min(picture.height - 1, bottom < (1 << 30) ? bottom + reach : bottom);
  std::vector<double> weight;
  double total = 0;
  for (int i = -reach; i <= reach; ++i) {
    weight.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
    total += weight.back();
  }
  for (double& w : weight) w /= total;
  for (const bool across : {true, false}) {
    Picture out = picture;
    for (int v = top; v <= bottom; ++v) {
      for (int u = left; u <= right; ++u) {
        double sum = 0;
        for (int i = -reach; i <= reach; ++i) {
          const int x = across ? std::clamp(u + i, 0, picture.width - 1) : u;
          const int y = across ? v : std::clamp(v + i, 0, picture.height - 1);
          sum += weight[static_cast<size_t>(i + reach)] * picture.At(x, y);
        }
        out.At(u, v) = sum;
      }
    }
    picture = out;
  }
}

inline void AddNoise(Picture& picture, double sigma, std::mt19937& random) {
  std::normal_distribution<double> noise(0, sigma);
  for (double& g : picture.gray) g += noise(random);
}

// Corners of a tag seen under a tilt: a pinhole of focal length f px looks at a square of side `side_px` (as
// it would measure frontal), turned by `tilt` about an axis at `axis` in the picture and by `roll` in it.
inline Eigen::Matrix<double, 2, 4> TiltedCorners(const Eigen::Vector2d& center, double side_px, double tilt,
                                                 double axis, double roll, double f = 1500) {
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(tilt, Eigen::Vector3d(std::cos(axis), std::sin(axis), 0)) *
                                Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()))
                                   .toRotationMatrix();
  const double x[4] = {-0.5, 0.5, 0.5, -0.5};
  const double y[4] = {0.5, 0.5, -0.5, -0.5};
  Eigen::Matrix<double, 2, 4> corners;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d p = turn * Eigen::Vector3d(x[i], y[i], 0) * side_px + Eigen::Vector3d(0, 0, f);
    corners.col(i) = center + f * p.head<2>() / p.z();
  }
  return corners;
}

}  // namespace tendril::testing_support
