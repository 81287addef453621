#include "cli/id_ranges.h"

#include <fmt/core.h>

#include <charconv>
#include <optional>
#include <set>
#include <string_view>

namespace tendril::cli {
namespace {

constexpr int kLargest = 99999;

std::optional<int> ParseId(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  int id = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  if (error != std::errc{} || end != text.data() + text.size() || id < 0 || id > kLargest)
    return std::nullopt;
  return id;
}

}  // namespace

Result<std::vector<int>> ParseIds(const std::string& text) {
  std::set<int> ids;
  const std::string_view all = text;
  for (std::size_t from = 0; from <= all.size();) {
    const std::size_t to = std::min(all.find(',', from), all.size());
    const std::string_view part = all.substr(from, to - from);
    from = to + 1;
    const std::size_t dash = part.find('-');
    const std::optional<int> first = ParseId(part.substr(0, dash));
    const std::optional<int> last = dash == std::string_view::npos ? first : ParseId(part.substr(dash + 1));
    if (!first || !last || *last < *first) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("'{}' in '{}'; expected ids from 0 to {} or rising ranges, such as 0-97,120",
                               part, text, kLargest)};
    }
    for (int id = *first; id <= *last; ++id) ids.insert(id);
  }
  return std::vector<int>(ids.begin(), ids.end());
}

std::string IdsInWords(const std::vector<int>& ids) {
  const auto run = [&ids](std::size_t from, int step) {
    std::size_t end = from;
    while (end + 1 < ids.size() && ids[end + 1] == ids[end] + step) ++end;
    return end;
  };
  std::string text;
  for (std::size_t i = 0; i < ids.size();) {
    // Facets show their front and back in turn, so every second id is common.
    const std::size_t each = run(i, 1), second = run(i, 2);
    const bool by_two = second > each && second >= i + 2;
    const std::size_t end = by_two ? second : each;
    if (!text.empty()) text += ", ";
    text += fmt::format("{}", ids[i]);
    if (end > i) text += fmt::format("-{}{}", ids[end], by_two ? " by 2" : "");
    i = end + 1;
  }
  return text.empty() ? "none" : text;
}

}  // namespace tendril::cli
