#include "calibrate/fold/view_places.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "capture/rig/folded_views.h"
#include "capture/rig/tag_family.h"
#include "db/files/recording_logs.h"
#include "model/fold/gripper.h"
#include "model/median.h"

namespace tendril {
namespace {

constexpr int kAzimuths = 8;
constexpr double kElevations[] = {-35, 0, 35};  // degrees
constexpr int kMoments = 12;
constexpr double kDegree = std::numbers::pi / 180;

Eigen::Vector3d EyeOf(const Camera& camera) { return camera.camera_from_lab.inverse().translation(); }

// Looks at a point; x or y of the picture level.
Camera LookingAt(const Camera& like, const Eigen::Vector3d& eye, const Eigen::Vector3d& target,
                 bool on_its_side) {
  const Eigen::Vector3d forward = (target - eye).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  const Eigen::Vector3d down = forward.cross(right);
  Eigen::Matrix3d lab_from_camera;
  if (on_its_side) {
    lab_from_camera << down, -right, forward;
  } else {
    lab_from_camera << right, down, forward;
  }
  Camera camera = like;
  camera.camera_from_lab.linear() = lab_from_camera.transpose();
  camera.camera_from_lab.translation() = -(lab_from_camera.transpose() * eye);
  return camera;
}

// Of the straight gripper.
Result<Eigen::Vector3d> MiddleOf(const TrialSpec& trial) {
  const Result<TentacleLayout> layout = LayOut(trial.design);
  if (!layout.ok()) return layout.error();
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (int i = 0; i < trial.gripper.tentacles; ++i) {
    middle += LabFromTentacle(trial.gripper, i) * Eigen::Vector3d(0, 0, 0.5 * layout.value().tip_z) /
              trial.gripper.tentacles;
  }
  return middle;
}

// Cameras that saw each facet, from what the tracker used: frame -> tentacle -> facet -> cameras.
std::map<int, std::map<std::pair<int, int>, std::set<int>>> SightOf(const std::vector<ResidualRow>& rows,
                                                                    const TagLayout& tags) {
  std::map<int, std::map<std::pair<int, int>, std::set<int>>> sight;
  for (const ResidualRow& row : rows) {
    const TagPlace* const tag = row.used ? tags.Find(row.tag) : nullptr;
    if (tag != nullptr) sight[static_cast<int>(row.frame)][{tag->tentacle, tag->facet}].insert(row.camera);
  }
  return sight;
}

// Views that cameras have of each facet.
std::vector<Eigen::VectorXi> CountViews(std::span<const FoldedTentacle> tentacles, const TagLayout& tags,
                                        int modules, std::span<const Camera> cameras) {
  std::vector<Eigen::VectorXi> count;
  for (const Camera& camera : cameras) {
    const std::vector<Eigen::VectorXi> seen = FacetsSeen(tentacles, tags, modules, camera);
    if (count.empty()) count.assign(seen.size(), Eigen::VectorXi());
    for (std::size_t t = 0; t < seen.size(); ++t) {
      count[t] = count[t].size() == 0 ? seen[t] : (count[t] + seen[t]).eval();
    }
  }
  return count;
}

struct Setting {
  Rig rig;
  TagLayout tags;
  std::optional<TagLayout> all_tags;  // none: no more would fit
  int modules = 0;
  std::vector<Camera> candidates;
  std::vector<TentacleLayout> layouts;  // by tentacle
};

Result<Setting> SettingOf(const TrialSpec& trial) {
  Setting setting{.rig = {}, .tags = {}, .all_tags = {}, .candidates = {}, .layouts = {}};
  Result<Rig> rig = ParseRig(trial.rig_toml, "rig " + trial.rig_name);
  if (!rig.ok()) return rig.error();
  setting.rig = std::move(rig).value();
  TagLayoutOptions options = LayoutOptionsOf(trial.tags);
  Result<TagLayout> tags = LayOutTags(trial.design, trial.gripper, options);
  if (!tags.ok()) return tags.error();
  setting.tags = std::move(tags).value();
  const Result<TagFamily> family = FamilyOf(setting.tags.family);
  if (!family.ok()) return family.error();
  setting.modules = family.value().total_width;
  if (options.every > 1 || options.sides != TagSides::kBoth) {
    options.every = 1;
    options.sides = TagSides::kBoth;
    Result<TagLayout> all = LayOutTags(trial.design, trial.gripper, options);
    if (all.ok()) setting.all_tags = std::move(all).value();
  }
  const Result<Eigen::Vector3d> middle = MiddleOf(trial);
  if (!middle.ok()) return middle.error();
  setting.candidates = CandidateCameras(setting.rig, middle.value());
  for (int i = 0; i < trial.gripper.tentacles; ++i) {
    Result<TentacleLayout> layout = LayOut(DesignOfTentacle(trial.gripper, trial.design, i));
    if (!layout.ok()) return layout.error();
    setting.layouts.push_back(std::move(layout).value());
  }
  return setting;
}

// What each place would add, by tentacle                       (places, nodes)
std::vector<Eigen::MatrixXi> FurtherAt(const Setting& setting, std::span<const FoldedTentacle> tentacles) {
  const std::size_t places = setting.candidates.size() + 1;
  std::vector<Eigen::MatrixXi> further;
  for (const FoldedTentacle& tentacle : tentacles) {
    further.push_back(
        Eigen::MatrixXi::Zero(static_cast<Eigen::Index>(places), tentacle.layout.hole_z.size()));
  }
  for (std::size_t place = 0; place < setting.candidates.size(); ++place) {
    const auto seen = FacetsSeen(tentacles, setting.tags, setting.modules, setting.candidates[place]);
    for (std::size_t t = 0; t < tentacles.size(); ++t)
      further[t].row(static_cast<Eigen::Index>(place)) = seen[t].transpose();
  }
  if (!setting.all_tags) return further;
  const auto with = CountViews(tentacles, *setting.all_tags, setting.modules, setting.rig.cameras);
  const auto now = CountViews(tentacles, setting.tags, setting.modules, setting.rig.cameras);
  for (std::size_t t = 0; t < tentacles.size(); ++t)
    further[t].bottomRows(1) = (with[t] - now[t]).cwiseMax(0).transpose();
  return further;
}

void Compare(const Setting& setting, std::span<const FoldedTentacle> tentacles,
             const std::map<std::pair<int, int>, std::set<int>>& sight, ViewPlaces& places) {
  std::set<std::pair<int, int>> asked;
  for (const TagPlace& tag : setting.tags.tags) asked.insert({tag.tentacle, tag.facet});
  for (std::size_t c = 0; c < setting.rig.cameras.size(); ++c) {
    const auto foretold = FacetsSeen(tentacles, setting.tags, setting.modules, setting.rig.cameras[c]);
    for (const auto& [tentacle, facet] : asked) {
      if (tentacles[static_cast<std::size_t>(tentacle)].lab_from_sheet.empty()) continue;
      const auto found = sight.find({tentacle, facet});
      const bool seen = found != sight.end() && found->second.contains(static_cast<int>(c));
      const bool told = foretold[static_cast<std::size_t>(tentacle)][facet] != 0;
      ++places.facets;
      places.seen += seen ? 1 : 0;
      places.foretold += told ? 1 : 0;
      places.both += seen && told ? 1 : 0;
    }
  }
}

}  // namespace

std::vector<Camera> CandidateCameras(const Rig& rig, const Eigen::Vector3d& middle_in_lab) {
  std::vector<Camera> candidates;
  if (rig.cameras.empty()) return candidates;
  std::vector<double> distances;
  for (const Camera& camera : rig.cameras) distances.push_back((EyeOf(camera) - middle_in_lab).norm());
  const double distance = Median(std::move(distances));
  const Camera& like =
      *std::max_element(rig.cameras.begin(), rig.cameras.end(), [](const Camera& a, const Camera& b) {
        return static_cast<double>(a.width_px) * a.height_px < static_cast<double>(b.width_px) * b.height_px;
      });
  const bool on_its_side =
      std::abs(like.camera_from_lab.linear()(0, 2)) > std::abs(like.camera_from_lab.linear()(1, 2));
  for (const double elevation : kElevations) {
    for (int i = 0; i < kAzimuths; ++i) {
      const double azimuth = 2 * std::numbers::pi * i / kAzimuths;
      const double level = std::cos(elevation * kDegree);
      const Eigen::Vector3d toward(level * std::cos(azimuth), level * std::sin(azimuth),
                                   std::sin(elevation * kDegree));
      Camera& camera = candidates.emplace_back(
          LookingAt(like, middle_in_lab + distance * toward, middle_in_lab, on_its_side));
      camera.name = fmt::format("azimuth {} deg, elevation {} deg about the gripper's middle",
                                360 / kAzimuths * i, elevation);
    }
  }
  return candidates;
}

void MergePlaces(const ViewPlaces& of_trial, ViewPlaces& places) {
  if (of_trial.names.empty()) return;
  if (places.names.empty()) places.names = of_trial.names;
  if (places.names != of_trial.names) places.names = of_trial.relative_names;
  places.relative_names = of_trial.relative_names;
  places.seen += of_trial.seen;
  places.foretold += of_trial.foretold;
  places.both += of_trial.both;
  places.facets += of_trial.facets;
}

Result<ViewPlaces> AddViews(const std::filesystem::path& trial_folder, FoldData& data) {
  ViewPlaces places;
  const std::filesystem::path file = trial_folder / "residuals.csv";
  const bool angles =
      std::any_of(data.angles.begin(), data.angles.end(), [](const auto& a) { return a.size() > 0; });
  if (data.trial.rig_toml.empty() || !angles || !std::filesystem::exists(file)) return places;
  const Result<std::vector<ResidualRow>> rows = ReadResiduals(file);
  if (!rows.ok()) return Error(rows.error()).Within("trial " + data.trial.label);
  const Result<Setting> made = SettingOf(data.trial);
  if (!made.ok()) return Error(made.error()).Within("trial " + data.trial.label);
  const Setting& setting = made.value();
  if (setting.candidates.empty()) return places;
  const auto sight = SightOf(rows.value(), setting.tags);

  std::map<int, std::vector<std::size_t>> by_frame;  // observations
  for (std::size_t i = 0; i < data.observations.size(); ++i) by_frame[data.frames[i]].push_back(i);
  const std::size_t stride = (by_frame.size() + kMoments - 1) / kMoments;
  std::vector<Eigen::MatrixXi> further;
  std::size_t count = 0;
  static const std::map<std::pair<int, int>, std::set<int>> kNothing;
  for (const auto& [frame, observations] : by_frame) {
    const auto found = sight.find(frame);
    const auto& of_frame = found == sight.end() ? kNothing : found->second;
    if (count++ % stride == 0) {
      std::vector<FoldedTentacle> tentacles;
      for (std::size_t t = 0; t < setting.layouts.size(); ++t) {
        tentacles.push_back({DesignOfTentacle(data.trial.gripper, data.trial.design, static_cast<int>(t)),
                             setting.layouts[t],
                             {}});
      }
      for (const std::size_t i : observations) {
        const FoldObservation& o = data.observations[i];
        FoldedTentacle& tentacle = tentacles[static_cast<std::size_t>(o.tentacle)];
        tentacle = LayOnCurve(tentacle.design, tentacle.layout, data.angles[i], o.curve);
      }
      further = FurtherAt(setting, tentacles);
      Compare(setting, tentacles, of_frame, places);
    }
    for (const std::size_t i : observations) {
      FoldObservation& o = data.observations[i];
      o.further = further[static_cast<std::size_t>(o.tentacle)];
      o.cameras.setZero(o.curve.points.cols());
      for (Eigen::Index node = 0; node < o.cameras.size(); ++node) {
        const auto views = of_frame.find({o.tentacle, static_cast<int>(node)});
        if (views != of_frame.end()) o.cameras[node] = static_cast<int>(views->second.size());
      }
    }
  }
  for (const Camera& camera : setting.candidates) {
    // Rounded here, so that none reads -0.00.
    const Eigen::Vector3d at = (100 * EyeOf(camera)).array().round() / 100 + 0.0;
    places.names.push_back(
        fmt::format("another camera at ({:.2f}, {:.2f}, {:.2f}) m", at.x(), at.y(), at.z()));
    places.relative_names.push_back("another camera at " + camera.name);
  }
  places.names.push_back("tags on both sides of every facet");
  places.relative_names.push_back(places.names.back());
  return places;
}

}  // namespace tendril
