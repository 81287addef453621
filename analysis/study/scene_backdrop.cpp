#include "analysis/study/scene_backdrop.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace tendril {
namespace {

double Smooth(double from, double to, double x) {
  const double s = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

// A different fraction of a gray level for each pixel, so that slow gradients show no steps.
double Dither(int x, int y) {
  auto h = static_cast<std::uint32_t>(x) * 0x9E3779B1U ^ static_cast<std::uint32_t>(y) * 0x85EBCA77U;
  h ^= h >> 15;
  h *= 0x2C1B3C6DU;
  h ^= h >> 13;
  return static_cast<double>(h & 0xFFFFU) / 65536.0;
}

Eigen::Vector3d RayOf(const SceneView& view, double x, double y) {
  const Eigen::Vector3d in_camera((x - view.center_x_px) / view.focal_px,
                                  (y - view.center_y_px) / view.focal_px, 1);
  return view.camera_from_lab.linear().transpose() * in_camera;
}

constexpr double kSoft = 0.010, kFootSoft = 0.022;  // of the light's picture
constexpr double kFootRange = 0.10;                 // of the scene's reach

// What is hidden from a light, 255 all of it, with an edge `soft` of the light's picture wide; each ray that
// meets something counts as its depth does, 0 .. 1.
template <class Weigh>
cv::Mat HiddenFrom(const SceneView& light, const SceneRaster& seen, double soft, const Weigh& weigh) {
  cv::Mat hidden(light.height_px, light.width_px, CV_8UC1, cv::Scalar(0));
  for (int y = seen.top; y < seen.bottom; ++y) {
    auto* row = hidden.ptr<std::uint8_t>(y);
    for (int x = seen.left; x < seen.right; ++x) {
      const std::size_t at = seen.At(x, y);
      if (seen.piece[at] >= 0) row[x] = static_cast<std::uint8_t>(std::lround(255 * weigh(seen.depth[at])));
    }
  }
  cv::GaussianBlur(hidden, hidden, {}, soft * light.width_px);
  return hidden;
}

// What a light sees of the floor, as the view does.
cv::Mat OnFloor(const cv::Mat& hidden, const SceneView& light, const SceneView& view) {
  // A pixel's ray d meets the floor at e + d (floor - e_z) / d_z; times d_z, that is linear in d, so pixels
  // go to the light's picture by a homography.
  const Eigen::Matrix3d turn = view.camera_from_lab.linear();
  const Eigen::Vector3d eye = view.camera_from_lab.inverse().translation();
  const auto inner = [](const SceneView& v) {
    Eigen::Matrix3d k;
    k << v.focal_px, 0, v.center_x_px, 0, v.focal_px, v.center_y_px, 0, 0, 1;
    return k;
  };
  Eigen::Matrix3d on_floor = Eigen::Matrix3d::Identity() * (view.floor_z - eye.z());
  on_floor.col(2) += eye;
  const Eigen::RowVector3d down = Eigen::RowVector3d::UnitZ();
  const Eigen::Matrix3d to_light =
      inner(light) *
      (light.camera_from_lab.linear() * on_floor + light.camera_from_lab.translation() * down) *
      turn.transpose() * inner(view).inverse();
  const Eigen::Matrix3d scaled = to_light / to_light.norm();
  const cv::Matx33d map(scaled(0, 0), scaled(0, 1), scaled(0, 2), scaled(1, 0), scaled(1, 1), scaled(1, 2),
                        scaled(2, 0), scaled(2, 1), scaled(2, 2));
  cv::Mat seen;
  cv::warpPerspective(hidden, seen, map, {view.width_px, view.height_px},
                      cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
  return seen;
}

}  // namespace

double RoundLength(double length) {
  const double power = std::pow(10.0, std::floor(std::log10(length)));
  const double head = length / power;
  return (head >= 5 ? 5 : head >= 2 ? 2 : 1) * power;
}

Backdrop PaintBackdrop(const SceneView& view) {
  const Eigen::Vector3d wall_high(0.885, 0.900, 0.920), wall_low(0.965, 0.968, 0.972);  // blue last below
  const bool table = view.floor_is_table;
  const Eigen::Vector3d ground =
      table ? Eigen::Vector3d(0.882, 0.858, 0.815) : Eigen::Vector3d(0.905, 0.905, 0.900);
  const Eigen::Vector3d line =
      table ? Eigen::Vector3d(0.745, 0.710, 0.655) : Eigen::Vector3d(0.770, 0.780, 0.795);
  const Eigen::Vector3d eye = view.camera_from_lab.inverse().translation();
  Backdrop backdrop{.color = cv::Mat(view.height_px, view.width_px, CV_8UC3),
                    .floor = cv::Mat(view.height_px, view.width_px, CV_8UC1, cv::Scalar(0)),
                    .grid_step = RoundLength(0.42 * view.reach)};
  for (int y = 0; y < view.height_px; ++y) {
    auto* color = backdrop.color.ptr<cv::Vec3b>(y);
    auto* floor = backdrop.floor.ptr<std::uint8_t>(y);
    const double down = (y + 0.5) / view.height_px;
    for (int x = 0; x < view.width_px; ++x) {
      const double aside = 2.0 * (x + 0.5) / view.width_px - 1;
      const double bright = Smooth(0, 1, down) - 0.25 * aside * aside;
      Eigen::Vector3d here = wall_high + bright * (wall_low - wall_high);
      const Eigen::Vector3d ray = RayOf(view, x, y);
      const double t = (view.floor_z - eye.z()) / ray.z();
      if (ray.z() < 0 && t > 0) {
        const Eigen::Vector3d at = eye + t * ray - view.middle;
        const double seen = 1 - Smooth(1.0, 2.6, at.head<2>().norm() / view.reach);
        if (seen > 0) {
          here += seen * (ground - here);
          double on_line = 0;
          const Eigen::Vector3d next_x = RayOf(view, x + 1, y), next_y = RayOf(view, x, y + 1);
          for (int k = 0; k < 2; ++k) {
            // How much of the floor, across this family of lines, one pixel covers.
            const double wide = std::abs(next_x[k] - ray[k] * next_x.z() / ray.z()) * t +
                                std::abs(next_y[k] - ray[k] * next_y.z() / ray.z()) * t;
            const double from = at[k] + view.middle[k];
            const double off = std::abs(from - backdrop.grid_step * std::round(from / backdrop.grid_step));
            const double dense = std::clamp(0.3 - wide / backdrop.grid_step, 0.0, 0.2) / 0.2;
            on_line = std::max(on_line, dense * std::clamp(1.3 - off / std::max(wide, 1e-300), 0.0, 1.0));
          }
          here += 0.8 * seen * on_line * (line - here);
          floor[x] = static_cast<std::uint8_t>(std::lround(255 * seen));
        }
      }
      for (int k = 0; k < 3; ++k) {
        const double level = std::clamp(255 * here[2 - k] + Dither(x, y), 0.0, 255.0);
        color[x][k] = static_cast<std::uint8_t>(level);
      }
    }
  }
  return backdrop;
}

cv::Mat WithShadow(const Backdrop& backdrop, const SceneView& view, const SceneLights& lights,
                   const SceneRaster& seen_by_key, const SceneRaster& seen_from_below) {
  const cv::Mat shadow = OnFloor(HiddenFrom(lights.from_key, seen_by_key, kSoft, [](float) { return 1.0F; }),
                                 lights.from_key, view);
  // What touches a table keeps the sky's light from around its foot.
  cv::Mat foot(shadow.size(), CV_8UC1, cv::Scalar(0));
  if (view.floor_is_table) {
    const auto range = static_cast<float>(kFootRange * view.reach);
    const auto ground = static_cast<float>(DepthOf(lights.from_below, {0, 0, view.floor_z}));
    foot = OnFloor(HiddenFrom(lights.from_below, seen_from_below, kFootSoft,
                              [&](float depth) {
                                const float clear = std::clamp(1 - (depth - ground) / range, 0.0F, 1.0F);
                                return clear * clear;
                              }),
                   lights.from_below, view);
  }

  cv::Mat picture = backdrop.color.clone();
  constexpr int kDark = 72, kFootDark = 130;  // of 256, under a full shadow
  for (int y = 0; y < picture.rows; ++y) {
    const auto* from_key = shadow.ptr<std::uint8_t>(y);
    const auto* from_foot = foot.ptr<std::uint8_t>(y);
    const auto* floor = backdrop.floor.ptr<std::uint8_t>(y);
    auto* color = picture.ptr<cv::Vec3b>(y);
    for (int x = 0; x < picture.cols; ++x) {
      const int dark = (kDark * from_key[x] + kFootDark * from_foot[x]) * floor[x] / (255 * 255);
      if (dark == 0) continue;
      for (int k = 0; k < 3; ++k) {
        color[x][k] = static_cast<std::uint8_t>(color[x][k] * (256 - dark) / 256);
      }
    }
  }
  return picture;
}

}  // namespace tendril
