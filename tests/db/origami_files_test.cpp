// db/files/origami_files.h: what a program that folds paper reads, against geometry alone: angles from the
// folded corners, lengths kept, a planar graph.
#include "db/files/origami_files.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "model/fold/exact_law.h"
#include "model/fold/fold.h"

namespace tendril {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

struct Written {
  TentacleLayout layout;
  CreasePattern pattern;
  std::vector<FoldedFrame> frames;
};

Written Folded(const TentacleDesign& design, const std::vector<double>& pulls) {
  Written w;
  w.layout = LayOut(design).value();
  w.pattern = CreasePatternOf(design, w.layout).value();
  for (const double pull : pulls) {
    const Eigen::VectorXd angle = SolveFold(design, pull).value().angle;
    w.frames.push_back({"pull", angle, FoldedVertices(w.layout, FoldChain(w.layout, angle))});
  }
  return w;
}

Eigen::Vector3d Vertex(const nlohmann::json& coords, size_t i) {
  return {coords[i][0], coords[i][1], coords[i].size() > 2 ? coords[i][2].get<double>() : 0.0};
}

// FOLD's rule: valley (+) points the two faces' normals into each other.
double SignedFoldAngle(const nlohmann::json& file, const nlohmann::json& coords, size_t edge) {
  const size_t from = file["edges_vertices"][edge][0];
  const size_t to = file["edges_vertices"][edge][1];
  Eigen::Vector3d normal[2];
  Eigen::Vector3d centre[2];
  size_t faces = 0;
  for (const auto& face : file["faces_vertices"]) {
    const std::vector<size_t> corners = face;
    if (std::count(corners.begin(), corners.end(), from) == 0) continue;
    if (std::count(corners.begin(), corners.end(), to) == 0) continue;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const size_t c : corners) sum += Vertex(coords, c) / 4;
    centre[faces] = sum;
    normal[faces] = (Vertex(coords, corners[2]) - Vertex(coords, corners[0]))
                        .cross(Vertex(coords, corners[3]) - Vertex(coords, corners[1]))
                        .normalized();
    ++faces;
  }
  EXPECT_EQ(faces, 2u);
  const double size = std::atan2(normal[0].cross(normal[1]).norm(), normal[0].dot(normal[1]));
  // The other face rises on the side to which this face's normal points: a valley.
  return (centre[1] - Vertex(coords, from)).dot(normal[0]) > 0 ? size : -size;
}

TEST(FoldText, FoldedFormsHaveTheAnglesThatTheirEdgesState) {
  TentacleDesign oblique;
  oblique.alpha = 105 * kDegree;
  for (const TentacleDesign& design : {TentacleDesign{}, oblique}) {
    const Written w = Folded(design, {0.1, 0.3});
    const auto file = nlohmann::json::parse(FoldText(w.pattern, w.frames, "a", "b"));
    EXPECT_EQ(file["file_spec"], 1.2);
    EXPECT_EQ(file["edges_foldAngle"], file["file_frames"][1]["edges_foldAngle"]);
    for (const auto& frame : file["file_frames"]) {
      EXPECT_EQ(frame["frame_parent"], 0);
      EXPECT_EQ(frame["frame_inherit"], true);
      int folded = 0;
      for (size_t e = 0; e < file["edges_vertices"].size(); ++e) {
        const size_t from = file["edges_vertices"][e][0], to = file["edges_vertices"][e][1];
        const auto length = [&](const nlohmann::json& coords) {
          return (Vertex(coords, to) - Vertex(coords, from)).norm();
        };
        EXPECT_NEAR(length(frame["vertices_coords"]), length(file["vertices_coords"]), 1e-13);
        const double stated = frame["edges_foldAngle"][e];
        const std::string assignment = file["edges_assignment"][e];
        if (assignment == "B") {
          EXPECT_EQ(stated, 0);
          continue;
        }
        EXPECT_NEAR(SignedFoldAngle(file, frame["vertices_coords"], e), stated * kDegree, 1e-12);
        EXPECT_EQ(assignment, stated < 0 ? "M" : "V");
        ++folded;
      }
      EXPECT_EQ(folded, 48);
    }
  }
}

