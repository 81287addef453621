#include "capture/rig/tag_views.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "capture/rig/tag_family.h"
#include "model/fold/facet_chain.h"

namespace tendril {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double k45 = std::numbers::pi / 4;
constexpr double k60 = std::numbers::pi / 3;

// A straight tentacle: one flat strip.
struct Strip {
  Eigen::Isometry3d lab_from_sheet;
  TentacleLayout layout;
  TentacleDesign design;
};

bool Blocks(const Strip& strip, const Eigen::Vector3d& from_in_lab, const Eigen::Vector3d& to_in_lab) {
  const Eigen::Isometry3d sheet_from_lab = strip.lab_from_sheet.inverse();
  const Eigen::Vector3d from = sheet_from_lab * from_in_lab;
  const Eigen::Vector3d to = sheet_from_lab * to_in_lab;
  if ((from.x() > 0) == (to.x() > 0)) return false;
  const double share = from.x() / (from.x() - to.x());
  const Eigen::Vector3d at = from + share * (to - from);
  if (at.z() < strip.layout.base_z || at.z() > strip.layout.tip_z) return false;
  return std::abs(at.y()) < 0.5 * WidthAt(strip.design, strip.layout, at.z());
}

struct Glued {
  Eigen::Vector3d center, right, up, normal;     // lab; unit vectors but for the centre
  std::vector<Eigen::Vector3d> printed_corners;  // lab
};

Glued GluedAt(const TagPlace& tag, const Eigen::Isometry3d& lab_from_sheet) {
  const Eigen::Matrix<double, 3, 4> corners = lab_from_sheet * tag.corners_in_sheet;
  Glued glued;
  glued.center = corners.rowwise().mean();
  glued.right = (corners.col(1) - corners.col(0)).normalized();
  glued.up = (corners.col(3) - corners.col(0)).normalized();
  glued.normal = glued.right.cross(glued.up);
  const double half = 0.5 * tag.footprint;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    glued.printed_corners.emplace_back(glued.center + half * (x * glued.right + y * glued.up));
  }
  return glued;
}

bool InPicture(const Camera& camera, const Eigen::Vector3d& point) {
  const auto px = Project(camera, point);
  return px && px->x() >= -0.5 && px->y() >= -0.5 && px->x() <= camera.width_px - 0.5 &&
         px->y() <= camera.height_px - 0.5;
}

// Pixels per metre along two directions at a point, by central differences; none behind the camera.
std::optional<Eigen::Matrix2d> PxPerMetre(const Camera& camera, const Eigen::Vector3d& at,
                                          const Eigen::Vector3d& first, const Eigen::Vector3d& second) {
  constexpr double kStep = 1e-5;  // m
  Eigen::Matrix2d slope;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector3d step = kStep * (i == 0 ? first : second);
    const auto ahead = Project(camera, at + step);
    const auto behind = Project(camera, at - step);
    if (!ahead || !behind) return std::nullopt;
    slope.col(i) = (*ahead - *behind) / (2 * kStep);
  }
  return slope;
}

TagOutlook ViewOf(const Camera& camera, const Glued& tag, double module, int modules) {
  TagOutlook view;
  const Eigen::Vector3d eye = camera.camera_from_lab.inverse().translation();
  const Eigen::Vector3d ray = (tag.center - eye).normalized();
  const Eigen::Vector3d side = ray.unitOrthogonal();
  const auto frontal = PxPerMetre(camera, tag.center, side, ray.cross(side));
  const auto tilted = PxPerMetre(camera, tag.center, tag.right, tag.up);
  view.tilt = std::acos(std::clamp(-ray.dot(tag.normal), -1.0, 1.0));
  view.m_per_px = kNan;
  if (!frontal || !tilted) return view;
  // A lens stretches a little more along the radius than across it: the area's root stands for both.
  const double px_per_m = std::sqrt(std::abs(frontal->determinant()));
  view.m_per_px = 1 / px_per_m;
  view.module_px = module * px_per_m;
  view.least_module_px = module * Eigen::JacobiSVD<Eigen::Matrix2d>(*tilted).singularValues()[1];
  if (view.tilt >= std::numbers::pi / 2) {
    view.use = TagUse::kTurnedAway;
    return view;
  }
  for (const Eigen::Vector3d& corner : tag.printed_corners) {
    if (!InPicture(camera, corner)) return view;
  }
  view.use = UseOf(view.module_px, modules, view.tilt);
  return view;
}

double WidestAngle(const Rig& rig, const Eigen::Vector3d& middle) {
  double widest = 0;
  for (size_t a = 0; a < rig.cameras.size(); ++a) {
    for (size_t b = a + 1; b < rig.cameras.size(); ++b) {
      const Eigen::Vector3d to_a = rig.cameras[a].camera_from_lab.inverse().translation() - middle;
      const Eigen::Vector3d to_b = rig.cameras[b].camera_from_lab.inverse().translation() - middle;
      widest = std::max(widest, std::atan2(to_a.cross(to_b).norm(), to_a.dot(to_b)));
    }
  }
  return widest;
}

