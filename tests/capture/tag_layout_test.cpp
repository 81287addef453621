// capture/rig/tag_layout.h: every tag lies on its facet, clear of hole, creases and edges, and reads from its
// side.
#include "capture/rig/tag_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "capture/rig/tag_family.h"

namespace tendril {
namespace {

constexpr double kPi = std::numbers::pi;

TentacleDesign Uniform() {
  TentacleDesign design;
  design.taper = 1;
  design.spacing_ratio = 1;
  design.beta = kPi / 2;
  return design;
}

Gripper Few(int tentacles = 2) {
  Gripper gripper;
  gripper.tentacles = tentacles;
  return gripper;
}

// The printed square's corners (z, y), from its border's.
Eigen::Matrix<double, 3, 4> Printed(const TagPlace& tag, const TagFamily& family) {
  const Eigen::Vector3d center = tag.corners_in_sheet.rowwise().mean();
  return ((tag.corners_in_sheet.colwise() - center) * (1.0 * family.total_width / family.border_width))
             .colwise() +
         center;
}

// Distance of a point to a segment, in the sheet.
double ToSegment(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - t * (b - a)).norm();
}

void ExpectClear(const TentacleDesign& design, const Gripper& gripper, const TagLayoutOptions& options) {
  const auto tags = LayOutTags(design, gripper, options);
  ASSERT_TRUE(tags.ok()) << tags.error().message;
  const TagFamily family = FamilyOf(options.family).value();
  for (const TagPlace& tag : tags.value().tags) {
    const auto layout = LayOut(DesignOfTentacle(gripper, design, tag.tentacle));
    ASSERT_TRUE(layout.ok());
    const Eigen::Matrix3Xd& facet = layout.value().facets[static_cast<size_t>(tag.facet)];
    const Eigen::Matrix<double, 3, 4> printed = Printed(tag, family);
    EXPECT_NEAR((printed.col(1) - printed.col(0)).norm(), tag.footprint, 1e-12);
    const Eigen::Vector3d hole(0, 0, layout.value().hole_z[tag.facet]);
    // Sampled along the printed outline: inside the facet, and off its edges and its hole.
    for (int side = 0; side < 4; ++side) {
      for (int step = 0; step < 10; ++step) {
        const Eigen::Vector3d p =
            printed.col(side) + 0.1 * step * (printed.col((side + 1) % 4) - printed.col(side));
        EXPECT_GE((p - hole).norm(), 0.5 * design.hole_diameter + options.clearance - 1e-9);
        for (int i = 0; i < facet.cols(); ++i) {
          const Eigen::Vector3d a = facet.col(i);
          const Eigen::Vector3d b = facet.col((i + 1) % facet.cols());
          EXPECT_GE(ToSegment(p, a, b), options.clearance - 1e-9) << "facet " << tag.facet;
          EXPECT_GT((b - a).cross(p - a).x(), 0) << "facet " << tag.facet;  // counter-clockwise seen from +x
        }
      }
    }
    const double half = 0.5 * tag.footprint;
    const Eigen::Vector3d center = printed.rowwise().mean();
    EXPECT_FALSE(std::abs(center.y()) < half && std::abs(center.z() - hole.z()) < half) << "covers its hole";
  }
}

TEST(LayOutTags, KeepsClearOfHolesCreasesAndEdges) {
  ExpectClear(TentacleDesign{}, Few(), {});
  ExpectClear(Uniform(), Few(), {});
  TentacleDesign oblique;
  oblique.alpha = 60 * kPi / 180;
  oblique.beta = 110 * kPi / 180;
  ExpectClear(oblique, Few(), {});
  ExpectClear(TentacleDesign{}, Few(), {.family = "tagStandard41h12", .clearance = 0.0006});
}

TEST(LayOutTags, ThePapersDesignHoldsEightMillimetres) {
  const auto tags = LayOutTags(TentacleDesign{}, Few(), {});
  ASSERT_TRUE(tags.ok()) << tags.error().message;
  EXPECT_EQ(tags.value().tags.size(), 2u * 49u * 2u);
  EXPECT_DOUBLE_EQ(tags.value().tags[0].footprint, 0.008);
  // 10 mm from hole to crease, less 1 mm hole, twice 0.3 mm: 8.4 mm would still fit.
  EXPECT_TRUE(LayOutTags(TentacleDesign{}, Few(), {.footprint = 0.00839}).ok());
  const auto more = LayOutTags(TentacleDesign{}, Few(), {.footprint = 0.012});
  ASSERT_FALSE(more.ok());
  EXPECT_EQ(more.error().kind, ErrorKind::kBadInput);
  EXPECT_THAT(more.error().message, testing::HasSubstr("facet"));
  EXPECT_THAT(more.error().message, testing::HasSubstr("12 mm"));
}

// R_S 1, tapered to 10 mm: 7.5 mm from hole to crease, less the hole's 1 mm and two clearances of 0.3 mm.
TEST(LayOutTags, TheLargestSquareIsWhatArithmeticSays) {
  TentacleDesign narrow = Uniform();
  narrow.base_width = 0.010;
  const auto tags = LayOutTags(narrow, Few(), {});
  ASSERT_TRUE(tags.ok());
  EXPECT_NEAR(tags.value().tags[10].footprint, 0.0059, 1e-9);
}

TEST(LayOutTags, BordersFollowTheFamilyAndIdsAscend) {
  for (const char* name : {"tag36h11", "tagStandard41h12"}) {
    const auto tags = LayOutTags(TentacleDesign{}, Few(3), {.family = name, .first_id = 7});
    ASSERT_TRUE(tags.ok()) << tags.error().message;
    const double border = name == std::string("tag36h11") ? 0.8 : 5.0 / 9.0;  // published geometry
    int id = 7;
    for (const TagPlace& tag : tags.value().tags) {
      EXPECT_EQ(tag.id, id);
      EXPECT_EQ(tag.side, (id - 7) % 2 == 0 ? TagSide::kOuter : TagSide::kInner);
      EXPECT_NEAR((tag.corners_in_sheet.col(2) - tag.corners_in_sheet.col(1)).norm(), border * 0.008, 1e-12);
      EXPECT_EQ(tags.value().Find(id)->facet, tag.facet);
      ++id;
    }
    EXPECT_EQ(tags.value().Find(6), nullptr);
    EXPECT_EQ(tags.value().Find(id), nullptr);
  }
}

// Seen from its own side a tag's corners run counter-clockwise, or it would be a mirror image nobody decodes.
TEST(LayOutTags, CornersAreCounterClockwiseSeenFromTheirSide) {
  const auto tags = LayOutTags(TentacleDesign{}, Few(), {});
  ASSERT_TRUE(tags.ok());
  for (const TagPlace& tag : tags.value().tags) {
    const Eigen::Vector3d right = tag.corners_in_sheet.col(1) - tag.corners_in_sheet.col(0);
    const Eigen::Vector3d up = tag.corners_in_sheet.col(3) - tag.corners_in_sheet.col(0);
    const double toward = right.cross(up).x();
    EXPECT_TRUE(tag.side == TagSide::kOuter ? toward > 0 : toward < 0);
    EXPECT_GT(up.z(), 0);
  }
}

TEST(LayOutTags, BadInputIsRefused) {
  const auto says = [](const Result<TagLayout>& r, const char* what) {
    ASSERT_FALSE(r.ok());
    EXPECT_EQ(r.error().kind, ErrorKind::kBadInput);
    EXPECT_THAT(r.error().message, testing::HasSubstr(what));
  };
  says(LayOutTags(TentacleDesign{}, Few(), {.family = "tag99"}), "tag36h11");
  says(LayOutTags(TentacleDesign{}, Few(8), {}), "587");
  says(LayOutTags(TentacleDesign{}, Few(), {.footprint = -1}), "-1");
  says(LayOutTags(TentacleDesign{}, Few(), {.footprint = std::nan("")}), "nan");
  says(LayOutTags(TentacleDesign{}, Few(), {.first_id = -4}), "-4");
  says(LayOutTags(TentacleDesign{}, Few(0), {}), "0 tentacles");
  TentacleDesign tiny;
  tiny.base_width = 0.002;
  says(LayOutTags(tiny, Few(), {}), "no facet");
  EXPECT_TRUE(LayOutTags(TentacleDesign{}, Few(8), {.family = "tagStandard41h12"}).ok());
}

TEST(TagFamily, PatternsHaveTheirPublishedShape) {
  const auto tag = PatternOf("tag36h11", 0);
  ASSERT_TRUE(tag.ok());
  ASSERT_EQ(tag.value().rows(), 10);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(tag.value()(0, i), 255);
    EXPECT_EQ(tag.value()(i, 9), 255);
    if (i > 0 && i < 9) {
      EXPECT_EQ(tag.value()(1, i), 0);
    }
  }
  EXPECT_FALSE(PatternOf("tag36h11", 587).ok());
  EXPECT_FALSE(PatternOf("tag36h11", -1).ok());
  for (const std::string& name : TagFamilyNames()) EXPECT_TRUE(FamilyOf(name).ok());
}

}  // namespace
}  // namespace tendril
