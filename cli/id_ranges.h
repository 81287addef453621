#pragma once
// Sets of ids as people write them: "0-97,120".

#include <string>
#include <vector>

#include "model/result.h"

namespace tendril::cli {

//   returns  ascending, each once
//   errors   kBadInput: no number, a range that falls, an id below 0 or above 99,999 (names it)
Result<std::vector<int>> ParseIds(const std::string& text);

// "0-3, 7", "10-20 by 2"; "none" of none.
//   ids  ascending
std::string IdsInWords(const std::vector<int>& ids);

}  // namespace tendril::cli
