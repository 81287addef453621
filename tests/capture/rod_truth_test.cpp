// capture/rig/rod_truth.h: a rod at rest gives the fold model's own shape; a rod that something bends takes
// the holes with it.
#include "capture/rig/rod_truth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "model/fold/facet_chain.h"
#include "model/fold/fold.h"
#include "model/geometry/rotation.h"
#include "tests/support/entangled.h"

namespace tendril {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TruthRanges NothingDrawn() {
  TruthRanges r;
  r.position_sd = r.crease_angle_sd = r.stiffness_sd = r.facet_bend_sd = r.largest_sag_compliance = 0;
  r.base_position_sd = r.base_angle_sd = r.largest_delay = r.rate_perturbation = 0;
  r.object_position_sd = r.object_angle_sd = 0;
  return r;
}

Gripper Pair() {
  Gripper gripper;
  gripper.tentacles = 2;
  return gripper;
}

VirtualTruth Draw(const TruthRanges& ranges) {
  std::mt19937_64 random(1);
  auto truth =
      DrawTruth(TentacleDesign{}, Pair(), {1, 1, 1}, PullCommand{}, VirtualCylinder{}, ranges, random);
  EXPECT_TRUE(truth.ok()) << truth.error().message;
  return std::move(truth).value();
}

// The rest curve with more turning, `more` about its own directors per piece, rad.
FramedCurve Bent(const FramedCurve& rest, const Vector3d& more) {
  FramedCurve curve = rest;
  const Eigen::Index pieces = rest.points.cols() - 1;
  Matrix3d turned = Matrix3d::Identity();
  std::vector<Matrix3d> turns;
  for (Eigen::Index i = 0; i < pieces; ++i) {
    const Vector3d step = rest.points.col(i + 1) - rest.points.col(i);
    const Vector3d d3 = step.normalized();
    const Vector3d n = rest.normals.col(i) + rest.normals.col(i + 1);
    Matrix3d frame;
    frame.col(0) = (n - n.dot(d3) * d3).normalized();
    frame.col(2) = d3;
    frame.col(1) = d3.cross(Vector3d(frame.col(0)));
    turned = turned * frame * ExpSo3(more) * frame.transpose();
    turns.push_back(turned);
    curve.points.col(i + 1) = curve.points.col(i) + turned * step;
  }
  for (Eigen::Index i = 0; i <= pieces; ++i) {
    const Matrix3d& before = turns[static_cast<std::size_t>(std::max<Eigen::Index>(i - 1, 0))];
    const Matrix3d& after = turns[static_cast<std::size_t>(std::min<Eigen::Index>(i, pieces - 1))];
    const Vector3d n = rest.normals.col(i);
    curve.normals.col(i) = (before * n + after * n).normalized();
  }
  return curve;
}

struct OnRods {
  std::vector<RodShape> rods;
  TrueShape shape;
};

OnRods Shape(const VirtualTruth& truth, double pull, const Vector3d& more) {
  OnRods on;
  for (int i = 0; i < 2; ++i) {
    const TentacleDesign design = DesignOfTentacle(Pair(), truth.design, i);
    const FramedCurve rest = RodAtRest(LayOut(design).value(), SolveFold(design, pull).value().angle, pull,
                                       100, LabFromTentacle(Pair(), i));
    on.rods.push_back({pull, pull, Bent(rest, more)});
  }
  auto shape = TrueShapeOnRods(truth, Pair(), on.rods, 0);
  EXPECT_TRUE(shape.ok()) << shape.error().message;
  on.shape = std::move(shape).value();
  return on;
}

double FarthestFromRod(const TentacleDesign& design, const OnRods& on, int tentacle) {
  const auto i = static_cast<std::size_t>(tentacle);
  return testing_support::DistancesFromRod(LayOut(design).value(), on.rods[i].curve.points,
                                           on.shape.tentacles[i].centerline.points)
      .maxCoeff();
}

TEST(TrueShapeOnRods, ARodAtRestIsTheFoldModel) {
  const VirtualTruth truth = Draw(NothingDrawn());
  for (const double pull : {0.0, 0.1, 0.3}) {
    const OnRods on = Shape(truth, pull, Vector3d::Zero());
    for (int i = 0; i < 2; ++i) {
      const TentacleDesign design = DesignOfTentacle(Pair(), truth.design, i);
      const TentacleLayout layout = LayOut(design).value();
      const Eigen::VectorXd angle = SolveFold(design, pull).value().angle;
      const FramedCurve model = NodesAtHoles(TendonCurveOf(layout, FoldChain(layout, angle), angle));
      const Eigen::Matrix3Xd holes = (LabFromTentacle(Pair(), i) * model.points).eval();
      const auto& made = on.shape.tentacles[static_cast<std::size_t>(i)];
      EXPECT_LT((made.centerline.points - holes).cwiseAbs().maxCoeff(), 1e-10) << "pull " << pull;
      EXPECT_LT((made.fold_angle - angle).cwiseAbs().maxCoeff(), 1e-10) << "pull " << pull;
    }
  }
}

TEST(TrueShapeOnRods, HolesFollowARodThatIsBentAnyWay) {
  const VirtualTruth truth = Draw(NothingDrawn());
  for (const double pull : {0.1, 0.2, 0.3}) {
    const double at_rest = FarthestFromRod(TentacleDesign{}, Shape(truth, pull, Vector3d::Zero()), 0);
    for (const Vector3d& more : {Vector3d(0.01, 0, 0), Vector3d(0, -0.01, 0), Vector3d(0, 0, 0.01)}) {
      const double bent = FarthestFromRod(TentacleDesign{}, Shape(truth, pull, more), 0);  // 1 rad in all
      // The rest curvature is the fold's smoothed over two holes; that is what is off at rest.
      EXPECT_LT(at_rest, 0.004) << "pull " << pull;
      EXPECT_LT(bent, at_rest + 0.0015) << "pull " << pull << ", turned " << more.transpose();
    }
  }
}

TEST(TrueShapeOnRods, TurningBeyondTheFoldIsAllFoundAgain) {
  // Directions, not places: facets are turned by what the rod is turned by.
  const VirtualTruth truth = Draw(NothingDrawn());
  const OnRods rest = Shape(truth, 0.2, Vector3d::Zero());
  const OnRods bent = Shape(truth, 0.2, Vector3d(0.004, 0.006, -0.005));
  const auto middle = [](const OnRods& on) {
    return Matrix3d(on.shape.tentacles[0].strips[48 * 3 + 1].lab_from_sheet.linear());
  };
  const auto end = [](const OnRods& on) {
    const FramedCurve& c = on.rods[0].curve;
    Matrix3d f;
    f.col(2) = (c.points.col(100) - c.points.col(99)).normalized();
    const Vector3d n = c.normals.col(99) + c.normals.col(100);
    f.col(0) = (n - n.dot(f.col(2)) * f.col(2)).normalized();
    f.col(1) = f.col(2).cross(f.col(0));
    return f;
  };
  const Matrix3d of_facet = middle(bent) * middle(rest).transpose();
  const Matrix3d of_rod = end(bent) * end(rest).transpose();
  // The last hole lies two pieces before the rod's end, which turn by 0.009 rad each.
  EXPECT_LT(LogSo3(Matrix3d(of_facet.transpose() * of_rod)).norm(), 0.03);
  EXPECT_GT(LogSo3(of_rod).norm(), 0.3);
}

TEST(TrueShapeOnRods, ARodThatDoesNotSuitIsNamed) {
  const VirtualTruth truth = Draw(NothingDrawn());
  OnRods on = Shape(truth, 0.2, Vector3d::Zero());
  std::vector<RodShape> one(on.rods.begin(), on.rods.begin() + 1);
  EXPECT_EQ(TrueShapeOnRods(truth, Pair(), one, 0).error().message,
            "virtual rig: 1 rods for 2 tentacles; expected one each");
  on.rods[1].curve.points(0, 3) = std::nan("");
  EXPECT_NE(TrueShapeOnRods(truth, Pair(), on.rods, 0).error().message.find("rod 1"), std::string::npos);
}

}  // namespace
}  // namespace tendril
