// The derived rows of db/trial_store.h: tracks, link values, fits, each with its provenance.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "db/files/safe_file.h"
#include "db/simulation_store.h"
#include "db/statement.h"
#include "db/trial_store.h"

namespace tendril {
namespace {

Status CheckProvenance(const Provenance& provenance) {
  if (!nlohmann::json::accept(provenance.parameters_json)) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("provenance: parameters = {}: expected JSON", provenance.parameters_json)};
  }
  std::set<std::string> names;
  for (const auto& [name, sha256] : provenance.input_sha256) {
    if (sha256.size() != 64 || !names.insert(name).second) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("provenance: input {} = {}: expected one SHA-256 per name", name, sha256)};
    }
  }
  return Ok{};
}

std::int64_t InsertProvenance(SQLite::Database& db, const Provenance& provenance) {
  Run(db, "INSERT INTO provenance (made_ns, program_version, parameters_json) VALUES (?,?,?)", NowNs(),
      provenance.program_version, provenance.parameters_json);
  const std::int64_t id = db.getLastInsertRowid();
  for (const auto& [name, sha256] : provenance.input_sha256) {
    Run(db, "INSERT INTO provenance_input (provenance_id, name, sha256) VALUES (?,?,?)", id, name, sha256);
  }
  return id;
}

// Deletes a trial's row of a derived table, with the provenance that only it had.
void Forget(SQLite::Database& db, const std::string& table, const std::string& trial_id) {
  const std::int64_t old =
      Ask(db, fmt::format("SELECT coalesce((SELECT provenance_id FROM {} WHERE trial_id = ?), 0)", table),
          trial_id);
  Run(db, fmt::format("DELETE FROM {} WHERE trial_id = ?", table), trial_id);
  Run(db, "DELETE FROM provenance WHERE id = ?", old);
}

// Checks, then runs `work` with the new provenance's id in one transaction.
Status Store(Lab& lab, const std::vector<std::string>& trial_ids, const Provenance& provenance,
             const std::function<void(SQLite::Database&, std::int64_t)>& work) {
  if (Status good = CheckProvenance(provenance); !good.ok()) return good;
  return lab.db().Write([&](SQLite::Database& db) -> Status {
    for (const std::string& id : trial_ids) {
      if (Ask(db, "SELECT count(*) FROM trial WHERE id = ?", id) == 0) {
        return Error{ErrorKind::kNotFound, fmt::format("no trial with id {}", id)};
      }
    }
    work(db, InsertProvenance(db, provenance));
    return Ok{};
  });
}

}  // namespace

Status StoreTrack(Lab& lab, const std::string& id, const TrackRow& row, const Provenance& provenance) {
  return Store(lab, {id}, provenance, [&](SQLite::Database& db, std::int64_t made_from) {
    Forget(db, "track", id);
    Run(db,
        "INSERT INTO track (trial_id, provenance_id, frames, tentacles, rms_reprojection_px, seen_fraction, "
        "rms_sigma_m) VALUES (?,?,?,?,?,?,?)",
        id, made_from, row.frames, row.tentacles, row.rms_reprojection_px, row.seen_fraction,
        row.rms_sigma_m);
  });
}

