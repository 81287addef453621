#include "cli/report_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "cli/link_bands_answer.h"
#include "cli/report_html.h"
#include "cli/trials_commands.h"
#include "db/files/page_text.h"

namespace tendril::cli {
namespace {

std::string Plots(const std::vector<PageFigure>& figures) {
  if (figures.empty()) return {};
  std::string html = fmt::format("<div class=\"plots{}\">\n", figures.size() > 1 ? " pair" : "");
  for (const PageFigure& figure : figures) html += "<figure class=\"plot\">" + figure.svg + "</figure>\n";
  return html + "</div>\n";
}

std::string CameraName(const CameraFacts& camera) {
  return camera.name.empty() ? fmt::format("{}", camera.number)
                             : fmt::format("{} ({})", camera.number, camera.name);
}

std::string Head(const TrialFacts& facts) {
  const TrialOverview& t = facts.details.overview;
  HtmlRows rows = {
      {"id", t.id},
      {"kind", NameOf(t.kind)},
      {"state",
       NameOf(t.state) + (facts.details.state_reason.empty() ? "" : ": " + facts.details.state_reason)}};
  std::string judged = OutcomeText(t) == "-" ? "not judged" : OutcomeText(t);
  for (const TrialEvent& event : facts.details.events) {
    if (event.counts)
      judged += fmt::format(", judged by {}{}", event.by, event.by_person ? "" : " (a program)");
  }
  rows.emplace_back("outcome", judged);
  rows.emplace_back("date", UtcText(t.started_ns) + " UTC");
  rows.emplace_back("design", t.design);
  const Gripper& gripper = facts.trial.gripper;
  rows.emplace_back("gripper", gripper.tentacles == 1
                                   ? std::string("1 tentacle")
                                   : fmt::format("{} tentacles on a circle of {:.0f} mm radius",
                                                 gripper.tentacles, 1e3 * gripper.carrier_radius));
  rows.emplace_back(
      "object", fmt::format("{}, {:.0f} mm from the carrier, in {}", t.object, 1e3 * t.distance, t.medium));
  rows.emplace_back(
      "pull", fmt::format("{:.4g} of the tendon, at {:.4g} 1/s (commanded)", t.pull, facts.trial.pull_rate));
  rows.emplace_back("rig", facts.rig.cameras.empty() ? std::string("no cameras")
                                                     : fmt::format("{}{}{} camera{}", facts.trial.rig_name,
                                                                   facts.trial.rig_name.empty() ? "" : ", ",
                                                                   facts.rig.cameras.size(),
                                                                   facts.rig.cameras.size() == 1 ? "" : "s"));
  const Eigen::VectorXd& time = facts.curves.front().time;
  rows.emplace_back(
      "frames", fmt::format("{}, from {:.2f} s to {:.2f} s", time.size(), time[0], time[time.size() - 1]));
  for (const DerivedResult& result : facts.details.results) {
    if (result.what != "track") continue;
    std::string from;
    for (const auto& [name, hash] : result.input_sha256) from += (from.empty() ? "" : ", ") + name;
    rows.emplace_back("tracked", fmt::format("{} UTC by {}, from {}", UtcText(result.made_ns),
                                             result.program_version, from));
  }
  if (!facts.details.notes.empty()) rows.emplace_back("notes", facts.details.notes);
  std::string html = fmt::format("<h1>{}</h1>\n", XmlText(t.label)) + HtmlFacts(rows);
  if (facts.remarks.empty()) return html + HtmlParagraph("Nothing stands out.", "short");
  html += "<ul class=\"remarks\">\n";
  for (const std::string& remark : facts.remarks) html += fmt::format("<li>{}</li>\n", XmlText(remark));
  return html + "</ul>\n";
}

std::string Stills(const TrialFacts& facts, const std::vector<PageStill>& stills) {
  std::string html = "<h2>Pictures</h2>\n";
  if (stills.empty())
    return html + HtmlParagraph("Not shown: a video or detections.csv is not in the trial's folder.");
  html +=
      "<p class=\"note\">What the tracker made of them, drawn over the pictures (only what is around the "
      "curves):";
  for (const auto& [color, meaning] : {std::pair{"#40d0ff", "node seen"},
                                       {"#ffa500", "bridged by the model (circle: sigma)"},
                                       {"#d65cd6", "not seen (dashed: the model alone)"},
                                       {"#40d060", "tag on its facet"},
                                       {"#f04040", "tag elsewhere"}}) {
    html +=
        fmt::format(" <span class=\"legend\"><span class=\"key\" style=\"background:{}\"></span> {}</span>",
                    color, meaning);
  }
  html += "</p>\n";
  html += fmt::format("<div class=\"stills{}\">\n", facts.cameras.size() == 1 ? " single" : "");
  for (const PageStill& still : stills) {
    const std::string caption = fmt::format("camera {}, frame {}, {:.2f} s: {}",
                                            CameraName(facts.cameras[static_cast<std::size_t>(still.camera)]),
                                            still.frame, still.time, still.why);
    html += fmt::format(
        "<figure><img width=\"{}\" height=\"{}\" alt=\"{}\" src=\"data:image/jpeg;base64,{}\"/><figcaption>{}"
        "</figcaption></figure>\n",
        still.width_px, still.height_px, XmlText(caption), Base64(still.jpeg), XmlText(caption));
  }
  return html + "</div>\n";
}

std::string Folds(const PageFigures& figures) {
  std::string html = "<h2>Fold angles</h2>\n";
  if (figures.folds.empty()) return html + HtmlParagraph("Not in curves.h5.");
  html += HtmlParagraph(
      "phi of each crease (half of its outer angle; 0 is flat). Hatched: the pictures of this frame tell "
      "less of it than what the model expects of its neighbours. Gray: not known.");
  return html + Plots(figures.folds);
}

std::string Sight(const TrialFacts& facts, const PageFigures& figures) {
  std::string html = "<h2>What was seen</h2>\n";
  std::vector<std::vector<std::string>> rows;
  for (const TentacleFacts& t : facts.tentacles) {
    const std::string where =
        t.worst_node < 0 ? "" : fmt::format(" (node {}, frame {})", t.worst_node, t.worst_frame);
    rows.push_back({t.name, fmt::format("{:.1f} %", 100 * t.seen), fmt::format("{:.1f} %", 100 * t.bridged),
                    fmt::format("{:.1f} %", 100 * t.not_seen), NumberText(1e3 * t.median_sigma, 2) + " mm",
                    NumberText(1e3 * t.worst_sigma, 2) + " mm" + where});
  }
  html += HtmlTable(
      {"tentacle", "nodes seen", "bridged", "not seen", "sigma of the seen, median", "largest sigma"}, rows);
  html += HtmlParagraph(
      "A node is seen if a tag of its own facet was used, bridged if the model carries it from facets that "
      "were seen, not seen if the nearest of those is too far; sigma is its 1-sigma distance to the true "
      "place.");
  return html + Plots(figures.seen) + Plots(figures.sights) + Plots(figures.sigma);
}

std::string Cameras(const TrialFacts& facts, const PageFigures& figures) {
  std::string html = "<h2>Cameras</h2>\n";
  if (facts.cameras.empty()) return html + HtmlParagraph("This trial's rig has no cameras.");
  std::vector<std::vector<std::string>> rows;
  for (const CameraFacts& c : facts.cameras) {
    std::vector<std::string> row = {CameraName(c), fmt::format("{}", c.pictures),
                                    fmt::format("{}", c.dropped), fmt::format("{}", c.found)};
    if (facts.residuals_known) {
      row.push_back(fmt::format("{}", c.used));
      row.push_back(fmt::format("{}", c.left_out));
      row.push_back(NumberText(c.rms_px, 2));
      row.push_back(NumberText(c.median_px, 2));
      row.push_back(fmt::format("{}, {} +- {}", NumberText(c.shift_px.x(), 2), NumberText(c.shift_px.y(), 2),
                                NumberText(c.shift_error_px.norm(), 2)));
    }
    row.push_back(NumberText(c.stated_sigma_px, 3));
    rows.push_back(std::move(row));
  }
  std::vector<std::string> head = {"camera", "pictures", "lost", "tags found"};
  if (facts.residuals_known) {
    for (const char* more :
         {"used", "left out", "RMS px", "median px", "mean shift px (right, down), its error"})
      head.emplace_back(more);
  }
  head.emplace_back("corner noise stated px");
  html += HtmlTable(head, rows);
  if (facts.residuals_known) {
    html += HtmlParagraph(
        "RMS, median and shift: from where the reconstructed chain has a tag's corner, at the tag's nominal "
        "place on its "
        "facet, to where it was found; of the tags that were used (residuals.csv). They hold the detector's "
        "error, how tags "
        "were glued, what the cameras' calibration is off, and the chain's own error. A camera that moved "
        "stands out; what all "
        "cameras agree on does not show, for the chain follows it.");
    if (facts.cameras.size() > 1) {
      html += HtmlParagraph(
          fmt::format("{} tags were seen by several cameras at once; of {} of these a sighting was left out.",
                      facts.shared, facts.shared_contradicted));
    }
    html += Plots(figures.residuals);
  }
  html += "<h3>Tags that were expected and not believed</h3>\n";
  std::set<std::string> causes;
  bool known = false;
  for (const CameraFacts& c : facts.cameras) {
    known = known || c.rejected.has_value();
    if (!c.rejected) continue;
    for (const auto& [cause, count] : *c.rejected) causes.insert(cause);
  }
  if (!known) {
    return html + HtmlParagraph("Not kept: tags were not followed in the videos when this was tracked.");
  }
  if (causes.empty()) return html + HtmlParagraph("None.");
  std::vector<std::string> causes_head = {"camera"};
  causes_head.insert(causes_head.end(), causes.begin(), causes.end());
  std::vector<std::vector<std::string>> counts;
  for (const CameraFacts& c : facts.cameras) {
    std::vector<std::string> row = {CameraName(c)};
    for (const std::string& cause : causes) {
      long count = 0;
      for (const auto& [name, its] : c.rejected.value_or(std::vector<std::pair<std::string, long>>())) {
        if (name == cause) count = its;
      }
      row.push_back(c.rejected ? fmt::format("{}", count) : "not kept");
    }
    counts.push_back(std::move(row));
  }
  return html + HtmlTable(causes_head, counts) +
         HtmlParagraph("Sightings, counted while each camera's tags were followed from picture to picture.");
}

// Values that may be either of two, moment by moment.
std::string EitherOr(const TrialFacts& facts, const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 30;
  const Eigen::VectorXd& time = facts.curves.front().time;
  std::vector<std::vector<std::string>> rows;
  std::size_t more = 0;
  const auto add = [&](std::size_t moment, const std::string& what, const LinkBand& band) {
    if (band.modes.size() < 2) return;
    if (rows.size() == kMost) {
      ++more;
      return;
    }
    rows.push_back({fmt::format("{:.2f} s", time[facts.link.frames[moment]]), what, BandText(band)});
  };
  for (std::size_t k = 0; k < facts.link.bands.size(); ++k) {
    const LinkBands& bands = facts.link.bands[k];
    for (std::size_t c = 0; c < bands.curves.size(); ++c) {
      if (facts.link.axis) add(k, names[c] + " - object", bands.curves[c].object_link);
    }
    for (const PairBands& pair : bands.pairs) {
      add(k, names[static_cast<std::size_t>(pair.a)] + " - " + names[static_cast<std::size_t>(pair.b)],
          pair.link);
    }
  }
  if (rows.empty()) return {};
  return "<h3>One value or another</h3>\n" +
         HtmlParagraph(
             "Here strands, or the rays that go on from their ends, may lie on either side of each other; a "
             "mean would "
             "say nothing, so the plots show each value as a point.") +
         HtmlTable({"when", "link", "turns"}, rows) +
         (more > 0 ? HtmlParagraph(fmt::format("And {} more.", more)) : std::string());
}

std::string Links(const TrialFacts& facts, const PageFigures& figures) {
  std::string html = "<h2>Links</h2>\n";
  const LinkFacts& link = facts.link;
  if (link.bands.empty()) return html + HtmlParagraph("No bands: " + link.why_none + ".");
  std::vector<std::string> names;
  for (const TentacleFacts& tentacle : facts.tentacles) names.push_back(tentacle.name);
  const LinkBands& end = link.bands.back();
  const Eigen::VectorXd& time = facts.curves.front().time;
  html += HtmlParagraph(fmt::format(
      "Turns; mean and 95 % over {} draws of the curves, at {} of {} frames. Open ends go on as rays. {}",
      end.draws, link.frames.size(), time.size(),
      link.axis ? "" : "The object has no axis, so that nothing links with it."));
  html += Plots(figures.link);
  std::vector<std::vector<std::string>> rows;
  for (std::size_t c = 0; c < end.curves.size(); ++c) {
    if (link.axis) rows.push_back({names[c] + " - object", BandText(end.curves[c].object_link)});
    rows.push_back({names[c] + ", writhe", BandText(end.curves[c].writhe)});
  }
  for (const PairBands& pair : end.pairs) {
    rows.push_back({names[static_cast<std::size_t>(pair.a)] + " - " + names[static_cast<std::size_t>(pair.b)],
                    BandText(pair.link)});
  }
  if (!end.pairs.empty()) rows.push_back({"mutual link (mean |link| over pairs)", BandText(end.mutual_link)});
  if (link.axis) rows.push_back({"object link (mean |link|)", BandText(end.object_link)});
  html += fmt::format("<h3>At the last frame, {:.2f} s</h3>\n", time[link.frames.back()]) +
          HtmlTable({"link", "turns"}, rows);
  html += EitherOr(facts, names) + "<h3>Undecided crossings</h3>\n";
  if (link.undecided.empty()) {
    return html +
           HtmlParagraph(
               "None: at every moment strands are farther apart than three standard deviations. (The rays "
               "that go on from "
               "their ends are not strands; where these may pass on either side, the table above says so.)");
  }
  html += HtmlParagraph(
      "Strands nearer than three standard deviations of their distance: it is not known who lies in front.");
  std::vector<std::vector<std::string>> spans;
  for (const UndecidedSpan& span : link.undecided) {
    const double first = time[span.frames.front()];
    const double last = time[span.frames.back()];
    spans.push_back({span.frames.size() == 1 ? fmt::format("{:.2f} s", first)
                                             : fmt::format("{:.2f} to {:.2f} s", first, last),
                     UndecidedText(span.nearest, names)});
  }
  return html + HtmlTable({"when", "nearest, in standard deviations"}, spans);
}

std::string Origins(const TrialFacts& facts) {
  std::string html = "<h2>Made from</h2>\n";
  for (const DerivedResult& result : facts.details.results) {
    if (result.what != "track") continue;
    html +=
        HtmlParagraph(fmt::format("Tracked {} UTC by {}.", UtcText(result.made_ns), result.program_version));
    std::vector<std::vector<std::string>> inputs;
    for (const auto& [name, hash] : result.input_sha256) inputs.push_back({name, hash});
    if (!inputs.empty()) html += HtmlTable({"file", "SHA-256"}, inputs);
    const auto parameters =
        nlohmann::json::parse(result.parameters_json, nullptr, /*allow_exceptions=*/false);
    HtmlRows rows;
    if (parameters.is_object()) {
      for (const auto& [name, value] : parameters.items()) {
        if (name == "tags_rejected") continue;
        rows.emplace_back(name, value.is_string() ? value.get<std::string>() : value.dump());
      }
    }
    if (!rows.empty()) html += "<details><summary>Parameters</summary>\n" + HtmlFacts(rows) + "</details>\n";
  }
  return html;
}

}  // namespace

std::string PageOf(const TrialFacts& facts, const PageFigures& figures,
                   const std::vector<PageStill>& stills) {
  return HtmlDocument(facts.details.overview.label, Head(facts) + Stills(facts, stills) + Folds(figures) +
                                                        Sight(facts, figures) + Cameras(facts, figures) +
                                                        Links(facts, figures) + Origins(facts));
}

}  // namespace tendril::cli
