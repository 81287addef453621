#pragma once
// Tests of holding, done on a finished grasp: what a scene does after its own end, and what is to be said of
// it.
//
// All begin with a lift, so that the object hangs from the rods and no longer from its string. Up is against
// gravity; without gravity, along z.

#include <limits>
#include <optional>
#include <string>

#include "model/result.h"
#include "model/scene/scene.h"
#include "model/scene/simulate.h"

namespace tendril {

enum class HoldingTest {
  kLift,     // the carrier rises; held where the object's centre rose above its start and stays (the paper's
             // rule)
  kLoad,     // then a weight grows on the object until it slips
  kStrike,   // then it is struck 15 times from each of four sides over a minute
  kRelease,  // then the tendons unwind until the object is free
};

// What a scene's gripper is to grasp: its first object that can move, else its first that is no table.
std::optional<std::size_t> GraspedObject(const Scene& scene);

struct HoldingOptions {
  std::size_t object = 0;
  double height = 0.15, lift_time = 2, watch_time = 2;  // m, s, s
  double load_rate = 0.1, largest_load = 2;             // kg/s, kg
  double strike = 0.02, strike_time = 0.01;             // N s each, half a sine that long, s
  int strikes_a_side = 15;
  double strike_every = 1;                      // s
  double release_rate = 0.1, release_wait = 2;  // 1/s, s
  // What hangs on its string trembles: above its start is what is above it by this, m.
  double least_rise = 0.01;
  // And of its weight the rods bear at least this share, or it hangs from its string.
  double least_borne = 0.5;
  // It is lost when it has sunk by this share of the height since the lift.
  double lost_share = 0.5;
};

// When parts of a test begin, s.
struct HoldingTimes {
  double lift = 0, watch = 0, test = 0, end = 0;
};

// Adds the test behind all that the scene does.
//   errors  kBadInput  no such object, one that is fixed, a scene without held rods, a release without a
//   gripper
Result<HoldingTimes> AddHoldingTest(Scene& scene, HoldingTest test, const HoldingOptions& options = {});

struct HoldingResult {
  HoldingTest test = HoldingTest::kLift;
  bool lifted = false;  // rose with the carrier and stayed, by RuleOf(kLift)
  bool held = false;    // to the end; of kRelease: let go
  double rise = 0;      // the least while it is watched, m
  double shift = 0;     // the most from where it hung after the lift, m
  double payload = std::numeric_limits<double>::quiet_NaN();  // kLoad: the object and what slipped it, kg
  bool payload_is_least = false;                              // the largest load did not slip it
  double payload_ratio = std::numeric_limits<double>::quiet_NaN();  // by the rods' own mass
  int strikes = 0;                                                  // that it withstood
  double release_time = std::numeric_limits<double>::quiet_NaN();  // kRelease: from the start of unwinding, s
  std::string Sentence() const;
  // Whether it counts as a grasp: of kLift and kStrike, held; of kLoad and kRelease, lifted before the load
  // grows or the tendons unwind. What a grasp carries, and whether it lets go, are other questions.
  bool Grasped() const;
};

// What Grasped() asks, in words.
std::string RuleOf(HoldingTest test, const HoldingOptions& options = {});

// From the frames of a run of that scene: some ten a second or more.
//   rods_mass  kg
//   errors  kBadInput  the run did not reach the test's end
Result<HoldingResult> JudgeHolding(const Scene& scene, HoldingTest test, const HoldingTimes& times,
                                   const HoldingOptions& options, const Simulated& run, double rods_mass);

std::string NameOf(HoldingTest test);

}  // namespace tendril
