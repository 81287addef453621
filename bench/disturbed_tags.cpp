// What tracking makes of tags that motion, glare or a cable spoils: how many are given, how far off they are,
// and why the others are refused. Drawn films of one tag (tests/support/disturbed_tags.h).
//   bench_disturbed_tags [FILMS] [FIRST SEED] [LARGEST RESIDUAL, of the contrast]
// Seeds 1 .. 999 may be used for tuning; the table in docs/detection.md is of 10001 and up, which are not.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "capture/track/tags_in_video.h"
#include "tests/support/disturbed_tags.h"

namespace tendril {
namespace {

using testing_support::Disturbance;
using testing_support::DisturbedFilm;

struct Tally {
  int spoilt = 0, given = 0, outside = 0, over_half = 0, wrong = 0;
  double squares = 0, squares_of_sigma = 0;
  std::map<std::string, long> rejected;
};

void Watch(const DisturbedFilm& film, TagTrackLevel level, double largest_residual, Tally& tally) {
  TagTrackOptions options;
  options.fit.largest_residual = largest_residual;
  options.level = level;
  TagTracker tracker = TagTracker::Create(options).value();
  for (int f = 0; f < DisturbedFilm::kFrames; ++f) {
    const auto index = static_cast<std::size_t>(f);
    const auto tags = tracker.Next(
        {film.pictures[index].data(), DisturbedFilm::kWidth, DisturbedFilm::kHeight, DisturbedFilm::kWidth});
    if (f < DisturbedFilm::kFrom) continue;
    ++tally.spoilt;
    for (const TrackedTag& tag : tags.value()) {
      if (tag.id != film.id) {
        ++tally.wrong;
        continue;
      }
      ++tally.given;
      const Eigen::Matrix<double, 8, 1> off = (tag.corners_px - film.truth[index]).reshaped();
      const double farthest = (tag.corners_px - film.truth[index]).colwise().norm().maxCoeff();
      tally.squares += off.squaredNorm() / 8;
      tally.squares_of_sigma += tag.covariance.trace() / 8;
      // The 0.99 quantile of chi-square with 8 degrees of freedom.
      if (off.dot(tag.covariance.ldlt().solve(off)) > 20.09) ++tally.outside;
      if (farthest > 0.5) ++tally.over_half;
      if (farthest > 1) ++tally.wrong;
    }
  }
  for (const auto& [cause, count] : RejectedByCause(tracker.counts())) tally.rejected[cause] += count;
}

int Main(int films, unsigned first, double largest_residual) {
  fmt::print("{} films each, seeds from {}; 5 pictures of each are spoilt; residuals up to {}\n", films,
             first, largest_residual);
  fmt::print("{:<9} {:<9} {:>7} {:>9} {:>10} {:>9} {:>8} {:>8}  {}\n", "spoilt by", "level", "given",
             "rms, px", "stated, px", "> 0.5 px", "> 1 px", "outside", "rejected");
  for (const auto disturbance :
       {Disturbance::kNone, Disturbance::kSmear, Disturbance::kGlare, Disturbance::kCable}) {
    for (const auto level : {TagTrackLevel::kPreview, TagTrackLevel::kStandard, TagTrackLevel::kBest}) {
      Tally tally;
      for (int i = 0; i < films; ++i) {
        Watch(testing_support::FilmOf(disturbance, first + static_cast<unsigned>(i)), level, largest_residual,
              tally);
      }
      std::string rejected;
      for (const auto& [cause, count] : tally.rejected) {
        rejected += fmt::format("{}{} {}", rejected.empty() ? "" : ", ", count, cause);
      }
      const double given = std::max(1, tally.given);
      fmt::print("{:<9} {:<9} {:>7.3f} {:>9.3f} {:>10.3f} {:>9.4f} {:>8.4f} {:>8.3f}  {}\n",
                 testing_support::kDisturbanceNames[static_cast<int>(disturbance)], NameOf(level),
                 given / tally.spoilt, std::sqrt(tally.squares / given),
                 std::sqrt(tally.squares_of_sigma / given), tally.over_half / given, tally.wrong / given,
                 tally.outside / given, rejected);
    }
  }
  return 0;
}

}  // namespace
}  // namespace tendril

int main(int argc, char** argv) {
  return tendril::Main(argc > 1 ? std::stoi(argv[1]) : 200,
                       argc > 2 ? static_cast<unsigned>(std::stoul(argv[2])) : 1,
                       argc > 3 ? std::stod(argv[3]) : tendril::TagFitOptions{}.largest_residual);
}
