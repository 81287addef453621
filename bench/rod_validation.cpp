// Rods against closed forms: our figure, the reference and the error for each case of docs/validation.md.
// Arguments: names of cases (unless given all but those that take minutes); --csv.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/support/rod_validation.h"

namespace tendril {
namespace {

using testing_support::Figure;
using testing_support::ValidationCase;
using testing_support::ValidationCases;

void Print(const char* name, const Figure& f, bool csv) {
  const auto given = [](double value, const char* format) {
    return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : std::string();
  };
  const std::string reference = given(f.reference, csv ? "{:.8g}" : "{:.6g}");
  const std::string error = given(100 * f.Error(), "{:.4f}"), order = given(f.order, "{:.2f}");
  if (csv) {
    fmt::print("{},\"{}\",{:.8g},{},{},{},{},{}\n", name, f.quantity, f.ours, reference, error, f.level,
               f.elements, order);
  } else {
    fmt::print("| {} | {} | {:.6g} | {} | {} | {} | {} | {} |\n", name, f.quantity, f.ours, reference, error,
               f.level, f.elements, order);
  }
}

int Run(const std::vector<std::string>& wanted, bool csv) {
  for (const std::string& one : wanted) {
    const auto& all = ValidationCases();
    if (std::any_of(all.begin(), all.end(), [&](const ValidationCase& c) { return c.name == one; })) continue;
    fmt::print(stderr, "no case '{}': expected", one);
    for (const ValidationCase& c : all) fmt::print(stderr, " {}", c.name);
    fmt::print(stderr, "\n");
    return 2;
  }
  const char* const head =
      csv ? "case,quantity,ours,reference,error_percent,level,elements,order\n"
          : "| case | quantity | ours | reference | error, % | level | elements | order |\n"
            "|---|---|---|---|---|---|---|---|\n";
  std::fputs(head, stdout);
  for (const ValidationCase& one : ValidationCases()) {
    const bool named = std::find(wanted.begin(), wanted.end(), one.name) != wanted.end();
    if (!named && (one.by_name_alone || !wanted.empty())) continue;
    const auto start = std::chrono::steady_clock::now();
    for (const Figure& figure : one.run(false)) Print(one.name, figure, csv);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    std::fflush(stdout);
    fmt::print(stderr, "{}: {:.1f} s\n", one.name, took.count());
  }
  return 0;
}

}  // namespace
}  // namespace tendril

int main(int argc, char** argv) {
  std::vector<std::string> wanted(argv + 1, argv + argc);
  const bool csv = std::erase(wanted, "--csv") > 0;
  return tendril::Run(wanted, csv);
}
