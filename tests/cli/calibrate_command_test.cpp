// tendril calibrate fold, through the built program: a lab of virtual trials (curves and servo logs written
// here) to parameters and a row in the database; calls that cannot be.
#include <SQLiteCpp/Database.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "db/files/curve_files.h"
#include "db/files/design_toml.h"
#include "db/files/recording_logs.h"
#include "db/lab.h"
#include "db/trial_store.h"
#include "tests/support/perturbed_tentacle.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using testing_support::RunProgram;
using testing_support::TemporaryFolder;

class CalibrateFoldCommand : public testing::Test {
 protected:
  void SetUp() override {
    auto lab = Lab::Create(folder_.path() / "lab");
    ASSERT_TRUE(lab.ok()) << lab.error().message;
  }

  // A trial whose tentacles follow their servos at once: ramp for 10 s, then 2 s of rest.
  void AddTrial(const std::string& label, const TentacleDesign& design, const std::string& design_name,
                std::uint64_t seed, const std::vector<int>& tracked = {0, 1}) {
    auto lab = Lab::Open(folder_.path() / "lab");
    ASSERT_TRUE(lab.ok()) << lab.error().message;
    TrialSpec spec;
    spec.label = label;
    spec.kind = TrialKind::kVirtual;
    spec.started_ns = 1'700'000'000'000'000'000;
    spec.design = design;
    spec.design_name = design_name;
    spec.gripper.tentacles = 2;
    const auto begun = BeginTrial(lab.value(), spec);
    ASSERT_TRUE(begun.ok()) << begun.error().message;
    const std::filesystem::path trial = lab.value().TrialFolder(begun.value().id);
    const auto command = [](double t) { return std::clamp(0.03 * t, 0.0, 0.3); };

    test::Random random(seed);
    std::vector<CurveSeries> curves;
    std::vector<ServoRow> rows;
    for (const int i : tracked) {
      CurveSeries& series = curves.emplace_back();
      series.name = "tentacle" + std::to_string(i);
      series.time = Eigen::VectorXd::LinSpaced(7, 0, 12);
      const auto shape = test::Draw(DesignOfTentacle(spec.gripper, design, i), {0.9, 1.3, 1.2}, {}, random);
      for (const double time : series.time) {
        FoldObservation o;
        test::Observe(test::HolesAt(shape, 0.9 * command(time)), {}, random, o);
        series.curves.push_back(o.curve);
        series.sigma.push_back(o.sigma);
        series.interpolated.push_back(o.interpolated);
      }
    }
    for (int tick = 0; tick <= 240; ++tick) {
      for (int i = 0; i < 2; ++i) {
        ServoRow row;
        row.host_ns = spec.started_ns + std::int64_t{50'000'000} * tick;
        row.servo = i;
        row.command = command(0.05 * tick);
        rows.push_back(row);
      }
    }
    ASSERT_TRUE(WriteCurves(trial / "curves.h5", curves, "test").ok());
    ASSERT_TRUE(WriteServoLog(trial / "servo.csv", rows).ok());
    ASSERT_TRUE(SetTrialState(lab.value(), begun.value().id, TrialState::kRecorded).ok());
  }

  testing_support::ProgramRun Calibrate(std::vector<std::string> more) {
    std::vector<std::string> call = {"calibrate", "fold", "--lab", folder_ / "lab"};
    call.insert(call.end(), more.begin(), more.end());
    return RunProgram(call);
  }

  int Rows(const std::string& table) {
    SQLite::Database db((folder_.path() / "lab/lab.db").string());
    return db.execAndGet("SELECT count(*) FROM " + table).getInt();
  }

  TemporaryFolder folder_;
};

TentacleDesign Short(double taper) {
  TentacleDesign d;
  d.length = 0.32;
  d.holes = 21;
  d.taper = taper;
  return d;
}

