#include "analysis/study/scene_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>
#include <utility>

#include "analysis/study/scene_backdrop.h"
#include "analysis/study/scene_labels.h"
#include "analysis/study/scene_light.h"
#include "analysis/study/scene_openness.h"
#include "analysis/study/scene_pieces.h"
#include "analysis/study/scene_raster.h"
#include "model/check.h"

namespace tendril {
namespace {

constexpr int kRays = 2;            // each way per pixel
constexpr double kThinnest = 0.75;  // half a width, px

// Red, green, blue. Okabe and Ito's colours, told apart with any kind of colour vision; their black, which
// shows no shading, is replaced by Tol's wine.
constexpr unsigned char kTubeColors[][3] = {{0, 114, 178},  {230, 159, 0},   {0, 158, 115},  {213, 94, 0},
                                            {86, 180, 233}, {204, 121, 167}, {240, 228, 66}, {136, 34, 85}};
// Objects in muted ones, told from the tubes'.
constexpr unsigned char kObjectColors[][3] = {
    {162, 164, 172}, {142, 164, 152}, {178, 152, 166}, {186, 170, 144}};
constexpr unsigned char kWireColor[3] = {70, 74, 84}, kPaleWireColor[3] = {176, 180, 188};

// Names by their text, with numbers in them by their value: rod2 before rod10.
bool NameBefore(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  while (i < a.size() && j < b.size()) {
    if (digit(a[i]) && digit(b[j])) {
      const auto number = [&digit](const std::string& s, std::size_t& at) {
        while (at < s.size() && s[at] == '0') ++at;
        const std::size_t from = at;
        while (at < s.size() && digit(s[at])) ++at;
        return std::string_view(s).substr(from, at - from);
      };
      const std::string_view x = number(a, i), y = number(b, j);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  if (i < a.size() || j < b.size()) return j < b.size();
  return a < b;  // rod01 before rod1
}

std::vector<std::size_t> TubesByName(const ScenePicture& picture) {
  std::vector<std::size_t> order(picture.tubes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return NameBefore(picture.tubes[a].name, picture.tubes[b].name);
  });
  return order;
}

bool OnlyFloor(const ShownObject& object) {
  return std::all_of(object.shape.begin(), object.shape.end(),
                     [&](const Primitive& part) { return IsFloor(part, object.pose); });
}

// All but the floor, by name, and of one name by where they are and what they begin with.
std::vector<const ShownObject*> ObjectsInOrder(const ScenePicture& picture) {
  std::vector<const ShownObject*> objects;
  for (const ShownObject& object : picture.objects) {
    if (object.pose.matrix().allFinite() && !OnlyFloor(object)) objects.push_back(&object);
  }
  const auto key = [](const ShownObject& object) {
    const Primitive& first = object.shape.front();
    const Eigen::Vector3d at = object.pose.translation(), half = first.half;
    return std::array{at.x(),   at.y(),   at.z(),       half.x(),
                      half.y(), half.z(), first.radius, static_cast<double>(first.kind)};
  };
  std::sort(objects.begin(), objects.end(), [&](const ShownObject* a, const ShownObject* b) {
    if (NameBefore(a->name, b->name)) return true;
    return !NameBefore(b->name, a->name) && key(*a) < key(*b);
  });
  return objects;
}

bool IsFlat(const ScenePiece& piece) {
  return piece.kind == ScenePiece::Kind::kDisc || piece.kind == ScenePiece::Kind::kFace;
}

const unsigned char* ColorOfTube(std::size_t rank) { return kTubeColors[rank % std::size(kTubeColors)]; }

Eigen::Array3f Linear(const unsigned char* rgb) {
  return {LinearOf(rgb[0]), LinearOf(rgb[1]), LinearOf(rgb[2])};
}

// What a picture's tubes, objects and wires are as pieces, and what the legend says of them.
struct PaintedScene {
  std::vector<ScenePiece> pieces;
  std::vector<Eigen::Array3f> colors;  // of bodies
  double thickness = 0;                // of the thickest tube, or else object: half of it, m
  std::vector<std::string> names;
  std::vector<cv::Scalar> name_colors;

  // The number of the next body.
  int Body() const { return static_cast<int>(colors.size()); }
  void Name(const std::string& name, const unsigned char* rgb) {
    if (name.empty()) return;
    names.push_back(name);
    name_colors.emplace_back(rgb[2], rgb[1], rgb[0]);
  }
  void Measure() {
    for (const ScenePiece& piece : pieces) thickness = std::max(thickness, piece.radius_a);
  }
};

PaintedScene PaintedOf(const ScenePicture& picture, const SceneView& view) {
  PaintedScene scene;
  for (const std::size_t index : TubesByName(picture)) {
    const unsigned char* rgb = ColorOfTube(scene.colors.size());
    AddTube(picture.tubes[index], scene.Body(), view, kThinnest, scene.pieces);
    scene.Name(picture.tubes[index].name, rgb);
    scene.colors.push_back(Linear(rgb));
  }
  scene.Measure();
  const std::vector<const ShownObject*> objects = ObjectsInOrder(picture);
  // One object needs no name. Where there is no room for all names, the objects' are told.
  constexpr std::size_t kMostNames = 12;
  const std::size_t more = objects.size() > 1 ? objects.size() : 0;
  if (scene.names.size() < 2 || (more > 0 && scene.names.size() + more > kMostNames)) {
    scene.names.clear();
    scene.name_colors.clear();
  }
  for (std::size_t rank = 0; rank < objects.size(); ++rank) {
    const unsigned char* rgb = kObjectColors[rank % std::size(kObjectColors)];
    AddObject(*objects[rank], scene.Body(), view, kThinnest, scene.pieces);
    if (more > 0) scene.Name(objects[rank]->name, rgb);
    scene.colors.push_back(Linear(rgb));
  }
  if (!(scene.thickness > 0)) scene.Measure();
  for (const Wire& wire : picture.wires) {
    AddWire(wire, scene.Body(), view, kThinnest, scene.pieces);
    scene.colors.push_back(Linear(wire.pale ? kPaleWireColor : kWireColor));
  }
  return scene;
}

}  // namespace

struct ScenePainter::State {
  SceneView view;
  SceneView fine;
  SceneLights lights;
  Backdrop backdrop;
  SceneRaster seen, seen_by_key, seen_from_below;
  ScenePixels pixels;

