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
constexpr unsigned char kSolidColor[3] = {162, 164, 172};

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

std::vector<Solid> SolidsInOrder(const ScenePicture& picture) {
  std::vector<Solid> solids = picture.solids;
  const auto key = [](const Solid& s) {
    return std::array{s.start.x(), s.start.y(), s.start.z(), s.end.x(),
                      s.end.y(),   s.end.z(),   s.radius,    static_cast<double>(s.kind)};
  };
  std::erase_if(solids, [](const Solid& s) { return !s.start.allFinite() || !s.end.allFinite(); });
  std::sort(solids.begin(), solids.end(), [&](const Solid& a, const Solid& b) { return key(a) < key(b); });
  return solids;
}

const unsigned char* ColorOfTube(std::size_t rank) { return kTubeColors[rank % std::size(kTubeColors)]; }

Eigen::Array3f Linear(const unsigned char* rgb) {
  return {LinearOf(rgb[0]), LinearOf(rgb[1]), LinearOf(rgb[2])};
}

std::vector<SceneBall> BallsOf(const ScenePicture& picture) {
  std::vector<SceneBall> balls;
  const auto add = [&](const Eigen::Vector3d& at, double radius) {
    if (CanBeDrawn(at)) balls.push_back({at, std::isfinite(radius) ? std::max(0.0, radius) : 0.0});
  };
  for (const Tube& tube : picture.tubes) {
    for (Eigen::Index i = 0; i < tube.points.cols(); ++i) {
      add(tube.points.col(i), i < tube.radius.size() ? tube.radius[i] : 0.0);
    }
  }
  constexpr int kAlong = 24;  // a solid counts like some nodes of a tube
  for (const Solid& solid : picture.solids) {
    const Eigen::Vector3d axis = solid.kind == Solid::Kind::kSphere
                                     ? Eigen::Vector3d::Zero()
                                     : Eigen::Vector3d(solid.end - solid.start);
    for (int i = 0; i <= kAlong; ++i) add(solid.start + axis * i / kAlong, solid.radius);
  }
  return balls;
}

// How good a place to look from: over how much of the screen, in cells of a grid, the balls' middles are
// spread; less where some are so much nearer than others that perspective distorts.
double WorthOf(const std::vector<SceneBall>& balls, const SceneView& view) {
  std::set<std::pair<int, int>> cells;
  double nearest = std::numeric_limits<double>::infinity(), farthest = 0;
  for (const SceneBall& ball : balls) {
    const std::optional<Eigen::Vector2d> pixel = PixelOf(view, ball.center);
    if (!pixel) continue;
    const double depth = DepthOf(view, ball.center);
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
    cells.emplace(static_cast<int>(std::floor(pixel->x() * 100 / view.width_px)),
                  static_cast<int>(std::floor(pixel->y() * 56 / view.height_px)));
  }
  return cells.empty() ? 0 : static_cast<double>(cells.size()) * std::sqrt(nearest / farthest);
}

// Nearer 1 the less solids are seen end on.
double BroadsideOf(const ScenePicture& picture, const SceneView& view) {
  double worth = 1;
  for (const Solid& solid : picture.solids) {
    const Eigen::Vector3d axis = solid.end - solid.start;
    if (solid.kind == Solid::Kind::kSphere || !(axis.norm() > 0) || !axis.allFinite()) continue;
    const double end_on = std::abs((view.camera_from_lab.linear() * axis).z()) / axis.norm();
    worth *= 1 - 0.3 * end_on * end_on;
  }
  return worth;
}

}  // namespace

