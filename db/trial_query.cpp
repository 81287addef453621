#include "db/trial_query.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "db/files/nearest_name.h"
#include "db/statement.h"

namespace tendril {
namespace {

// A rate key's column in the view grasp_rate_input. SQL is made of these columns only, never of what was
// typed.
struct Column {
  RateKey key;
  const char* column;
};

const std::vector<Column>& Columns() {
  static const std::vector<Column> columns = {
      {{"design", false, ""}, "design"},
      {{"taper", true, ""}, "taper"},
      {{"spacing_ratio", true, ""}, "spacing_ratio"},
      {{"alpha_deg", true, "deg"}, "alpha_deg"},
      {{"beta_deg", true, "deg"}, "beta_deg"},
      {{"tentacles", true, ""}, "tentacles"},
      {{"carrier_radius", true, "m"}, "carrier_radius_m"},
      {{"handedness", false, ""}, "handedness"},
      {{"object", false, ""}, "object"},
      {{"object_kind", false, ""}, "object_kind"},
      {{"object_radius", true, "m"}, "object_radius_m"},
      {{"object_mass", true, "kg"}, "object_mass_kg"},
      {{"medium", false, ""}, "medium"},
      {{"distance", true, "m"}, "distance_m"},
      {{"pull", true, ""}, "pull"},
      {{"pull_rate", true, "1/s"}, "pull_rate_per_s"},
      {{"rig", false, ""}, "rig"},
      {{"state", false, ""}, "state"},
      {{"judged_by", false, ""}, "judged_by"},
      {{"method", false, ""}, "method"},
      {{"test", false, ""}, "test"},
      {{"level", false, ""}, "level"},
      {{"friction", true, ""}, "friction"},
  };
  return columns;
}

Result<const Column*> ColumnOf(const std::string& option, const std::string& name) {
  std::vector<std::string> known;
  for (const Column& column : Columns()) {
    if (column.key.name == name) return &column;
    known.push_back(column.key.name);
  }
  if (name == "kind") {
    return Error{ErrorKind::kBadInput,
                 fmt::format("{} kind: kinds are never mixed in a rate; ask for one with "
                             "--kind real|virtual|simulated|published",
                             option)};
  }
  const auto near = NearestName(name, known);
  return Error{ErrorKind::kBadInput,
               fmt::format("{} {}: unknown name; {}", option, name,
                           near ? "did you mean " + *near + "?"
                                : fmt::format("expected one of {}", fmt::join(known, ", ")))};
}

constexpr const char* kOverview =
    "SELECT trial_id, label, kind, state, started_ns, design, object, medium, distance_m, pull, voided, "
    "grasped, trusted "
    "FROM trial_overview";

TrialOverview OverviewOf(SQLite::Statement& row) {
  TrialOverview trial;
  trial.id = row.getColumn(0).getString();
  trial.label = row.getColumn(1).getString();
  trial.kind = TrialKindOf(row.getColumn(2).getString()).value_or(TrialKind::kReal);
  trial.state = TrialStateOf(row.getColumn(3).getString()).value_or(TrialState::kRecording);
  trial.started_ns = row.getColumn(4).getInt64();
  trial.design = row.getColumn(5).getString();
  trial.object = row.getColumn(6).getString();
  trial.medium = row.getColumn(7).getString();
  trial.distance = row.getColumn(8).getDouble();
  trial.pull = row.getColumn(9).getDouble();
  trial.voided = row.getColumn(10).getInt() != 0;
  if (!row.getColumn(11).isNull()) trial.grasped = row.getColumn(11).getInt() != 0;
  trial.trusted = row.getColumn(12).getInt() != 0;
  return trial;
}

// `where` and kind of a question as SQL, with what is to be bound.
struct Condition {
  std::string sql = "kind = ?";
  std::vector<std::pair<std::optional<double>, std::string>> values{};  // a number, or the text

