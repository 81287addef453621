#pragma once
// What rows that were made from a trial have in common: they replace the ones before, and come with what they
// were made from.

#include <SQLiteCpp/Database.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "db/lab.h"
#include "db/provenance.h"
#include "model/result.h"

namespace tendril {

// Deletes a trial's row of a derived table, with the provenance that only it had.
void ForgetDerived(SQLite::Database& db, const std::string& table, const std::string& trial_id);

// Checks, then runs `work` with the new provenance's id in one transaction.
//   errors  kNotFound no such trial; kBadInput provenance that is none; kIo
Status StoreDerived(Lab& lab, const std::vector<std::string>& trial_ids, const Provenance& provenance,
                    const std::function<void(SQLite::Database&, std::int64_t)>& work);

}  // namespace tendril
