// capture/rig/tag_views.h, tag_choice.h, tag_weight.h: what cameras see of a straight gripper, held against
// projected corners, closed forms and a drawn picture; which family is proposed; what tags weigh.
#include "capture/rig/tag_views.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core/mat.hpp>
#include <random>
#include <set>

#include "capture/rig/tag_choice.h"
#include "capture/rig/tag_family.h"
#include "capture/rig/tag_weight.h"
#include "capture/rig/virtual_render.h"
#include "capture/rig/virtual_truth.h"
#include "capture/track/tag_detect.h"

namespace tendril {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180;

Gripper Hanging(int tentacles) {
  return {.tentacles = tentacles, .first_azimuth = 0, .tilt = 0, .handedness = Handedness::kSame};
}

// At (distance, 0, z) of the lab, looking along -x; its picture's right is +y.
Camera FromX(double x, double z, double focal_px) {
  Camera camera{.name = "x", .width_px = 4000, .height_px = 4000};
  camera.focal_x_px = camera.focal_y_px = focal_px;
  camera.center_x_px = camera.center_y_px = 1999.5;
  Eigen::Isometry3d lab_from_camera = Eigen::Isometry3d::Identity();
  lab_from_camera.linear().col(0) = Eigen::Vector3d::UnitY();
  lab_from_camera.linear().col(1) = -Eigen::Vector3d::UnitZ();
  lab_from_camera.linear().col(2) = -Eigen::Vector3d::UnitX();
  lab_from_camera.translation() = Eigen::Vector3d(x, 0, z);
  camera.camera_from_lab = lab_from_camera.inverse();
  return camera;
}

// Tentacle 0 hangs at x = 0.12 m and faces +x: a pinhole sees f / (x - 0.12) px per metre.
TEST(SeeTags, AFrontalTagHasFocalLengthOverDistance) {
  const Gripper gripper = Hanging(1);
  const auto tags = LayOutTags(TentacleDesign{}, gripper);
  const auto sight = SeeTags({}, gripper, tags.value(), {.name = "r", .cameras = {FromX(1.12, -0.36, 3000)}});
  ASSERT_TRUE(sight.ok()) << sight.error().message;
  ASSERT_EQ(sight.value().views.size(), 98u);
  int turned = 0;
  for (const TagOutlook& view : sight.value().views) {
    const TagPlace& tag = tags.value().tags[view.tag];
    const double up = tag.corners_in_sheet.row(2).mean() - 0.36;  // of the camera's axis, m
    const double tilt = std::atan(std::hypot(up, tag.corners_in_sheet.row(1).mean()));
    if (tag.side == TagSide::kInner) {
      EXPECT_EQ(view.use, TagUse::kTurnedAway);
      ++turned;
      continue;
    }
    EXPECT_NEAR(view.tilt, tilt, 1e-6);
    // A plane parallel to the picture is not shortened; what faces the camera off its axis is larger by the
    // root of what the tilt takes of its area.
    EXPECT_NEAR(view.module_px, 2.4 / std::sqrt(std::cos(tilt)), 1e-6);
    EXPECT_NEAR(view.least_module_px, 2.4, 1e-6);  // the sheet is parallel to the picture
  }
  EXPECT_EQ(turned, 49);
  EXPECT_EQ(sight.value().cameras[0].count[static_cast<size_t>(TagUse::kTurnedAway)], 49);
}

// Corners through the camera's own lens: the quad's area is (px per module)^2 cos(tilt) per module, its sides
// are no shorter than the least.
TEST(SeeTags, PixelsPerModuleAreThoseOfProjectedCorners) {
  const auto rig = ReadRig(TENDRIL_SOURCE_DIR "/examples/rigs/two_cameras.toml");
  ASSERT_TRUE(rig.ok());
  const Gripper gripper{.tentacles = 2};
  const auto tags = LayOutTags(TentacleDesign{}, gripper, {.family = "tagStandard41h12"});
  const auto sight = SeeTags({}, gripper, tags.value(), rig.value());
  ASSERT_TRUE(sight.ok());
  ASSERT_EQ(sight.value().views.size(), 2 * 196u);
  for (const TagOutlook& view : sight.value().views) {
    if (view.use > TagUse::kUnsure) continue;
    const TagPlace& tag = tags.value().tags[view.tag];
    Eigen::Matrix<double, 2, 4> px;
    for (int i = 0; i < 4; ++i) {
      px.col(i) = *Project(rig.value().cameras[view.camera],
                           LabFromTentacle(gripper, tag.tentacle) * tag.corners_in_sheet.col(i));
    }
    double area = 0;
    double shortest = 1e9;
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector2d a = px.col(i);
      const Eigen::Vector2d b = px.col((i + 1) % 4);
      area += 0.5 * (a.x() * b.y() - a.y() * b.x());
      shortest = std::min(shortest, (b - a).norm());
    }
    const double modules = 5;  // of this family's border
    EXPECT_NEAR(std::abs(area) / (modules * modules), view.module_px * view.module_px * std::cos(view.tilt),
                0.01 * view.module_px * view.module_px);
    EXPECT_LE(view.least_module_px, 1.01 * shortest / modules);
    EXPECT_NEAR(view.least_module_px, view.module_px * std::cos(view.tilt), 0.02 * view.module_px);
  }
}

