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
  std::set<int> kept_clear;  // over its hole or beside it
  for (const TagPlace& tag : tags.value().tags) {
    kept_clear.insert(tag.over_hole ? 1 : 0);
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
    const bool covers = std::abs(center.y()) < half && std::abs(center.z() - hole.z()) < half;
    EXPECT_EQ(covers, tag.over_hole);
    if (tag.over_hole) {  // the whole hole in the middle that carries no bit
      EXPECT_LT((center - hole).norm(), 1e-12);
      EXPECT_GE(0.2 * tag.footprint, design.hole_diameter);
    }
  }
  EXPECT_EQ(kept_clear.contains(1), options.over_hole);
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

// R_S 1, 20 mm wide: beside the hole 10 - 1 - 0.6 = 8.4 mm; over it 15 - 0.6 = 14.4 mm, whose middle of 2.88
// mm holds it.
TEST(LayOutTags, OverTheHoleAUniformDesignHoldsFarLargerTags) {
  TagLayoutOptions over{.family = "tagCustom48h12", .over_hole = true};
  const TagLayoutOptions each{.family = "tagCustom48h12", .each = true};
  EXPECT_NEAR(LayOutTags(Uniform(), Few(), each).value().tags[20].footprint, 0.0084, 1e-9);
  const auto tags = LayOutTags(Uniform(), Few(), over);
  ASSERT_TRUE(tags.ok()) << tags.error().message;
  for (const TagPlace& tag : tags.value().tags) EXPECT_NEAR(tag.footprint, 0.0144, 1e-9);
  ExpectClear(Uniform(), Few(), over);
  over.each = true;
  ExpectClear(Uniform(), Few(), over);
  over.each = false;
  // The paper's holes are 5 mm from an oblique crease: over one there is room for
  // 2 (5 sin 75 - 0.3) / (sin 75 + cos 75) = 7.4 mm only, whose middle is narrower than the hole.
  const auto paper = LayOutTags(TentacleDesign{}, Few(), over);
  ASSERT_TRUE(paper.ok());
  for (const TagPlace& tag : paper.value().tags) {
    EXPECT_FALSE(tag.over_hole);
    EXPECT_DOUBLE_EQ(tag.footprint, 0.008);
  }
}

TEST(LayOutTags, EachAsLargeAsItsFacetHolds) {
  TentacleDesign design;
  design.taper = 0.3;  // 20 mm to 6 mm wide
  const auto equal = LayOutTags(design, Few(), {});
  const auto each = LayOutTags(design, Few(), {.each = true});
  ASSERT_TRUE(equal.ok() && each.ok()) << each.error().message;
  const std::vector<TagPlace>& tags = each.value().tags;
  ASSERT_EQ(tags.size(), equal.value().tags.size());
  EXPECT_NEAR(tags[20].footprint, 0.0084, 1e-9);  // 10 mm from hole to crease, less 1 mm and twice 0.3 mm
  EXPECT_LT(tags[97].footprint, 0.0059);          // the tip's width
  for (size_t i = 0; i < tags.size(); ++i) EXPECT_GE(tags[i].footprint, equal.value().tags[0].footprint);
  ExpectClear(design, Few(), {.each = true});
  const auto bounded = LayOutTags(design, Few(), {.footprint = 0.006, .each = true});
  ASSERT_TRUE(bounded.ok());
  EXPECT_DOUBLE_EQ(bounded.value().tags[20].footprint, 0.006);
  EXPECT_EQ(bounded.value().tags[97].footprint, tags[97].footprint);
}

TEST(LayOutTags, EveryNthFacetAndOneSideLeaveOutTheOthers) {
  const auto tags =
      LayOutTags(TentacleDesign{}, Few(3), {.first_id = 5, .every = 3, .sides = TagSides::kInner});
  ASSERT_TRUE(tags.ok());
  ASSERT_EQ(tags.value().tags.size(), 3u * 17u);  // facets 0, 3, ..., 48
  int id = 5;
  for (const TagPlace& tag : tags.value().tags) {
    EXPECT_EQ(tag.id, id++);
    EXPECT_EQ(tag.facet % 3, 0);
    EXPECT_EQ(tag.side, TagSide::kInner);
  }
  const auto outer = LayOutTags(TentacleDesign{}, Few(), {.sides = TagSides::kOuter});
  ASSERT_EQ(outer.value().tags.size(), 98u);
  for (const TagPlace& tag : outer.value().tags) EXPECT_EQ(tag.side, TagSide::kOuter);
  EXPECT_EQ(LayOutTags(TentacleDesign{}, Few(), {.every = 1000}).value().tags.size(), 4u);
}

// Where a trial says nothing of it, tags lie where they always lay.
TEST(LayOutTags, ATrialsSpecIsTheOptionsOfTheSameName) {
  const TagLayoutOptions plain = LayoutOptionsOf(TagSpec{});
  EXPECT_EQ(LayOutTags(TentacleDesign{}, Few(), plain).value().tags.size(), 196u);
  const TagLayoutOptions options = LayoutOptionsOf({.family = "tag36h10",
                                                    .footprint = 0.006,
                                                    .first_id = 9,
                                                    .sizes = TagSizes::kEach,
                                                    .every = 2,
                                                    .sides = TagSides::kOuter,
                                                    .over_hole = true});
  EXPECT_EQ(options.family, "tag36h10");
  EXPECT_EQ(options.footprint, 0.006);
  EXPECT_EQ(options.first_id, 9);
  EXPECT_TRUE(options.each && options.over_hole);
  EXPECT_EQ(options.every, 2);
  EXPECT_EQ(options.sides, TagSides::kOuter);
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
  says(LayOutTags(TentacleDesign{}, Few(8), {}), "tag36h10 has 2320");
  says(LayOutTags(TentacleDesign{}, Few(), {.every = 0}), "every 0th");
  says(LayOutTags(TentacleDesign{}, Few(), {.over_hole = true}), "tagCustom48h12");
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
  EXPECT_EQ(FamilyOf("tagCustom48h12").value().void_width, 2);
  EXPECT_EQ(FamilyOf("tagCustom48h12").value().ids, 42211);
  for (const char* full : {"tag36h11", "tag36h10", "tagStandard41h12", "tagStandard52h13"}) {
    EXPECT_EQ(FamilyOf(full).value().void_width, 0) << full;
  }
}

}  // namespace
}  // namespace tendril