void Count(const TagOutlook& view, CameraSight& sight) {
  ++sight.count[static_cast<size_t>(view.use)];
  if (!(view.m_per_px > 0)) return;
  sight.nearest_m_per_px = std::fmin(sight.nearest_m_per_px, view.m_per_px);
  sight.farthest_m_per_px = std::fmax(sight.farthest_m_per_px, view.m_per_px);
  sight.least_module_px = std::fmin(sight.least_module_px, view.module_px);
  sight.largest_module_px = std::fmax(sight.largest_module_px, view.module_px);
}

}  // namespace

std::string NameOf(TagUse use) {
  constexpr const char* kNames[] = {"decoded", "tracked", "unsure", "hidden", "turned away", "outside"};
  return kNames[static_cast<size_t>(use)];
}

double DecodeLimitPx(double tilt) {
  if (tilt <= k45) return 2 + tilt / k45;
  return 3 * std::cos(k45) / std::max(std::cos(tilt), 1e-9);
}

TagUse UseOf(double module_px, int modules, double tilt) {
  if (module_px >= DecodeLimitPx(tilt)) return TagUse::kDecoded;
  if (module_px * modules >= 20 && tilt <= k60) return TagUse::kTracked;
  return TagUse::kUnsure;
}

TagOutlook LookAtTag(const Camera& camera, const TagPlace& tag, const Eigen::Isometry3d& lab_from_sheet,
                     int modules) {
  return ViewOf(camera, GluedAt(tag, lab_from_sheet), tag.footprint / modules, modules);
}

Result<TagSight> SeeTags(const TentacleDesign& design, const Gripper& gripper, const TagLayout& tags,
                         const Rig& rig) {
  if (rig.cameras.empty()) return Error{ErrorKind::kBadInput, "the rig has no camera; expected one or more"};
  const auto family = FamilyOf(tags.family);
  if (!family.ok()) return family.error();
  const int modules = family.value().total_width;
  std::vector<Strip> strips;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (int i = 0; i < gripper.tentacles; ++i) {
    const TentacleDesign own = DesignOfTentacle(gripper, design, i);
    auto layout = LayOut(own);
    if (!layout.ok()) return layout.error();
    const FacetChain flat = FoldChain(layout.value(), Eigen::VectorXd::Zero(layout.value().crease_z.size()));
    const Eigen::Isometry3d lab_from_sheet = LabFromTentacle(gripper, i) * flat.tentacle_from_sheet.front();
    middle += lab_from_sheet * Eigen::Vector3d(0, 0, 0.5 * layout.value().tip_z) / gripper.tentacles;
    strips.push_back({lab_from_sheet, std::move(layout).value(), own});
  }

  TagSight sight;
  sight.widest_angle = WidestAngle(rig, middle);
  for (const Camera& camera : rig.cameras) {
    sight.cameras.push_back({.name = camera.name,
                             .nearest_m_per_px = kNan,
                             .farthest_m_per_px = kNan,
                             .least_module_px = kNan,
                             .largest_module_px = kNan});
  }
  for (size_t t = 0; t < tags.tags.size(); ++t) {
    const TagPlace& tag = tags.tags[t];
    const Glued glued = GluedAt(tag, strips[static_cast<size_t>(tag.tentacle)].lab_from_sheet);
    if (sight.facets.empty() || sight.facets.back().facet != tag.facet ||
        sight.facets.back().tentacle != tag.tentacle) {
      sight.facets.push_back({.tentacle = tag.tentacle, .facet = tag.facet});
    }
    FacetSight& facet = sight.facets.back();
    for (size_t c = 0; c < rig.cameras.size(); ++c) {
      TagOutlook view = ViewOf(rig.cameras[c], glued, tag.footprint / modules, modules);
      view.tag = t;
      view.camera = c;
      if (view.use <= TagUse::kUnsure) {
        const Eigen::Vector3d eye = rig.cameras[c].camera_from_lab.inverse().translation();
        for (size_t other = 0; other < strips.size(); ++other) {
          if (static_cast<int>(other) != tag.tentacle && Blocks(strips[other], glued.center, eye)) {
            view.use = TagUse::kHidden;
          }
        }
      }
      Count(view, sight.cameras[c]);
      if (view.use <= TagUse::kTracked) ++facet.cameras;
      if (view.use < facet.best || (view.use == facet.best && view.least_module_px > facet.best_module_px)) {
        facet.best = view.use;
        facet.best_module_px = view.least_module_px;
      }
      sight.views.push_back(view);
    }
  }
  return sight;
}

}  // namespace tendril