TEST_F(CalibrateFoldCommand, FitsEachDesignAndStoresIt) {
  for (int i = 0; i < 4; ++i) AddTrial("tapered-" + std::to_string(i), Short(0.5), "tapered", 10 + i);
  for (int i = 0; i < 3; ++i) AddTrial("even-" + std::to_string(i), Short(1), "even", 20 + i);
  const auto run = Calibrate({"--kind", "virtual", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto answer = nlohmann::json::parse(run.out);
  ASSERT_EQ(answer["fits"].size(), 2U);
  const auto& even = answer["fits"][0];
  EXPECT_EQ(even["design"], "even");
  EXPECT_EQ(even["trials"], 3);
  EXPECT_EQ(even["parameters"][2]["identified"], false);
  EXPECT_NE(even["parameters"][2]["why"].get<std::string>().find("taper"), std::string::npos);
  EXPECT_TRUE(even["parameters"][2]["standard_error"].is_null());
  const auto& tapered = answer["fits"][1];
  EXPECT_EQ(tapered["curves"], 56);
  EXPECT_EQ(tapered["clustered_by_trial"], true);
  EXPECT_EQ(tapered["degrees_of_freedom"], 3);
  const double wanted[] = {0.9, 1.3, 1.2};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& p = tapered["parameters"][i];
    EXPECT_LT(std::abs(p["value"].get<double>() - wanted[i]), 8 * p["standard_error"].get<double>())
        << p["name"];
    EXPECT_NEAR(p["value"].get<double>(), wanted[i], 0.1) << p["name"];
  }
  EXPECT_EQ(Rows("fit"), 2);
  EXPECT_EQ(Rows("fit_parameter"), 6);
  EXPECT_EQ(Rows("fit_trial"), 7);

  const auto one = Calibrate({"--trials", "tapered-1,tapered-2", "--dry-run"});
  ASSERT_EQ(one.exit_code, 0) << one.err;
  EXPECT_NE(one.out.find("stiffness_ratio"), std::string::npos);
  EXPECT_EQ(Rows("fit"), 2);
}

TEST_F(CalibrateFoldCommand, ComparesModelsAndWritesTheDesignThatScenesFoldBy) {
  for (int i = 0; i < 4; ++i) AddTrial("t-" + std::to_string(i), Short(0.5), "tapered", 10 + i);
  const std::string fitted = folder_ / "fitted.toml";
  const auto run = Calibrate(
      {"--kind", "virtual", "--json", "--compare", "--profile", "stiffness_exponent", "--out", fitted});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto answer = nlohmann::json::parse(run.out);
  ASSERT_EQ(answer["comparisons"].size(), 1U);
  const auto& comparison = answer["comparisons"][0];
  EXPECT_EQ(comparison["models"].size(), 7U);
  EXPECT_EQ(comparison["chosen"].get<std::string>().substr(0, 5), "paper");
  EXPECT_FALSE(comparison["verdict"].empty());
  EXPECT_EQ(answer["fits"][0]["model"], comparison["chosen"]);
  EXPECT_TRUE(answer["fits"][0]["hint"].is_object());
  EXPECT_EQ(answer["profiles"][0]["parameter"], "stiffness_exponent");
  EXPECT_EQ(Rows("fit"), 1);

  const auto design = ReadDesign(fitted);
  ASSERT_TRUE(design.ok()) << design.error().message;
  const auto& parameters = answer["fits"][0]["parameters"];
  EXPECT_EQ(design.value().law, FoldLaw::kPaper);
  EXPECT_EQ(design.value().pull_scale, parameters[0]["value"].get<double>());
  EXPECT_EQ(design.value().stiffness_ratio, parameters[1]["value"].get<double>());
  EXPECT_EQ(design.value().stiffness_exponent, parameters[2]["value"].get<double>());
  EXPECT_EQ(design.value().holes, 21);

  EXPECT_EQ(Calibrate({"--kind", "virtual", "--model", "guess"}).exit_code, 2);
  const auto none = Calibrate({"--kind", "virtual", "--profile", "friction"});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_NE(none.err.find("has no such parameter"), std::string::npos) << none.err;
  EXPECT_EQ(Rows("fit"), 1);
}

TEST_F(CalibrateFoldCommand, AProfileThatTheChosenModelHasNotIsAWarning) {
  for (int i = 0; i < 3; ++i) AddTrial("t-" + std::to_string(i), Short(0.5), "tapered", 10 + i, {1});
  const std::string fitted = folder_ / "fitted.toml";
  const auto run =
      Calibrate({"--kind", "virtual", "--json", "--compare", "--profile", "friction", "--out", fitted});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto answer = nlohmann::json::parse(run.out);
  ASSERT_EQ(answer["comparisons"][0]["chosen"], "paper");
  EXPECT_NE(answer["warnings"].dump().find("has no such parameter"), std::string::npos);
  EXPECT_EQ(Rows("fit"), 1);
  // Only the mirrored tentacle was tracked; the design is the trials' own.
  const auto design = ReadDesign(fitted);
  ASSERT_TRUE(design.ok()) << design.error().message;
  EXPECT_EQ(design.value().alpha, Short(0.5).alpha);
  EXPECT_EQ(design.value().beta, Short(0.5).beta);
}

TEST_F(CalibrateFoldCommand, ADesignThatAPersonWroteIsNotReplaced) {
  AddTrial("a", Short(0.5), "tapered", 1);
  const std::string mine = folder_ / "mine.toml";
  testing_support::WriteText(mine, "# my notes\n[tentacle]\n");
  const auto run = Calibrate({"--trials", "a", "--out", mine});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("not a file that calibrate fold wrote"), std::string::npos) << run.err;
  EXPECT_TRUE(testing_support::ReadText(mine).starts_with("# my notes"));
  EXPECT_EQ(Rows("fit"), 0);
}

