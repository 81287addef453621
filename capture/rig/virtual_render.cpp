#include "capture/rig/virtual_render.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "capture/rig/portable_random.h"
#include "capture/rig/virtual_tags.h"

namespace tendril {
namespace {

using Vector2 = Eigen::Vector2d;
using Vector3 = Eigen::Vector3d;

// Samples of a pixel: eight, no two in one row or column, so that an edge along the pixels' grid is placed to
// 1/8 px before the blur.
constexpr int kSamples = 8;
constexpr std::array<std::array<double, 2>, kSamples> kSampleAt = {{{1 / 16.0, -3 / 16.0},
                                                                    {-1 / 16.0, 3 / 16.0},
                                                                    {5 / 16.0, 1 / 16.0},
                                                                    {-3 / 16.0, -5 / 16.0},
                                                                    {-5 / 16.0, 5 / 16.0},
                                                                    {-7 / 16.0, -1 / 16.0},
                                                                    {3 / 16.0, 7 / 16.0},
                                                                    {7 / 16.0, -7 / 16.0}}};
constexpr int kCell = 4;       // pixels between rays that are computed; between them they are interpolated
constexpr int kBandRows = 32;  // rows whose samples are held at once
constexpr int kNoiseTile = 1 << 17;

// Normalised coordinates of a pixel and how they change from one to the next, within a cell of the grid.
struct Ray {
  Vector2 at;
  Vector2 per_column;
  Vector2 per_row;
};

struct RayGrid {
  int columns = 0;  // nodes along a row of the grid
  std::vector<Vector2> nodes;

  Ray At(int column, int row) const {
    const int i = column / kCell;
    const int j = row / kCell;
    const double s = static_cast<double>(column - i * kCell) / kCell;
    const double t = static_cast<double>(row - j * kCell) / kCell;
    const Vector2* top =
        &nodes[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i)];
    const Vector2* bottom = top + columns;
    const Vector2 across_top = top[1] - top[0];
    const Vector2 across_bottom = bottom[1] - bottom[0];
    const Vector2 left = top[0] + s * across_top;
    const Vector2 right = bottom[0] + s * across_bottom;
    return {left + t * (right - left), ((1 - t) * across_top + t * across_bottom) / kCell,
            (right - left) / kCell};
  }
};

// A value that is linear in the normalised coordinates: c . (x, y, 1).
struct Linear {
  double x = 0;
  double y = 0;
  double one = 0;
  double At(const Vector2& p) const { return x * p.x() + y * p.y() + one; }
  double Along(const Vector2& p) const { return x * p.x() + y * p.y(); }
};

// A strip as one camera sees it. Its sheet coordinates at a ray are (y / w, z / w), its depth is 1 / w.
struct Patch {
  int left = 0, right = 0, top = 0, bottom = 0;  // pixels, inclusive
  Linear y, z, w;
  std::array<Linear, 8> edges;  // all >= 0 inside
  int edge_count = 0;
  const VirtualTag* tag = nullptr;
  std::uint8_t paper = 0;
  std::uint8_t ink = 0;
  Vector2 hole = Vector2::Zero();  // (y, z)
};

// The object in the camera's frame.
struct Barrel {
  int left = 0, right = 0, top = 0, bottom = 0;
  Vector3 center, axis;
  double radius = 0, half_length = 0;
};

// Samples of a few rows: inverse depth (0: nothing yet) and brightness.
struct Band {
  int width = 0, first_row = 0, rows = 0;
  int touched_left = 0, touched_right = -1;
  std::vector<float> inverse_depth;
  std::vector<std::uint8_t> value;

