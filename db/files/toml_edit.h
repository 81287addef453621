#pragma once
// Values of a TOML file set from outside, before it is read: "object.0.position.2=-0.15".
//
// A setting is a path and a value. The path's steps are keys, and places in lists counted from 0; the value
// is TOML (`0.2`, `[0, 0, 1]`, `true`, `"text"`) or, where it is not, text without its quotes. A key or table
// that the file does not have is made; a place in a list must be there. Whether a key means anything is
// for the reader to say.

#include <string>
#include <vector>

#include "model/result.h"

namespace tendril {

// A file's text with the settings in it, in their order; without settings the text as it is. Comments go.
//   errors  kBadInput  not TOML (names the line); no `=`, a step that is empty or leads nowhere (names
//   setting,
//           step and what would do)
Result<std::string> EditedToml(const std::string& text, const std::string& name_in_messages,
                               const std::vector<std::string>& settings);

// A file's values alone, in an order and layout that depend on nothing else: texts that say the same give the
// same.
//   without  keys of the top that do not count
//   errors   kBadInput  not TOML (names the line)
Result<std::string> BareToml(const std::string& text, const std::string& name_in_messages,
                             const std::vector<std::string>& without = {});

}  // namespace tendril
