#include "cli/shape_strip.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tendril::cli {
namespace {

// Where the viewer is, and what is right and up for them; the tentacle hangs along -z of this frame.
struct View {
  Eigen::Vector3d toward;
  Eigen::Vector3d right;
  Eigen::Vector3d up;
};

View ViewFrom(double azimuth, double elevation) {
  View view;
  view.toward << std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
      std::sin(elevation);
  view.right << -std::sin(azimuth), std::cos(azimuth), 0;
  view.up = view.toward.cross(view.right);
  return view;
}

std::string Shade(bool outer, double light) {
  const Eigen::Array3d colour = outer ? Eigen::Array3d(250, 214, 120) : Eigen::Array3d(90, 130, 170);
  const Eigen::Array3i rgb = (colour * light).round().cast<int>();
  return fmt::format("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]);
}

struct DrawnFacet {
  double depth = 0;  // toward the viewer
  PlotPolygon polygon;
};

DrawnFacet Draw(const Eigen::Matrix3Xd& facet, const View& view, double offset) {
  const Eigen::Matrix3Xd hanging = Eigen::Vector3d(1, -1, -1).asDiagonal() * facet;
  DrawnFacet drawn;
  drawn.depth = view.toward.dot(hanging.rowwise().mean());
  for (Eigen::Index i = 0; i < hanging.cols(); ++i) {
    drawn.polygon.x.push_back(1e3 * (offset + view.right.dot(hanging.col(i))));
    drawn.polygon.y.push_back(1e3 * view.up.dot(hanging.col(i)));
  }
  const Eigen::Vector3d normal =
      (hanging.col(2) - hanging.col(0)).cross(hanging.col(3) - hanging.col(1)).normalized();
  const Eigen::Vector3d lamp = (view.toward + 0.6 * view.up - 0.5 * view.right).normalized();
  const bool outer = normal.dot(view.toward) > 0;
  drawn.polygon.fill = Shade(outer, 0.62 + 0.38 * std::abs(normal.dot(lamp)));
  return drawn;
}

}  // namespace

Panel StripPanel(const std::string& title, const std::vector<StripShape>& shapes, double step, double depth) {
  const View view = ViewFrom(55 * std::numbers::pi / 180, 12 * std::numbers::pi / 180);
  Panel panel{.title = title, .x_label = "mm", .y_label = "mm", .equal_axes = true};
  panel.x_range = {{-500 * step, 1e3 * step * (static_cast<double>(shapes.size()) - 0.5)}};
  panel.y_range = {{-1e3 * depth, 0.17e3 * depth}};
  for (size_t k = 0; k < shapes.size(); ++k) {
    const double offset = step * static_cast<double>(k);
    std::vector<DrawnFacet> drawn;
    for (const Eigen::Matrix3Xd& facet : shapes[k].facets) drawn.push_back(Draw(facet, view, offset));
    std::stable_sort(drawn.begin(), drawn.end(),
                     [](const DrawnFacet& a, const DrawnFacet& b) { return a.depth < b.depth; });
    for (DrawnFacet& facet : drawn) panel.polygons.push_back(std::move(facet.polygon));
    panel.texts.push_back({.x = 1e3 * offset, .y = 0.13e3 * depth, .text = shapes[k].label});
  }
  return panel;
}

}  // namespace tendril::cli