  Eigen::Array3f Light(const Eigen::Array3f& color, const Eigen::Vector3d& point,
                       const Eigen::Vector3d& normal, float open) const {
    if (view.floor_is_table) open *= OpenAbove(point, normal);
    return Shade(lights, color, point, normal, KeyShare(lights, seen_by_key, point, normal), open);
  }

  // A table is not among what darkens what is close to it.
  float OpenAbove(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const {
    const double height = std::max(0.0, point.z() - view.floor_z);
    return static_cast<float>(1 - 0.35 * (1 - normal.z()) * std::exp(-height / (0.04 * view.reach)));
  }

  Eigen::Vector3d InLab(const Eigen::Vector3d& in_camera) const {
    return view.camera_from_lab.linear().transpose() * (in_camera - view.camera_from_lab.translation());
  }

  Eigen::Array3f LightOfRay(const std::vector<ScenePiece>& pieces, const std::vector<Eigen::Array3f>& colors,
                            int ray_x, int ray_y, float open) const {
    const std::size_t hit = seen.At(ray_x, ray_y);
    const double depth = seen.depth[hit];
    const Eigen::Vector3d point = InLab({(ray_x - fine.center_x_px) / fine.focal_px * depth,
                                         (ray_y - fine.center_y_px) / fine.focal_px * depth, depth});
    const ScenePiece& piece = pieces[static_cast<std::size_t>(seen.piece[hit])];
    return Light(colors[static_cast<std::size_t>(piece.body)], point, NormalAt(piece, point), open);
  }

  // The body that all rays of a pixel meet, at nearly one depth; -1: there is none.
  // A pixel on an edge has no single normal.
  int BodyOfPixel(const std::vector<ScenePiece>& pieces, int x, int y) const {
    const int ray_x = x * kRays, ray_y = y * kRays;
    if (!seen.Holds(ray_x, ray_y) || !seen.Holds(ray_x + kRays - 1, ray_y + kRays - 1)) return -1;
    int body = -1, first = -1;
    float least = std::numeric_limits<float>::infinity(), most = 0;
    for (int ray = 0; ray < kRays * kRays; ++ray) {
      const std::size_t hit = seen.At(ray_x + ray % kRays, ray_y + ray / kRays);
      if (seen.piece[hit] < 0) return -1;
      const ScenePiece& piece = pieces[static_cast<std::size_t>(seen.piece[hit])];
      if (ray > 0 && piece.body != body) return -1;
      if (ray > 0 && seen.piece[hit] != first &&
          (IsFlat(piece) || IsFlat(pieces[static_cast<std::size_t>(first)])))
        return -1;
      body = piece.body;
      first = seen.piece[hit];
      least = std::min(least, seen.depth[hit]);
      most = std::max(most, seen.depth[hit]);
    }
    constexpr double kSteepest = 3;  // pixels of depth per pixel
    return most - least < kSteepest * least / view.focal_px ? body : -1;
  }

  void PaintBodies(const std::vector<ScenePiece>& pieces, const std::vector<Eigen::Array3f>& colors,
                   cv::Mat& picture) const {
    for (int y = 0; y < pixels.height; ++y) {
      auto* row = picture.ptr<cv::Vec3b>(y + pixels.top);
      for (int x = 0; x < pixels.width; ++x) {
        const std::size_t here = pixels.At(x, y);
        if (!std::isfinite(pixels.depth[here])) continue;
        const float open = pixels.open[here];
        cv::Vec3b& pixel = row[x + pixels.left];
        Eigen::Array3f mean = Eigen::Array3f::Zero();
        // Within a surface one ray speaks for the pixel.
        if (const int body = BodyOfPixel(pieces, x + pixels.left, y + pixels.top); body >= 0) {
          const Eigen::Vector3d normal =
              view.camera_from_lab.linear().transpose() * pixels.normals[here].cast<double>();
          mean = Light(colors[static_cast<std::size_t>(body)], InLab(pixels.points[here].cast<double>()),
                       normal, open);
        } else {
          int hits = 0;
          for (int ray = 0; ray < kRays * kRays; ++ray) {
            const int ray_x = (x + pixels.left) * kRays + ray % kRays;
            const int ray_y = (y + pixels.top) * kRays + ray / kRays;
            if (!seen.Holds(ray_x, ray_y) || seen.piece[seen.At(ray_x, ray_y)] < 0) continue;
            mean += LightOfRay(pieces, colors, ray_x, ray_y, open);
            ++hits;
          }
          const auto empty = static_cast<float>(kRays * kRays - hits);
          mean += empty * Eigen::Array3f(LinearOf(pixel[2]), LinearOf(pixel[1]), LinearOf(pixel[0]));
          mean /= kRays * kRays;
        }
        for (int k = 0; k < 3; ++k) pixel[2 - k] = EncodedOf(mean[k]);
      }
    }
  }
};

ScenePainter::ScenePainter(const SceneView& view)
    : state_(new State{.view = view,
                       .fine = Magnified(view, kRays),
                       .lights = LightsOf(view),
                       .backdrop = PaintBackdrop(view),
                       .seen = {},
                       .seen_by_key = {},
                       .seen_from_below = {},
                       .pixels = {}}) {}
ScenePainter::~ScenePainter() = default;
ScenePainter::ScenePainter(ScenePainter&&) noexcept = default;
ScenePainter& ScenePainter::operator=(ScenePainter&&) noexcept = default;

void ScenePainter::LookFrom(const SceneView& view) {
  State& s = *state_;
  if (view.camera_from_lab.matrix() == s.view.camera_from_lab.matrix() && view.subject == s.view.subject)
    return;
  s.view = view;
  s.fine = Magnified(view, kRays);
  s.lights = LightsOf(view);
  s.backdrop = PaintBackdrop(view);
}

cv::Mat ScenePainter::Draw(const ScenePicture& picture) {
  State& s = *state_;
  const PaintedScene scene = PaintedOf(picture, s.view);
  CastRays(scene.pieces, s.fine, s.seen);
  CastRays(scene.pieces, s.lights.from_key, s.seen_by_key);
  if (s.view.floor_is_table) CastRays(scene.pieces, s.lights.from_below, s.seen_from_below);
  cv::Mat drawn = WithShadow(s.backdrop, s.view, s.lights, s.seen_by_key, s.seen_from_below);
  MeasurePixels(scene.pieces, s.seen, kRays, s.view, std::min(2.5 * scene.thickness, 0.15 * s.view.reach),
                s.pixels);
  s.PaintBodies(scene.pieces, scene.colors, drawn);
  DrawLabels(LayOutLabels(picture, s.view, scene.names, scene.name_colors, s.backdrop.grid_step), drawn);
  return drawn;
}

cv::Mat DrawScene(const ScenePicture& picture, const SceneView& view) {
  return ScenePainter(view).Draw(picture);
}

}  // namespace tendril
