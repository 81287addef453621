// db/files/drawing_files.h: the drawings as an XML and a DXF reader see them, against the design's own
// numbers.
#include "db/files/drawing_files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>

#include "tests/support/program.h"

namespace tendril {
namespace {

// A DXF as its (code, value) pairs; empty if codes and values do not alternate.
std::vector<std::pair<int, std::string>> Groups(const std::string& dxf) {
  std::vector<std::pair<int, std::string>> groups;
  std::istringstream lines(dxf);
  std::string code, value;
  while (std::getline(lines, code)) {
    if (!std::getline(lines, value)) return {};
    groups.emplace_back(std::stoi(code), value);
  }
  return groups;
}

struct Entity {
  std::string type;
  std::map<int, std::string> values;
  double operator[](int code) const { return std::stod(values.at(code)); }
};

std::vector<Entity> Entities(const std::string& dxf) {
  std::vector<Entity> entities;
  bool inside = false;
  for (const auto& [code, value] : Groups(dxf)) {
    if (code == 2 && value == "ENTITIES") inside = true;
    if (!inside) continue;
    if (code == 0) {
      if (value == "ENDSEC") break;
      entities.push_back({value, {}});
    } else if (!entities.empty()) {
      entities.back().values[code] = value;
    }
  }
  return entities;
}

TEST(CutDxf, HoldsOutlineCreasesAndHolesInMillimetres) {
  const CutPattern pattern = CutPatternOf({}).value();
  const std::vector<Entity> entities = Entities(CutDxf(pattern));
  int holes = 0;
  int vertices = 0;
  size_t dashes = 0;
  for (const Entity& e : entities) {
    if (e.type == "CIRCLE") {
      EXPECT_EQ(e.values.at(8), "HOLE");
      // Holes 20 and 10 mm apart in turn, the first 15 mm from the base, on the centerline.
      EXPECT_NEAR(e[10], 15 + 30 * (holes / 2) + 20 * (holes % 2), 1e-5);
      EXPECT_NEAR(e[20], 10, 1e-5);
      EXPECT_NEAR(e[40], 1, 1e-5);
      ++holes;
    } else if (e.type == "LINE") {
      EXPECT_NEAR(std::hypot(e[11] - e[10], e[21] - e[20]), 1, 1e-4);
      // Every second crease is a valley. An oblique one runs up to 2.7 mm to either side of its middle.
      const double places = (0.5 * (e[10] + e[11]) - 25) / 15;
      EXPECT_NEAR(places, std::round(places), 0.2);
      EXPECT_EQ(e.values.at(8), std::lround(places) % 2 == 0 ? "CREASE_M" : "CREASE_V");
      ++dashes;
    } else if (e.type == "POLYLINE") {
      EXPECT_EQ(e.values.at(70), "1");  // closed
    } else if (e.type == "VERTEX") {
      EXPECT_EQ(e.values.at(8), "CUT");
      const double x = e[10];
      EXPECT_NEAR(std::abs(e[20] - 10), x < 1 ? 10 : 5, 1e-5);
      EXPECT_NEAR(x, x < 1 ? 0 : 750, 1e-5);
      ++vertices;
    }
  }
  EXPECT_EQ(holes, 49);
  EXPECT_EQ(vertices, 4);
  size_t expected = 0;
  for (const CutCrease& crease : pattern.creases) expected += crease.dashes.size();
  EXPECT_EQ(dashes, expected);
}

TEST(CutSvg, IsDrawnAtTrueSizeWithALayerPerTool) {
  const std::string svg = CutSvg(CutPatternOf({}).value(), "a < b & c");
  EXPECT_NE(svg.find("width=\"750.00000mm\" height=\"20.00000mm\" viewBox=\"0 0 750.00000 20.00000\""),
            std::string::npos);
  EXPECT_NE(svg.find("<title>a &lt; b &amp; c</title>"), std::string::npos);
  for (const char* layer : {"CUT", "HOLE", "CREASE_M", "CREASE_V"}) {
    EXPECT_NE(svg.find("inkscape:label=\"" + std::string(layer) + "\""), std::string::npos);
  }
  int circles = 0;
  for (size_t at = svg.find("<circle "); at != std::string::npos; at = svg.find("<circle ", at + 1))
    ++circles;
  EXPECT_EQ(circles, 49);
  EXPECT_EQ(svg.find("-0.00000"), std::string::npos);
}

TEST(WriteCutSvg, AFolderThatIsNotThereIsAnError) {
  const testing_support::TemporaryFolder folder;
  EXPECT_FALSE(WriteCutSvg(folder / "no/such.svg", CutPatternOf({}).value(), "").ok());
  EXPECT_TRUE(WriteCutDxf(folder / "a.dxf", CutPatternOf({}).value()).ok());
}

}  // namespace
}  // namespace tendril
