#include "capture/rig/folded_views.h"

#include <array>
#include <cmath>

#include "capture/rig/tag_views.h"
#include "model/fold/facet_chain.h"

namespace tendril {
namespace {

// A facet as something that may stand before others.
struct Screen {
  size_t tentacle = 0;
  size_t facet = 0;
  Eigen::Isometry3d sheet_from_lab;
  double low = 0, high = 0;  // along the sheet, m
  Eigen::Vector3d middle;    // lab
  double radius = 0;         // of a ball about the middle that holds it, m
};

std::vector<Screen> ScreensOf(std::span<const FoldedTentacle> tentacles) {
  std::vector<Screen> screens;
  for (size_t t = 0; t < tentacles.size(); ++t) {
    const FoldedTentacle& tentacle = tentacles[t];
    const TentacleLayout& layout = tentacle.layout;
    const auto facets = static_cast<Eigen::Index>(tentacle.lab_from_sheet.size());
    for (Eigen::Index i = 0; i < facets; ++i) {
      const Eigen::Isometry3d& lab_from_sheet = tentacle.lab_from_sheet[static_cast<size_t>(i)];
      Screen screen{.tentacle = t,
                    .facet = static_cast<size_t>(i),
                    .sheet_from_lab = lab_from_sheet.inverse(),
                    .low = i == 0 ? layout.base_z : layout.crease_z[i - 1],
                    .high = i + 1 == facets ? layout.tip_z : layout.crease_z[i],
                    .middle = {}};
      screen.middle = lab_from_sheet * Eigen::Vector3d(0, 0, 0.5 * (screen.low + screen.high));
      screen.radius =
          0.5 * std::hypot(screen.high - screen.low, WidthAt(tentacle.design, layout, screen.low));
      screens.push_back(screen);
    }
  }
  return screens;
}

bool Covers(const Screen& screen, const FoldedTentacle& tentacle, const Eigen::Vector3d& from_in_lab,
            const Eigen::Vector3d& to_in_lab) {
  const Eigen::Vector3d from = screen.sheet_from_lab * from_in_lab;
  const Eigen::Vector3d to = screen.sheet_from_lab * to_in_lab;
  if ((from.x() > 0) == (to.x() > 0)) return false;
  const double share = from.x() / (from.x() - to.x());
  const Eigen::Vector3d at = from + share * (to - from);
  if (at.z() < screen.low || at.z() > screen.high) return false;
  return std::abs(at.y()) < 0.5 * WidthAt(tentacle.design, tentacle.layout, at.z());
}

bool Hidden(const TagPlace& tag, const std::array<Eigen::Vector3d, 5>& points, const Eigen::Vector3d& eye,
            std::span<const FoldedTentacle> tentacles, const std::vector<Screen>& screens) {
  std::array<bool, 5> covered{};
  const Eigen::Vector3d ray = eye - points[0];
  const double distance = ray.norm();
  for (const Screen& screen : screens) {
    if (screen.tentacle == static_cast<size_t>(tag.tentacle) &&
        screen.facet == static_cast<size_t>(tag.facet))
      continue;
    // Far from the line of sight: most of them.
    const Eigen::Vector3d aside = screen.middle - points[0];
    const double along = aside.dot(ray) / distance;
    const double reach = screen.radius + tag.footprint;
    if (along < -reach || aside.squaredNorm() - along * along > reach * reach) continue;
    for (size_t i = 0; i < points.size(); ++i) {
      covered[i] = covered[i] || Covers(screen, tentacles[screen.tentacle], points[i], eye);
    }
  }
  return covered[0] || covered[1] + covered[2] + covered[3] + covered[4] > 1;
}

}  // namespace

FoldedTentacle LayOnCurve(const TentacleDesign& design, const TentacleLayout& layout,
                          const Eigen::VectorXd& angle, const FramedCurve& curve) {
  FoldedTentacle folded{design, layout, {}};
  if (angle.size() != layout.crease_z.size() || !angle.allFinite() ||
      curve.points.cols() != layout.hole_z.size()) {
    return folded;
  }
  const FacetChain chain = FoldChain(layout, angle);
  Eigen::Matrix3Xd model(3, curve.points.cols());
  Eigen::Matrix3Xd known(3, curve.points.cols());
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < curve.points.cols(); ++i) {
    if (!curve.points.col(i).allFinite()) continue;
    model.col(count) =
        chain.tentacle_from_sheet[static_cast<size_t>(i)] * Eigen::Vector3d(0, 0, layout.hole_z[i]);
    known.col(count++) = curve.points.col(i);
  }
  if (count < 4) return folded;
  const Eigen::Isometry3d lab_from_tentacle(
      Eigen::umeyama(model.leftCols(count), known.leftCols(count), /*with_scaling=*/false));
  for (const Eigen::Isometry3d& facet : chain.tentacle_from_sheet) {
    folded.lab_from_sheet.push_back(lab_from_tentacle * facet);
  }
  return folded;
}

std::vector<Eigen::VectorXi> FacetsSeen(std::span<const FoldedTentacle> tentacles, const TagLayout& tags,
                                        int modules, const Camera& camera) {
  std::vector<Eigen::VectorXi> seen;
  for (const FoldedTentacle& tentacle : tentacles) {
    seen.push_back(Eigen::VectorXi::Zero(tentacle.layout.hole_z.size()));
  }
  const std::vector<Screen> screens = ScreensOf(tentacles);
  const Eigen::Vector3d eye = camera.camera_from_lab.inverse().translation();
  for (const TagPlace& tag : tags.tags) {
    if (tag.tentacle < 0 || static_cast<size_t>(tag.tentacle) >= tentacles.size()) continue;
    const FoldedTentacle& tentacle = tentacles[static_cast<size_t>(tag.tentacle)];
    if (static_cast<size_t>(tag.facet) >= tentacle.lab_from_sheet.size()) continue;
    const Eigen::Isometry3d& lab_from_sheet = tentacle.lab_from_sheet[static_cast<size_t>(tag.facet)];
    if (LookAtTag(camera, tag, lab_from_sheet, modules).use > TagUse::kTracked) continue;
    const Eigen::Matrix<double, 3, 4> corners = lab_from_sheet * tag.corners_in_sheet;
    const Eigen::Vector3d center = corners.rowwise().mean();
    const std::array<Eigen::Vector3d, 5> points = {center, corners.col(0), corners.col(1), corners.col(2),
                                                   corners.col(3)};
    if (!Hidden(tag, points, eye, tentacles, screens)) seen[static_cast<size_t>(tag.tentacle)][tag.facet] = 1;
  }
  return seen;
}

}  // namespace tendril
