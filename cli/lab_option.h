#pragma once
// `--lab DIR` as every command that needs a lab takes it.

#include <CLI/App.hpp>
#include <string>

#include "db/lab.h"
#include "model/result.h"

namespace tendril::cli {

void AddLabOption(CLI::App& app, std::string& folder);

// The lab in `folder`; where that is empty, the lab that the current folder is in.
Result<Lab> OpenLab(const std::string& folder);

}  // namespace tendril::cli
