#pragma once
// A lab of its own for each test, and what tests do with it again and again.

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "db/lab.h"
#include "db/trial_store.h"
#include "tests/support/program.h"

namespace tendril::testing_support {

class LabTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto made = Lab::Create(folder_ / "lab");
    ASSERT_TRUE(made.ok()) << made.error().message;
    lab_ = std::make_unique<Lab>(std::move(made).value());
  }

  Lab& lab() { return *lab_; }

  std::string Begin(TrialSpec spec = TrialSpec()) {
    if (spec.design_name.empty()) spec.design_name = "paper";
    auto trial = BeginTrial(lab(), std::move(spec));
    EXPECT_TRUE(trial.ok()) << trial.error().message;
    return trial.ok() ? trial.value().id : "";
  }

  std::string Judged(bool grasped, TrialSpec spec) {
    const std::string id = Begin(std::move(spec));
    EXPECT_TRUE(SetTrialState(lab(), id, TrialState::kRecorded).ok());
    Judge(id, grasped, "ada", true);
    return id;
  }

  void Judge(const std::string& id, bool grasped, const std::string& by, bool person) {
    const Status s = AddOutcome(lab(), id, {.grasped = grasped, .judged_by = by, .by_person = person});
    EXPECT_TRUE(s.ok()) << s.error().message;
  }

  std::string Ask(const std::string& sql) {
    std::string answer;
    const Status s = lab().db().Read([&](SQLite::Database& db) -> Status {
      answer = db.execAndGet(sql).getString();
      return Ok{};
    });
    EXPECT_TRUE(s.ok()) << s.error().message;
    return answer;
  }

  Status Try(const std::string& sql) {
    return lab().db().Write([&](SQLite::Database& db) -> Status {
      db.exec(sql);
      return Ok{};
    });
  }

  TemporaryFolder folder_;
  std::unique_ptr<Lab> lab_;
};

}  // namespace tendril::testing_support
