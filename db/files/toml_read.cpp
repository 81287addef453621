#include "db/files/toml_read.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <utility>

#include "db/files/nearest_name.h"
#include "db/files/safe_file.h"
#include "db/files/toml_set.h"
#include "db/files/toml_write.h"
#include "model/check.h"

namespace tendril {

struct TomlDocument::State {
  struct Problem {
    bool unknown_key;
    std::uint32_t line;
    std::string message;
  };
  std::string name;
  toml::table root;
  std::vector<Problem> problems;
  std::vector<std::shared_ptr<TomlTable::Node>> nodes;
};

struct TomlTable::Node {
  TomlDocument::State* document;  // owns this node
  const toml::table* table;       // null: the file has no such table
  std::string path;               // "gripper.rod"; empty for the root
  std::uint32_t line;             // where the table begins
  std::set<std::string> asked;

  std::string Field(const std::string& key) const { return path.empty() ? key : path + "." + key; }

  const toml::node* Find(const std::string& key) {
    asked.insert(key);
    return table == nullptr ? nullptr : table->get(key);
  }

  void Add(std::uint32_t at, const std::string& text, bool unknown_key = false) {
    document->problems.push_back(
        {unknown_key, at, fmt::format("{}:{}: {}", document->name, std::max(at, 1U), text)});
  }

