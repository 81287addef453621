// db/files/state_file.h: a state comes back to the bit; what is damaged or of another run is refused.
#include "db/files/state_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "db/files/safe_file.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

SimulationState SomeState() {
  SimulationState state;
  for (int i = 0; i < 1000; ++i) state.numbers.push_back(std::sin(i) * std::pow(10, i % 300));
  for (int r = 0; r < 2; ++r) {
    CurveSeries& series = state.curves.emplace_back();
    series.time = Eigen::Vector3d(0, 0.1, 1.0 / 3);
    for (int f = 0; f < 3; ++f) {
      series.curves.push_back({Eigen::Matrix3Xd::Random(3, 4 + r), Eigen::Matrix3Xd::Random(3, 4 + r)});
    }
  }
  return state;
}

TEST(StateFile, GivesBackEveryBit) {
  const testing_support::TemporaryFolder folder;
  const SimulationState state = SomeState();
  ASSERT_TRUE(WriteState(folder / "run.state", state, "abc").ok());
  const auto read = ReadState(folder / "run.state", "abc");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read.value().numbers, state.numbers);
  ASSERT_EQ(read.value().curves.size(), 2u);
  for (size_t r = 0; r < 2; ++r) {
    EXPECT_EQ(read.value().curves[r].time, state.curves[r].time);
    for (size_t f = 0; f < 3; ++f) {
      EXPECT_EQ(read.value().curves[r].curves[f].points, state.curves[r].curves[f].points);
      EXPECT_EQ(read.value().curves[r].curves[f].normals, state.curves[r].curves[f].normals);
    }
  }
}

TEST(StateFile, RefusesAnotherRunAndDamage) {
  const testing_support::TemporaryFolder folder;
  const std::filesystem::path file = folder / "run.state";
  EXPECT_EQ(ReadState(file, "abc").error().kind, ErrorKind::kNotFound);
  ASSERT_TRUE(WriteState(file, SomeState(), "abc").ok());
  EXPECT_NE(ReadState(file, "abd").error().message.find("another run"), std::string::npos);
  const std::string bytes = ReadText(file).value();
  for (const size_t length : {size_t{0}, size_t{10}, bytes.size() / 2}) {
    ASSERT_TRUE(WriteText(file, bytes.substr(0, length)).ok());
    const auto read = ReadState(file, "abc");
    ASSERT_FALSE(read.ok()) << length;
    EXPECT_EQ(read.error().kind, ErrorKind::kBadInput);
  }
}

}  // namespace
}  // namespace tendril
