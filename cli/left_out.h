#pragma once
// Says which trials a rate leaves out, so that nobody takes it for a rate of all.

#include <cstdint>

#include "cli/command.h"
#include "db/lab.h"
#include "db/trial_query.h"

namespace tendril::cli {

// Warns of simulations that are left out because they are not trusted; the JSON has `left_out_untrusted`.
//   returns  how many
//   errors   as CountLeftOut
Result<std::int64_t> TellLeftOut(Lab& lab, const RateQuestion& question, Output& out);

}  // namespace tendril::cli
