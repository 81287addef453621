// capture/rig/folded_views.h: flat tentacles are seen as rig/tag_views.h sees them; what folds away is not.
#include "capture/rig/folded_views.h"

#include <gtest/gtest.h>

#include <numbers>

#include "capture/rig/tag_family.h"
#include "capture/rig/tag_views.h"
#include "capture/rig/virtual_rig.h"
#include "model/fold/facet_chain.h"
#include "model/fold/fold.h"

namespace tendril {
namespace {

Gripper Hanging(int tentacles) {
  return {.tentacles = tentacles, .first_azimuth = 0, .tilt = 0, .handedness = Handedness::kSame};
}

FoldedTentacle At(const Gripper& gripper, int tentacle, double pull) {
  const TentacleDesign design = DesignOfTentacle(gripper, {}, tentacle);
  const TentacleLayout layout = LayOut(design).value();
  const Eigen::VectorXd angle = SolveFold(layout, design.base_width, design.closed_angle, pull).value().angle;
  const FacetChain chain = FoldChain(layout, angle);
  FramedCurve curve;
  curve.points.resize(3, layout.hole_z.size());
  for (Eigen::Index i = 0; i < layout.hole_z.size(); ++i) {
    curve.points.col(i) =
        LabFromTentacle(gripper, tentacle) *
        (chain.tentacle_from_sheet[static_cast<size_t>(i)] * Eigen::Vector3d(0, 0, layout.hole_z[i]));
  }
  return LayOnCurve(design, layout, angle, curve);
}

int Modules(const TagLayout& tags) { return FamilyOf(tags.family).value().total_width; }

TEST(FacetsSeen, FlatTentaclesAreSeenAsDesignTagsSaysOrLess) {
  const Gripper gripper = Hanging(2);
  const TagLayout tags = LayOutTags({}, gripper).value();
  const Rig rig = VirtualRig({}, gripper).value();
  const TagSight sight = SeeTags({}, gripper, tags, rig).value();
  const std::vector<FoldedTentacle> tentacles = {At(gripper, 0, 1e-12), At(gripper, 1, 1e-12)};
  int seen = 0, less = 0;
  for (size_t c = 0; c < rig.cameras.size(); ++c) {
    std::vector<Eigen::VectorXi> expected(2, Eigen::VectorXi::Zero(49));
    for (const TagOutlook& view : sight.views) {
      const TagPlace& tag = tags.tags[view.tag];
      if (view.camera == c && view.use <= TagUse::kTracked)
        expected[static_cast<size_t>(tag.tentacle)][tag.facet] = 1;
    }
    const auto found = FacetsSeen(tentacles, tags, Modules(tags), rig.cameras[c]);
    for (size_t t = 0; t < 2; ++t) {
      // Corners count here, not only a tag's middle: a little more is hidden.
      EXPECT_LE((found[t] - expected[t]).maxCoeff(), 0) << "camera " << c << " tentacle " << t;
      seen += expected[t].sum();
      less += (expected[t] - found[t]).sum();
    }
  }
  EXPECT_GT(seen, 49);
  EXPECT_LT(less, 0.1 * seen);
}

TEST(FacetsSeen, WhatStandsBeforeATentacleHidesIt) {
  const Gripper gripper = Hanging(1);
  const TagLayout tags = LayOutTags({}, gripper).value();
  const Rig rig = VirtualRig({}, gripper).value();
  const FoldedTentacle alone = At(gripper, 0, 0.1);
  const std::vector<FoldedTentacle> one = {alone};
  const Eigen::VectorXi open = FacetsSeen(one, tags, Modules(tags), rig.cameras[0])[0];
  ASSERT_GT(open.sum(), 10);
  // A copy of it, three times as wide, 20 mm nearer to the camera.
  FoldedTentacle before = alone;
  before.design.base_width *= 3;
  const Eigen::Vector3d eye = rig.cameras[0].camera_from_lab.inverse().translation();
  for (Eigen::Isometry3d& facet : before.lab_from_sheet) {
    facet.translation() += 0.02 * (eye - facet * Eigen::Vector3d::Zero()).normalized();
  }
  const std::vector<FoldedTentacle> two = {alone, before};
  EXPECT_LT(FacetsSeen(two, tags, Modules(tags), rig.cameras[0])[0].sum(), 0.2 * open.sum());
}

TEST(FacetsSeen, ACameraBehindSeesNothingAndNobodyIsSeenWhereNobodyKnows) {
  const Gripper gripper = Hanging(1);
  const TagLayout tags = LayOutTags({}, gripper).value();
  Camera camera = VirtualRig({}, gripper).value().cameras[0];
  std::vector<FoldedTentacle> one = {At(gripper, 0, 0.1)};
  EXPECT_GT(FacetsSeen(one, tags, Modules(tags), camera)[0].sum(), 0);
  Camera away = camera;
  away.camera_from_lab =
      Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitY()) * camera.camera_from_lab;
  EXPECT_EQ(FacetsSeen(one, tags, Modules(tags), away)[0].sum(), 0);
  one[0].lab_from_sheet.clear();
  EXPECT_EQ(FacetsSeen(one, tags, Modules(tags), camera)[0].sum(), 0);
}

TEST(LayOnCurve, FindsThePoseFromTheNodesThatAreKnown) {
  const Gripper gripper = Hanging(1);
  const FoldedTentacle whole = At(gripper, 0, 0.2);
  const Eigen::VectorXd angle =
      SolveFold(whole.layout, whole.design.base_width, whole.design.closed_angle, 0.2).value().angle;
  FramedCurve curve;
  curve.points.resize(3, 49);
  for (Eigen::Index i = 0; i < 49; ++i) {
    curve.points.col(i) =
        whole.lab_from_sheet[static_cast<size_t>(i)] * Eigen::Vector3d(0, 0, whole.layout.hole_z[i]);
    if (i % 3 == 0) curve.points.col(i).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  const FoldedTentacle found = LayOnCurve(whole.design, whole.layout, angle, curve);
  ASSERT_EQ(found.lab_from_sheet.size(), 49u);
  for (size_t i = 0; i < 49; ++i) {
    EXPECT_LT((found.lab_from_sheet[i].matrix() - whole.lab_from_sheet[i].matrix()).cwiseAbs().maxCoeff(),
              1e-9);
  }
  curve.points.leftCols(47).setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(LayOnCurve(whole.design, whole.layout, angle, curve).lab_from_sheet.empty());
  EXPECT_TRUE(LayOnCurve(whole.design, whole.layout, Eigen::VectorXd(), curve).lab_from_sheet.empty());
}

}  // namespace
}  // namespace tendril
