#include "db/derived_row.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

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

}  // namespace

void ForgetDerived(SQLite::Database& db, const std::string& table, const std::string& trial_id) {
  const std::int64_t old =
      Ask(db, fmt::format("SELECT coalesce((SELECT provenance_id FROM {} WHERE trial_id = ?), 0)", table),
          trial_id);
  Run(db, fmt::format("DELETE FROM {} WHERE trial_id = ?", table), trial_id);
  Run(db, "DELETE FROM provenance WHERE id = ?", old);
}

Status StoreDerived(Lab& lab, const std::vector<std::string>& trial_ids, const Provenance& provenance,
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

}  // namespace tendril