  // About a value or key; one that was set from outside has no line.
  void Add(const toml::source_region& at, const std::string& text, bool unknown_key = false) {
    if (at.path == nullptr || *at.path == document->name) {
      Add(at.begin.line, text, unknown_key);
    } else {
      document->problems.push_back(
          {unknown_key, 0, fmt::format("{}: {}: {}", document->name, *at.path, text)});
    }
  }
};

namespace {

constexpr size_t kLongestShown = 60;

std::string Shown(const toml::node& node) {
  std::ostringstream text;
  if (node.is_table()) {
    text << "a table";
  } else if (const auto* real = node.as_floating_point()) {
    text << fmt::format("{}", real->get());
  } else {
    node.visit([&](const auto& value) { text << value; });
  }
  std::string shown = text.str();
  std::replace(shown.begin(), shown.end(), '\n', ' ');
  if (shown.size() > kLongestShown) shown = shown.substr(0, kLongestShown) + "...";
  return shown;
}

std::string WithUnit(const std::string& text, const std::string& unit) {
  return unit.empty() ? text : text + " " + unit;
}

bool Takes(const Bounds& bounds, double value) {
  return std::isfinite(value) && (bounds.low_open ? value > bounds.low : value >= bounds.low) &&
         (bounds.high_open ? value < bounds.high : value <= bounds.high);
}

std::string Expected(const Bounds& bounds, const std::string& noun) {
  std::string text = noun;
  if (std::isfinite(bounds.low)) text += fmt::format("{}{}", bounds.low_open ? " > " : " >= ", bounds.low);
  if (std::isfinite(bounds.high)) {
    text += std::isfinite(bounds.low) ? " and" : "";
    text += fmt::format("{}{}", bounds.high_open ? " < " : " <= ", bounds.high);
  }
  return WithUnit(text, bounds.unit);
}

std::optional<double> NumberIn(const toml::node& node) {
  if (const auto real = node.as_floating_point()) return real->get();
  if (const auto whole = node.as_integer()) return static_cast<double>(whole->get());
  return std::nullopt;
}

}  // namespace

Bounds Finite(std::string unit) { return {.unit = std::move(unit)}; }
Bounds Above(double low, std::string unit) { return {.low = low, .low_open = true, .unit = std::move(unit)}; }
Bounds AtLeast(double low, std::string unit) { return {.low = low, .unit = std::move(unit)}; }
Bounds Between(double low, double high, std::string unit) {
  return {.low = low, .high = high, .unit = std::move(unit)};
}
Bounds Inside(double low, double high, std::string unit) {
  return {.low = low, .high = high, .low_open = true, .high_open = true, .unit = std::move(unit)};
}

const void* TomlTable::Ask(const std::string& key) {
  TENDRIL_CHECK(node_ != nullptr);
  const bool required = std::exchange(required_, false);
  const toml::node* found = node_->Find(key);
  if (found == nullptr && required) {
    node_->Add(node_->line, node_->Field(key) + ": missing, and there is no default");
  }
  return found;
}

// Reports a value that is not what the key takes; always false.
bool TomlTable::Refuse(const void* value, const std::string& key, const std::string& expected) {
  const toml::node& node = *static_cast<const toml::node*>(value);
  node_->Add(node.source(), fmt::format("{} = {}: expected {}", node_->Field(key), Shown(node), expected));
  return false;
}

bool TomlTable::Number(const std::string& key, double& target, const Bounds& bounds) {
  const auto* node = static_cast<const toml::node*>(Ask(key));
  if (node == nullptr) return false;
  const std::optional<double> value = NumberIn(*node);
  if (!value || !Takes(bounds, *value)) return Refuse(node, key, Expected(bounds, "a number"));
  target = *value;
  return true;
}

bool TomlTable::Degrees(const std::string& key, double& target_rad, const Bounds& bounds_deg) {
  double degrees = 0;
  if (!Number(key, degrees, bounds_deg)) return false;
  target_rad = RadiansOfDegrees(degrees);
  return true;
}

bool TomlTable::Integer(const std::string& key, std::int64_t& target, const Bounds& bounds) {
  const auto* node = static_cast<const toml::node*>(Ask(key));
  if (node == nullptr) return false;
  const auto* whole = node->as_integer();
  if (whole == nullptr || !Takes(bounds, static_cast<double>(whole->get()))) {
    return Refuse(node, key, Expected(bounds, "a whole number"));
  }
  target = whole->get();
  return true;
}

bool TomlTable::Integer(const std::string& key, int& target, const Bounds& bounds) {
  Bounds narrow = bounds;
  if (narrow.low < std::numeric_limits<int>::min()) narrow.low = std::numeric_limits<int>::min();
  if (narrow.high > std::numeric_limits<int>::max()) narrow.high = std::numeric_limits<int>::max();
  std::int64_t wide = 0;
  if (!Integer(key, wide, narrow)) return false;
  target = static_cast<int>(wide);
  return true;
}

bool TomlTable::Flag(const std::string& key, bool& target) {
  const auto* node = static_cast<const toml::node*>(Ask(key));
  if (node == nullptr) return false;
  if (!node->is_boolean()) return Refuse(node, key, "true or false");
  target = node->as_boolean()->get();
  return true;
}

bool TomlTable::Text(const std::string& key, std::string& target) {
  const auto* node = static_cast<const toml::node*>(Ask(key));
  if (node == nullptr) return false;
  if (!node->is_string()) return Refuse(node, key, "text in quotes");
  target = node->as_string()->get();
  return true;
}

bool TomlTable::Choice(const std::string& key, std::string& target, const std::vector<std::string>& known) {
  const auto* node = static_cast<const toml::node*>(Ask(key));
  if (node == nullptr) return false;
  if (node->is_string() && std::find(known.begin(), known.end(), node->as_string()->get()) != known.end()) {
    target = node->as_string()->get();
    return true;
  }
  // `true` without quotes is meant by who writes it where it is a choice.
  if (node->is_boolean() && node->as_boolean()->get() &&
      std::find(known.begin(), known.end(), "true") != known.end()) {
    target = "true";
    return true;
  }
  return Refuse(node, key, fmt::format("one of {}", fmt::join(known, ", ")));
}

bool TomlTable::Vector(const std::string& key, Eigen::Vector3d& target, const Bounds& bounds) {
  const auto* node = static_cast<const toml::node*>(Ask(key));
  if (node == nullptr) return false;
  const auto* array = node->as_array();
  Eigen::Vector3d value;
  bool good = array != nullptr && array->size() == 3;
  for (size_t i = 0; good && i < 3; ++i) {
    const std::optional<double> number = NumberIn((*array)[i]);
    good = number && Takes(bounds, *number);
    if (good) value[static_cast<Eigen::Index>(i)] = *number;
  }
  if (!good) return Refuse(node, key, Expected(bounds, "three numbers [x, y, z], each"));
  target = value;
  return true;
}

bool TomlTable::Numbers(const std::string& key, std::vector<double>& target, const Bounds& bounds) {
  const auto* node = static_cast<const toml::node*>(Ask(key));
  if (node == nullptr) return false;
  const auto* array = node->as_array();
  std::vector<double> values;
  bool good = array != nullptr;
  for (size_t i = 0; good && i < array->size(); ++i) {
    const std::optional<double> number = NumberIn((*array)[i]);
    good = number && Takes(bounds, *number);
    if (good) values.push_back(*number);
  }
  if (!good) return Refuse(node, key, Expected(bounds, "a list of numbers, each"));
  target = std::move(values);
  return true;
}

TomlTable& TomlTable::Required() {
  required_ = true;
  return *this;
}

TomlTable TomlTable::Child(const void* table, const std::string& path) const {
  const auto* node = static_cast<const toml::table*>(table);
  TomlTable child;
  child.node_ = std::make_shared<Node>(
      Node{node_->document, node, path, node == nullptr ? node_->line : node->source().begin.line, {}});
  node_->document->nodes.push_back(child.node_);
  return child;
}

TomlTable TomlTable::Table(const std::string& key) {
  const auto* node = static_cast<const toml::node*>(Ask(key));
  const toml::table* table = node == nullptr ? nullptr : node->as_table();
  if (node != nullptr && table == nullptr) Refuse(node, key, "a table, [" + node_->Field(key) + "]");
  return Child(table, node_->Field(key));
}

std::vector<TomlTable> TomlTable::Tables(const std::string& key) {
  const auto* node = static_cast<const toml::node*>(Ask(key));
  std::vector<TomlTable> tables;
  if (node == nullptr) return tables;
  const auto* array = node->as_array();
  if (array == nullptr || !array->is_homogeneous(toml::node_type::table)) {
    if (array == nullptr || !array->empty()) Refuse(node, key, "tables, [[" + node_->Field(key) + "]]");
    return tables;
  }
  for (size_t i = 0; i < array->size(); ++i) {
    tables.push_back(Child((*array)[i].as_table(), fmt::format("{}[{}]", node_->Field(key), i)));
  }
  return tables;
}

bool TomlTable::Has(const std::string& key) const {
  return node_->table != nullptr && node_->table->contains(key);
}

bool TomlTable::exists() const { return node_->table != nullptr; }

void TomlTable::Skip() {
  if (node_->table == nullptr) return;
  for (const auto& [key, value] : *node_->table) node_->asked.insert(std::string(key.str()));
}

void TomlTable::Reject(const std::string& key, const std::string& expected) {
  const toml::node* node = node_->Find(key);
  if (node != nullptr) {
    Refuse(node, key, expected);
  } else {
    node_->Add(node_->line, node_->Field(key) + ": missing, expected " + expected);
  }
}

Result<TomlDocument> TomlDocument::Parse(const std::string& text, const std::string& name_in_messages) {
  TomlDocument document;
  document.state_ = std::make_shared<State>();
  State& state = *document.state_;
  state.name = name_in_messages;
  try {
    state.root = toml::parse(text, name_in_messages);
  } catch (const toml::parse_error& error) {
    return Error{ErrorKind::kBadInput, fmt::format("{}:{}: not TOML: {}", name_in_messages,
                                                   error.source().begin.line, error.description())};
  }
  document.root_.node_ = std::make_shared<TomlTable::Node>(TomlTable::Node{&state, &state.root, "", 1, {}});
  state.nodes.push_back(document.root_.node_);
  return document;
}

Result<TomlDocument> TomlDocument::Read(const std::filesystem::path& file) {
  const auto text = ReadText(file);
  if (!text.ok()) return text.error();
  return Parse(text.value(), file.string());
}

Status TomlDocument::Set(const std::vector<std::string>& settings) {
  for (const std::string& setting : settings) {
    if (Status set = SetInToml(state_->root, setting); !set.ok()) {
      return std::move(set).error().Within(state_->name);
    }
  }
  return Ok{};
}

TomlTable& TomlDocument::Root() { return root_; }

Status TomlDocument::Finish() {
  for (const auto& node : state_->nodes) {
    if (node->table == nullptr) continue;
    const std::vector<std::string> known(node->asked.begin(), node->asked.end());
    for (const auto& [key, value] : *node->table) {
      const std::string name(key.str());
      if (node->asked.contains(name)) continue;
      const std::optional<std::string> near = NearestName(name, known);
      const std::string help = near ? "did you mean " + node->Field(*near) + "?"
                                    : fmt::format("known here: {}", fmt::join(known, ", "));
      node->Add(value.source().path == nullptr ? key.source() : value.source(),
                fmt::format("{}: unknown key; {}", node->Field(name), help), true);
    }
  }
  auto& problems = state_->problems;
  if (problems.empty()) return Ok{};
  std::stable_sort(problems.begin(), problems.end(), [](const auto& a, const auto& b) {
    return a.unknown_key != b.unknown_key ? a.unknown_key : a.line < b.line;
  });
  const size_t more = problems.size() - 1;
  return Error{ErrorKind::kBadInput,
               problems.front().message + (more == 0 ? "" : fmt::format(" (and {} more)", more))};
}

}  // namespace tendril
