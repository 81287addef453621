#include "analysis/study/scene_light.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tendril {
namespace {

constexpr int kShadowMap = 640;    // px across
constexpr double kLightAway = 40;  // of the scene's reach
constexpr int kLevels = 4096;      // of linear light, for encoding

double Encode(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

double Decode(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

// x^n for the highlight's width, n = 32.
float Highlight(float x) {
  x = std::max(0.0F, x);
  for (int k = 0; k < 5; ++k) x *= x;
  return x;
}

// What is seen of the whole scene from a place far away.
SceneView FromFar(const SceneView& view, int size_px, const Eigen::Vector3d& eye,
                  const Eigen::Vector3d& across, const Eigen::Vector3d& forward) {
  Eigen::Matrix3d axes;
  axes << across, forward.cross(across), forward;
  SceneView from = view;
  from.width_px = from.height_px = size_px;
  from.center_x_px = from.center_y_px = 0.5 * (size_px - 1);
  from.focal_px = 0.49 * size_px * kLightAway;
  from.camera_from_lab.linear() = axes.transpose();
  from.camera_from_lab.translation() = -(axes.transpose() * eye);
  return from;
}

}  // namespace

float LinearOf(unsigned char encoded) {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> t{};
    for (std::size_t i = 0; i < t.size(); ++i)
      t[i] = static_cast<float>(Decode(static_cast<double>(i) / 255));
    return t;
  }();
  return table[encoded];
}

unsigned char EncodedOf(float linear) {
  static const std::array<unsigned char, kLevels + 1> table = [] {
    std::array<unsigned char, kLevels + 1> t{};
    for (std::size_t i = 0; i < t.size(); ++i) {
      t[i] = static_cast<unsigned char>(std::lround(255 * Encode(static_cast<double>(i) / kLevels)));
    }
    return t;
  }();
  const float level = std::clamp(linear, 0.0F, 1.0F) * kLevels + 0.5F;
  return table[static_cast<std::size_t>(level)];
}

SceneLights LightsOf(const SceneView& view) {
  const Eigen::Matrix3d lab_from_camera = view.camera_from_lab.linear().transpose();
  const Eigen::Vector3d right = lab_from_camera.col(0);
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  // Toward the camera, level; right is level in any view that keeps z up.
  const Eigen::Vector3d front = right.cross(up);
  SceneLights lights;
  lights.toward_key = (0.55 * front - 0.60 * right + 1.15 * up).normalized();
  lights.toward_fill = (0.75 * front + 0.90 * right + 0.25 * up).normalized();
  lights.eye = view.camera_from_lab.inverse().translation();

  const Eigen::Vector3d forward = -lights.toward_key;
  lights.from_key = FromFar(view, kShadowMap, view.middle - kLightAway * view.reach * forward,
                            forward.cross(up).normalized(), forward);
  Eigen::Vector3d below = view.middle;
  below.z() = view.floor_z - kLightAway * view.reach;
  lights.from_below = FromFar(view, kShadowMap, below, Eigen::Vector3d::UnitX(), up);
  return lights;
}
float KeyShare(const SceneLights& lights, const SceneRaster& seen_by_key, const Eigen::Vector3d& point,
               const Eigen::Vector3d& normal) {
  const SceneView& from = lights.from_key;
  const double pixel = kLightAway * from.reach / from.focal_px;  // m
  // Off the surface by as much as the filter reaches, or a surface would shade itself.
  const Eigen::Vector3d p = from.camera_from_lab * (point + 2.0 * pixel * normal);
  const double x = from.focal_px * p.x() / p.z() + from.center_x_px;
  const double y = from.focal_px * p.y() / p.z() + from.center_y_px;
  const auto depth = static_cast<float>(p.z() - pixel);
  constexpr int kWide = 4;  // pixels each way that count in full, and one more in part
  const int left = static_cast<int>(std::floor(x)) - kWide / 2;
  const int top = static_cast<int>(std::floor(y)) - kWide / 2;
  const auto part_x = static_cast<float>(x - std::floor(x));
  const auto part_y = static_cast<float>(y - std::floor(y));
  const bool whole = seen_by_key.Holds(left, top) && seen_by_key.Holds(left + kWide, top + kWide);
  float lit = 0;
  for (int j = 0; j <= kWide; ++j) {
    float row = 0;
    const float* const depths = whole ? &seen_by_key.depth[seen_by_key.At(left, top + j)] : nullptr;
    const auto open = [&](int i) -> float {
      if (whole) return depths[i] < depth ? 0 : 1;
      const bool held = seen_by_key.Holds(left + i, top + j);
      return held && seen_by_key.depth[seen_by_key.At(left + i, top + j)] < depth ? 0 : 1;
    };
    for (int i = 1; i < kWide; ++i) row += open(i);
    row += (1 - part_x) * open(0) + part_x * open(kWide);
    lit += (j == 0 ? 1 - part_y : j == kWide ? part_y : 1) * row;
  }
  return lit / (kWide * kWide);
}

Eigen::Array3f Shade(const SceneLights& lights, const Eigen::Array3f& color, const Eigen::Vector3d& point,
                     const Eigen::Vector3d& normal, float key_share, float open) {
  static const Eigen::Array3f kKey(1.00F, 0.97F, 0.92F);
  static const Eigen::Array3f kFill(0.86F, 0.92F, 1.00F);
  static const Eigen::Array3f kSky(0.92F, 0.96F, 1.00F);
  static const Eigen::Array3f kFloor(0.80F, 0.78F, 0.76F);
  const Eigen::Vector3d to_eye = (lights.eye - point).normalized();
  const auto key = static_cast<float>(std::max(0.0, normal.dot(lights.toward_key)));
  const auto fill = static_cast<float>(std::max(0.0, normal.dot(lights.toward_fill)));
  const auto upward = static_cast<float>(0.5 + 0.5 * normal.z());
  const auto grazing = static_cast<float>(1 - std::clamp(normal.dot(to_eye), 0.0, 1.0));
  const auto mirror = static_cast<float>(normal.dot((lights.toward_key + to_eye).normalized()));
  const Eigen::Array3f around = (kFloor + upward * (kSky - kFloor)) * open;
  const Eigen::Array3f diffuse =
      0.42F * around + 0.78F * key * key_share * kKey + 0.16F * fill * open * kFill;
  const float shine = 0.22F * Highlight(mirror) * key_share + 0.10F * grazing * grazing * grazing * open;
  return color * diffuse + shine;
}

}  // namespace tendril
