#include "cli/report_json.h"

#include "cli/command.h"
#include "cli/link_bands_answer.h"

namespace tendril::cli {
namespace {

using Json = nlohmann::ordered_json;

Json CameraJson(const CameraFacts& camera, bool residuals_known) {
  Json json{
      {"camera", camera.number},
      {"name", camera.name},
      {"pictures", camera.pictures},
      {"dropped", camera.dropped},
      {"tags_found", camera.found},
      {"tags_used", residuals_known ? Json(camera.used) : Json(nullptr)},
      {"tags_left_out", residuals_known ? Json(camera.left_out) : Json(nullptr)},
      {"rms_px", NumberOrNull(camera.rms_px)},
      {"median_px", NumberOrNull(camera.median_px)},
      {"shift_px", {NumberOrNull(camera.shift_px.x()), NumberOrNull(camera.shift_px.y())}},
      {"shift_error_px", {NumberOrNull(camera.shift_error_px.x()), NumberOrNull(camera.shift_error_px.y())}},
      {"stated_sigma_px", NumberOrNull(camera.stated_sigma_px)},
      {"rejected", nullptr}};
  if (!camera.rejected) return json;
  json["rejected"] = Json::object();
  for (const auto& [cause, count] : *camera.rejected) json["rejected"][cause] = count;
  return json;
}

}  // namespace

Json FactsAsJson(const TrialFacts& facts) {
  const TrialOverview& trial = facts.details.overview;
  Json json{{"trial", trial.id}, {"label", trial.label}, {"frames", facts.curves.front().curves.size()}};
  json["tentacles"] = Json::array();
  for (const TentacleFacts& t : facts.tentacles) {
    json["tentacles"].push_back(
        {{"name", t.name},
         {"seen_fraction", t.seen},
         {"bridged_fraction", t.bridged},
         {"not_seen_fraction", t.not_seen},
         {"median_sigma_mm", NumberOrNull(1e3 * t.median_sigma)},
         {"worst_sigma_mm", NumberOrNull(1e3 * t.worst_sigma)},
         {"worst_sigma_node", t.worst_node < 0 ? Json(nullptr) : Json(t.worst_node)},
         {"worst_sigma_frame", t.worst_frame < 0 ? Json(nullptr) : Json(t.worst_frame)}});
  }
  json["cameras"] = Json::array();
  for (const CameraFacts& camera : facts.cameras)
    json["cameras"].push_back(CameraJson(camera, facts.residuals_known));
  json["shared_tags"] = facts.residuals_known ? Json(facts.shared) : Json(nullptr);
  json["shared_tags_contradicted"] = facts.residuals_known ? Json(facts.shared_contradicted) : Json(nullptr);
  json["link_at_end"] = nullptr;
  json["undecided"] = Json::array();
  if (!facts.link.bands.empty()) {
    const LinkBands& end = facts.link.bands.back();
    std::vector<std::string> names;
    for (const TentacleFacts& t : facts.tentacles) names.push_back(t.name);
    json["link_at_end"] = {
        {"frame", facts.link.frames.back()},
        {"draws", end.draws},
        {"mutual_link", NumberOrNull(end.mutual_link.mean)},
        {"object_link", NumberOrNull(end.object_link.mean)},
        {"object_link_band95", {NumberOrNull(end.object_link.low95), NumberOrNull(end.object_link.high95)}}};
    for (const UndecidedSpan& span : facts.link.undecided) {
      json["undecided"].push_back({{"frames", span.frames}, {"nearest", UndecidedText(span.nearest, names)}});
    }
  }
  json["remarks"] = facts.remarks;
  return json;
}

}  // namespace tendril::cli
