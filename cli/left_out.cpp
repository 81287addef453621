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
  return count;
}

}  // namespace tendril::cli
