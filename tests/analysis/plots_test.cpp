// analysis/study/plots.h: figures come out as files of their kind, labels cannot command gnuplot, failures
// leave nothing behind.
#include "analysis/study/plots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <set>

#include "tests/support/program.h"

namespace tendril {
namespace {

using testing_support::ReadText;
using testing_support::TemporaryFolder;

Figure TwoPanels() {
  PlotSeries line{.name = "it's a curve", .x = {0, 1, 2, 3}, .y = {0, 1, std::nan(""), 9}};
  PlotSeries rates{.name = "rate", .x = {50, 60}, .y = {1, .5}, .low = {.6, .2}, .high = {1, .8}};
  rates.style = PlotSeries::Style::kLineAndPoints;
  return {.panels = {{.title = "left", .x_label = "time (s)", .y_label = "link (turns)", .series = {line}},
                     {.title = "right", .x_label = "distance (mm)", .y_label = "rate", .series = {rates}}},
          .columns = 2};
}

size_t FilesIn(const TemporaryFolder& folder) {
  size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.path())) ++count;
  return count;
}

TEST(DrawFigure, WritesSvgWithTheLabelsAsText) {
  const TemporaryFolder folder;
  const Status done = DrawFigure(TwoPanels(), folder / "figure.svg");
  ASSERT_TRUE(done.ok()) << done.error().message;
  const std::string text = ReadText(folder / "figure.svg");
  EXPECT_THAT(text, testing::HasSubstr("<svg"));
  EXPECT_THAT(text, testing::HasSubstr("time (s)"));
  EXPECT_THAT(text, testing::HasSubstr("distance (mm)"));
  EXPECT_EQ(FilesIn(folder), 1u);
}

TEST(DrawFigure, WritesPngOfTheSizeAskedFor) {
  const TemporaryFolder folder;
  const Status done = DrawFigure(TwoPanels(), folder / "figure.png");
  ASSERT_TRUE(done.ok()) << done.error().message;
  const std::string bytes = ReadText(folder / "figure.png");
  ASSERT_GT(bytes.size(), 24u);
  EXPECT_EQ(bytes.substr(1, 3), "PNG");
  const auto byte = [&](int i) { return static_cast<unsigned>(static_cast<unsigned char>(bytes[16 + i])); };
  EXPECT_EQ(byte(2) << 8 | byte(3), 1240u);  // width, from the header
  EXPECT_EQ(byte(6) << 8 | byte(7), 420u);
}

TEST(DrawFigure, LabelsAreTextNeverCommands) {
  const TemporaryFolder folder;
  Figure figure = TwoPanels();
  const std::string mark = folder / "made";
  figure.panels[0].title =
      "x'; system('touch " + mark + "'); print '`touch " + mark + "`\nsystem('touch " + mark + "')";
  figure.panels[0].series[0].name = "$(touch " + mark + ")";
  const Status done = DrawFigure(figure, folder / "figure.svg");
  ASSERT_TRUE(done.ok()) << done.error().message;
  EXPECT_FALSE(std::filesystem::exists(mark));
}

TEST(DrawFigure, BadCallsAreRefusedAndLeaveNothing) {
  const TemporaryFolder folder;
  EXPECT_EQ(DrawFigure(TwoPanels(), folder / "figure.bmp").error().kind, ErrorKind::kBadInput);
  EXPECT_EQ(DrawFigure({}, folder / "figure.svg").error().kind, ErrorKind::kBadInput);
  Figure uneven = TwoPanels();
  uneven.panels[0].series[0].y.pop_back();
  EXPECT_THAT(DrawFigure(uneven, folder / "figure.svg").error().message, testing::HasSubstr("it's a curve"));
  EXPECT_EQ(DrawFigure(TwoPanels(), folder / "no/such/folder/figure.svg").error().kind, ErrorKind::kIo);
  EXPECT_EQ(FilesIn(folder), 0u);
}

TEST(DrawFigure, EmptySeriesGiveAnEmptyPanel) {
  const TemporaryFolder folder;
  Figure figure = TwoPanels();
  figure.panels[0].series = {PlotSeries{}, {.name = "gap", .x = {1}, .y = {std::nan("")}}};
  const Status done = DrawFigure(figure, folder / "figure.svg");
  EXPECT_TRUE(done.ok()) << done.error().message;
}

