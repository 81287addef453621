// model/fold/facet_chain.h: rigid facets, the tendon's frames, closed limits and mirror images.
#include "model/fold/facet_chain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "model/fold/facet_overlap.h"
#include "model/fold/fold.h"
#include "model/geometry/rotation.h"

namespace tendril {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

struct Folded {
  TentacleLayout layout;
  Fold fold;
  FacetChain chain;
  TendonCurve curve;
};

Folded FoldAt(const TentacleDesign& design, double pull) {
  Folded folded;
  folded.layout = LayOut(design).value();
  folded.fold = SolveFold(folded.layout, design.base_width, design.closed_angle, pull).value();
  folded.chain = FoldChain(folded.layout, folded.fold.angle);
  folded.curve = TendonCurveOf(folded.layout, folded.chain, folded.fold.angle);
  return folded;
}

TentacleDesign RandomDesign(std::mt19937_64& random) {
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  TentacleDesign design;
  design.holes = static_cast<int>(uniform(2, 60));
  design.length = design.unit_length * 0.5 * (design.holes + 2);
  design.taper = uniform(0.05, 1);
  design.spacing_ratio = uniform(0.05, 1);
  design.alpha = uniform(15, 165) * kDegree;
  design.beta = uniform(15, 165) * kDegree;
  return design;
}

TEST(FacetChain, FacetsAreMovedRigidlyAndShareTheirCreases) {
  std::mt19937_64 random(11);
  for (int trial = 0; trial < 100; ++trial) {
    const Folded f = FoldAt(RandomDesign(random), std::uniform_real_distribution<double>(0, 1)(random));
    for (size_t i = 0; i < f.chain.tentacle_from_sheet.size(); ++i) {
      const Eigen::Isometry3d& pose = f.chain.tentacle_from_sheet[i];
      EXPECT_LT((pose.linear() * pose.linear().transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-13);
      EXPECT_NEAR(pose.linear().determinant(), 1, 1e-13);
      const Eigen::Matrix3Xd& flat = f.layout.facets[i];
      const Eigen::Matrix3Xd folded = (pose.linear() * flat).colwise() + pose.translation();
      for (int c = 0; c < 4; ++c) {
        EXPECT_NEAR((folded.col(c) - folded.col((c + 1) % 4)).norm(),
                    (flat.col(c) - flat.col((c + 1) % 4)).norm(), 1e-12);
      }
      if (i == 0) continue;
      const Eigen::Isometry3d& before = f.chain.tentacle_from_sheet[i - 1];
      EXPECT_LT((before * flat.col(0) - folded.col(0)).norm(), 1e-13);
      EXPECT_LT((before * flat.col(1) - folded.col(1)).norm(), 1e-13);
      const double bend = std::acos(std::clamp(before.linear().col(0).dot(pose.linear().col(0)), -1.0, 1.0));
      EXPECT_NEAR(bend, 2 * f.fold.angle[static_cast<int>(i) - 1], 1e-7);  // acos halves the digits
    }
  }
}

TEST(FacetChain, CreaseZeroIsAMountainSeenFromPlusX) {
  TentacleDesign design;
  const TentacleLayout layout = LayOut(design).value();
  Eigen::VectorXd angle = Eigen::VectorXd::Zero(48);
  angle[0] = 0.3;
  const FacetChain chain = FoldChain(layout, angle);
  // Facet 0 sees the rest turn towards its -x, and its z axis leans to +x of the chord.
  const Eigen::Matrix3d first_from_second =
      chain.tentacle_from_sheet[0].linear().transpose() * chain.tentacle_from_sheet[1].linear();
  EXPECT_NEAR(first_from_second(0, 2), -std::sin(0.6), 1e-15);
  EXPECT_NEAR(first_from_second(2, 2), std::cos(0.6), 1e-15);
}

TEST(TendonCurve, HoleToHoleDistanceIsTheRigidFacetsOwn) {
  std::mt19937_64 random(12);
  for (int trial = 0; trial < 100; ++trial) {
    const TentacleDesign design = RandomDesign(random);
    const Folded f = FoldAt(design, std::uniform_real_distribution<double>(0, 1)(random));
    for (Eigen::Index i = 0; i < f.curve.segment_length.size(); ++i) {
      const double sine = std::sin(f.layout.crease_angle[i]) * std::sin(f.fold.angle[i]);
      const double expected = 2 * f.layout.half_spacing[i] * std::sqrt(std::max(0.0, 1 - sine * sine));
      EXPECT_NEAR((f.curve.holes.col(i + 1) - f.curve.holes.col(i)).norm(), expected, 1e-13);
      EXPECT_NEAR(f.curve.segment_length[i], expected, 1e-13);
    }
  }
}

TEST(TendonCurve, DirectorsAreTheChordAndTheMeanNormalWhileFacetsAreOpen) {
  std::mt19937_64 random(13);
  for (int trial = 0; trial < 50; ++trial) {
    const Folded f = FoldAt(RandomDesign(random), std::uniform_real_distribution<double>(0.01, 0.6)(random));
    for (Eigen::Index i = 0; i < f.curve.segment_length.size(); ++i) {
      if (f.fold.angle[i] > 1.5 || f.curve.segment_length[i] < 1e-4) continue;
      const Eigen::Vector3d d3 = (f.curve.holes.col(i + 1) - f.curve.holes.col(i)).normalized();
      Eigen::Vector3d d1 =
          f.chain.tentacle_from_sheet[i].linear().col(0) + f.chain.tentacle_from_sheet[i + 1].linear().col(0);
      d1 = (d1 - d1.dot(d3) * d3).normalized();
      EXPECT_LT((f.curve.frames[i].row(2).transpose() - d3).norm(), 1e-10);
      EXPECT_LT((f.curve.frames[i].row(0).transpose() - d1).norm(), 1e-10);
      EXPECT_LT((f.curve.frames[i].row(1).transpose() - d3.cross(d1)).norm(), 1e-10);
    }
  }
}

TEST(TendonCurve, TurningIsMinusTheLogOfTheFramesAndIntegratesBackToTheHoles) {
  std::mt19937_64 random(14);
  for (int trial = 0; trial < 60; ++trial) {
    for (const double pull : {1e-12, 0.3, 0.6, 0.95, 1.0}) {
      const Folded f = FoldAt(trial == 0 ? TentacleDesign{} : RandomDesign(random), pull);
      Eigen::Matrix3d directors = Eigen::Matrix3d::Identity();  // columns
      Eigen::Vector3d hole = Eigen::Vector3d::Zero();
      for (Eigen::Index i = 0; i < f.curve.segment_length.size(); ++i) {
        if (i > 0) {
          directors = directors * ExpSo3(f.curve.turning.col(i - 1));
          const Eigen::Matrix3d step = f.curve.frames[i] * f.curve.frames[i - 1].transpose();
          // exp(-turning) = Q_{i+1} Q_i^T, whichever of the two logs a half turn has.
          EXPECT_LT((ExpSo3(-f.curve.turning.col(i - 1)) - step).norm(), 1e-12);
        }
        hole += f.curve.segment_length[i] * directors.col(2);
        EXPECT_LT((hole - f.curve.holes.col(i + 1)).norm(), 1e-12) << "pull " << pull << " hole " << i + 1;
        EXPECT_LT((directors.transpose() - f.curve.frames[i]).norm(), 1e-12);
      }
    }
  }
}

TEST(TendonCurve, StartsAtTheOriginAlongZWithItsNormalAlongX) {
  std::mt19937_64 random(15);
  for (int trial = 0; trial < 40; ++trial) {
    const Folded f = FoldAt(RandomDesign(random), trial / 39.0);
    EXPECT_LT(f.curve.holes.col(0).norm(), 1e-15);
    EXPECT_LT((f.curve.frames[0] - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(TendonCurve, ClosedPerpendicularCreasesHaveLengthZeroAndTheLimitsFrame) {
  TentacleDesign design;
  design.beta = std::numbers::pi / 2;
  const Folded closed = FoldAt(design, 1);
  EXPECT_EQ(closed.curve.segment_length.maxCoeff(), 0);
  const Folded nearly = FoldAt(design, 1 - 1e-13);
  for (size_t i = 0; i < closed.curve.frames.size(); ++i) {
    EXPECT_LT((closed.curve.frames[i] - nearly.curve.frames[i]).norm(), 1e-6) << i;
  }
  EXPECT_TRUE(NodesAtHoles(closed.curve).normals.allFinite());
}

TEST(TendonCurve, SmallAnglesKeepTheirDigits) {
  // For phi -> 0 the turning is phi_{i+1} u_{i+1} - phi_i u_i to first order: nothing else is left of it.
  for (const double pull : {1e-300, 1e-40, 1e-20}) {
    const Folded f = FoldAt({}, pull);
    for (Eigen::Index i = 1; i < f.fold.angle.size(); ++i) {
      Eigen::Vector3d expected = Eigen::Vector3d::Zero();
      for (const Eigen::Index j : {i - 1, i}) {
        const double signed_angle = (j % 2 == 0 ? -1 : 1) * f.fold.angle[j];
        expected += signed_angle * Eigen::Vector3d(0, std::sin(f.layout.crease_angle[j]),
                                                   std::cos(f.layout.crease_angle[j]));
      }
      const Eigen::Vector3d turning = f.curve.turning.col(i - 1);
      EXPECT_NEAR(turning.y() / expected.y(), 1, 1e-9) << pull;
      EXPECT_NEAR(turning.z() / expected.z(), 1, 1e-9) << pull;
    }
  }
}

TEST(TendonCurve, AMirrorDesignIsTheMirrorImage) {
  std::mt19937_64 random(16);
  const Eigen::Vector3d mirror(1, -1, 1);  // in the plane y = 0
  for (int trial = 0; trial < 30; ++trial) {
    const TentacleDesign design = RandomDesign(random);
    const double pull = std::uniform_real_distribution<double>(0, 0.9)(random);
    const Folded f = FoldAt(design, pull);
    const Folded m = FoldAt(Mirrored(design), pull);
    EXPECT_LT((mirror.asDiagonal() * f.curve.holes - m.curve.holes).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(TendonCurve, UnevenCreasesKeepTheirChordToo) {
  TentacleLayout layout = LayOut({}).value();
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> shift(-1e-3, 1e-3);
  for (double& z : layout.crease_z) z += shift(random);
  const Eigen::VectorXd angle = Eigen::VectorXd::Constant(48, 0.5);
  const TendonCurve curve = TendonCurveOf(layout, FoldChain(layout, angle), angle);
  for (Eigen::Index i = 0; i < 48; ++i) {
    const Eigen::Vector3d chord = curve.holes.col(i + 1) - curve.holes.col(i);
    EXPECT_NEAR(curve.segment_length[i], chord.norm(), 1e-14);
    EXPECT_LT((curve.frames[i].row(2).transpose() - chord.normalized()).norm(), 1e-12);
    EXPECT_LT((curve.frames[i] * curve.frames[i].transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-13);
  }
}

TEST(NodesAtHoles, NormalsAreUnitVectorsAcrossTheMeanTangentAtEveryExtreme) {
  for (const double alpha : {15.0, 90.0, 165.0}) {
    for (const double beta : {15.0, 90.0, 165.0}) {
      for (const double pull : {0.0, 1e-300, 0.5, std::nextafter(1.0, 0.0), 1.0}) {
        TentacleDesign design;
        design.alpha = alpha * kDegree;
        design.beta = beta * kDegree;
        const Folded f = FoldAt(design, pull);
        const FramedCurve nodes = NodesAtHoles(f.curve);
        ASSERT_TRUE(nodes.points.allFinite() && nodes.normals.allFinite());
        EXPECT_LT((nodes.normals.colwise().norm().array() - 1).abs().maxCoeff(), 1e-12);
        for (Eigen::Index i = 1; i + 1 < nodes.points.cols(); ++i) {
          const Eigen::Vector3d tangent =
              (f.curve.frames[i - 1].row(2) + f.curve.frames[i].row(2)).transpose();
          EXPECT_NEAR(nodes.normals.col(i).dot(tangent), 0, 1e-9) << alpha << ' ' << beta << ' ' << pull;
        }
      }
    }
  }
}

TEST(KinematicPull, PublishedValueOfThePapersDesign) {
  EXPECT_NEAR(KinematicPull(FoldAt({}, 0.3).layout, FoldAt({}, 0.3).curve), 0.297, 5e-4);
  TentacleDesign perpendicular;
  perpendicular.beta = std::numbers::pi / 2;
  const Folded f = FoldAt(perpendicular, 0.3);
  EXPECT_NEAR(KinematicPull(f.layout, f.curve), 0.3, 1e-14);
}

TEST(OverlappingFacets, PublishedCounts) {
  EXPECT_EQ(OverlappingFacets(FoldAt({}, 0.30).layout, FoldAt({}, 0.30).chain).size(), 0u);
  EXPECT_EQ(OverlappingFacets(FoldAt({}, 0.40).layout, FoldAt({}, 0.40).chain).size(), 9u);
  TentacleDesign bending;
  bending.beta = std::numbers::pi / 2;
  EXPECT_EQ(OverlappingFacets(FoldAt(bending, 0.1).layout, FoldAt(bending, 0.1).chain).size(), 0u);
  EXPECT_GT(OverlappingFacets(FoldAt(bending, 0.2).layout, FoldAt(bending, 0.2).chain).size(), 0u);
}

TEST(FoldChain, ReusedStorageGivesTheSameBits) {
  const Folded f = FoldAt({}, 0.3);
  FacetChain chain = FoldAt({}, 0.7).chain;
  TendonCurve curve = FoldAt({}, 0.7).curve;
  FoldChain(f.layout, f.fold.angle, chain);
  TendonCurveOf(f.layout, chain, f.fold.angle, curve);
  EXPECT_EQ(curve.holes, f.curve.holes);
  EXPECT_EQ(curve.turning, f.curve.turning);
}

// A unit of two creases at angles that differ by delta, folded by phi1 and phi2 in opposite senses, turns by
// theta with cos(theta / 2) = cos phi1 cos phi2 + sin phi1 sin phi2 cos delta; folded alike by 4 asin(sin phi
// sin(delta / 2)).
TEST(FoldChain, AUnitsNetRotationIsTheClosedForm) {
  for (const double alpha : {86.0, 90.0, 140.0}) {
    for (const double delta : {0.0, 1e-6, 15.0, 70.0, -15.0}) {
      for (const auto& [first, second] : {std::pair{0.3, 0.3}, {1.2, 0.4}, {1e-5, 1.5}, {1.4, 1.4}}) {
        TentacleDesign design;
        design.holes = 3;
        design.alpha = alpha * std::numbers::pi / 180;
        design.beta = (alpha - delta) * std::numbers::pi / 180;
        const FacetChain chain = FoldChain(LayOut(design).value(), Eigen::Vector2d(first, second));
        const Eigen::Matrix3d turn =
            chain.tentacle_from_sheet[0].linear().transpose() * chain.tentacle_from_sheet[2].linear();
        const double theta = LogSo3(turn).norm();
        const double d = delta * std::numbers::pi / 180;
        EXPECT_NEAR(std::cos(0.5 * theta),
                    std::cos(first) * std::cos(second) + std::sin(first) * std::sin(second) * std::cos(d),
                    1e-14);
        if (first == second) {
          EXPECT_NEAR(theta, 4 * std::asin(std::sin(first) * std::sin(0.5 * std::abs(d))), 1e-14);
        }
      }
    }
  }
}

}  // namespace
}  // namespace tendril
