#pragma once
// A lab: a folder with lab.db, the files that people write, and a folder per trial (docs/database.md).

#include <filesystem>
#include <string>

#include "db/connection.h"
#include "model/result.h"

namespace tendril {

class Lab {
 public:
  // Makes lab.db, designs/, rigs/, scenes/, sweeps/ and trials/.
  //   errors  kBadInput there is a lab already; kIo not writable
  static Result<Lab> Create(const std::filesystem::path& folder);

  // Opens a lab and brings its database to this program's schema.
  //   errors  kNotFound no lab there (says how to make one); kBadInput not a database, or a newer schema
  //           (left untouched); kIo
  static Result<Lab> Open(const std::filesystem::path& folder);

  // The lab's folder that `start` is in: itself or the nearest one above.
  //   errors  kNotFound (says how to make or name one)
  static Result<std::filesystem::path> Find(const std::filesystem::path& start);

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path TrialFolder(const std::string& id) const { return folder_ / "trials" / id; }
  Connection& db() { return db_; }

 private:
  Lab(std::filesystem::path folder, Connection db) : folder_(std::move(folder)), db_(std::move(db)) {}

  std::filesystem::path folder_;
  Connection db_;
};

}  // namespace tendril
