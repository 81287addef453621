#pragma once
// Whole files or none: text and data written beside the target, flushed to the disk, then renamed over it;
// and the hash by which a row says which file it was made from.

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "model/result.h"

namespace tendril {

// The whole file.  errors  kNotFound no such file; kIo not readable
Result<std::string> ReadText(const std::filesystem::path& file);

// Replaces the file by `text`. After a failure the target is what it was and nothing else is left.
//   errors  kNotFound no such folder; kIo disk full, not writable
Status WriteText(const std::filesystem::path& file, std::string_view text);

// The same for a library that writes files itself: `write` gets a name in the target's folder, with the
// target's extension; if it succeeds, that file is flushed and renamed over the target, else it is removed.
Status WriteBeside(const std::filesystem::path& file,
                   const std::function<Status(const std::filesystem::path& beside)>& write);

// SHA-256, 64 lower-case hexadecimal digits.
std::string Sha256(std::string_view bytes);
Result<std::string> Sha256OfFile(const std::filesystem::path& file);

}  // namespace tendril
