#include "cli/left_out.h"

namespace tendril::cli {

Result<std::int64_t> TellLeftOut(Lab& lab, const RateQuestion& question, Output& out) {
  Result<std::int64_t> count = CountLeftOut(lab, question);
  if (!count.ok()) return count;
  out.fields()["left_out_untrusted"] = count.value();
  if (count.value() > 0) {
    out.Warn(
        fmt::format("{} {} trial{} left out, for the run cannot be trusted (`tendril trials show` says why; "
                    "--include-untrusted counts such trials)",
                    count.value(), NameOf(question.kind), count.value() == 1 ? "" : "s"));
  }
  const Result<std::int64_t> repeats = CountRepeats(lab, question);
  if (!repeats.ok()) return repeats;
  out.fields()["left_out_repeats"] = repeats.value();
  if (repeats.value() > 0) {
    out.Warn(fmt::format("{} {} trial{} left out, for the lab has the same run again, stored later",
                         repeats.value(), NameOf(question.kind), repeats.value() == 1 ? "" : "s"));
  }
  return count;
}

Status TellSplit(Lab& lab, RateQuestion& question, Output& out) {
  const Result<bool> split = SplitByTest(lab, question);
  if (!split.ok()) return split.error();
  if (split.value()) {
    out.Warn(
        "a rate is of one kind of test: split by test of holding (choose one with --where test=lift, ...; "
        "none: without a test)");
  }
  return Ok{};
}

}  // namespace tendril::cli
