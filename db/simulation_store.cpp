#include "db/simulation_store.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "db/derived_row.h"
#include "db/files/safe_file.h"
#include "db/statement.h"

namespace tendril {
namespace {

std::optional<std::string> OrNone(const std::string& text) {
  return text.empty() ? std::nullopt : std::optional(text);
}

double NumberAt(SQLite::Statement& row, const char* column) {
  const SQLite::Column cell = row.getColumn(column);
  return cell.isNull() ? kNotKnown : cell.getDouble();
}

// Empty where it is not known.
std::string TextAt(SQLite::Statement& row, const char* column) {
  const SQLite::Column cell = row.getColumn(column);
  return cell.isNull() ? "" : cell.getString();
}

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

HoldingRow HoldingAt(SQLite::Statement& row) {
  HoldingRow holding;
  holding.test = TextAt(row, "test");
  holding.lifted = row.getColumn("lifted").getInt() != 0;
  holding.held = row.getColumn("held").getInt() != 0;
  holding.rise_m = NumberAt(row, "rise_m");
  holding.shift_m = NumberAt(row, "shift_m");
  holding.payload_kg = NumberAt(row, "payload_kg");
  holding.payload_is_least = row.getColumn("payload_is_least").getInt() != 0;
  holding.payload_by_rods_mass = NumberAt(row, "payload_by_rods_mass");
  if (!row.getColumn("strikes").isNull()) holding.strikes = row.getColumn("strikes").getInt64();
  holding.release_s = NumberAt(row, "release_s");
  holding.rule = TextAt(row, "rule");
  holding.begins_s = NumberAt(row, "begins_s");
  return holding;
}

}  // namespace

Status StoreSimulation(Lab& lab, const std::string& id, const SimulationRow& row,
                       const Provenance& provenance) {
  if (!nlohmann::json::accept(row.terms_json)) {
    return Error{ErrorKind::kBadInput, fmt::format("simulation: terms = {}: expected JSON", row.terms_json)};
  }
  const std::string sha256 = Sha256(row.scene_toml);
  return StoreDerived(lab, {id}, provenance, [&](SQLite::Database& db, std::int64_t made_from) {
    Run(db, "INSERT INTO scene (name, sha256, toml) VALUES (?,?,?) ON CONFLICT (sha256) DO NOTHING",
        row.scene_name, sha256, row.scene_toml);
    const std::int64_t scene = Ask(db, "SELECT id FROM scene WHERE sha256 = ?", sha256);
    ForgetDerived(db, "simulation", id);
    const double passed = row.nothing_passed ? (*row.nothing_passed ? 1.0 : 0.0) : kNotKnown;
    Run(db,
        "INSERT INTO simulation (trial_id, provenance_id, scene_id, level, seed, trial_number, time_step_s, "
        "steps, simulated_s, wall_s, terms_json, least_axis_distance_m, least_axis_share, longest_move_m, "
        "nothing_passed, divergence, trusted, doubts, longest_stick_share, friction, medium, run_key) "
        "VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)",
        id, made_from, scene, row.level, row.seed, row.trial_number, row.time_step_s, row.steps,
        row.simulated_s, row.wall_s, row.terms_json, row.least_axis_distance_m, row.least_axis_share,
        row.longest_move_m, passed, OrNone(row.divergence),  // passed: SQLite keeps 1.0 as the integer 1
        row.doubts.empty() ? 1 : 0, fmt::format("{}", fmt::join(row.doubts, "\n")), row.longest_stick_share,
        row.friction, OrNone(row.medium), OrNone(row.run_key));
    if (!row.holding) return;
    const HoldingRow& holding = *row.holding;
    Run(db,
        "INSERT INTO holding (trial_id, test, lifted, held, rise_m, shift_m, payload_kg, payload_is_least, "
        "payload_by_rods_mass, strikes, release_s, rule, begins_s) VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?)",
        id, holding.test, holding.lifted ? 1 : 0, holding.held ? 1 : 0, holding.rise_m, holding.shift_m,
        holding.payload_kg, holding.payload_is_least ? 1 : 0, holding.payload_by_rods_mass, holding.strikes,
        holding.release_s, holding.rule, holding.begins_s);
  });
}

Result<std::optional<StoredSimulation>> LoadSimulation(Lab& lab, const std::string& id) {
  std::optional<StoredSimulation> found;
  const Status read = lab.db().Read([&](SQLite::Database& db) -> Status {
    SQLite::Statement row(db,
                          "SELECT s.*, scene.name AS scene_name, scene.toml AS scene_toml, h.* "
                          "FROM simulation s JOIN scene ON scene.id = s.scene_id "
                          "LEFT JOIN holding h ON h.trial_id = s.trial_id WHERE s.trial_id = ?");
    Bind(row, id);
    if (!row.executeStep()) return Ok{};
    SimulationRow& simulation = found.emplace().row;
    simulation.scene_name = TextAt(row, "scene_name");
    simulation.scene_toml = TextAt(row, "scene_toml");
    simulation.level = TextAt(row, "level");
    simulation.seed = row.getColumn("seed").getInt64();
    simulation.trial_number = row.getColumn("trial_number").getInt64();
    simulation.time_step_s = NumberAt(row, "time_step_s");
    simulation.steps = row.getColumn("steps").getInt64();
    simulation.simulated_s = NumberAt(row, "simulated_s");
    simulation.wall_s = NumberAt(row, "wall_s");
    simulation.terms_json = TextAt(row, "terms_json");
    simulation.least_axis_distance_m = NumberAt(row, "least_axis_distance_m");
    simulation.least_axis_share = NumberAt(row, "least_axis_share");
    simulation.longest_move_m = NumberAt(row, "longest_move_m");
    if (!row.getColumn("nothing_passed").isNull()) {
      simulation.nothing_passed = row.getColumn("nothing_passed").getInt() != 0;
    }
    simulation.divergence = TextAt(row, "divergence");
    simulation.doubts = Lines(TextAt(row, "doubts"));
    simulation.longest_stick_share = NumberAt(row, "longest_stick_share");
    simulation.friction = NumberAt(row, "friction");
    simulation.medium = TextAt(row, "medium");
    simulation.run_key = TextAt(row, "run_key");
    found->trusted = row.getColumn("trusted").getInt() != 0;
    if (!row.getColumn("test").isNull()) simulation.holding = HoldingAt(row);
    return Ok{};
  });
  if (!read.ok()) return read.error();
  return found;
}

Result<std::optional<std::string>> FindRun(Lab& lab, const std::string& run_key,
                                           const std::string& program_version) {
  std::optional<std::string> label;
  const Status read = lab.db().Read([&](SQLite::Database& db) -> Status {
    SQLite::Statement row(
        db,
        "SELECT t.label FROM simulation s JOIN trial t ON t.id = s.trial_id "
        "JOIN provenance p ON p.id = s.provenance_id "
        "WHERE s.run_key = ? AND p.program_version = ? AND t.state IN ('recorded', 'degraded') "
        "AND NOT EXISTS (SELECT 1 FROM void WHERE void.trial_id = t.id) "
        "ORDER BY t.id DESC LIMIT 1");
    Bind(row, run_key, program_version);
    if (row.executeStep()) label = row.getColumn(0).getString();
    return Ok{};
  });
  if (!read.ok()) return read.error();
  return label;
}

}  // namespace tendril