TEST(DrawFigure, PolygonsNeedRangesAndEqualArrays) {
  const TemporaryFolder folder;
  Figure figure{
      .panels = {{.title = "shape", .polygons = {{.x = {0, 1, 1}, .y = {0, 0, 1}, .fill = "#aabbcc"}}}}};
  EXPECT_FALSE(DrawFigure(figure, folder / "a.svg").ok());
  figure.panels[0].x_range = figure.panels[0].y_range = {{-1, 2}};
  figure.panels[0].texts = {{.x = 0.5, .y = 1.5, .text = "it's a triangle"}};
  const Status done = DrawFigure(figure, folder / "a.svg");
  ASSERT_TRUE(done.ok()) << done.error().message;
  const std::string text = ReadText(folder / "a.svg");
  EXPECT_THAT(text, testing::HasSubstr("it's a triangle"));
  EXPECT_THAT(text, testing::HasSubstr("rgb(170, 187, 204)"));
  figure.panels[0].polygons[0].y.pop_back();
  EXPECT_FALSE(DrawFigure(figure, folder / "b.svg").ok());
}

Figure Map() {
  PlotHeat heat{
      .columns = 3, .rows = 2, .values = {0, 1, 2, 3, std::nan(""), 5}, .hatched = {0, 1, 0, 0, 0, 0}};
  heat.range = {0, 5};
  heat.label = "phi (degrees)";
  Panel panel{.title = "a map", .x_range = {{0, 1}}, .y_range = {{0, 1}}};
  panel.heat = heat;
  return {.panels = {panel}};
}

TEST(DrawFigure, AMapIsAPictureInsideTheFileWithItsColourBar) {
  const TemporaryFolder folder;
  const Status done = DrawFigure(Map(), folder / "map.svg");
  ASSERT_TRUE(done.ok()) << done.error().message;
  const std::string text = ReadText(folder / "map.svg");
  EXPECT_THAT(text, testing::HasSubstr("data:image/png;base64,"));
  EXPECT_THAT(text, testing::HasSubstr("phi (degrees)"));
  EXPECT_EQ(FilesIn(folder), 1u);
}

TEST(DrawFigure, AMapNeedsAValueForEachCell) {
  const TemporaryFolder folder;
  Figure figure = Map();
  figure.panels[0].heat->values.pop_back();
  EXPECT_THAT(DrawFigure(figure, folder / "map.svg").error().message,
              testing::HasSubstr("2 by 3 cells has 5"));
  figure = Map();
  figure.panels[0].heat->hatched.pop_back();
  EXPECT_EQ(DrawFigure(figure, folder / "map.svg").error().kind, ErrorKind::kBadInput);
  figure.panels[0].heat->rows = 0;
  EXPECT_EQ(DrawFigure(figure, folder / "map.svg").error().kind, ErrorKind::kBadInput);
}

TEST(FigureForPage, RefersToNothingOutsideAndSharesNoIdWithAnother) {
  const auto first = FigureForPage(Map(), "f1", "a map of <b>\"angles\"");
  const auto second = FigureForPage(TwoPanels(), "f2", "two panels");
  ASSERT_TRUE(first.ok()) << first.error().message;
  ASSERT_TRUE(second.ok()) << second.error().message;
  for (const std::string& svg : {first.value(), second.value()}) {
    EXPECT_EQ(svg.rfind("<svg ", 0), 0u);
    EXPECT_THAT(svg, testing::Not(testing::HasSubstr("http")));
    EXPECT_THAT(svg, testing::Not(testing::HasSubstr("<title>")));
    EXPECT_THAT(svg, testing::Not(testing::HasSubstr("xlink")));
  }
  EXPECT_THAT(first.value(), testing::HasSubstr("aria-label=\"a map of &lt;b&gt;&quot;angles&quot;\""));
  const auto ids = [](const std::string& svg) {
    std::set<std::string> found;
    for (std::size_t at = 0; (at = svg.find(" id=", at)) != std::string::npos;) {
      at += 5;
      EXPECT_TRUE(found.insert(svg.substr(at, svg.find(svg[at - 1], at) - at)).second);
    }
    return found;
  };
  std::set<std::string> all = ids(first.value());
  EXPECT_FALSE(all.empty());
  for (const std::string& id : ids(second.value())) EXPECT_TRUE(all.insert(id).second) << id;
}

}  // namespace
}  // namespace tendril