TEST_F(CalibrateFoldCommand, AFileThatCannotBeWrittenIsRefusedBeforeTheFit) {
  AddTrial("a", Short(0.5), "tapered", 1);
  const auto run = Calibrate({"--trials", "a", "--out", folder_ / "none/fitted.toml"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("there is no folder"), std::string::npos) << run.err;
  EXPECT_EQ(run.out.find("pull_scale"), std::string::npos) << run.out;
  EXPECT_EQ(Calibrate({"--trials", "a", "--out", folder_ / "lab"}).exit_code, 2);
  EXPECT_EQ(Rows("fit"), 0);
}

TEST_F(CalibrateFoldCommand, SaysWhatItsColumnsAre) {
  for (int i = 0; i < 3; ++i) AddTrial("t-" + std::to_string(i), Short(0.5), "tapered", 10 + i);
  const auto run = Calibrate({"--kind", "virtual", "--compare", "--dry-run"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* const line : {"residual: of the holes, RMS", "held-out: of distances", "dAIC takes"})
    EXPECT_NE(run.out.find(line), std::string::npos) << line;
  // Trials without cameras: what perfect pictures would do.
  EXPECT_NE(run.out.find("every node seen without error"), std::string::npos) << run.out;
}

TEST_F(CalibrateFoldCommand, SaysWhatIsMissing) {
  auto run = Calibrate({});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("no tracked real trial"), std::string::npos) << run.err;
  AddTrial("a", Short(0.5), "tapered", 1);
  EXPECT_EQ(Calibrate({"--trials", "b"}).exit_code, 2);
  EXPECT_EQ(Calibrate({"--kind", "imagined"}).exit_code, 2);
  EXPECT_EQ(Calibrate({"--lag", "-1"}).exit_code, 2);
  run = Calibrate({"--trials", "a", "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(nlohmann::json::parse(run.out)["fits"][0]["clustered_by_trial"], false);
  EXPECT_EQ(Rows("fit"), 1);
}

}  // namespace
}  // namespace tendril
