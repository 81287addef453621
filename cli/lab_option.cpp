#include "cli/lab_option.h"

#include <filesystem>

namespace tendril::cli {

void AddLabOption(CLI::App& app, std::string& folder) {
  app.add_option("--lab", folder, "the lab's folder (default: the lab that the current folder is in)");
}

Result<Lab> OpenLab(const std::string& folder) {
  if (!folder.empty()) return Lab::Open(folder);
  std::error_code error;
  const auto found = Lab::Find(std::filesystem::current_path(error));
  if (!found.ok()) return found.error();
  return Lab::Open(found.value());
}

}  // namespace tendril::cli
