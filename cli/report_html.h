#pragma once
// Pieces of a report's HTML. All take plain text and escape it.

#include <string>
#include <utility>
#include <vector>

namespace tendril::cli {

// "not known" of NaN; never "-0.00".
std::string NumberText(double value, int digits);

using HtmlRows = std::vector<std::pair<std::string, std::string>>;  // name, value
std::string HtmlFacts(const HtmlRows& rows);
std::string HtmlTable(const std::vector<std::string>& head,
                      const std::vector<std::vector<std::string>>& rows);
std::string HtmlParagraph(const std::string& text, const char* kind = "note");

// The whole page; `body` is HTML.
std::string HtmlDocument(const std::string& title, const std::string& body);

}  // namespace tendril::cli
