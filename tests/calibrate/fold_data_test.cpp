// calibrate/fold/fold_data.h: from a trial's files to the parameters.
#include "calibrate/fold/fold_data.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "db/files/curve_files.h"
#include "tests/support/perturbed_tentacle.h"
#include "tests/support/servo_log.h"

namespace tendril {
namespace {

using test::kLogStart;
using test::RampLog;
using ::testing::HasSubstr;

class LoadFoldDataTest : public ::testing::Test {
 protected:
  LoadFoldDataTest() {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ("fold_data_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~LoadFoldDataTest() override { std::filesystem::remove_all(folder_); }

  // A noiseless trial of two tentacles that follow their servos at once.
  void Write(const test::FoldTruth& truth) {
    TrialSpec trial;
    trial.id = "0190-test";
    trial.label = "t-1";
    trial.kind = TrialKind::kVirtual;
    trial.started_ns = kLogStart;
    trial.design_name = "short";
    trial.design.length = 0.32;
    trial.design.holes = 21;
    trial.gripper.tentacles = 2;
    std::ofstream(folder_ / "trial.toml") << TrialToml(trial);
    std::vector<CurveSeries> curves(2);
    test::Random random(3);
    for (int i = 0; i < 2; ++i) {
      CurveSeries& series = curves[static_cast<std::size_t>(i)];
      series.name = "tentacle" + std::to_string(i);
      series.time = Eigen::VectorXd::LinSpaced(6, 0, 5);
      const auto shape =
          test::Draw(DesignOfTentacle(trial.gripper, trial.design, i), truth, test::kExactly, random);
      for (Eigen::Index f = 0; f < 6; ++f) {
        const double pull = std::clamp(0.1 * (series.time[f] - 1 - 0.3 * i), 0.0, 0.2);
        series.curves.push_back({test::HolesAt(shape, truth.pull_scale * pull), {}});
        series.sigma.push_back(Eigen::VectorXd::Constant(21, 1e-4));
      }
    }
    ASSERT_TRUE(WriteCurves(folder_ / "curves.h5", curves, "test").ok());
    std::vector<ServoRow> rows = RampLog(0);
    for (const ServoRow& row : RampLog(1, 0.3)) rows.push_back(row);
    std::stable_sort(rows.begin(), rows.end(),
                     [](const ServoRow& a, const ServoRow& b) { return a.host_ns < b.host_ns; });
    ASSERT_TRUE(WriteServoLog(folder_ / "servo.csv", rows).ok());
  }

  std::filesystem::path folder_;
};

TEST_F(LoadFoldDataTest, FilesGiveBackTheParameters) {
  const test::FoldTruth truth{0.9, 1.3, 1.2};
  Write(truth);
  const Result<FoldData> data = LoadFoldData(folder_);
  ASSERT_TRUE(data.ok()) << data.error().message;
  ASSERT_EQ(data.value().observations.size(), 12U);
  EXPECT_EQ(data.value().input_sha256.size(), 3U);
  EXPECT_TRUE(data.value().warnings.empty());
  EXPECT_NEAR(data.value().observations[2].commanded_pull, 0.1, 1e-9);
  EXPECT_NEAR(data.value().observations[8].commanded_pull, 0.07, 1e-9);
  FoldFitOptions options;
  options.longest_lag = 0.5;
  const auto fit = FitFold(data.value().observations, options);
  ASSERT_TRUE(fit.ok()) << fit.error().message;
  EXPECT_NEAR(fit.value().parameters[0].value, 0.9, 1e-7);
  EXPECT_NEAR(fit.value().parameters[1].value, 1.3, 1e-7);
  EXPECT_NEAR(fit.value().parameters[2].value, 1.2, 1e-7);
}

TEST_F(LoadFoldDataTest, MissingFilesSayWhatToRun) {
  EXPECT_FALSE(LoadFoldData(folder_).ok());
  Write({});
  std::filesystem::remove(folder_ / "servo.csv");
  EXPECT_THAT(LoadFoldData(folder_).error().message, HasSubstr("servo.csv"));
  std::filesystem::remove(folder_ / "curves.h5");
  const auto missing = LoadFoldData(folder_);
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().kind, ErrorKind::kNotFound);
  EXPECT_THAT(missing.error().message, HasSubstr("tendril track"));
}

TEST_F(LoadFoldDataTest, ForeignCurvesAndSilentServosAreNamed) {
  Write({});
  std::vector<CurveSeries> curves = ReadCurves(folder_ / "curves.h5").value();
  curves[1].name = "rope";
  ASSERT_TRUE(WriteCurves(folder_ / "curves.h5", curves, "test").ok());
  const auto data = LoadFoldData(folder_);
  ASSERT_TRUE(data.ok()) << data.error().message;
  EXPECT_THAT(data.value().warnings, ::testing::ElementsAre(HasSubstr("rope")));
  std::vector<ServoRow> rows = RampLog(0);
  for (ServoRow& row : rows) row.command.reset();
  ASSERT_TRUE(WriteServoLog(folder_ / "servo.csv", rows).ok());
  EXPECT_THAT(LoadFoldData(folder_).error().message, HasSubstr("commanded pull"));
}

}  // namespace
}  // namespace tendril
