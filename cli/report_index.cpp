// The index of several trials' pages.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cli/link_bands_answer.h"
#include "cli/report_html.h"
#include "cli/report_page.h"
#include "cli/trials_commands.h"
#include "db/files/page_text.h"

namespace tendril::cli {

IndexRow KeyFigures(const TrialFacts& facts) {
  IndexRow row;
  row.trial = facts.details.overview;
  row.frames = static_cast<int>(facts.curves.front().curves.size());
  std::vector<double> sigmas;
  for (std::size_t t = 0; t < facts.tentacles.size(); ++t) {
    row.seen += facts.tentacles[t].seen / static_cast<double>(facts.tentacles.size());
    if (std::isfinite(facts.tentacles[t].median_sigma)) sigmas.push_back(facts.tentacles[t].median_sigma);
  }
  row.median_sigma = sigmas.empty() ? std::numeric_limits<double>::quiet_NaN()
                                    : *std::max_element(sigmas.begin(), sigmas.end());
  row.worst_camera_px = std::numeric_limits<double>::quiet_NaN();
  for (const CameraFacts& camera : facts.cameras)
    row.worst_camera_px = std::fmax(row.worst_camera_px, camera.rms_px);
  if (!facts.link.bands.empty() && facts.link.axis)
    row.object_link = BandText(facts.link.bands.back().object_link);
  row.remarks = facts.remarks;
  return row;
}

std::string IndexOf(const std::string& lab, const std::vector<IndexRow>& rows) {
  std::string html = fmt::format(
      "<h1>Trials of {}</h1>\n<div class=\"wide\"><table class=\"index\">\n<thead><tr>", XmlText(lab));
  for (const char* head :
       {"trial", "date (UTC)", "kind", "state", "outcome", "design", "pull", "frames", "nodes seen",
        "sigma mm", "worst camera px", "object link at the end", "remarks"}) {
    html += fmt::format("<th>{}</th>", head);
  }
  html += "</tr></thead>\n<tbody>\n";
  for (const IndexRow& row : rows) {
    const TrialOverview& t = row.trial;
    const std::string label = XmlText(t.label);
    html += fmt::format(
        "<tr><td>{}</td>",
        row.file.empty() ? label : fmt::format("<a href=\"{}\">{}</a>", XmlText(row.file), label));
    for (const std::string& cell : {UtcText(t.started_ns), NameOf(t.kind), NameOf(t.state), OutcomeText(t),
                                    t.design, fmt::format("{:.4g}", t.pull)}) {
      html += fmt::format("<td>{}</td>", XmlText(cell));
    }
    if (row.file.empty()) {
      html += fmt::format("<td colspan=\"6\">{}</td></tr>\n", XmlText(row.why_none));
      continue;
    }
    for (const std::string& cell :
         {fmt::format("{}", row.frames), fmt::format("{:.0f} %", 100 * row.seen),
          NumberText(1e3 * row.median_sigma, 2), NumberText(row.worst_camera_px, 2), row.object_link}) {
      html += fmt::format("<td>{}</td>", XmlText(cell));
    }
    html += "<td>";
    if (!row.remarks.empty()) {
      html += fmt::format("<details><summary>{}</summary>", row.remarks.size());
      for (const std::string& remark : row.remarks) html += HtmlParagraph(remark);
      html += "</details>";
    }
    html += "</td></tr>\n";
  }
  html += "</tbody></table></div>\n";
  html += HtmlParagraph(
      "Sigma: the largest tentacle's median over its seen nodes. Worst camera: RMS of the corners of its "
      "tags "
      "against the chain. Object link: mean magnitude, in turns, with its 95 % band.");
  return HtmlDocument("Trials of " + lab, html);
}

}  // namespace tendril::cli
