#include "cli/report_html.h"

#include <fmt/format.h>

#include <cmath>

#include "cli/program_version.h"
#include "cli/report_style.h"
#include "db/files/page_text.h"

namespace tendril::cli {

std::string NumberText(double value, int digits) {
  if (!std::isfinite(value)) return "not known";
  const double least = 0.5 * std::pow(10.0, -digits);  // no "-0.00"
  return fmt::format("{:.{}f}", std::abs(value) < least ? 0.0 : value, digits);
}

std::string HtmlFacts(const HtmlRows& rows) {
  std::string html = "<table class=\"facts\">\n";
  for (const auto& [name, value] : rows) {
    html += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", XmlText(name), XmlText(value));
  }
  return html + "</table>\n";
}

std::string HtmlTable(const std::vector<std::string>& head,
                      const std::vector<std::vector<std::string>>& rows) {
  std::string html = "<div class=\"wide\"><table>\n<thead><tr>";
  for (const std::string& cell : head) html += fmt::format("<th>{}</th>", XmlText(cell));
  html += "</tr></thead>\n<tbody>\n";
  for (const auto& row : rows) {
    html += "<tr>";
    for (const std::string& cell : row) html += fmt::format("<td>{}</td>", XmlText(cell));
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string HtmlParagraph(const std::string& text, const char* kind) {
  return fmt::format("<p class=\"{}\">{}</p>\n", kind, XmlText(text));
}

std::string HtmlDocument(const std::string& title, const std::string& body) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\"/>\n<meta name=\"color-scheme\" content=\"light "
      "dark\"/>\n"
      "<title>{}</title>\n<style>\n{}</style>\n</head>\n<body>\n{}<footer>{}</footer>\n</body>\n</html>\n",
      XmlText(title), kReportStyle, body, XmlText("Made by " + ProgramVersion() + " report."));
}

}  // namespace tendril::cli