  void BindTo(SQLite::Statement& query) const {
    int at = 0;
    for (const auto& [number, text] : values) {
      ++at;
      if (number) {
        BindOne(query, at, *number);
      } else {
        BindOne(query, at, text);
      }
    }
  }
};

// Numbers are compared and grouped to 9 decimals: 0.15 typed by two programs is one distance.
Result<Condition> ConditionOf(const RateQuestion& question) {
  Condition condition;
  condition.values.emplace_back(std::nullopt, NameOf(question.kind));
  for (const auto& [name, value] : question.where) {
    const auto found = ColumnOf("--where", name);
    if (!found.ok()) return found.error();
    const Column& column = *found.value();
    if (!column.key.is_number) {
      condition.sql += fmt::format(" AND {} = ?", column.column);
      condition.values.emplace_back(std::nullopt, value);
      continue;
    }
    double number = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    if (error != std::errc{} || end != value.data() + value.size() || !std::isfinite(number)) {
      return Error{ErrorKind::kBadInput, fmt::format("--where {}={}: expected a number{}{}", name, value,
                                                     column.key.unit.empty() ? "" : " in ", column.key.unit)};
    }
    condition.sql += fmt::format(" AND round({}, 9) = round(?, 9)", column.column);
    condition.values.emplace_back(number, "");
  }
  return condition;
}

//   sql  one number of the trials that fit; ends where the condition goes
Result<std::int64_t> CountWhere(Lab& lab, const RateQuestion& question, const std::string& sql) {
  const Result<Condition> condition = ConditionOf(question);
  if (!condition.ok()) return condition.error();
  std::int64_t count = 0;
  const Status read = lab.db().Read([&](SQLite::Database& db) -> Status {
    SQLite::Statement query(db, sql + condition.value().sql);
    condition.value().BindTo(query);
    query.executeStep();
    count = query.getColumn(0).getInt64();
    return Ok{};
  });
  if (!read.ok()) return read.error();
  return count;
}

}  // namespace

Result<int> TrackedWithFoldLaw(Lab& lab, const std::vector<std::string>& ids) {
  int count = 0;
  const Status read = lab.db().Read([&](SQLite::Database& db) -> Status {
    // Rows of before the choice was given have no `fold_law`, but the law's sigma.
    SQLite::Statement row(db,
                          "SELECT coalesce(json_extract(p.parameters_json, '$.fold_law'), "
                          "json_extract(p.parameters_json, '$.sigma_angle_rad') IS NOT NULL) "
                          "FROM track JOIN provenance p ON p.id = provenance_id WHERE trial_id = ?");
    for (const std::string& id : ids) {
      row.reset();
      Bind(row, id);
      if (row.executeStep() && row.getColumn(0).getInt() != 0) ++count;
    }
    return Ok{};
  });
  if (!read.ok()) return read.error();
  return count;
}

Result<std::string> FindTrial(Lab& lab, const std::string& name) {
  constexpr size_t kShown = 5;
  std::vector<std::string> fitting;
  std::vector<std::string> labels;
  std::int64_t count = 0;
  const Status read = lab.db().Read([&](SQLite::Database& db) -> Status {
    SQLite::Statement exact(db, "SELECT id FROM trial WHERE id = ?1 OR label = ?1");
    Bind(exact, name);
    if (exact.executeStep()) {
      fitting = {exact.getColumn(0).getString()};
      count = 1;
      return Ok{};
    }
    SQLite::Statement query(db, "SELECT id, label FROM trial ORDER BY id");
    while (query.executeStep()) {
      const std::string id = query.getColumn(0).getString();
      labels.push_back(query.getColumn(1).getString());
      if (name.empty() || !id.starts_with(name)) continue;
      ++count;
      if (fitting.size() < kShown) fitting.push_back(id);
    }
    return Ok{};
  });
  if (!read.ok()) return read.error();
  if (count == 1) return fitting.front();
  if (count > 1) {
    return Error{ErrorKind::kBadInput, fmt::format("trial {}: {} ids begin so ({}{}); give more of it", name,
                                                   count, fmt::join(fitting, ", "),
                                                   count > static_cast<std::int64_t>(kShown) ? ", ..." : "")};
  }
  const auto near = NearestName(name, labels);
  return Error{ErrorKind::kNotFound,
               fmt::format("trial {}: no trial has this id or label{}", name,
                           near ? "; did you mean " + *near + "?" : "; `tendril trials list` shows all")};
}

Result<std::vector<TrialOverview>> ListTrials(Lab& lab, const TrialFilter& filter) {
  std::vector<TrialOverview> trials;
  const Status read = lab.db().Read([&](SQLite::Database& db) -> Status {
    SQLite::Statement query(db, std::string(kOverview) +
                                    " WHERE (?1 IS NULL OR kind = ?1) AND (?2 IS NULL OR state = ?2) "
                                    "AND (?3 IS NULL OR design = ?3) ORDER BY trial_id");
    std::optional<std::string> kind;
    std::optional<std::string> state;
    if (filter.kind) kind = NameOf(*filter.kind);
    if (filter.state) state = NameOf(*filter.state);
    Bind(query, kind, state, filter.design);
    while (query.executeStep()) trials.push_back(OverviewOf(query));
    return Ok{};
  });
  if (!read.ok()) return read.error();
  return trials;
}

Result<TrialSpec> LoadTrial(Lab& lab, const std::string& id) {
  return ReadTrialToml(lab.TrialFolder(id) / "trial.toml");
}

const std::vector<RateKey>& RateKeys() {
  static const std::vector<RateKey> keys = [] {
    std::vector<RateKey> all;
    for (const Column& column : Columns()) all.push_back(column.key);
    return all;
  }();
  return keys;
}

Result<std::vector<RateGroup>> CountGrasps(Lab& lab, const RateQuestion& question) {
  std::vector<std::string> by;
  std::vector<const Column*> columns;
  for (const std::string& name : question.by) {
    const auto column = ColumnOf("--by", name);
    if (!column.ok()) return column.error();
    columns.push_back(column.value());
    by.push_back(column.value()->key.is_number ? fmt::format("round({}, 9)", column.value()->column)
                                               : column.value()->column);
  }
  const Result<Condition> condition = ConditionOf(question);
  if (!condition.ok()) return condition.error();
  const std::string list = fmt::format("{}", fmt::join(by, ", "));
  const std::string sql = fmt::format(
      "SELECT count(*), coalesce(sum(grasped), 0){}{} FROM {} WHERE {} {} {}", by.empty() ? "" : ", ", list,
      question.include_untrusted ? "judged_trial" : "grasp_rate_input", condition.value().sql,
      by.empty() ? "" : "GROUP BY " + list, by.empty() ? "" : "ORDER BY " + list);
  std::vector<RateGroup> groups;
  const Status read = lab.db().Read([&](SQLite::Database& db) -> Status {
    SQLite::Statement query(db, sql);
    condition.value().BindTo(query);
    while (query.executeStep()) {
      RateGroup group;
      group.trials = query.getColumn(0).getInt64();
      group.grasped = query.getColumn(1).getInt64();
      for (size_t i = 0; i < columns.size(); ++i) {
        const SQLite::Column cell = query.getColumn(static_cast<int>(i) + 2);
        group.keys.emplace_back(columns[i]->key.name, columns[i]->key.is_number && !cell.isNull()
                                                          ? fmt::format("{}", cell.getDouble())
                                                          : cell.getString());
      }
      if (group.trials > 0) groups.push_back(std::move(group));
    }
    return Ok{};
  });
  if (!read.ok()) return read.error();
  return groups;
}

Result<std::int64_t> CountLeftOut(Lab& lab, const RateQuestion& question) {
  if (question.include_untrusted) return std::int64_t{0};
  return CountWhere(lab, question, "SELECT count(*) FROM judged_trial WHERE NOT trusted AND ");
}

Result<std::int64_t> CountRepeats(Lab& lab, const RateQuestion& question) {
  return CountWhere(
      lab, question,
      "SELECT count(*) FROM judged_run WHERE trial_id NOT IN (SELECT trial_id FROM judged_trial) "
      "AND ");
}

Result<bool> SplitByTest(Lab& lab, RateQuestion& question) {
  if (question.kind != TrialKind::kSimulated) return false;
  const auto asks = [](const std::string& name) { return name == "test"; };
  if (std::any_of(question.by.begin(), question.by.end(), asks) ||
      std::any_of(question.where.begin(), question.where.end(),
                  [&](const auto& w) { return asks(w.first); })) {
    return false;
  }
  RateQuestion tests = question;
  tests.by = {"test"};
  const Result<std::vector<RateGroup>> groups = CountGrasps(lab, tests);
  if (!groups.ok()) return groups.error();
  if (groups.value().size() < 2) return false;
  question.by.insert(question.by.begin(), "test");
  return true;
}

Result<std::vector<std::pair<TrialKind, std::int64_t>>> JudgedByKind(Lab& lab) {
  std::vector<std::pair<TrialKind, std::int64_t>> counts;
  const Status read = lab.db().Read([&](SQLite::Database& db) -> Status {
    SQLite::Statement query(db, "SELECT kind, count(*) FROM grasp_rate_input GROUP BY kind ORDER BY kind");
    while (query.executeStep()) {
      if (const auto kind = TrialKindOf(query.getColumn(0).getString())) {
        counts.emplace_back(*kind, query.getColumn(1).getInt64());
      }
    }
    return Ok{};
  });
  if (!read.ok()) return read.error();
  return counts;
}

}  // namespace tendril