TEST(SeeTags, AnotherTentacleHidesWhatHangsBehindIt) {
  const Gripper gripper = Hanging(2);  // at x = 0.12 and -0.12
  const auto tags = LayOutTags(TentacleDesign{}, gripper);
  const auto sight = SeeTags({}, gripper, tags.value(), {.name = "r", .cameras = {FromX(3, -0.36, 9000)}});
  ASSERT_TRUE(sight.ok());
  for (const TagOutlook& view : sight.value().views) {
    const TagPlace& tag = tags.value().tags[view.tag];
    const bool toward = (tag.tentacle == 0) == (tag.side == TagSide::kOuter);
    EXPECT_EQ(view.use, !toward             ? TagUse::kTurnedAway
                        : tag.tentacle == 0 ? TagUse::kDecoded
                                            : TagUse::kHidden)
        << tag.id;
  }
  for (const FacetSight& facet : sight.value().facets) EXPECT_EQ(facet.cameras, facet.tentacle == 0 ? 1 : 0);
}

TEST(SeeTags, WhatIsOutsideOrBehindIsNotSeen) {
  const Gripper gripper = Hanging(1);
  const auto tags = LayOutTags(TentacleDesign{}, gripper);
  Camera away = FromX(-1, -0.36, 3000);  // looks away from the gripper
  Camera low = FromX(1.12, -5, 3000);
  const auto sight = SeeTags({}, gripper, tags.value(), {.name = "r", .cameras = {away, low}});
  ASSERT_TRUE(sight.ok());
  for (const TagOutlook& view : sight.value().views) EXPECT_GE(view.use, TagUse::kTurnedAway);
  EXPECT_TRUE(std::isnan(sight.value().cameras[0].nearest_m_per_px));
  EXPECT_EQ(SeeTags({}, gripper, tags.value(), {}).error().kind, ErrorKind::kBadInput);
}

TEST(TagUse, LimitsAreThoseOfTheDocumentation) {
  EXPECT_DOUBLE_EQ(DecodeLimitPx(0), 2);
  EXPECT_DOUBLE_EQ(DecodeLimitPx(45 * kDegree), 3);
  EXPECT_NEAR(DecodeLimitPx(60 * kDegree), 3 * std::sqrt(2.0), 1e-12);
  EXPECT_EQ(UseOf(2, 10, 0), TagUse::kDecoded);
  EXPECT_EQ(UseOf(2, 10, 45 * kDegree), TagUse::kTracked);
  EXPECT_EQ(UseOf(3, 10, 45 * kDegree), TagUse::kDecoded);
  EXPECT_EQ(UseOf(2, 10, 59.9 * kDegree), TagUse::kTracked);
  EXPECT_EQ(UseOf(1.9, 10, 0), TagUse::kUnsure);
  EXPECT_EQ(UseOf(3, 10, 61 * kDegree), TagUse::kUnsure);
  EXPECT_EQ(UseOf(1e6, 10, 89 * kDegree), TagUse::kDecoded);
}

// The virtual rig draws the straight gripper; the detector is asked what it reads.
TEST(SeeTags, WhatIsSaidToBeDecodedIsDecodedInADrawnPicture) {
  const auto rig = ReadRig(TENDRIL_SOURCE_DIR "/examples/rigs/two_cameras.toml");
  const Gripper gripper{.tentacles = 2};
  const TentacleDesign design;
  const auto tags = LayOutTags(design, gripper);
  const auto sight = SeeTags(design, gripper, tags.value(), rig.value());
  std::mt19937_64 random(3);
  const auto truth = DrawTruth(design, gripper, {1, 1, 1}, {0.3, 0.03}, VirtualCylinder{}, {}, random);
  ASSERT_TRUE(rig.ok() && sight.ok() && truth.ok());
  const auto shape = TrueShapeAt(truth.value(), 0);
  auto detector = TagDetector::Create();
  std::array<int, 6> said{};
  std::array<int, 6> read{};
  for (size_t c = 0; c < 2; ++c) {
    const auto camera = VirtualCamera::Make(rig.value().cameras[c], tags.value(), design.hole_diameter);
    const cv::Mat picture = camera.value().Render(shape.value(), random);
    std::set<int> ids;
    const auto found =
        detector.value().Detect({picture.data, picture.cols, picture.rows, static_cast<int>(picture.step)});
    for (const TagDetection& tag : found.value()) ids.insert(tag.id);
    for (const TagOutlook& view : sight.value().views) {
      if (view.camera != c) continue;
      ++said[static_cast<size_t>(view.use)];
      if (ids.contains(tags.value().tags[view.tag].id)) ++read[static_cast<size_t>(view.use)];
    }
  }
  RecordProperty("read", fmt::format("{} / {}", fmt::join(read, " "), fmt::join(said, " ")));
  EXPECT_GE(read[0], 0.95 * said[0]);
  EXPECT_GT(said[0], 50);
  EXPECT_EQ(read[static_cast<size_t>(TagUse::kTurnedAway)], 0);
  EXPECT_EQ(read[static_cast<size_t>(TagUse::kOutside)], 0);
}