TEST(FoldText, ThePatternIsAPlanarGraphOfCounterclockwiseFaces) {
  const Written w = Folded({}, {0.2});
  const auto file = nlohmann::json::parse(FoldText(w.pattern, w.frames, "a", "b"));
  EXPECT_EQ(file["vertices_coords"].size() + file["faces_vertices"].size(),
            file["edges_vertices"].size() + 1);  // Euler, without the outer face
  std::map<std::pair<int, int>, int> uses;
  double area = 0;
  for (const auto& face : file["faces_vertices"]) {
    double twice = 0;
    for (size_t k = 0; k < 4; ++k) {
      const int a = face[k], b = face[(k + 1) % 4];
      ++uses[std::minmax(a, b)];
      const Eigen::Vector3d p = Vertex(file["vertices_coords"], static_cast<size_t>(a));
      const Eigen::Vector3d q = Vertex(file["vertices_coords"], static_cast<size_t>(b));
      twice += p.x() * q.y() - p.y() * q.x();
    }
    EXPECT_GT(twice, 0);
    area += 0.5 * twice;
  }
  EXPECT_NEAR(area, 0.750 * 0.015, 1e-15);  // the trapezium
  for (size_t e = 0; e < file["edges_vertices"].size(); ++e) {
    const int a = file["edges_vertices"][e][0], b = file["edges_vertices"][e][1];
    EXPECT_EQ(uses[std::minmax(a, b)], file["edges_assignment"][e] == "B" ? 1 : 2);
  }
}

// An attribute's value in an element on one line; empty: it has none.
std::string Attribute(const std::string& element, const std::string& name) {
  const size_t at = element.find(" " + name + "=\"");
  if (at == std::string::npos) return "";
  const size_t from = at + name.size() + 3;
  return element.substr(from, element.find('"', from) - from);
}

// Read as Origami Simulator reads it: children of <svg> only, type by stroke, target by opacity.
TEST(OrigamiSvg, LinesCarryTypeAndTargetAngle) {
  TentacleDesign design;
  design.taper = 1;
  const Written w = Folded(design, {0.3});
  const Eigen::VectorXd exact = SolveExactFold(design, 0.3).value().angle;  // its short creases are flat
  for (const Eigen::VectorXd& angle : {w.frames[0].angle, exact}) {
    const std::string svg = OrigamiSvg(w.pattern, angle);
    EXPECT_EQ(svg.find("<g"), std::string::npos);
    std::map<std::string, int> count;
    std::map<double, std::pair<std::string, double>> creases;  // by place along the sheet
    std::istringstream lines(svg);
    for (std::string line; std::getline(lines, line);) {
      if (line.rfind("<line ", 0) != 0) continue;
      const std::string stroke = Attribute(line, "stroke");
      ++count[stroke];
      if (stroke == "#000000") continue;
      const double place = 0.5 * (std::stod(Attribute(line, "x1")) + std::stod(Attribute(line, "x2"))) - 2;
      const std::string opacity = Attribute(line, "opacity");
      creases[place] = {stroke, opacity.empty() ? 0.0 : 180 * std::stod(opacity)};
    }
    EXPECT_EQ(count["#000000"], 2 * 49 + 2);
    ASSERT_EQ(creases.size(), 48u);
    int i = 0;
    for (const auto& [place, crease] : creases) {
      EXPECT_NEAR(place, 25 + 15 * i, 1e-4);  // midway between holes at 15, 35, 45, 65, ... mm
      EXPECT_NEAR(crease.second, 2 * angle[i] / kDegree, 1e-6);
      const char* colour = angle[i] == 0 ? "#ffff00" : i % 2 == 0 ? "#ff0000" : "#0000ff";
      EXPECT_EQ(crease.first, colour);
      ++i;
    }
  }
}

TEST(CreasePatternOf, RefusesCreasesThatCrossOrLeaveAndSaysWhere) {
  TentacleDesign design;
  design.beta = 15 * kDegree;
  const auto crossing = CreasePatternOf(design, LayOut(design).value());
  ASSERT_FALSE(crossing.ok());
  EXPECT_NE(crossing.error().message.find("creases 0 and 1 cross"), std::string::npos);
  TentacleDesign leaving;
  leaving.holes = 2;
  leaving.length = 0.03;
  leaving.alpha = 30 * kDegree;
  const auto out = CreasePatternOf(leaving, LayOut(leaving).value());
  ASSERT_FALSE(out.ok());
  EXPECT_NE(out.error().message.find("crease 0, 15 mm from the base end, leaves through the"),
            std::string::npos);
}

}  // namespace
}  // namespace tendril
