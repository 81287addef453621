#include "bench/grasp_trends/grasp_questions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "analysis/statistics/ranks_differ.h"
#include "analysis/statistics/rates_differ.h"
#include "bench/grasp_trends/grasp_report.h"

namespace tendril {
namespace {

Successes Of(const GraspPoint& point, const std::vector<GraspOutcome>& outcomes) {
  const GraspCount count = CountGrasps(point, outcomes);
  return {count.held, count.trusted};
}

std::string Chance(double p) { return p < 0.001 ? "p < 0.001" : fmt::format("p = {:.3f}", p); }

std::string Words(const Successes& s) { return fmt::format("{} of {}", s.successes, s.trials); }

Successes Sum(const std::vector<Successes>& groups) {
  Successes sum;
  for (const Successes& one : groups) {
    sum.successes += one.successes;
    sum.trials += one.trials;
  }
  return sum;
}

bool AllTried(const std::vector<Successes>& groups) {
  return !groups.empty() &&
         std::all_of(groups.begin(), groups.end(), [](const Successes& s) { return s.trials > 0; });
}

// The points of a line, in the panel's order.
std::vector<const GraspPoint*> LineOf(const GraspPanel& panel, const std::string& line) {
  std::vector<const GraspPoint*> points;
  for (const GraspPoint& point : panel.points) {
    if (point.line == line) points.push_back(&point);
  }
  return points;
}

std::vector<std::string> LinesOf(const GraspPanel& panel) {
  std::vector<std::string> lines;
  for (const GraspPoint& point : panel.points) {
    if (std::find(lines.begin(), lines.end(), point.line) == lines.end()) lines.push_back(point.line);
  }
  return lines;
}

class Asking {
 public:
  explicit Asking(const std::vector<GraspOutcome>& outcomes) : outcomes_(outcomes) {}

  std::vector<GraspAnswer> answers;

  // By ranks: steps of the series are even.
  void Trend(const std::string& question, const std::vector<const GraspPoint*>& points) {
    std::vector<Scored> groups;
    std::vector<Successes> counts;
    for (const GraspPoint* point : points) {
      counts.push_back(Of(*point, outcomes_));
      groups.push_back({static_cast<int>(groups.size()), counts.back()});
    }
    if (!AllTried(counts)) return;
    std::vector<std::string> words;
    for (const Successes& count : counts) words.push_back(Words(count));
    answers.push_back({question, fmt::format("{}", fmt::join(words, ", ")), NoTrendP(groups)});
  }

  void Against(const std::string& question, const std::vector<const GraspPoint*>& one,
               const std::vector<const GraspPoint*>& other) {
    std::vector<RatePair> places;
    std::vector<Successes> ones, others;
    for (std::size_t i = 0; i < std::min(one.size(), other.size()); ++i) {
      ones.push_back(Of(*one[i], outcomes_));
      others.push_back(Of(*other[i], outcomes_));
      places.push_back({ones.back(), others.back()});
    }
    if (!AllTried(ones) || !AllTried(others)) return;
    answers.push_back({question, Words(Sum(ones)) + ", " + Words(Sum(others)), SameRateP(places)});
  }

