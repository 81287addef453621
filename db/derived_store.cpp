// The derived rows of db/trial_store.h: tracks, link values, fits, each with its provenance.
#include <fmt/format.h>

#include <cmath>

#include "db/derived_row.h"
#include "db/statement.h"
#include "db/trial_store.h"

namespace tendril {
Status StoreTrack(Lab& lab, const std::string& id, const TrackRow& row, const Provenance& provenance) {
  return StoreDerived(lab, {id}, provenance, [&](SQLite::Database& db, std::int64_t made_from) {
    ForgetDerived(db, "track", id);
    Run(db,
        "INSERT INTO track (trial_id, provenance_id, frames, tentacles, rms_reprojection_px, seen_fraction, "
        "rms_sigma_m) VALUES (?,?,?,?,?,?,?)",
        id, made_from, row.frames, row.tentacles, row.rms_reprojection_px, row.seen_fraction,
        row.rms_sigma_m);
  });
}

Status StoreLink(Lab& lab, const std::string& id, const LinkRows& rows, const Provenance& provenance) {
  return StoreDerived(lab, {id}, provenance, [&](SQLite::Database& db, std::int64_t made_from) {
    ForgetDerived(db, "link_metrics", id);
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

Status StoreFit(Lab& lab, const FitRow& row, const Provenance& provenance) {
  if (row.trial_ids.empty()) return Error{ErrorKind::kBadInput, "fit: no trial, expected one or more"};
  for (const FitParameter& parameter : row.parameters) {
    if (!std::isfinite(parameter.value)) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("fit: {} = {}: expected a number", parameter.name, parameter.value)};
    }
  }
  return StoreDerived(lab, row.trial_ids, provenance, [&](SQLite::Database& db, std::int64_t made_from) {
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