  std::size_t At(int column, int row) const {
    return (static_cast<std::size_t>(row - first_row) * static_cast<std::size_t>(width) +
            static_cast<std::size_t>(column)) *
           kSamples;
  }
  void Touch(int left, int right) {
    touched_left = std::min(touched_left, left);
    touched_right = std::max(touched_right, right);
  }
};

std::uint8_t Gray(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

// Bounding box of points of the camera's frame, with a pixel to spare; empty if any is not in front.
bool BoundingBox(const Camera& camera, const std::vector<Vector3>& points, int& left, int& right, int& top,
                 int& bottom) {
  double low_x = INFINITY, high_x = -INFINITY, low_y = INFINITY, high_y = -INFINITY;
  for (const Vector3& p : points) {
    if (!(p.z() > 1e-3)) return false;
    const Vector2 pixel = ProjectInCamera<double>(camera, p);
    low_x = std::min(low_x, pixel.x());
    high_x = std::max(high_x, pixel.x());
    low_y = std::min(low_y, pixel.y());
    high_y = std::max(high_y, pixel.y());
  }
  const double far = 1e6;  // keeps the conversion to int defined
  left = std::max(0, static_cast<int>(std::floor(std::clamp(low_x, -far, far))) - 1);
  right = std::min(camera.width_px - 1, static_cast<int>(std::ceil(std::clamp(high_x, -far, far))) + 1);
  top = std::max(0, static_cast<int>(std::floor(std::clamp(low_y, -far, far))) - 1);
  bottom = std::min(camera.height_px - 1, static_cast<int>(std::ceil(std::clamp(high_y, -far, far))) + 1);
  return left <= right && top <= bottom;
}

void DrawPatch(const RayGrid& rays, const Patch& patch, double hole_radius, Band& band) {
  const double hole_radius2 = hole_radius * hole_radius;
  const int from = std::max(patch.top, band.first_row);
  const int to = std::min(patch.bottom, band.first_row + band.rows - 1);
  if (from > to) return;
  band.Touch(patch.left, patch.right);
  for (int row = from; row <= to; ++row) {
    for (int column = patch.left; column <= patch.right; ++column) {
      const Ray ray = rays.At(column, row);
      bool outside = false;
      for (int e = 0; e < patch.edge_count && !outside; ++e) {
        const Linear& edge = patch.edges[static_cast<std::size_t>(e)];
        const double reach = 0.5 * (std::abs(edge.Along(ray.per_column)) + std::abs(edge.Along(ray.per_row)));
        outside = edge.At(ray.at) < -reach;
      }
      if (outside) continue;
      const std::size_t first = band.At(column, row);
      for (std::size_t s = 0; s < kSamples; ++s) {
        const Vector2 p = ray.at + kSampleAt[s][0] * ray.per_column + kSampleAt[s][1] * ray.per_row;
        bool inside = true;
        for (int e = 0; e < patch.edge_count && inside; ++e) {
          inside = patch.edges[static_cast<std::size_t>(e)].At(p) >= 0;
        }
        if (!inside) continue;
        const double w = patch.w.At(p);
        if (!(static_cast<float>(w) > band.inverse_depth[first + s])) continue;
        const Vector2 sheet(patch.y.At(p) / w, patch.z.At(p) / w);
        if ((sheet - patch.hole).squaredNorm() < hole_radius2) continue;
        std::uint8_t value = patch.paper;
        if (patch.tag != nullptr) {
          const Eigen::Matrix<double, 2, 3>& m = patch.tag->modules_from_sheet;
          const double u = m(0, 0) * sheet.x() + m(0, 1) * sheet.y() + m(0, 2);
          const double v = m(1, 0) * sheet.x() + m(1, 1) * sheet.y() + m(1, 2);
          const int n = patch.tag->modules;
          if (u >= 0 && v >= 0 && u < n && v < n &&
              patch.tag->white[static_cast<std::size_t>(v) * static_cast<std::size_t>(n) +
                               static_cast<std::size_t>(u)] == 0) {
            value = patch.ink;
          }
        }
        band.inverse_depth[first + s] = static_cast<float>(w);
        band.value[first + s] = value;
      }
    }
  }
}

// Nearest hit of a ray from the camera's centre along d (z = 1): depth and normal, or depth 0.
std::pair<double, Vector3> HitBarrel(const Barrel& b, const Vector3& d) {
  double nearest = INFINITY;
  Vector3 normal = Vector3::Zero();
  const Vector3 across = d - d.dot(b.axis) * b.axis;
  const Vector3 to = b.center - b.center.dot(b.axis) * b.axis;
  const double a = across.squaredNorm();
  const double half = across.dot(to);
  const double discriminant = half * half - a * (to.squaredNorm() - b.radius * b.radius);
  if (discriminant < 0) return {0, normal};
  if (a > 0) {
    const double t = (half - std::sqrt(discriminant)) / a;
    const Vector3 hit = t * d - b.center;
    const double along = hit.dot(b.axis);
    if (t > 0 && std::abs(along) <= b.half_length) {
      nearest = t;
      normal = (hit - along * b.axis) / b.radius;
    }
  }
  const double slope = d.dot(b.axis);
  for (const double sign : {-1.0, 1.0}) {
    if (slope * sign >= 0) continue;  // this end faces away
    const double t = (b.center.dot(b.axis) + sign * b.half_length) / slope;
    const Vector3 hit = t * d - b.center - sign * b.half_length * b.axis;
    if (t > 0 && t < nearest && hit.squaredNorm() <= b.radius * b.radius) {
      nearest = t;
      normal = sign * b.axis;
    }
  }
  return {std::isfinite(nearest) ? nearest : 0, normal};
}

double Shade(const VirtualOptics& optics, const Vector3& normal_in_camera) {
  // One lamp above the camera's shoulder.
  const Vector3 lamp = Vector3(0.3, -0.5, -0.8).normalized();
  return optics.ambient + (1 - optics.ambient) * std::max(0.0, normal_in_camera.dot(lamp));
}

void DrawBarrel(const RayGrid& rays, const Barrel& barrel, const VirtualOptics& optics, Band& band) {
  const int from = std::max(barrel.top, band.first_row);
  const int to = std::min(barrel.bottom, band.first_row + band.rows - 1);
  if (from > to) return;
  band.Touch(barrel.left, barrel.right);
  for (int row = from; row <= to; ++row) {
    for (int column = barrel.left; column <= barrel.right; ++column) {
      const Ray ray = rays.At(column, row);
      const std::size_t first = band.At(column, row);
      for (std::size_t s = 0; s < kSamples; ++s) {
        const Vector2 p = ray.at + kSampleAt[s][0] * ray.per_column + kSampleAt[s][1] * ray.per_row;
        const auto [depth, normal] = HitBarrel(barrel, Vector3(p.x(), p.y(), 1));
        if (depth <= 0) continue;
        const auto w = static_cast<float>(1 / depth);
        if (!(w > band.inverse_depth[first + s])) continue;
        band.inverse_depth[first + s] = w;
        band.value[first + s] = Gray(optics.object * Shade(optics, normal));
      }
    }
  }
}

Status CheckOptics(const VirtualOptics& o) {
  const auto in = [](double v, double low, double high) { return v >= low && v <= high; };
  const std::pair<const char*, bool> all[] = {{"blur_px (0 .. 20 px)", in(o.blur_px, 0, 20)},
                                              {"read_noise (0 .. 50 gray levels)", in(o.read_noise, 0, 50)},
                                              {"shot_noise (0 .. 10 gray levels)", in(o.shot_noise, 0, 10)},
                                              {"background (0 .. 255)", in(o.background, 0, 255)},
                                              {"paper (0 .. 255)", in(o.paper, 0, 255)},
                                              {"ink (0 .. 255)", in(o.ink, 0, 255)},
                                              {"object (0 .. 255)", in(o.object, 0, 255)},
                                              {"ambient (0 .. 1)", in(o.ambient, 0, 1)}};
  for (const auto& [what, good] : all) {
    if (!good)
      return Error{ErrorKind::kBadInput, fmt::format("virtual optics: {} is out of its range", what)};
  }
  return Ok{};
}

}  // namespace

struct VirtualCamera::Prepared {
  Camera camera;
  VirtualOptics optics;
  VirtualTags tags;
  double hole_radius = 0;
  RayGrid rays;
  std::vector<std::int16_t> noise;          // normal values, in 1/1024 of a deviation
  std::array<std::int32_t, 256> deviation;  // of a brightness, in 1/1024 gray level

