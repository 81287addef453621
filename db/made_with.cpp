#include "db/made_with.h"

#include <fmt/format.h>

#include "db/files/design_toml.h"
#include "db/files/safe_file.h"
#include "db/files/toml_write.h"
#include "db/statement.h"

namespace tendril {
namespace {

template <class... Values>
std::optional<std::int64_t> Find(SQLite::Database& db, const char* sql, const Values&... values) {
  SQLite::Statement query(db, sql);
  Bind(query, values...);
  if (!query.executeStep()) return std::nullopt;
  return query.getColumn(0).getInt64();
}

template <class... Values>
std::int64_t Add(SQLite::Database& db, const char* sql, const Values&... values) {
  Run(db, sql, values...);
  return db.getLastInsertRowid();
}

// The name, or name@<hash> where another content has it already.
std::string FreeLabel(SQLite::Database& db, const char* count_sql, const std::string& name,
                      const std::string& sha256) {
  std::string label = name;
  for (size_t digits = 7; digits <= sha256.size(); ++digits) {
    if (*Find(db, count_sql, label) == 0) return label;
    label = name + "@" + sha256.substr(0, digits);
  }
  return label;
}

// Degrees as a person would type them, not 74.99999999999999.
double Degrees(double radians) { return std::stod(TomlDegrees(radians)); }

std::int64_t StoreDesign(SQLite::Database& db, const std::string& name, const TentacleDesign& design) {
  const std::string toml = DesignToml(design);
  const std::string sha256 = Sha256(toml);
  if (const auto id = Find(db, "SELECT id FROM design WHERE name = ? AND sha256 = ?", name, sha256)) {
    return *id;
  }
  const std::string label =
      FreeLabel(db, "SELECT count(*) FROM design WHERE label = ?", name.empty() ? "unnamed" : name, sha256);
  return Add(db,
             "INSERT INTO design (label, name, sha256, toml, length_m, base_width_m, taper, unit_length_m, "
             "spacing_ratio, alpha_deg, beta_deg, holes) VALUES (?,?,?,?,?,?,?,?,?,?,?,?)",
             label, name, sha256, toml, design.length, design.base_width, design.taper, design.unit_length,
             design.spacing_ratio, Degrees(design.alpha), Degrees(design.beta), design.holes);
}

std::int64_t StoreGripper(SQLite::Database& db, const Gripper& gripper) {
  const std::string toml = GripperToml(gripper);
  const std::string sha256 = Sha256(toml);
  if (const auto id = Find(db, "SELECT id FROM gripper WHERE sha256 = ?", sha256)) return *id;
  return Add(db,
             "INSERT INTO gripper (sha256, toml, tentacles, carrier_radius_m, first_azimuth_deg, tilt_deg, "
             "handedness) VALUES (?,?,?,?,?,?,?)",
             sha256, toml, gripper.tentacles, gripper.carrier_radius, Degrees(gripper.first_azimuth),
             Degrees(gripper.tilt), NameOf(gripper.handedness));
}

// The object without its place: that belongs to the trial.
std::int64_t StoreObject(SQLite::Database& db, ObjectSpec object) {
  object.position.setZero();
  const std::string toml = ObjectToml(object);
  const std::string sha256 = Sha256(toml);
  if (const auto id = Find(db, "SELECT id FROM object WHERE sha256 = ?", sha256)) return *id;
  constexpr double kMmPerM = 1000;
  const std::string name =
      fmt::format("{} {:.4g} x {:.4g} mm", object.kind, 2 * object.radius * kMmPerM, object.length * kMmPerM);
  const std::string label = FreeLabel(db, "SELECT count(*) FROM object WHERE label = ?", name, sha256);
  return Add(db,
             "INSERT INTO object (label, sha256, toml, kind, radius_m, length_m, mass_kg) "
             "VALUES (?,?,?,?,?,?,?)",
             label, sha256, toml, object.kind, object.radius, object.length, object.mass);
}

std::int64_t StoreMedium(SQLite::Database& db, const std::string& name) {
  if (const auto id = Find(db, "SELECT id FROM medium WHERE name = ?", name)) return *id;
  return Add(db, "INSERT INTO medium (name, sha256) VALUES (?,?)", name, Sha256(name));
}

std::int64_t StoreRig(SQLite::Database& db, const std::string& name, const std::string& toml) {
  const std::string sha256 = Sha256(toml);
  if (const auto id = Find(db, "SELECT id FROM rig WHERE name = ? AND sha256 = ?", name, sha256)) return *id;
  const std::string label =
      FreeLabel(db, "SELECT count(*) FROM rig WHERE label = ?", name.empty() ? "unnamed" : name, sha256);
  return Add(db, "INSERT INTO rig (label, name, sha256, toml) VALUES (?,?,?,?)", label, name, sha256, toml);
}

}  // namespace

MadeWith StoreMadeWith(SQLite::Database& db, const TrialSpec& trial) {
  MadeWith made;
  made.design_id = StoreDesign(db, trial.design_name, trial.design);
  made.gripper_id = StoreGripper(db, trial.gripper);
  made.object_id = StoreObject(db, trial.object);
  made.medium_id = StoreMedium(db, trial.medium);
  if (!trial.rig_toml.empty()) made.rig_id = StoreRig(db, trial.rig_name, trial.rig_toml);
  return made;
}

}  // namespace tendril
