// capture/rig/virtual_truth.h: without perturbation it is the fold model by another route; with it, facets
// stay joined and rigid, deviations have the stated size, and the same seed gives the same trial.
#include "capture/rig/virtual_truth.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/rig/portable_random.h"
#include "model/fold/facet_chain.h"
#include "model/fold/fold.h"

namespace tendril {
namespace {

using Vector3 = Eigen::Vector3d;

TruthRanges Exact() {
  TruthRanges r;
  r.position_sd = r.crease_angle_sd = r.stiffness_sd = r.facet_bend_sd = r.largest_sag_compliance = 0;
  r.base_position_sd = r.base_angle_sd = r.largest_delay = r.rate_perturbation = 0;
  r.object_position_sd = r.object_angle_sd = 0;
  return r;
}

VirtualTruth Draw(const TruthRanges& ranges, std::uint64_t seed = 1, const TrueFold& fold = {1, 1, 1}) {
  Gripper gripper;
  gripper.tentacles = 2;
  std::mt19937_64 random(seed);
  auto truth = DrawTruth(TentacleDesign{}, gripper, fold, PullCommand{}, VirtualCylinder{}, ranges, random);
  EXPECT_TRUE(truth.ok()) << truth.error().message;
  return std::move(truth).value();
}

TrueShape ShapeAt(const VirtualTruth& truth, double time) {
  auto shape = TrueShapeAt(truth, time);
  EXPECT_TRUE(shape.ok()) << shape.error().message;
  return std::move(shape).value();
}

TEST(TrueShapeAt, WithoutPerturbationIsTheFoldModel) {
  const VirtualTruth truth = Draw(Exact());
  for (const double time : {0.0, 2.0, 7.0, 10.0, 20.0}) {
    const TrueShape shape = ShapeAt(truth, time);
    const double pull = std::min(0.3, 0.03 * time);
    for (int i = 0; i < 2; ++i) {
      Gripper gripper;
      gripper.tentacles = 2;
      const TentacleDesign design = DesignOfTentacle(gripper, TentacleDesign{}, i);
      const TentacleLayout layout = LayOut(design).value();
      const Fold fold = SolveFold(design, pull).value();
      const FacetChain chain = FoldChain(layout, fold.angle);
      const Eigen::Isometry3d lab = LabFromTentacle(gripper, i);
      const auto& tentacle = shape.tentacles[static_cast<std::size_t>(i)];
      EXPECT_NEAR(tentacle.pull, pull, 1e-15);
      for (const TrueStrip& strip : tentacle.strips) {
        const Eigen::Isometry3d expected =
            lab * chain.tentacle_from_sheet[static_cast<std::size_t>(strip.facet)];
        ASSERT_LT((strip.lab_from_sheet.matrix() - expected.matrix()).cwiseAbs().maxCoeff(), 1e-11);
      }
      const FramedCurve curve = NodesAtHoles(TendonCurveOf(layout, chain, fold.angle));
      EXPECT_LT((tentacle.centerline.points - (lab * curve.points)).cwiseAbs().maxCoeff(), 1e-11);
      EXPECT_LT((tentacle.centerline.normals - lab.linear() * curve.normals).cwiseAbs().maxCoeff(), 1e-9);
    }
  }
}

// Neighbouring strips meet along the line they share, whatever was drawn.
TEST(TrueShapeAt, BentFacetsStayJoined) {
  const VirtualTruth truth = Draw(TruthRanges{}, 3);
  const TrueShape shape = ShapeAt(truth, 9);
  for (std::size_t t = 0; t < 2; ++t) {
    const auto& strips = shape.tentacles[t].strips;
    const TentacleLayout& layout = truth.tentacles[t].layout;
    ASSERT_EQ(strips.size(), 3 * 49U);
    for (std::size_t i = 0; i + 1 < strips.size(); ++i) {
      const bool crease = strips[i].facet != strips[i + 1].facet;
      const double z = crease ? layout.crease_z[strips[i].facet] : strips[i].to_z;
      const double angle = crease ? layout.crease_angle[strips[i].facet] : M_PI / 2;
      for (const double y : {-0.01, 0.0, 0.01}) {
        const Vector3 on_line(0, y * std::sin(angle), z + y * std::cos(angle));
        EXPECT_LT((strips[i].lab_from_sheet * on_line - strips[i + 1].lab_from_sheet * on_line).norm(),
                  1e-12);
      }
      const Eigen::Matrix3d& r = strips[i].lab_from_sheet.linear();
      EXPECT_LT((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    }
  }
}

TEST(TrueShapeAt, StripsTileTheirFacets) {
  const VirtualTruth truth = Draw(TruthRanges{}, 4);
  const TrueShape shape = ShapeAt(truth, 0);
  const auto area = [](const Eigen::Matrix3Xd& p) {
    double twice = 0;  // the shoelace, positive when counter-clockwise
    for (Eigen::Index i = 0; i < p.cols(); ++i) {
      const Eigen::Index j = (i + 1) % p.cols();
      twice += p(1, i) * p(2, j) - p(1, j) * p(2, i);
    }
    return 0.5 * twice;
  };
  double sheet = 0;
  for (const TrueStrip& strip : shape.tentacles[0].strips) sheet += area(strip.corners_in_sheet);
  EXPECT_NEAR(sheet, 0.75 * 0.015, 1e-9);  // length times mean width, whatever the creases' places
}

TEST(TrueShapeAt, SagIsAFewMillimetresAndGrowsWithCompliance) {
  TruthRanges sagging = Exact();
  sagging.largest_sag_compliance = TruthRanges{}.largest_sag_compliance;
  double largest = 0;
  for (const double time : {0.0, 5.0, 10.0}) {
    VirtualTruth truth = Draw(sagging);
    for (auto& t : truth.tentacles) t.sag_compliance = sagging.largest_sag_compliance;
    const TrueShape sagged = ShapeAt(truth, time);
    const TrueShape straight = ShapeAt(Draw(Exact()), time);
    for (std::size_t t = 0; t < 2; ++t) {
      const auto& a = sagged.tentacles[t].centerline.points;
      const auto& b = straight.tentacles[t].centerline.points;
      largest = std::max(largest, (a - b).colwise().norm().maxCoeff());
    }
  }
  std::printf("largest sag %.2f mm\n", 1e3 * largest);
  EXPECT_GT(largest, 0.5e-3);
  EXPECT_LT(largest, 10e-3);
}

// A horizontal tentacle's tip can only go down.
TEST(TrueShapeAt, SagIsDownward) {
  VirtualTruth truth = Draw(Exact());
  for (auto& t : truth.tentacles) {
    t.lab_from_tentacle.linear() = Eigen::AngleAxisd(M_PI / 2, Vector3::UnitY()).toRotationMatrix();
  }
  const double level = ShapeAt(truth, 0).tentacles[0].centerline.points(2, 48);
  truth.tentacles[0].sag_compliance = 1;
  EXPECT_LT(ShapeAt(truth, 0).tentacles[0].centerline.points(2, 48), level - 1e-3);
}

TEST(DrawTruth, DeviationsHaveTheStatedSize) {
  const TruthRanges ranges;
  const TentacleLayout drawn = LayOut(TentacleDesign{}).value();
  double hole = 0, angle = 0, stiffness = 0, bend = 0;
  int n = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const VirtualTruth truth = Draw(ranges, seed);
    const TentacleTruth& t = truth.tentacles[0];
    EXPECT_GE(t.delay, 0);
    EXPECT_LT(t.delay, ranges.largest_delay);
    EXPECT_LE(std::abs(t.rate_offset), ranges.rate_perturbation);
    for (Eigen::Index i = 0; i < 48; ++i, ++n) {
      hole += std::pow(t.layout.hole_z[i] - drawn.hole_z[i], 2);
      angle += std::pow(t.layout.crease_angle[i] - drawn.crease_angle[i], 2);
      stiffness += std::pow(std::log(t.layout.stiffness[i] / drawn.stiffness[i]), 2);
      bend += std::pow(t.facet_bend[i], 2);
    }
  }
  // A standard deviation from n draws is known to 1 / sqrt(2 n), here 1.6 %; four of those.
  EXPECT_NEAR(std::sqrt(hole / n) / ranges.position_sd, 1, 0.065);
  EXPECT_NEAR(std::sqrt(angle / n) / ranges.crease_angle_sd, 1, 0.065);
  EXPECT_NEAR(std::sqrt(stiffness / n) / ranges.stiffness_sd, 1, 0.065);
  EXPECT_NEAR(std::sqrt(bend / n) / ranges.facet_bend_sd, 1, 0.065);
}

TEST(GlueTags, MovesAndTurnsTagsInTheSheetsPlaneByTheStatedDeviations) {
  const TruthRanges ranges;
  Gripper five;
  five.tentacles = 5;
  const TagLayout drawn = LayOutTags(TentacleDesign{}, five).value();
  std::mt19937_64 random(17);
  double place = 0, turn = 0;
  const TagLayout glued = GlueTags(drawn, ranges, random);
  for (std::size_t i = 0; i < drawn.tags.size(); ++i) {
    const Eigen::Matrix<double, 3, 4>& was = drawn.tags[i].corners_in_sheet;
    const Eigen::Matrix<double, 3, 4>& is = glued.tags[i].corners_in_sheet;
    EXPECT_LT((is - was).row(0).norm(), 1e-15);
    const Vector3 moved = (is - was).rowwise().mean();
    place += moved.squaredNorm() / 2;
    const Vector3 before = was.col(1) - was.col(0), after = is.col(1) - is.col(0);
    EXPECT_NEAR(after.norm(), before.norm(), 1e-12);
    turn += std::pow(std::asin(before.cross(after).x() / before.squaredNorm()), 2);
  }
  const auto count = static_cast<double>(drawn.tags.size());  // 490: a deviation is known to 3.2 %
  EXPECT_NEAR(std::sqrt(place / count) / ranges.tag_place_sd, 1, 0.10);
  EXPECT_NEAR(std::sqrt(turn / count) / ranges.tag_turn_sd, 1, 0.13);
  TruthRanges none;
  none.tag_place_sd = none.tag_turn_sd = 0;
  EXPECT_EQ(GlueTags(drawn, none, random).tags[5].corners_in_sheet, drawn.tags[5].corners_in_sheet);
}

TEST(DrawTruth, TheSameSeedGivesTheSameTrial) {
  const auto tip = [](std::uint64_t seed) {
    return Vector3(ShapeAt(Draw(TruthRanges{}, seed), 10).tentacles[1].centerline.points.col(48));
  };
  EXPECT_EQ(tip(5), tip(5));
  EXPECT_GT((tip(5) - tip(6)).norm(), 1e-4);
}

TEST(DrawTruth, BadInputIsNamed) {
  std::mt19937_64 random(1);
  const auto message = [&](const TentacleDesign& design, const TruthRanges& ranges) {
    const auto truth = DrawTruth(design, Gripper{}, TrueFold{}, PullCommand{}, {}, ranges, random);
    return truth.ok() ? std::string() : truth.error().message;
  };
  TruthRanges ranges;
  ranges.stiffness_sd = -1;
  EXPECT_NE(message({}, ranges).find("stiffness_sd"), std::string::npos);
  ranges = {};
  ranges.position_sd = 0.01;
  EXPECT_NE(message({}, ranges).find("position_sd"), std::string::npos);
  TentacleDesign design;
  design.length = -1;
  EXPECT_FALSE(message(design, {}).empty());
}

TEST(DrawTruth, APullBeyondReachIsAnErrorNotACrash) {
  VirtualTruth truth = Draw(Exact(), 1, {4, 1, 1});  // effective pull 1.2
  const auto shape = TrueShapeAt(truth, 100);
  ASSERT_FALSE(shape.ok());
  EXPECT_EQ(shape.error().kind, ErrorKind::kUnreachable);
}

TEST(PortableRandom, HasTheMomentsOfItsDistributions) {
  std::mt19937_64 random(1);
  double mean = 0, square = 0, fourth = 0;
  const int n = 200000;
  for (int i = 0; i < n; ++i) {
    const double x = DrawNormal(random, 1);
    mean += x / n;
    square += x * x / n;
    fourth += x * x * x * x / n;
  }
  EXPECT_NEAR(mean, 0, 4 / std::sqrt(n));
  EXPECT_NEAR(square, 1, 4 * std::sqrt(2.0 / n));
  EXPECT_NEAR(fourth, 3, 4 * std::sqrt(96.0 / n));
}

}  // namespace
}  // namespace tendril
