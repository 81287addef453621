#pragma once
// "Did you mean ...?"

#include <optional>
#include <string>
#include <vector>

namespace tendril {

// The known name nearest to `name` by edit distance (insert, delete, replace, swap of neighbours; case
// aside), or one that goes on where `name` ends (`beta_deg` for `beta`); none if all are too far to be a
// slip.
std::optional<std::string> NearestName(const std::string& name, const std::vector<std::string>& known);

}  // namespace tendril
