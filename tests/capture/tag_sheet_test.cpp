// capture/rig/tag_sheet.h: what other programs (rsvg-convert, pdftoppm) make of a sheet is read back by the
// detector, at the stated size, and its bars measure 100 mm.
#include "capture/rig/tag_sheet.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/core/mat.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "capture/track/tag_detect.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using testing_support::TemporaryFolder;

constexpr double kDpi = 300;
constexpr double kPxPerMm = kDpi / 25.4;

bool Have(const char* program) {
  return std::system((std::string("command -v ") + program + " > /dev/null").c_str()) == 0;
}

TagLayout LayoutOf(const TagLayoutOptions& options, int tentacles = 3) {
  return LayOutTags(TentacleDesign{}, Gripper{.tentacles = tentacles}, options).value();
}

std::vector<cv::Mat> PrintSvg(const TagLayout& layout, const TemporaryFolder& folder) {
  std::vector<cv::Mat> pictures;
  const auto pages = TagSheetSvg(layout, {.title = "a <b> & c"});
  for (const std::string& page : pages.value()) {
    testing_support::WriteText(folder / "page.svg", page);
    const std::string call =
        "rsvg-convert -d 300 -p 300 -o '" + (folder / "page.png") + "' '" + (folder / "page.svg") + "'";
    EXPECT_EQ(std::system(call.c_str()), 0);
    pictures.push_back(cv::imread(folder / "page.png", cv::IMREAD_GRAYSCALE));
  }
  return pictures;
}

std::vector<cv::Mat> PrintPdf(const TagLayout& layout, const TemporaryFolder& folder) {
  testing_support::WriteText(folder / "tags.pdf", TagSheetPdf(layout, {.title = "a <b> & c"}).value());
  const std::string call =
      "pdftoppm -r 300 -gray -png '" + (folder / "tags.pdf") + "' '" + (folder / "page") + "'";
  EXPECT_EQ(std::system(call.c_str()), 0);
  std::set<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    if (entry.path().extension() == ".png") files.insert(entry.path().string());
  }
  std::vector<cv::Mat> pictures;
  for (const std::string& file : files) pictures.push_back(cv::imread(file, cv::IMREAD_GRAYSCALE));
  return pictures;
}

// Every tag of the layout once, upright, at its size (corners of the black border).
void ExpectAllTags(const std::vector<cv::Mat>& pages, const TagLayout& layout, double border_share,
                   double tolerance = 0.01) {
  auto detector = TagDetector::Create({.family = layout.family});
  ASSERT_TRUE(detector.ok());
  std::set<int> seen;
  for (const cv::Mat& gray : pages) {
    ASSERT_FALSE(gray.empty());
    EXPECT_NEAR(gray.cols, 210 * kPxPerMm, 2);
    EXPECT_NEAR(gray.rows, 297 * kPxPerMm, 2);
    const auto tags = detector.value().Detect({gray.data, gray.cols, gray.rows, static_cast<int>(gray.step)});
    ASSERT_TRUE(tags.ok());
    for (const TagDetection& tag : tags.value()) {
      const TagPlace* place = layout.Find(tag.id);
      ASSERT_NE(place, nullptr) << tag.id;
      EXPECT_TRUE(seen.insert(tag.id).second) << tag.id << " twice";
      EXPECT_EQ(tag.hamming, 0);
      const double expected_px = place->footprint * border_share * 1e3 * kPxPerMm;
      for (int i = 0; i < 4; ++i) {
        EXPECT_NEAR((tag.corners_px.col((i + 1) % 4) - tag.corners_px.col(i)).norm(), expected_px,
                    tolerance * expected_px);
      }
      EXPECT_GT(tag.corners_px(1, 0), tag.corners_px(1, 3));  // upright
    }
  }
  EXPECT_EQ(seen.size(), layout.tags.size());
}

// The longest dark run of a picture's rows, mm: the scale bar along, for nothing else on a page is as long.
double LongestRun(const cv::Mat& gray) {
  int longest = 0;
  for (int y = 0; y < gray.rows; ++y) {
    int run = 0;
    for (int x = 0; x < gray.cols; ++x) {
      run = gray.at<unsigned char>(y, x) < 128 ? run + 1 : 0;
      longest = std::max(longest, run);
    }
  }
  return longest / kPxPerMm;
}

void ExpectScaleBars(const cv::Mat& gray) {
  EXPECT_NEAR(LongestRun(gray), 100, 1.5 / kPxPerMm);
  EXPECT_NEAR(LongestRun(gray.t()), 100, 1.5 / kPxPerMm);
}