  std::vector<Patch> PatchesOf(const TrueShape& shape) const;
  void AddNoise(cv::Mat& image, std::mt19937_64& random) const;
};

std::vector<Patch> VirtualCamera::Prepared::PatchesOf(const TrueShape& shape) const {
  std::vector<Patch> patches;
  for (std::size_t t = 0; t < shape.tentacles.size(); ++t) {
    const TrueTentacle& tentacle = shape.tentacles[t];
    for (const TrueStrip& strip : tentacle.strips) {
      const Eigen::Index corners = strip.corners_in_sheet.cols();
      if (corners < 3 || corners > 8) continue;
      const Eigen::Isometry3d pose = camera.camera_from_lab * strip.lab_from_sheet;
      Patch patch;
      std::vector<Vector3> points;
      for (Eigen::Index i = 0; i < corners; ++i)
        points.push_back(pose * Vector3(strip.corners_in_sheet.col(i)));
      if (!BoundingBox(camera, points, patch.left, patch.right, patch.top, patch.bottom)) continue;

      Eigen::Matrix3d plane;
      plane << pose.linear().col(1), pose.linear().col(2), pose.translation();
      const Vector3 normal = pose.linear().col(0);
      const double off = normal.dot(pose.translation());  // the camera's distance from the plane
      if (std::abs(off) < 1e-9) continue;                 // seen exactly edge-on
      const Eigen::Matrix3d inverse = plane.inverse();
      const auto linear = [](const Eigen::RowVector3d& r) { return Linear{r[0], r[1], r[2]}; };
      patch.y = linear(inverse.row(0));
      patch.z = linear(inverse.row(1));
      patch.w = linear(inverse.row(2));
      for (Eigen::Index i = 0; i < corners; ++i) {
        const Vector3 a = strip.corners_in_sheet.col(i);
        const Vector3 b = strip.corners_in_sheet.col((i + 1) % corners);
        const double ny = -(b.z() - a.z());  // inward normal of a counter-clockwise edge in (y, z)
        const double nz = b.y() - a.y();
        const Eigen::RowVector3d edge =
            ny * inverse.row(0) + nz * inverse.row(1) - (ny * a.y() + nz * a.z()) * inverse.row(2);
        patch.edges[static_cast<std::size_t>(patch.edge_count++)] = linear(edge);
      }
      const TagSide side = off < 0 ? TagSide::kOuter : TagSide::kInner;
      patch.tag = tags.Find(static_cast<int>(t), strip.facet, side);
      const double light = Shade(optics, off < 0 ? normal : Vector3(-normal));
      patch.paper = Gray(optics.paper * light);
      patch.ink = Gray(optics.ink * light);
      patch.hole = strip.hole_in_sheet;
      patches.push_back(patch);
    }
  }
  return patches;
}

// Brightness-dependent noise from a tile of normal values, each row from a place of its own.
void VirtualCamera::Prepared::AddNoise(cv::Mat& image, std::mt19937_64& random) const {
  const auto places = static_cast<std::uint64_t>(kNoiseTile - std::min(image.cols, kNoiseTile - 1));
  for (int row = 0; row < image.rows; ++row) {
    std::uint8_t* pixel = image.ptr<std::uint8_t>(row);
    for (int from = 0; from < image.cols; from += kNoiseTile - 1) {
      const std::int16_t* tile = noise.data() + random() % places;
      const int count = std::min(image.cols - from, kNoiseTile - 1);
      for (int i = 0; i < count; ++i) {
        const std::int32_t value = pixel[from + i];
        const std::int32_t added = deviation[static_cast<std::size_t>(value)] * tile[i];
        pixel[from + i] = static_cast<std::uint8_t>(std::clamp(value + ((added + (1 << 19)) >> 20), 0, 255));
      }
    }
  }
}

Result<VirtualCamera> VirtualCamera::Make(const Camera& camera, const TagLayout& tags, double hole_diameter,
                                          const VirtualOptics& optics) {
  if (Status s = CheckOptics(optics); !s.ok()) return s.error();
  if (camera.width_px < 1 || camera.height_px < 1 || camera.width_px > 32768 || camera.height_px > 32768) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("camera '{}': image of {} x {} px; expected 1 .. 32768 each", camera.name,
                             camera.width_px, camera.height_px)};
  }
  auto prepared = std::make_shared<Prepared>();
  prepared->camera = camera;
  prepared->optics = optics;
  prepared->hole_radius = 0.5 * hole_diameter;
  Result<VirtualTags> bitmaps = VirtualTags::Make(tags);
  if (!bitmaps.ok()) return bitmaps.error();
  prepared->tags = std::move(bitmaps).value();

  RayGrid& rays = prepared->rays;
  rays.columns = (camera.width_px - 1) / kCell + 2;
  const int grid_rows = (camera.height_px - 1) / kCell + 2;
  for (int j = 0; j < grid_rows; ++j) {
    for (int i = 0; i < rays.columns; ++i) {
      const std::optional<Vector3> ray = RayOfPixel(camera, Vector2(i * kCell, j * kCell));
      if (!ray || !(ray->z() > 0)) {
        return Error{ErrorKind::kBadInput,
                     fmt::format("camera '{}': the distortion has no inverse at pixel ({}, {}); expected "
                                 "coefficients that map every pixel",
                                 camera.name, i * kCell, j * kCell)};
      }
      rays.nodes.emplace_back(ray->x() / ray->z(), ray->y() / ray->z());
    }
  }

  std::mt19937_64 tile(20231);  // the tile is the same for all; which part is used is drawn per picture
  prepared->noise.resize(kNoiseTile);
  for (std::int16_t& n : prepared->noise) {
    n = static_cast<std::int16_t>(std::lround(std::clamp(1024 * DrawNormal(tile, 1), -8192.0, 8192.0)));
  }
  for (std::size_t v = 0; v < 256; ++v) {
    const double variance =
        optics.read_noise * optics.read_noise + optics.shot_noise * static_cast<double>(v);
    prepared->deviation[v] = static_cast<std::int32_t>(std::lround(1024 * std::sqrt(variance)));
  }
  return VirtualCamera(prepared);
}

