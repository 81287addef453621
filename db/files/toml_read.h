#pragma once
// Reading our TOML files: each key is asked for once, with its target, bounds and unit. What was not asked
// for is an unknown key, and an error that suggests the nearest known one.
//
//   auto toml = TomlDocument::Parse(text, "paper.toml");          // syntax errors end here
//   TomlTable tentacle = toml.value().Table("tentacle");           // a missing table reads as empty
//   tentacle.Number("length", design.length, Above(0, "m"));       // optional: keeps the target's value
//   tentacle.Degrees("alpha_deg", design.alpha, Between(0, 180, "deg"));
//   tentacle.Required().Text("name", name);                        // the next key asked for must be there
//   if (Status s = toml.value().Finish(); !s.ok()) return s;      // the first error, as file:line: field:
//   ...

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/result.h"

namespace tendril {

// Which numbers a key takes.
struct Bounds {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;   // low itself is not taken
  bool high_open = false;  // nor high
  std::string unit;        // shown in messages
};
Bounds Finite(std::string unit = "");
Bounds Above(double low, std::string unit = "");
Bounds AtLeast(double low, std::string unit = "");
Bounds Between(double low, double high, std::string unit = "");  // both taken
Bounds Inside(double low, double high, std::string unit = "");   // neither taken

class TomlDocument;

// One table of a document. Reading never fails at once: the document keeps the errors until Finish().
class TomlTable {
 public:
  struct Node;  // the parsed table behind it

  // Targets keep their value where the key is absent. True if the key was there and good.
  bool Number(const std::string& key, double& target, const Bounds& bounds = Finite());
  bool Degrees(const std::string& key, double& target_rad, const Bounds& bounds_deg = Finite("deg"));
  bool Integer(const std::string& key, std::int64_t& target, const Bounds& bounds = Finite());
  bool Integer(const std::string& key, int& target, const Bounds& bounds = Finite());
  bool Flag(const std::string& key, bool& target);
  bool Text(const std::string& key, std::string& target);
  bool Choice(const std::string& key, std::string& target, const std::vector<std::string>& known);
  bool Vector(const std::string& key, Eigen::Vector3d& target, const Bounds& bounds = Finite());
  bool Numbers(const std::string& key, std::vector<double>& target, const Bounds& bounds = Finite());

  // The next key asked for must be there.
  TomlTable& Required();

  TomlTable Table(const std::string& key);                // [key]; empty where absent
  std::vector<TomlTable> Tables(const std::string& key);  // [[key]]

  bool Has(const std::string& key) const;  // does not count as asking
  bool exists() const;                     // whether the file has this table

  // All its keys count as asked for: something else is wrong with it.
  void Skip();

  // An error of the caller's own about one of this table's keys: `file:line: field = value: expected ...`.
  void Reject(const std::string& key, const std::string& expected);

 private:
  friend class TomlDocument;
  const void* Ask(const std::string& key);  // the key's node; null where absent
  bool Refuse(const void* value, const std::string& key, const std::string& expected);
  TomlTable Child(const void* table, const std::string& path) const;

  std::shared_ptr<Node> node_;
  bool required_ = false;
};

class TomlDocument {
 public:
  static Result<TomlDocument> Parse(const std::string& text, const std::string& name_in_messages);
  static Result<TomlDocument> Read(const std::filesystem::path& file);

  // Sets values before they are asked for (db/files/toml_edit.h); messages about such a value name the
  // setting instead of a line.
  Status Set(const std::vector<std::string>& settings);

  TomlTable& Root();
  TomlTable Table(const std::string& key) { return Root().Table(key); }
  std::vector<TomlTable> Tables(const std::string& key) { return Root().Tables(key); }

  // Unknown keys first (a misspelt key explains the missing one), then what was wrong, in the file's order.
  Status Finish();

 private:
  friend class TomlTable;
  struct State;
  std::shared_ptr<State> state_;
  TomlTable root_;
};

}  // namespace tendril