Status StoreLink(Lab& lab, const std::string& id, const LinkRows& rows, const Provenance& provenance) {
  return Store(lab, {id}, provenance, [&](SQLite::Database& db, std::int64_t made_from) {
    Forget(db, "link_metrics", id);
    Run(db,
        "INSERT INTO link_metrics (trial_id, provenance_id, mutual_link, object_link, performance, "
        "mutual_link_at_zero, object_link_at_zero, performance_at_zero) VALUES (?,?,?,?,?,?,?,?)",
        id, made_from, rows.mutual_link, rows.object_link, rows.performance, rows.mutual_link_at_zero,
        rows.object_link_at_zero, rows.performance_at_zero);
    SQLite::Statement tentacle(db,
                               "INSERT INTO link_tentacle (trial_id, frame, tentacle, time_s, self_link, "
                               "object_link, object_gauss, flags) VALUES (?,?,?,?,?,?,?,?)");
    for (const TentacleLinkRow& row : rows.tentacles) {
      RunAgain(tentacle, id, row.frame, row.tentacle, row.time_s, row.self_link, row.object_link,
               row.object_gauss, row.flags);
    }
    SQLite::Statement pair(db,
                           "INSERT INTO link_pair (trial_id, frame, tentacle_a, tentacle_b, time_s, link, "
                           "gauss, flags) VALUES (?,?,?,?,?,?,?,?)");
    for (const PairLinkRow& row : rows.pairs) {
      RunAgain(pair, id, row.frame, row.a, row.b, row.time_s, row.link, row.gauss, row.flags);
    }
  });
}

Status StoreSimulation(Lab& lab, const std::string& id, const SimulationRow& row,
                       const Provenance& provenance) {
  if (!nlohmann::json::accept(row.terms_json)) {
    return Error{ErrorKind::kBadInput, fmt::format("simulation: terms = {}: expected JSON", row.terms_json)};
  }
  const std::string sha256 = Sha256(row.scene_toml);
  return Store(lab, {id}, provenance, [&](SQLite::Database& db, std::int64_t made_from) {
    Run(db, "INSERT INTO scene (name, sha256, toml) VALUES (?,?,?) ON CONFLICT (sha256) DO NOTHING",
        row.scene_name, sha256, row.scene_toml);
    const std::int64_t scene = Ask(db, "SELECT id FROM scene WHERE sha256 = ?", sha256);
    Forget(db, "simulation", id);
    const double passed = row.nothing_passed ? (*row.nothing_passed ? 1.0 : 0.0) : kNotKnown;
    const auto divergence = row.divergence.empty() ? std::nullopt : std::optional(row.divergence);
    Run(db,
        "INSERT INTO simulation (trial_id, provenance_id, scene_id, level, seed, trial_number, time_step_s, "
        "steps, simulated_s, wall_s, terms_json, least_axis_distance_m, least_axis_share, longest_move_m, "
        "nothing_passed, divergence) VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)",
        id, made_from, scene, row.level, row.seed, row.trial_number, row.time_step_s, row.steps,
        row.simulated_s, row.wall_s, row.terms_json, row.least_axis_distance_m, row.least_axis_share,
        row.longest_move_m, passed, divergence);  // passed: SQLite keeps 1.0 as the integer 1
  });
}

Status StoreFit(Lab& lab, const FitRow& row, const Provenance& provenance) {
  if (row.trial_ids.empty()) return Error{ErrorKind::kBadInput, "fit: no trial, expected one or more"};
  for (const FitParameter& parameter : row.parameters) {
    if (!std::isfinite(parameter.value)) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("fit: {} = {}: expected a number", parameter.name, parameter.value)};
    }
  }
  return Store(lab, row.trial_ids, provenance, [&](SQLite::Database& db, std::int64_t made_from) {
    Run(db, "INSERT INTO fit (provenance_id, model, scope, residual_rms_m) VALUES (?,?,?,?)", made_from,
        row.model, row.scope, row.residual_rms_m);
    const std::int64_t fit = db.getLastInsertRowid();
    for (const std::string& id : row.trial_ids) {
      Run(db, "INSERT INTO fit_trial (fit_id, trial_id) VALUES (?,?)", fit, id);
    }
    for (const FitParameter& parameter : row.parameters) {
      Run(db,
          "INSERT INTO fit_parameter (fit_id, name, value, standard_error, identified, true_value) "
          "VALUES (?,?,?,?,?,?)",
          fit, parameter.name, parameter.value, parameter.standard_error, parameter.identified ? 1 : 0,
          parameter.true_value);
    }
  });
}

}  // namespace tendril
