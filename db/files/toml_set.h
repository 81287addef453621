#pragma once
// Sets one value of a parsed TOML file (db/files/toml_edit.h); what toml_read and toml_edit share.

#include <toml++/toml.h>

#include <string>

#include "model/result.h"

namespace tendril {

// The value keeps the setting as the place that it came from, for messages.
Status SetInToml(toml::table& root, const std::string& setting);

}  // namespace tendril
