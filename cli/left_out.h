#pragma once
// Says which trials a rate leaves out or tells apart, so that nobody takes it for a rate of all.

#include <cstdint>

#include "cli/command.h"
#include "db/lab.h"
#include "db/trial_query.h"

namespace tendril::cli {

// Warns of simulations that are left out because they are not trusted, or because the lab has the same run
// again; the JSON has `left_out_untrusted` and `left_out_repeats`.
//   returns  how many are not trusted
//   errors   as CountLeftOut
Result<std::int64_t> TellLeftOut(Lab& lab, const RateQuestion& question, Output& out);

// Splits the question by test of holding where it would mix several, and says so.
//   errors  as SplitByTest
Status TellSplit(Lab& lab, RateQuestion& question, Output& out);

}  // namespace tendril::cli