TEST(ChooseFamily, DarkBordersAsLongAsIdsLast) {
  const auto chosen = [](int tentacles, TagLayoutOptions options = {}, std::optional<double> m_per_px = {}) {
    const auto choice = ChooseFamily({}, {.tentacles = tentacles}, options, m_per_px);
    EXPECT_TRUE(choice.ok()) << choice.error().message;
    EXPECT_THAT(choice.value().why, testing::StartsWith(choice.value().family));
    return choice.value().family;
  };
  EXPECT_EQ(chosen(2), "tag36h11");                     // 196 tags of 587
  EXPECT_EQ(chosen(5), "tag36h11");                     // 490
  EXPECT_EQ(chosen(6), "tag36h10");                     // 588
  EXPECT_EQ(chosen(16), "tag36h10");                    // 1568 of 2320
  EXPECT_EQ(chosen(2, {.first_id = 400}), "tag36h10");  // 596
  EXPECT_TRUE(FamilyOf(chosen(64)).value().ids > 6272);
  // 0.42 mm per px: modules of 0.8 mm have 1.9 px, those of 9 to a side 2.1.
  EXPECT_EQ(chosen(2, {}, 0.42e-3), "tagStandard41h12");
  EXPECT_EQ(ChooseFamily({}, {.tentacles = 1000}, {}).error().kind, ErrorKind::kBadInput);
  TentacleDesign tiny;
  tiny.base_width = 0.002;
  EXPECT_THAT(ChooseFamily(tiny, {.tentacles = 2}, {}).error().message, testing::HasSubstr("no facet"));
}

TEST(ChooseFamily, OverHolesTheFamilyWithAnEmptyMiddle) {
  TentacleDesign uniform;
  uniform.taper = 1;
  uniform.spacing_ratio = 1;
  uniform.beta = kPi / 2;
  EXPECT_EQ(ChooseFamily(uniform, {.tentacles = 2}, {.over_hole = true}).value().family, "tagCustom48h12");
  EXPECT_EQ(ChooseFamily({}, {.tentacles = 2}, {.over_hole = true}).value().family, "tag36h11");
}

// 16 bits with up to 2 wrong: every fourth random square is a tag16h5.
TEST(FalseTagShare, CountsTheWordsThatDecode) {
  EXPECT_NEAR(FalseTagShare(FamilyOf("tag16h5").value()), 30.0 * 4 * 137 / 65536, 1e-12);
  EXPECT_NEAR(FalseTagShare(FamilyOf("tagCustom48h12").value()), 42211.0 * 4 * 49 / std::pow(2, 48), 1e-18);
  EXPECT_LT(FalseTagShare(FamilyOf("tag36h11").value()), 1e-4);
}

TEST(WeighTags, MassIsAreaTimesGrammage) {
  const auto tags = LayOutTags({}, {.tentacles = 2});
  const auto weight = WeighTags({}, tags.value());
  ASSERT_TRUE(weight.ok());
  EXPECT_NEAR(weight.value().film_mass, 1390 * 0.75 * 0.015 * 1e-4, 1e-12);  // 1.56 g
  EXPECT_NEAR(weight.value().tag_mass, 98 * 64e-6 * 0.1, 1e-12);             // 0.63 g
  const auto half = WeighTags({}, LayOutTags({}, {.tentacles = 2}, {.sides = TagSides::kOuter}).value());
  EXPECT_NEAR(half.value().tag_mass, 0.5 * weight.value().tag_mass, 1e-12);
}

TEST(WeighTags, StiffnessOfLayersFollowsItsClosedForms) {
  const auto tags = LayOutTags({}, {.tentacles = 1});
  // A label of the film's own thickness and modulus makes a sheet of twice or three times the thickness.
  const auto same =
      WeighTags({}, tags.value(), {.label_grammage = 0.1, .label_density = 1000, .label_modulus = 4e9});
  EXPECT_NEAR(same.value().one_side, 8, 1e-9);
  EXPECT_NEAR(same.value().both_sides, 27, 1e-9);
  EXPECT_NEAR(same.value().film_stiffness, 4e9 * 1e-12 / 12, 1e-18);
  const TentacleLayout layout = LayOut({}).value();
  EXPECT_NEAR(same.value().crease, 4e9 * 1e-12 / 12 * layout.width[24] / 1e-3, 1e-12);
  EXPECT_NEAR(same.value().facet, same.value().crease / 15, 1e-12);
  // A soft label adds nothing.
  EXPECT_NEAR(WeighTags({}, tags.value(), {.label_modulus = 1}).value().both_sides, 1, 1e-6);
  EXPECT_EQ(WeighTags({}, tags.value(), {.label_grammage = 0}).error().kind, ErrorKind::kBadInput);
  EXPECT_EQ(WeighTags({}, tags.value(), {.film_density = std::nan("")}).error().kind, ErrorKind::kBadInput);
}

}  // namespace
}  // namespace tendril