const Camera& VirtualCamera::camera() const { return prepared_->camera; }

cv::Mat VirtualCamera::Render(const TrueShape& shape, std::mt19937_64& random) const {
  const Camera& camera = prepared_->camera;
  const VirtualOptics& optics = prepared_->optics;
  const std::vector<Patch> patches = prepared_->PatchesOf(shape);

  Barrel barrel;
  bool has_object = false;
  if (shape.object.radius > 0) {
    barrel.center = camera.camera_from_lab * shape.object.center;
    barrel.axis = camera.camera_from_lab.linear() * shape.object.axis.normalized();
    barrel.radius = shape.object.radius;
    barrel.half_length = 0.5 * shape.object.length;
    const Vector3 u = barrel.axis.unitOrthogonal() * barrel.radius;
    const Vector3 v = barrel.axis.cross(u);
    std::vector<Vector3> hull;  // an octagon around each end
    for (const double end : {-barrel.half_length, barrel.half_length}) {
      for (int i = 0; i < 8; ++i) {
        const double angle = i * std::numbers::pi / 4;
        hull.push_back(barrel.center + end * barrel.axis +
                       1.0824 * (std::cos(angle) * u + std::sin(angle) * v));
      }
    }
    has_object = BoundingBox(camera, hull, barrel.left, barrel.right, barrel.top, barrel.bottom);
  }

  const std::uint8_t background = Gray(optics.background);
  cv::Mat image(camera.height_px, camera.width_px, CV_8UC1, cv::Scalar(background));
  Band band;
  band.width = camera.width_px;
  const std::size_t samples = static_cast<std::size_t>(camera.width_px) * kBandRows * kSamples;
  band.inverse_depth.assign(samples, 0.0F);
  band.value.assign(samples, background);
  for (band.first_row = 0; band.first_row < camera.height_px; band.first_row += kBandRows) {
    band.rows = std::min(kBandRows, camera.height_px - band.first_row);
    band.touched_left = camera.width_px;
    band.touched_right = -1;
    for (const Patch& patch : patches) DrawPatch(prepared_->rays, patch, prepared_->hole_radius, band);
    if (has_object) DrawBarrel(prepared_->rays, barrel, optics, band);
    for (int row = band.first_row; row < band.first_row + band.rows; ++row) {
      std::uint8_t* out = image.ptr<std::uint8_t>(row);
      for (int column = band.touched_left; column <= band.touched_right; ++column) {
        const std::size_t first = band.At(column, row);
        int sum = kSamples / 2;
        for (std::size_t s = 0; s < kSamples; ++s) sum += band.value[first + s];
        out[column] = static_cast<std::uint8_t>(sum / kSamples);
      }
      if (band.touched_right < band.touched_left) continue;
      const std::size_t from = band.At(band.touched_left, row);
      const std::size_t count =
          static_cast<std::size_t>(band.touched_right - band.touched_left + 1) * kSamples;
      std::fill_n(band.inverse_depth.begin() + static_cast<std::ptrdiff_t>(from), count, 0.0F);
      std::fill_n(band.value.begin() + static_cast<std::ptrdiff_t>(from), count, background);
    }
  }

  if (optics.blur_px > 0) cv::GaussianBlur(image, image, cv::Size(), optics.blur_px, 0, cv::BORDER_REPLICATE);
  if (optics.read_noise > 0 || optics.shot_noise > 0) prepared_->AddNoise(image, random);
  return image;
}

}  // namespace tendril