 private:
  const std::vector<GraspOutcome>& outcomes_;
};

void AskAboutDistance(const GraspPanel& panel, Asking& asking) {
  const std::vector<std::string> lines = LinesOf(panel);
  for (const std::string& line : lines) {
    asking.Trend(panel.title + ", " + line + ": does the rate depend on the distance?", LineOf(panel, line));
  }
  if (lines.size() == 2) {
    asking.Against(panel.title + ": does " + lines[0] + " hold as often as " + lines[1] + "?",
                   LineOf(panel, lines[0]), LineOf(panel, lines[1]));
  }
}

// Values other than that of the scene, which is the one with the fewest settings.
void AskAboutSensitivity(const GraspPanel& panel, Asking& asking) {
  for (const std::string& line : LinesOf(panel)) {
    const std::vector<const GraspPoint*> points = LineOf(panel, line);
    const GraspPoint* const usual = *std::min_element(
        points.begin(), points.end(),
        [](const GraspPoint* a, const GraspPoint* b) { return a->settings.size() < b->settings.size(); });
    for (const GraspPoint* point : points) {
      if (point == usual) continue;
      asking.Against(fmt::format("{}, {}: {} against {}", panel.title, line, point->label, usual->label),
                     {point}, {usual});
    }
  }
}

}  // namespace

std::vector<GraspAnswer> AnswersOf(const std::vector<GraspSeries>& series,
                                   const std::vector<GraspOutcome>& outcomes) {
  Asking asking(outcomes);
  const GraspPanel* air = nullptr;
  const GraspPanel* water = nullptr;
  for (const GraspSeries& one : series) {
    if (one.name == "distance") air = &one.panels[0];
    if (one.name == "water") water = &one.panels[0];
    for (const GraspPanel& panel : one.panels) {
      if (one.name == "distance" || one.name == "water") AskAboutDistance(panel, asking);
      if (one.name == "pairs") {
        asking.Trend(panel.title + ": does the rate depend on the pairs?", LineOf(panel, LinesOf(panel)[0]));
      }
      if (one.name == "sensitivity") AskAboutSensitivity(panel, asking);
    }
  }
  if (air != nullptr && water != nullptr) {
    std::vector<const GraspPoint*> in_water, in_air;
    for (const std::string& line : LinesOf(*air)) {
      const std::vector<const GraspPoint*> near = LineOf(*air, line), far = LineOf(*water, line);
      in_air.insert(in_air.end(), near.begin(), near.end());
      in_water.insert(in_water.end(), far.begin(), far.begin() + static_cast<std::ptrdiff_t>(near.size()));
    }
    asking.Against("does water hold as often as air?", in_water, in_air);
  }
  return std::move(asking.answers);
}

std::string AnswerTable(const std::vector<GraspAnswer>& answers) {
  std::string text = "| question | held | luck | |\n|---|---|---|---|\n";
  for (const GraspAnswer& a : answers) {
    text += fmt::format("| {} | {} | {} | {} |\n", a.question, a.seen, Chance(a.p),
                        a.p < kToldApart ? "told apart" : "not told apart");
  }
  return text;
}

std::string WindingTable(const std::vector<GraspSeries>& series, const std::vector<GraspOutcome>& outcomes) {
  struct Group {
    std::vector<Successes> kinds{4};  // about the object alone, both, about each other alone, neither
    std::vector<double> object_held, object_lost, mutual_held, mutual_lost;
  };
  std::map<std::pair<std::string, std::string>, Group> groups;
  for (const GraspSeries& one : series) {
    if (one.name != "distance" && one.name != "water") continue;
    for (const GraspPanel& panel : one.panels) {
      for (const GraspPoint& point : panel.points) {
        for (const GraspOutcome& o : outcomes) {
          if (!IsOf(point, o) || !o.doubt.empty()) continue;
          Group& group = groups[{panel.title, point.line}];
          const bool loops = o.looping > 0, braids = o.braiding > 0, held = Held(o);
          Successes& kind = group.kinds[loops ? (braids ? 1 : 0) : (braids ? 2 : 3)];
          ++kind.trials;
          kind.successes += held ? 1 : 0;
          (held ? group.object_held : group.object_lost).push_back(o.object_open);
          (held ? group.mutual_held : group.mutual_lost).push_back(o.mutual_open);
        }
      }
    }
  }
  std::string text =
      "| where | design | wound about the object alone | both | about each other alone | neither | object "
      "link "
      "larger where held | mutual link larger where held |\n|---|---|---|---|---|---|---|---|\n";
  const auto ranks = [](const std::vector<double>& held, const std::vector<double>& lost) -> std::string {
    if (held.empty() || lost.empty()) return "-";
    const RanksDiffer differ = CompareRanks(held, lost);
    return fmt::format("{:.0f} % of pairs, {}", 100 * differ.share, Chance(differ.p));
  };
  for (const auto& [key, group] : groups) {
    text += fmt::format("| {} | {} |", key.first, key.second);
    for (const Successes& kind : group.kinds) text += kind.trials == 0 ? " - |" : " " + Words(kind) + " |";
    text += " " + ranks(group.object_held, group.object_lost) + " |";
    text += " " + ranks(group.mutual_held, group.mutual_lost) + " |\n";
  }
  return text;
}

}  // namespace tendril
