// tendril link, as a user calls it.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "db/files/curve_files.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using testing_support::RunProgram;
using testing_support::TemporaryFolder;
using testing_support::WriteText;

// Two rings of a Hopf link, as a curves CSV.
std::string HopfCsv() {
  std::string text = "curve,node,x,y,z\n";
  for (int ring = 0; ring < 2; ++ring) {
    for (int i = 0; i <= 40; ++i) {
      const double t = 2 * std::numbers::pi * (i % 40) / 40;
      const double x = std::cos(t), y = std::sin(t);
      char line[120];
      std::snprintf(line, sizeof line, "ring%d,%d,%.17g,%.17g,%.17g\n", ring, i, ring == 0 ? x : x + 1,
                    ring == 0 ? y : 0.01, ring == 0 ? 0.0 : y);
      text += line;
    }
  }
  return text;
}

TEST(LinkCommand, HopfLinkAndItsAxis) {
  const TemporaryFolder folder;
  WriteText(folder / "hopf.csv", HopfCsv());
  const auto run =
      RunProgram({"link", folder / "hopf.csv", "--closure", "none", "--axis", "0,0,0,0,0,1", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  ASSERT_EQ(json["curves"].size(), 2U);
  EXPECT_EQ(json["curves"][0]["name"], "ring0");
  EXPECT_NEAR(json["curves"][0]["object_link"].get<double>(), 1, 1e-12);
  EXPECT_TRUE(json["curves"][0]["self_link"].is_null()) << "no normals";
  EXPECT_NEAR(json["curves"][1]["writhe"].get<double>(), 0, 1e-12);
  ASSERT_EQ(json["pairs"].size(), 1U);
  EXPECT_EQ(json["pairs"][0]["a"], "ring0");
  EXPECT_EQ(json["pairs"][0]["b"], "ring1");
  EXPECT_NEAR(std::abs(json["pairs"][0]["link"].get<double>()), 1, 1e-12);
  EXPECT_LT(json["pairs"][0]["link_error"].get<double>(), 1e-9);
  EXPECT_TRUE(json["pairs"][0]["flags"].empty());
  EXPECT_NEAR(json["mutual_link"].get<double>(), 1, 1e-12);
  EXPECT_NEAR(json["object_link"].get<double>(), 0.5, 0.5 + 1e-12);
}

TEST(LinkCommand, PrintsForPeopleAndOverTime) {
  const TemporaryFolder folder;
  std::string text = "frame,time,curve,node,x,y,z\n";
  for (int frame = 0; frame < 3; ++frame) {
    for (int curve = 0; curve < 2; ++curve) {
      for (int node = 0; node < 4; ++node) {
        text += std::to_string(frame) + "," + std::to_string(0.5 * frame) + ",t" + std::to_string(curve) +
                "," + std::to_string(node) + "," + std::to_string(0.2 * curve + 0.01 * node * node) + "," +
                std::to_string(0.05 * frame * node * (curve == 0 ? 1 : -1)) + "," +
                std::to_string(-0.1 * node) + "\n";
      }
    }
  }
  WriteText(folder / "c.csv", text);
  const auto all = RunProgram({"link", folder / "c.csv", "--frame", "all", "--json"});
  ASSERT_EQ(all.exit_code, 0) << all.err;
  const auto json = nlohmann::json::parse(all.out);
  EXPECT_EQ(json["frames"].size(), 3U);
  EXPECT_EQ(json["frames"][2]["mutual_link"], json["mutual_link"]);
  EXPECT_EQ(json["frames"][0]["mutual_link"], json["at_pull_0"]["mutual_link"]);
  EXPECT_TRUE(json["object_link"].is_null());
  const auto shown = RunProgram({"link", folder / "c.csv", "--frame", "1"});
  EXPECT_EQ(shown.exit_code, 0);
  EXPECT_NE(shown.out.find("mutual link"), std::string::npos);
  EXPECT_EQ(RunProgram({"link", folder / "c.csv", "--frame", "3"}).exit_code, 2);
  EXPECT_EQ(RunProgram({"link", folder / "c.csv", "--frame", "-1"}).exit_code, 2);
}

TEST(LinkCommand, BadCallsAreOneLineAndExitTwo) {
  const TemporaryFolder folder;
  WriteText(folder / "hopf.csv", HopfCsv());
  const std::vector<std::vector<std::string>> bad = {
      {"link", folder / "absent.csv"},
      {"link", folder / "hopf.csv", "--axis", "1,2,3"},
      {"link", folder / "hopf.csv", "--axis", "0,0,0,0,0,0"},
      {"link", folder / "hopf.csv", "--axis", "0,0,0,x,0,1"},
      {"link", folder / "hopf.csv", "--closure", "next_tangent"},
      {"link", folder / "hopf.csv", "--closure", "sideways:3"},
      {"link", folder / "hopf.csv", "--accuracy", "perfect"},
  };
  for (const auto& call : bad) {
    const auto run = RunProgram(call);
    EXPECT_EQ(run.exit_code, 2) << call.back();
    EXPECT_TRUE(run.out.empty()) << run.out;
    EXPECT_FALSE(run.err.empty());
  }
}

// Two long strands that cross a millimetre apart, known to a millimetre.
TEST(LinkCommand, BandsSayWhichCrossingIsUndecided) {
  const TemporaryFolder folder;
  std::vector<CurveSeries> strands(2);
  for (int k = 0; k < 2; ++k) {
    CurveSeries& strand = strands[static_cast<std::size_t>(k)];
    strand.name = k == 0 ? "under" : "over";
    strand.time = Eigen::VectorXd::LinSpaced(2, 0, 1);
    for (int frame = 0; frame < 2; ++frame) {
      FramedCurve curve{Eigen::Matrix3Xd::Zero(3, 5), {}};
      for (int i = 0; i < 5; ++i) curve.points(k, i) = 10 * (i - 2);
      curve.points.row(2).setConstant(k == 0 ? 0 : frame == 0 ? 1 : 1e-3);
      strand.curves.push_back(curve);
      strand.sigma.push_back(Eigen::VectorXd::Constant(5, 1e-3));
      Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(15, 1);
      for (int i = 0; i < 5; ++i) factor(3 * i + 2, 0) = k == 0 ? 0 : 1e-3;
      strand.covariance_factor.push_back(factor);
    }
  }
  ASSERT_TRUE(WriteCurves(folder / "strands.h5", strands, "test").ok());
  const auto last = RunProgram({"link", folder / "strands.h5", "--bands", "--json"});
  ASSERT_EQ(last.exit_code, 0) << last.err;
  const auto bands = nlohmann::json::parse(last.out)["bands"];
  ASSERT_EQ(bands["undecided"].size(), 1u);
  EXPECT_EQ(bands["undecided"][0]["b"], "over");
  EXPECT_NEAR(bands["undecided"][0]["node_a"].get<double>(), 2, 1e-6);
  EXPECT_NEAR(bands["undecided"][0]["separation_m"].get<double>(), 1e-3, 1e-9);
  EXPECT_NEAR(bands["undecided"][0]["sigma_m"].get<double>(), 1e-3, 1e-9);
  const auto modes = bands["pairs"][0]["gauss"]["modes"];
  ASSERT_EQ(modes.size(), 2u);
  EXPECT_NEAR(modes[1]["share"].get<double>(), 0.159, 0.08);  // beyond one sigma
  const auto first = RunProgram({"link", folder / "strands.h5", "--bands", "--frame", "0"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_NE(first.out.find("every crossing is decided"), std::string::npos) << first.out;

  // Normals whose turn is not known, then known.
  for (CurveSeries& strand : strands) {
    for (FramedCurve& curve : strand.curves) curve.normals = Eigen::Vector3d::UnitZ().replicate(1, 5);
  }
  ASSERT_TRUE(WriteCurves(folder / "framed.h5", strands, "test").ok());
  const auto still = RunProgram({"link", folder / "framed.h5", "--bands"});
  EXPECT_NE(still.out.find("states no turn of the normals"), std::string::npos) << still.out << still.err;
  for (CurveSeries& strand : strands) strand.turn_factor.assign(2, Eigen::MatrixXd::Constant(5, 1, 0.01));
  ASSERT_TRUE(WriteCurves(folder / "turned.h5", strands, "test").ok());
  const auto turned = RunProgram({"link", folder / "turned.h5", "--bands", "--json"});
  ASSERT_EQ(turned.exit_code, 0) << turned.err;
  EXPECT_TRUE(nlohmann::json::parse(turned.out)["bands"]["normals_drawn"].get<bool>());

  WriteText(folder / "hopf.csv", HopfCsv());
  const auto none = RunProgram({"link", folder / "hopf.csv", "--bands"});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_NE(none.err.find("states no covariance"), std::string::npos) << none.err;
}

}  // namespace
}  // namespace tendril