SceneView FitView(const std::vector<ScenePicture>& pictures, int width_px, int height_px) {
  TENDRIL_CHECK(width_px >= 64 && height_px >= 64);
  SceneView view{.width_px = width_px, .height_px = height_px};
  view.center_x_px = 0.5 * (width_px - 1);
  view.center_y_px = 0.5 * (height_px - 1);
  view.focal_px = 2.0 * std::min(height_px, width_px * 9 / 16);  // 28 degrees high: little distortion
  std::vector<SceneBall> all, last;
  for (const ScenePicture& picture : pictures) {
    const std::vector<SceneBall> balls = BallsOf(picture);
    all.insert(all.end(), balls.begin(), balls.end());
    if (!balls.empty()) last = balls;
  }
  if (all.empty()) all = last = {{Eigen::Vector3d::Zero(), 0.5}};

  Eigen::AlignedBox3d box;
  for (const SceneBall& ball : all) {
    box.extend(Eigen::Vector3d(ball.center.array() - ball.radius));
    box.extend(Eigen::Vector3d(ball.center.array() + ball.radius));
  }
  view.middle = box.center();
  view.reach = std::max(0.5 * box.diagonal().norm(), 1e-9);
  view.floor_z = box.min().z() - 0.03 * view.reach;
  if (box.diagonal().norm() < 1e-9) all.push_back({view.middle, view.reach});

  // Sixteen turns and three heights; a low camera shows best how far things hang, so a higher one must show
  // clearly more. Among equals, the one from the right front.
  const PictureRoom room = RoomBesideLabels(width_px, height_px);
  constexpr int kTurns = 16;
  constexpr double kPreferred = -0.32 * std::numbers::pi;
  double best = -1;
  SceneView chosen = view;
  for (const auto& [elevation, worth] :
       {std::pair(0.38, 1.0), std::pair(0.65, 0.80), std::pair(0.95, 0.60)}) {
    for (int turn = 0; turn < kTurns; ++turn) {
      const double azimuth = kPreferred + 2 * std::numbers::pi * turn / kTurns;
      Approach(all, azimuth, elevation, room, view);
      const double broadside = pictures.empty() ? 1 : BroadsideOf(pictures.back(), view);
      const double preference = 1 + 0.04 * std::cos(azimuth - kPreferred);
      const double score = worth * preference * WorthOf(last, view) * broadside;
      if (score <= best) continue;
      best = score;
      chosen = view;
    }
  }
  return chosen;
}

struct ScenePainter::State {
  SceneView view;
  SceneView fine;
  SceneLights lights;
  Backdrop backdrop;
  SceneRaster seen, seen_by_key;
  ScenePixels pixels;

  Eigen::Array3f Light(const Eigen::Array3f& color, const Eigen::Vector3d& point,
                       const Eigen::Vector3d& normal, float open) const {
    return Shade(lights, color, point, normal, KeyShare(lights, seen_by_key, point, normal), open);
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
  int BodyOfPixel(const std::vector<ScenePiece>& pieces, int x, int y) const {
    const int ray_x = x * kRays, ray_y = y * kRays;
    if (!seen.Holds(ray_x, ray_y) || !seen.Holds(ray_x + kRays - 1, ray_y + kRays - 1)) return -1;
    int body = -1;
    float least = std::numeric_limits<float>::infinity(), most = 0;
    for (int ray = 0; ray < kRays * kRays; ++ray) {
      const std::size_t hit = seen.At(ray_x + ray % kRays, ray_y + ray / kRays);
      if (seen.piece[hit] < 0) return -1;
      const int its = pieces[static_cast<std::size_t>(seen.piece[hit])].body;
      if (ray > 0 && its != body) return -1;
      body = its;
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
                       .pixels = {}}) {}
ScenePainter::~ScenePainter() = default;
ScenePainter::ScenePainter(ScenePainter&&) noexcept = default;
ScenePainter& ScenePainter::operator=(ScenePainter&&) noexcept = default;

cv::Mat ScenePainter::Draw(const ScenePicture& picture) {
  State& s = *state_;
  std::vector<ScenePiece> pieces;
  std::vector<Eigen::Array3f> colors;
  std::vector<std::string> names;
  std::vector<cv::Scalar> name_colors;
  double thickest = 0;
  for (const std::size_t index : TubesByName(picture)) {
    const unsigned char* rgb = ColorOfTube(colors.size());
    AddTube(picture.tubes[index], static_cast<int>(colors.size()), s.view, kThinnest, pieces);
    if (!picture.tubes[index].name.empty()) {
      names.push_back(picture.tubes[index].name);
      name_colors.emplace_back(rgb[2], rgb[1], rgb[0]);
    }
    colors.push_back(Linear(rgb));
  }
  for (const Solid& solid : SolidsInOrder(picture)) {
    AddSolid(solid, static_cast<int>(colors.size()), s.view, kThinnest, pieces);
    colors.push_back(Linear(kSolidColor));
  }
  for (const ScenePiece& piece : pieces) thickest = std::max(thickest, piece.radius_a);

  CastRays(pieces, s.fine, s.seen);
  CastRays(pieces, s.lights.from_key, s.seen_by_key);
  cv::Mat drawn = WithShadow(s.backdrop, s.view, s.lights, s.seen_by_key);
  MeasurePixels(pieces, s.seen, kRays, s.view, std::min(2.5 * thickest, 0.15 * s.view.reach), s.pixels);
  s.PaintBodies(pieces, colors, drawn);
  DrawLabels(LayOutLabels(picture, s.view, names, name_colors, s.backdrop.grid_step), drawn);
  return drawn;
}

cv::Mat DrawScene(const ScenePicture& picture, const SceneView& view) {
  return ScenePainter(view).Draw(picture);
}

}  // namespace tendril
