#include "db/trial_details.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ctime>

#include "db/statement.h"

namespace tendril {
namespace {

std::optional<double> NumberAt(SQLite::Statement& row, int at) {
  const SQLite::Column cell = row.getColumn(at);
  if (cell.isNull()) return std::nullopt;
  return cell.getDouble();
}

std::optional<std::int64_t> WholeAt(SQLite::Statement& row, int at) {
  const SQLite::Column cell = row.getColumn(at);
  if (cell.isNull()) return std::nullopt;
  return cell.getInt64();
}

void ReadFiles(SQLite::Database& db, const std::string& id, TrialDetails& details) {
  SQLite::Statement row(
      db, "SELECT role, file, sha256, frames, dropped FROM recording WHERE trial_id = ? ORDER BY role");
  Bind(row, id);
  while (row.executeStep()) {
    details.files.push_back({row.getColumn(0).getString(), row.getColumn(1).getString(),
                             row.getColumn(2).getString(), WholeAt(row, 3), WholeAt(row, 4)});
  }
}

std::vector<std::pair<std::string, std::string>> InputsOf(SQLite::Database& db, std::int64_t provenance) {
  std::vector<std::pair<std::string, std::string>> inputs;
  SQLite::Statement row(db,
                        "SELECT name, sha256 FROM provenance_input WHERE provenance_id = ? ORDER BY name");
  Bind(row, provenance);
  while (row.executeStep()) inputs.emplace_back(row.getColumn(0).getString(), row.getColumn(1).getString());
  return inputs;
}

// One derived row: what it was made from first, then its numbers.
void ReadResult(SQLite::Database& db, const std::string& what, const std::string& table,
                const std::vector<std::string>& columns, const std::string& id, TrialDetails& details) {
  SQLite::Statement row(db, fmt::format("SELECT p.made_ns, p.program_version, p.parameters_json, p.id, {} "
                                        "FROM {} JOIN provenance p ON p.id = "
                                        "provenance_id WHERE trial_id = ?",
                                        fmt::join(columns, ", "), table));
  Bind(row, id);
  while (row.executeStep()) {
    DerivedResult result{.what = what,
                         .values = {},
                         .made_ns = row.getColumn(0).getInt64(),
                         .program_version = row.getColumn(1).getString(),
                         .parameters_json = row.getColumn(2).getString(),
                         .input_sha256 = InputsOf(db, row.getColumn(3).getInt64())};
    for (size_t i = 0; i < columns.size(); ++i) {
      result.values.emplace_back(columns[i], NumberAt(row, static_cast<int>(i) + 4));
    }
    details.results.push_back(std::move(result));
  }
}

void ReadFits(SQLite::Database& db, const std::string& id, TrialDetails& details) {
  SQLite::Statement row(
      db,
      "SELECT f.id, f.scope, p.made_ns, p.program_version, q.name, q.value "
      "FROM fit_trial t JOIN fit f ON f.id = t.fit_id "
      "JOIN provenance p ON p.id = f.provenance_id "
      "LEFT JOIN fit_parameter q ON q.fit_id = f.id WHERE t.trial_id = ? ORDER BY f.id, q.name");
  Bind(row, id);
  while (row.executeStep()) {
    const std::string what =
        fmt::format("fit {} ({})", row.getColumn(0).getInt64(), row.getColumn(1).getString());
    if (details.results.empty() || details.results.back().what != what) {
      details.results.push_back(
          {what, {}, row.getColumn(2).getInt64(), row.getColumn(3).getString(), {}, {}});
    }
    if (!row.getColumn(4).isNull()) {
      details.results.back().values.emplace_back(row.getColumn(4).getString(), NumberAt(row, 5));
    }
  }
}

void ReadEvents(SQLite::Database& db, const std::string& id, TrialDetails& details) {
  SQLite::Statement row(
      db,
      "SELECT o.at_ns, CASE o.grasped WHEN 1 THEN 'success' ELSE 'failure' END, o.judged_by, o.by_person, "
      "c.id IS NOT NULL, o.method || CASE WHEN o.method <> '' AND o.notes <> '' THEN ': ' ELSE '' END || "
      "o.notes, o.load_N FROM outcome o LEFT JOIN outcome_current c ON c.id = o.id WHERE o.trial_id = ?1 "
      "UNION ALL SELECT at_ns, 'note', author, 1, 0, text, NULL FROM note WHERE trial_id = ?1 "
      "UNION ALL SELECT at_ns, 'label', author, 1, 0, word, NULL FROM label WHERE trial_id = ?1 "
      "UNION ALL SELECT at_ns, 'void', author, 1, 0, reason, NULL FROM void WHERE trial_id = ?1 "
      "ORDER BY 1");
  Bind(row, id);
  while (row.executeStep()) {
    details.events.push_back({row.getColumn(0).getInt64(), row.getColumn(1).getString(),
                              row.getColumn(2).getString(), row.getColumn(3).getInt() != 0,
                              row.getColumn(4).getInt() != 0, row.getColumn(5).getString(),
                              NumberAt(row, 6)});
  }
}

}  // namespace

Result<TrialDetails> TrialDetailsOf(Lab& lab, const std::string& id) {
  const auto all = ListTrials(lab);
  if (!all.ok()) return all.error();
  const auto found = std::find_if(all.value().begin(), all.value().end(),
                                  [&](const TrialOverview& trial) { return trial.id == id; });
  if (found == all.value().end()) {
    return Error{ErrorKind::kNotFound, fmt::format("no trial with id {}", id)};
  }
  TrialDetails details;
  details.overview = *found;
  const Status read = lab.db().Read([&](SQLite::Database& db) -> Status {
    SQLite::Statement trial(db, "SELECT state_reason, notes FROM trial WHERE id = ?");
    Bind(trial, id);
    trial.executeStep();
    details.state_reason = trial.getColumn(0).getString();
    details.notes = trial.getColumn(1).getString();
    ReadFiles(db, id, details);
    ReadResult(db, "track", "track",
               {"frames", "tentacles", "rms_reprojection_px", "seen_fraction", "rms_sigma_m"}, id, details);
    ReadResult(db, "link", "link_metrics",
               {"mutual_link", "object_link", "performance", "mutual_link_at_zero", "object_link_at_zero",
                "performance_at_zero"},
               id, details);
    ReadFits(db, id, details);
    ReadEvents(db, id, details);
    return Ok{};
  });
  if (!read.ok()) return read.error();
  Result<std::optional<StoredSimulation>> simulation = LoadSimulation(lab, id);
  if (!simulation.ok()) return simulation.error();
  details.simulation = std::move(simulation).value();
  return details;
}

std::string UtcText(std::int64_t ns) {
  constexpr std::int64_t kNsPerSecond = 1'000'000'000;
  const std::time_t seconds = ns / kNsPerSecond;
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S", &parts);
  return text.data();
}

}  // namespace tendril
