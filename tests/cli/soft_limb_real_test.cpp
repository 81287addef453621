// The main job on real data, from log to database, as the example script does it.
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/support/program.h"
#include "tests/support/shared_data.h"

namespace tendril {
namespace {

TEST(RealSoftLimb, TheExampleScriptTakesItIntoALab) {
  const auto log = testing_support::SharedFolder() / "data" / "soft_limb_tags" / "soft_limb_data.csv";
  TENDRIL_SKIP_WITHOUT(log);
  const testing_support::TemporaryFolder folder;
  const std::string command = std::string("TENDRIL='") + TENDRIL_PROGRAM + "' '" + TENDRIL_SOURCE_DIR +
                              "/examples/soft_limb.sh' '" + log.string() + "' '" + (folder / "lab") +
                              "' > '" + (folder / "out") + "' 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << testing_support::ReadText(folder / "out");
  const auto list = testing_support::RunProgram({"trials", "list", "--lab", folder / "lab", "--json"});
  ASSERT_EQ(list.exit_code, 0) << list.err;
  EXPECT_NE(list.out.find("\"real\""), std::string::npos);
  // 170 of 178 rows are complete (SOURCE.txt); the tags are 55 to 78 px apart.
  const std::string said = testing_support::ReadText(folder / "out");
  EXPECT_NE(said.find("centerline of 9 nodes in 170 of 176 frames"), std::string::npos) << said;
  int figures = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "lab")) {
    figures += entry.path().extension() == ".svg" ? 1 : 0;
  }
  EXPECT_EQ(figures, 3);  // against the duty cycle, and each limb against its actuators' temperature
  EXPECT_NE(said.find("95 %"), std::string::npos) << said;  // what is said of the loop
}

}  // namespace
}  // namespace tendril