TEST(TagSheet, SvgPagesShowEveryTagAtItsSize) {
  ASSERT_TRUE(Have("rsvg-convert")) << "librsvg2-bin of scripts/packages.txt is not installed";
  const TemporaryFolder folder;
  const TagLayout layout = LayoutOf({});
  const auto pages = PrintSvg(layout, folder);
  EXPECT_EQ(pages.size(), 2u);
  ExpectAllTags(pages, layout, 0.8);
  ExpectScaleBars(pages[0]);
}

TEST(TagSheet, PdfPagesShowEveryTagAtItsSize) {
  ASSERT_TRUE(Have("pdftoppm")) << "poppler-utils of scripts/packages.txt is not installed";
  for (const TagLayoutOptions& options : {TagLayoutOptions{.family = "tag36h11"},
                                          TagLayoutOptions{.family = "tagStandard41h12", .each = true}}) {
    const TemporaryFolder folder;
    const TagLayout layout = LayoutOf(options);
    const auto pages = PrintPdf(layout, folder);
    EXPECT_GE(pages.size(), 2u);
    // Corners of a light border are the library's own, an unfitted pixel more or less.
    ExpectAllTags(pages, layout, options.each ? 5.0 / 9.0 : 0.8, options.each ? 0.025 : 0.01);
    for (const cv::Mat& page : pages) ExpectScaleBars(page);
  }
}

// A tag's outline is gray, wholly outside of the printed side, and nothing else comes nearer than a label.
TEST(TagSheet, TheCutLineSurroundsTheWhiteRing) {
  ASSERT_TRUE(Have("pdftoppm")) << "poppler-utils of scripts/packages.txt is not installed";
  const TemporaryFolder folder;
  const TagLayout layout = LayoutOf({}, 1);
  const cv::Mat gray = PrintPdf(layout, folder).at(0);
  auto detector = TagDetector::Create();
  const auto tags = detector.value().Detect({gray.data, gray.cols, gray.rows, static_cast<int>(gray.step)});
  ASSERT_TRUE(tags.ok());
  ASSERT_EQ(tags.value().size(), 98u);
  for (const TagDetection& tag : tags.value()) {
    const Eigen::Vector2d center = tag.corners_px.rowwise().mean();
    const double half = 0.004 * 1e3 * kPxPerMm;
    int darkest = 255;
    for (int x = -4; x <= 4; ++x) {  // across the line, right of the tag
      darkest = std::min<int>(darkest, gray.at<unsigned char>(static_cast<int>(center.y()),
                                                              static_cast<int>(center.x() + half) + x));
    }
    EXPECT_LT(darkest, 230);
    EXPECT_GT(darkest, 100);
    const double ring = half - 0.4 * kPxPerMm;  // the ring is 0.8 mm wide
    for (int y = -static_cast<int>(ring); y < static_cast<int>(ring); ++y) {
      EXPECT_GT(gray.at<unsigned char>(static_cast<int>(center.y()) + y, static_cast<int>(center.x() + ring)),
                250);
    }
  }
}

// Nothing in it has a resolution.
TEST(TagSheet, ThePdfIsLinesAndAreas) {
  const TagLayout layout = LayoutOf({});
  const std::string pdf = TagSheetPdf(layout).value();
  EXPECT_EQ(pdf.substr(0, 5), "%PDF-");
  EXPECT_EQ(pdf.find("/Image"), std::string::npos);
  const auto svg = TagSheetSvg(layout);
  for (const std::string& page : svg.value()) EXPECT_EQ(page.find("<image"), std::string::npos);
}

TEST(TagSheet, ATagWiderThanThePageIsRefused) {
  TagLayout layout{
      .family = "tag36h11",
      .tags = {{.id = 0, .footprint = 0.5, .corners_in_sheet = Eigen::Matrix<double, 3, 4>::Zero()}}};
  EXPECT_EQ(TagSheetSvg(layout).error().kind, ErrorKind::kBadInput);
  EXPECT_EQ(TagSheetPdf(layout).error().kind, ErrorKind::kBadInput);
  layout.tags[0].footprint = 0.01;
  EXPECT_TRUE(TagSheetSvg(layout).ok());
  layout.tags[0].id = 9999;
  EXPECT_EQ(TagSheetSvg(layout).error().kind, ErrorKind::kBadInput);
  EXPECT_EQ(TagSheetPdf(layout).error().kind, ErrorKind::kBadInput);
  EXPECT_TRUE(TagSheetSvg({.family = "tag36h11", .tags = {}}).ok());
}

}  // namespace
}  // namespace tendril
