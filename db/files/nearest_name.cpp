#include "db/files/nearest_name.h"

#include <algorithm>
#include <cctype>

namespace tendril {
namespace {

std::string Lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<std::vector<size_t>> d(a.size() + 1, std::vector<size_t>(b.size() + 1));
  for (size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (size_t i = 1; i <= a.size(); ++i) {
    for (size_t j = 1; j <= b.size(); ++j) {
      d[i][j] =
          std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1] ? 1 : 0)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[a.size()][b.size()];
}

}  // namespace

std::optional<std::string> NearestName(const std::string& name, const std::vector<std::string>& known) {
  constexpr size_t kLongest = 64;  // nobody slips on such a name
  constexpr size_t kTelling = 3;   // so many letters say which name was meant
  if (name.size() > kLongest) return std::nullopt;
  std::optional<std::string> nearest;
  size_t least = std::max<size_t>(2, name.size() / 3) + 1;
  for (const std::string& candidate : known) {
    const size_t distance = EditDistance(Lower(name), Lower(candidate));
    const bool slip = distance < std::max(name.size(), candidate.size());
    if (slip && distance < least) {
      least = distance;
      nearest = candidate;
    }
  }
  if (nearest || name.size() < kTelling) return nearest;
  for (const std::string& candidate : known) {  // `beta` for `beta_deg`, or the other way round
    if (Lower(candidate).starts_with(Lower(name)) ||
        (candidate.size() >= kTelling && Lower(name).starts_with(Lower(candidate)))) {
      return candidate;
    }
  }
  return std::nullopt;
}

}  // namespace tendril
