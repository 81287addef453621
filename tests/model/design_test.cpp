// model/fold/design.h, gripper.h, cut_pattern.h: counts, widths, ranges; where tentacles hang; what can be
// cut.
#include "model/fold/design.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "model/fold/cut_pattern.h"
#include "model/fold/gripper.h"
#include "tests/support/random_design.h"

namespace tendril {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

TEST(LayOut, ThePapersCountsAndSpacing) {
  const TentacleLayout layout = LayOut({}).value();
  ASSERT_EQ(layout.hole_z.size(), 49);
  ASSERT_EQ(layout.crease_z.size(), 48);
  ASSERT_EQ(layout.facets.size(), 49u);
  EXPECT_NEAR(FlatTendonLength(layout), 0.720, 1e-15);
  EXPECT_NEAR(layout.base_z, -0.015, 1e-15);
  EXPECT_NEAR(layout.tip_z, 0.735, 1e-15);
  EXPECT_NEAR(layout.hole_z[1], 0.020, 1e-15);
  EXPECT_NEAR(layout.hole_z[2], 0.030, 1e-15);
  EXPECT_NEAR(layout.crease_z[0], 0.010, 1e-15);
  EXPECT_NEAR(layout.crease_z[1], 0.025, 1e-15);
  // Crease 0 is 25 mm of 750 mm from the base: 20 mm - 10 mm / 30.
  EXPECT_NEAR(layout.width[0], 0.020 - 0.010 / 30, 1e-15);
  EXPECT_NEAR(layout.stiffness[0], layout.width[0] / 0.020, 1e-15);
}

TEST(LayOut, FacetsTileTheSheet) {
  for (const double beta : {15.0, 75.0, 165.0}) {
    TentacleDesign design;
    design.beta = beta * kDegree;
    design.base_width = 0.002;  // narrow enough for creases at 15 degrees
    const TentacleLayout layout = LayOut(design).value();
    double area = 0;
    for (const Eigen::Matrix3Xd& facet : layout.facets) {
      double own = 0;
      for (int i = 0; i < 4; ++i) {
        const int j = (i + 1) % 4;
        own += 0.5 * (facet(1, i) * facet(2, j) - facet(1, j) * facet(2, i));
      }
      EXPECT_GT(own, 0);  // counter-clockwise from +x
      area += own;
    }
    EXPECT_NEAR(area, 0.75 * 0.0015, 1e-15);  // a trapezium, 2 mm to 1 mm
  }
}

TEST(LayOut, RefusesWhatIsOutOfRangeByName) {
  const auto message_of = [](auto change) {
    TentacleDesign design;
    change(design);
    const auto layout = LayOut(design);
    return layout.ok() ? std::string("accepted") : layout.error().message;
  };
  EXPECT_EQ(message_of([](auto& d) { d.length = -0.75; }).substr(0, 14), "length = -0.75");
  EXPECT_EQ(message_of([](auto& d) { d.taper = std::nan(""); }).substr(0, 11), "taper = nan");
  EXPECT_EQ(message_of([](auto& d) { d.alpha = 0; }).substr(0, 13), "alpha_deg = 0");
  EXPECT_EQ(message_of([](auto& d) { d.beta = std::numbers::pi; }).substr(0, 14), "beta_deg = 180");
  EXPECT_EQ(message_of([](auto& d) { d.holes = 1; }).substr(0, 9), "holes = 1");
  EXPECT_EQ(message_of([](auto& d) { d.closed_angle = 1.6; }).substr(0, 16), "closed_angle_deg");
  EXPECT_NE(message_of([](auto& d) { d.holes = 60; }).find("need 0.89 m"), std::string::npos)
      << message_of([](auto& d) { d.holes = 60; });
}

TEST(LabFromTentacle, HangsDownWithTheOuterFaceOutwardTiltedTowardTheAxis) {
  for (const auto handedness : {Handedness::kMirror, Handedness::kNormals, Handedness::kSame}) {
    Gripper gripper;
    gripper.handedness = handedness;
    for (int i = 0; i < 8; ++i) {
      const Eigen::Isometry3d pose = LabFromTentacle(gripper, i);
      const Eigen::Vector3d hole = pose.translation();
      EXPECT_NEAR(hole.norm(), 0.12, 1e-15);
      EXPECT_EQ(hole.z(), 0);
      EXPECT_NEAR(
          std::remainder(std::atan2(hole.y(), hole.x()) - (22.5 + 45 * i) * kDegree, 2 * std::numbers::pi), 0,
          1e-14);
      EXPECT_NEAR(pose.linear().determinant(), 1, 1e-14);
      EXPECT_LT((pose.linear() * pose.linear().transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
      EXPECT_NEAR(pose.linear()(2, 2), -std::cos(5 * kDegree), 1e-15);
      EXPECT_LT(pose.linear().col(2).dot(hole), 0);  // the tip leans to the axis
      const double outward = pose.linear().col(0).dot(hole.normalized());
      const double sign = handedness == Handedness::kNormals && i % 2 == 1 ? -1 : 1;
      EXPECT_NEAR(outward, sign * std::cos(5 * kDegree), 1e-14);
    }
  }
}

TEST(LabFromTentacle, PairsStandAsFarApartAsAskedAboutTheirMiddle) {
  Gripper even, paired;
  even.tentacles = paired.tentacles = 16;
  paired.pair_spacing = 0.022;
  for (int k = 0; k < 8; ++k) {
    const auto base = [k](const Gripper& gripper, int i) {
      return Eigen::Vector3d(LabFromTentacle(gripper, 2 * k + i).translation());
    };
    EXPECT_NEAR((base(paired, 1) - base(paired, 0)).norm(), 0.022, 1e-15);
    EXPECT_NEAR(base(paired, 1).norm(), 0.12, 1e-15);
    const Eigen::Vector3d middle = base(paired, 0) + base(paired, 1);
    EXPECT_NEAR(middle.normalized().dot((base(even, 0) + base(even, 1)).normalized()), 1, 1e-15);
    EXPECT_GT(base(paired, 0).cross(base(paired, 1)).z(), 0);  // in the same order
  }
}

TEST(LabFromTentacle, PairsAsWideAsAllStandEvenlyAreEvenAndTheWidestMeetTheNext) {
  Gripper even, paired;
  paired.pair_spacing = 2 * 0.12 * std::sin(std::numbers::pi / 8);
  for (int i = 0; i < 8; ++i) {
    EXPECT_LT((LabFromTentacle(paired, i).matrix() - LabFromTentacle(even, i).matrix()).norm(), 1e-15);
  }
  paired.pair_spacing = WidestPairSpacing(paired);
  EXPECT_LT((LabFromTentacle(paired, 1).matrix() - LabFromTentacle(paired, 2).matrix()).norm(), 1e-14);
  paired.tentacles = 2;
  EXPECT_NEAR(WidestPairSpacing(paired), 0.24, 1e-15);  // across the carrier
  paired.tentacles = 7;
  EXPECT_EQ(WidestPairSpacing(paired), 0);
}

TEST(DesignOfTentacle, OnlyOddTentaclesOfAMirrorGripperAreMirrored) {
  Gripper gripper;
  EXPECT_NEAR(DesignOfTentacle(gripper, {}, 1).beta, 105 * kDegree, 1e-15);
  EXPECT_EQ(DesignOfTentacle(gripper, {}, 1).alpha, std::numbers::pi / 2);
  EXPECT_EQ(DesignOfTentacle(gripper, {}, 2).beta, TentacleDesign{}.beta);
  gripper.handedness = Handedness::kNormals;
  EXPECT_EQ(DesignOfTentacle(gripper, {}, 1).beta, TentacleDesign{}.beta);
}

TEST(CutPattern, DashesLieOnTheirCreaseInsideTheOutline) {
  const CutPattern pattern = CutPatternOf({}, {.dash = 2e-3, .gap = 1e-3}).value();
  ASSERT_EQ(pattern.creases.size(), 48u);
  EXPECT_NEAR(pattern.length, 0.75, 1e-15);
  EXPECT_NEAR(pattern.width, 0.02, 1e-15);
  for (size_t i = 0; i < 48; ++i) {
    const CutCrease& crease = pattern.creases[i];
    ASSERT_FALSE(crease.dashes.empty());
    const double angle = i % 2 == 0 ? 90 : 105;  // y of the sheet is drawn downward
    for (size_t k = 0; k < crease.dashes.size(); ++k) {
      const Eigen::Vector2d dash = crease.dashes[k].to - crease.dashes[k].from;
      EXPECT_NEAR(dash.norm(), 2e-3, 1e-12);
      EXPECT_NEAR(std::atan2(dash.y(), dash.x()) / kDegree, angle, 1e-9);
      if (k == 0) continue;
      EXPECT_NEAR((crease.dashes[k].from - crease.dashes[k - 1].to).norm(), 1e-3, 1e-12);
    }
    for (const Eigen::Vector2d& end : {crease.dashes.front().from, crease.dashes.back().to}) {
      const double half_width = 0.01 - 0.005 * end.x() / 0.75;
      EXPECT_LT(std::abs(end.y() - 0.01), half_width - 0.4e-3);  // half a gap stands
    }
  }
  EXPECT_NEAR(pattern.holes(0, 0), 0.015, 1e-15);
  EXPECT_NEAR(pattern.holes(1, 48), 0.01, 1e-15);
}

TEST(CutPattern, RefusesWhatNoPlotterCanCutAndSaysWhere) {
  const auto message_of = [](auto change) {
    TentacleDesign design;
    change(design);
    EXPECT_TRUE(LayOut(design).ok());  // it can still be folded
    const auto pattern = CutPatternOf(design);
    return pattern.ok() ? std::string("accepted") : pattern.error().message;
  };
  const auto crossing = message_of([](auto& d) { d.beta = 30 * kDegree; });
  EXPECT_NE(crossing.find("creases 0 and 1 cross"), std::string::npos) << crossing;
  const auto wide = message_of([](auto& d) { d.hole_diameter = 0.012, d.spacing_ratio = 1; });
  EXPECT_NE(wide.find("hole 39, 600 mm"), std::string::npos)
      << wide;  // the ribbon is 12 mm wide there, less at the hole's far side
  const auto leaves = message_of([](auto& d) { d.alpha = 20 * kDegree, d.beta = 20 * kDegree; });
  EXPECT_NE(leaves.find("crease 0, 25 mm from the base end, leaves"), std::string::npos) << leaves;
  const auto hit = message_of([](auto& d) { d.spacing_ratio = 0.05; });
  EXPECT_NE(hit.find("meets crease 1"), std::string::npos) << hit;
  const auto end = message_of([](auto& d) { d.length = 0.7201; });
  EXPECT_NE(end.find("hole 0"), std::string::npos) << end;
  EXPECT_FALSE(CutPatternOf({}, {.dash = 0}).ok());
  EXPECT_FALSE(CutPatternOf({}, {.gap = 0.05}).ok());
}

// Whatever the design, what is let through can be cut: told from the drawing alone.
TEST(CutPattern, OverTheExtremesWhatItLetsThroughCanBeCut) {
  std::mt19937_64 random(5);
  int accepted = 0, refused = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    TentacleDesign design = test::RandomDesign(random);
    design.length *= 1 + 0.3 * (trial % 2);
    design.hole_diameter = design.base_width * std::uniform_real_distribution<double>(0.01, 0.4)(random);
    const double gap = 0.02 * design.base_width * design.taper;
    const auto result = CutPatternOf(design, {.dash = gap, .gap = gap});
    if (!result.ok()) {
      EXPECT_NE(result.error().message.find("cannot be cut: "), std::string::npos) << result.error().message;
      ++refused;
      continue;
    }
    ++accepted;
    const CutPattern& pattern = result.value();
    const double radius = 0.5 * pattern.hole_diameter;
    const auto inside = [&](const Eigen::Vector2d& p, double room) {
      const double half = 0.5 * design.base_width * (1 + (design.taper - 1) * p.x() / pattern.length);
      return p.x() > room && p.x() < pattern.length - room &&
             std::abs(p.y() - 0.5 * pattern.width) < half - room;
    };
    const auto side = [](const CutCrease& of, const Eigen::Vector2d& p) {  // which side of its line
      const Eigen::Vector2d along = of.dashes.back().to - of.dashes.front().from;
      const Eigen::Vector2d to = p - of.dashes.front().from;
      return (along.x() * to.y() - along.y() * to.x()) / along.norm();
    };
    for (size_t i = 0; i < pattern.creases.size(); ++i) {
      const CutCrease& crease = pattern.creases[i];
      EXPECT_TRUE(inside(crease.dashes.front().from, 0) && inside(crease.dashes.back().to, 0)) << trial;
      // All of the next crease, and its hole, on the tip's side; the hole before on the base's.
      if (i + 1 < pattern.creases.size()) {
        EXPECT_LT(side(crease, pattern.creases[i + 1].dashes.front().from), 0) << trial;
        EXPECT_LT(side(crease, pattern.creases[i + 1].dashes.back().to), 0) << trial;
      }
      const auto hole = static_cast<Eigen::Index>(i);
      EXPECT_GT(side(crease, pattern.holes.col(hole)), radius) << trial;
      EXPECT_LT(side(crease, pattern.holes.col(hole + 1)), -radius) << trial;
    }
    for (Eigen::Index i = 0; i < pattern.holes.cols(); ++i) {
      EXPECT_TRUE(inside(pattern.holes.col(i), 0.99 * radius)) << trial << " hole " << i;
    }
  }
  EXPECT_GT(accepted, 20);
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace tendril
