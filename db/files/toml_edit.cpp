#include "db/files/toml_edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <sstream>

#include "db/files/toml_set.h"
#include "db/files/toml_write.h"

namespace tendril {
namespace {

Error Bad(const std::string& setting, const std::string& what) {
  return Error{ErrorKind::kBadInput, fmt::format("--set {}: {}", setting, what)};
}

std::vector<std::string> StepsOf(const std::string& path) {
  std::vector<std::string> steps(1);
  for (const char c : path) {
    if (c == '.') {
      steps.emplace_back();
    } else {
      steps.back() += c;
    }
  }
  return steps;
}

// The value under the key "value" of a table of its own.
toml::table ValueOf(const std::string& text, const std::string& source) {
  try {
    return toml::parse("value = " + text, source);
  } catch (const toml::parse_error&) {
    return toml::parse("value = " + TomlText(text), source);
  }
}

std::optional<std::size_t> PlaceOf(const std::string& step) {
  std::size_t place = 0;
  const char* const end = step.data() + step.size();
  const auto [stop, error] = std::from_chars(step.data(), end, place);
  return error == std::errc() && stop == end ? std::optional(place) : std::nullopt;
}

// The list's entry that a step names, or why there is none.
Result<toml::node*> EntryOf(toml::array& list, const std::string& setting, const std::string& step) {
  const std::optional<std::size_t> place = PlaceOf(step);
  if (place && *place < list.size()) return &list[*place];
  return Bad(setting, list.empty() ? fmt::format("'{}' in an empty list", step)
                                   : fmt::format("'{}': expected a place in the list, 0 to {}", step,
                                                 list.size() - 1));
}

Result<toml::table> Parsed(const std::string& text, const std::string& name_in_messages) {
  try {
    return toml::parse(text, name_in_messages);
  } catch (const toml::parse_error& error) {
    return Error{ErrorKind::kBadInput, fmt::format("{}:{}: not TOML: {}", name_in_messages,
                                                   error.source().begin.line, error.description())};
  }
}

std::string TextOf(const toml::table& root) {
  std::ostringstream text;
  text << root << '\n';
  return text.str();
}

}  // namespace

Status SetInToml(toml::table& root, const std::string& setting) {
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos) return Bad(setting, "expected key=value");
  const std::vector<std::string> steps = StepsOf(setting.substr(0, equals));
  if (std::find(steps.begin(), steps.end(), "") != steps.end()) {
    return Bad(setting, "expected keys and places in lists, with a dot between two");
  }
  const std::string source = "--set " + setting;
  // Values are moved, for a copy forgets where it comes from.
  toml::table holder = ValueOf(setting.substr(equals + 1), source);
  toml::node& value = *holder.get("value");
  toml::node* at = &root;
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
    if (toml::table* table = at->as_table()) {
      if (!table->contains(steps[i])) {
        toml::table made = ValueOf("{}", source);
        table->insert(steps[i], std::move(*made.get_as<toml::table>("value")));
      }
      at = table->get(steps[i]);
    } else if (toml::array* list = at->as_array()) {
      const Result<toml::node*> entry = EntryOf(*list, setting, steps[i]);
      if (!entry.ok()) return entry.error();
      at = entry.value();
    } else {
      return Bad(setting, fmt::format("'{}' in what is neither a table nor a list", steps[i]));
    }
  }
  if (toml::table* table = at->as_table()) {
    value.visit([&](auto& one) { table->insert_or_assign(steps.back(), std::move(one)); });
  } else if (toml::array* list = at->as_array()) {
    const Result<toml::node*> entry = EntryOf(*list, setting, steps.back());
    if (!entry.ok()) return entry.error();
    const auto place = list->cbegin() + static_cast<std::ptrdiff_t>(*PlaceOf(steps.back()));
    value.visit([&](auto& one) { list->replace(place, std::move(one)); });
  } else {
    return Bad(setting, fmt::format("'{}' in what is neither a table nor a list", steps.back()));
  }
  return Ok{};
}

Result<std::string> EditedToml(const std::string& text, const std::string& name_in_messages,
                               const std::vector<std::string>& settings) {
  if (settings.empty()) return text;
  Result<toml::table> parsed = Parsed(text, name_in_messages);
  if (!parsed.ok()) return parsed.error();
  toml::table& root = parsed.value();
  for (const std::string& setting : settings) {
    if (Status set = SetInToml(root, setting); !set.ok()) return std::move(set).error();
  }
  return TextOf(root);
}

Result<std::string> BareToml(const std::string& text, const std::string& name_in_messages,
                             const std::vector<std::string>& without) {
  Result<toml::table> parsed = Parsed(text, name_in_messages);
  if (!parsed.ok()) return parsed.error();
  for (const std::string& key : without) parsed.value().erase(key);
  return TextOf(parsed.value());
}

}  // namespace tendril
