#include "db/files/origami_files.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "db/files/safe_file.h"
#include "model/check.h"

namespace tendril {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180;

template <class Matrix>
Json Columns(const Matrix& points) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    Json row = Json::array();
    for (Eigen::Index k = 0; k < points.rows(); ++k) row.push_back(points(k, i));
    rows.push_back(std::move(row));
  }
  return rows;
}

Json FoldAngles(const CreasePattern& pattern, const Eigen::VectorXd& angle) {
  Json degrees = Json::array();
  for (const CreasePattern::Edge& edge : pattern.edges) {
    const double size = edge.crease < 0 ? 0 : 2 * angle[edge.crease] / kDegree;
    degrees.push_back(size == 0 ? 0.0 : IsMountain(edge.crease) ? -size : size);
  }
  return degrees;
}

}  // namespace

std::string FoldText(const CreasePattern& pattern, const std::vector<FoldedFrame>& frames,
                     const std::string& title, const std::string& creator) {
  TENDRIL_CHECK(!frames.empty());
  Json file;
  file["file_spec"] = 1.2;
  file["file_creator"] = creator;
  file["file_title"] = title;
  file["file_classes"] = {"singleModel", "animation"};
  file["frame_title"] = "crease pattern";
  file["frame_classes"] = {"creasePattern"};
  file["frame_attributes"] = {"2D", "manifold", "orientable"};
  file["frame_unit"] = "m";
  file["vertices_coords"] = Columns(pattern.vertices);
  Json ends = Json::array();
  Json assignment = Json::array();
  for (const CreasePattern::Edge& edge : pattern.edges) {
    ends.push_back({edge.from, edge.to});
    assignment.push_back(edge.crease < 0 ? "B" : IsMountain(edge.crease) ? "M" : "V");
  }
  file["edges_vertices"] = std::move(ends);
  file["edges_assignment"] = std::move(assignment);
  file["edges_foldAngle"] = FoldAngles(pattern, frames.back().angle);
  file["faces_vertices"] = pattern.faces;
  file["file_frames"] = Json::array();
  for (const FoldedFrame& folded : frames) {
    Json frame;
    frame["frame_parent"] = 0;
    frame["frame_inherit"] = true;
    frame["frame_title"] = folded.title;
    frame["frame_classes"] = {"foldedForm"};
    frame["frame_attributes"] = {"3D", "manifold", "orientable"};
    frame["frame_unit"] = "m";
    frame["vertices_coords"] = Columns(folded.vertices);
    frame["edges_foldAngle"] = FoldAngles(pattern, folded.angle);
    file["file_frames"].push_back(std::move(frame));
  }
  return file.dump() + "\n";
}

std::string OrigamiSvg(const CreasePattern& pattern, const Eigen::VectorXd& angle) {
  constexpr double kMargin = 2e-3;  // m, so that no border lies on the picture's edge
  std::string out = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.5f}mm\" height=\"{1:.5f}mm\" "
      "viewBox=\"0 0 {0:.5f} {1:.5f}\">\n",
      1e3 * (pattern.length + 2 * kMargin), 1e3 * (pattern.width + 2 * kMargin));
  const auto at = [&](int vertex, const char* end) {  // SVG's y points down
    return fmt::format("x{0}=\"{1:.5f}\" y{0}=\"{2:.5f}\" ", end,
                       1e3 * (pattern.vertices(0, vertex) + kMargin),
                       1e3 * (pattern.width - pattern.vertices(1, vertex) + kMargin));
  };
  for (const CreasePattern::Edge& edge : pattern.edges) {
    out += "<line " + at(edge.from, "1") + at(edge.to, "2");
    if (edge.crease < 0) {
      out += "stroke=\"#000000\"";
    } else if (angle[edge.crease] == 0) {
      out += "stroke=\"#ffff00\"";
    } else {
      out += fmt::format("stroke=\"{}\" opacity=\"{:.9g}\"", IsMountain(edge.crease) ? "#ff0000" : "#0000ff",
                         2 * angle[edge.crease] / std::numbers::pi);
    }
    out += " stroke-width=\"0.2\"/>\n";
  }
  return out + "</svg>\n";
}

Status WriteFoldText(const std::filesystem::path& file, const CreasePattern& pattern,
                     const std::vector<FoldedFrame>& frames, const std::string& title,
                     const std::string& creator) {
  return WriteText(file, FoldText(pattern, frames, title, creator));
}

Status WriteOrigamiSvg(const std::filesystem::path& file, const CreasePattern& pattern,
                       const Eigen::VectorXd& angle) {
  return WriteText(file, OrigamiSvg(pattern, angle));
}

}  // namespace tendril
