// tendril stats: how often grasps succeed, with 95 % intervals.
#include "cli/stats_command.h"

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <vector>

#include "analysis/statistics/intervals.h"
#include "cli/lab_option.h"
#include "cli/left_out.h"
#include "db/trial_query.h"

namespace tendril::cli {
namespace {

struct StatsCall {
  std::string lab;
  std::vector<std::string> by;
  std::vector<std::string> where;
  std::string kind = "real";
  bool csv = false;
  bool include_untrusted = false;
};

Result<RateQuestion> QuestionOf(const StatsCall& call) {
  RateQuestion question;
  question.by = call.by;
  question.kind = *TrialKindOf(call.kind);  // the option takes known kinds only
  question.include_untrusted = call.include_untrusted;
  for (const std::string& text : call.where) {
    const size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
      return Error{ErrorKind::kBadInput, fmt::format("--where {}: expected NAME=VALUE, as medium=air", text)};
    }
    question.where.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  return question;
}

bool IsNumber(const std::string& key) {
  const auto& keys = RateKeys();
  return std::any_of(keys.begin(), keys.end(),
                     [&](const RateKey& known) { return known.name == key && known.is_number; });
}

std::string HeadOf(const std::string& key) {
  for (const RateKey& known : RateKeys()) {
    if (known.name == key && !known.unit.empty() && !key.ends_with("_deg")) return key + "_" + known.unit;
  }
  return key;
}

// Quotes what would tear a row of CSV.
std::string Cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

double RateOf(const RateGroup& group) {
  return static_cast<double>(group.grasped) / static_cast<double>(group.trials);
}

void AddFields(const std::vector<RateGroup>& groups, Output& out) {
  auto& list = out.fields()["groups"] = nlohmann::ordered_json::array();
  for (const RateGroup& group : groups) {
    nlohmann::ordered_json one;
    for (const auto& [key, value] : group.keys) {
      if (IsNumber(key) && !value.empty()) {
        one[key] = std::strtod(value.c_str(), nullptr);
      } else if (value.empty()) {
        one[key] = nullptr;
      } else {
        one[key] = value;
      }
    }
    const Interval wilson = WilsonInterval(group.grasped, group.trials);
    const Interval exact = ClopperPearsonInterval(group.grasped, group.trials);
    one["n"] = group.trials;
    one["k"] = group.grasped;
    one["rate"] = RateOf(group);
    one["wilson95"] = {wilson.low, wilson.high};
    one["clopper_pearson95"] = {exact.low, exact.high};
    list.push_back(std::move(one));
  }
}

void PrintCsv(const std::vector<std::string>& by, const std::vector<RateGroup>& groups, Output& out) {
  std::string head;
  for (const std::string& key : by) head += HeadOf(key) + ",";
  out.Print("{}n,k,rate,wilson95_low,wilson95_high,clopper_pearson95_low,clopper_pearson95_high", head);
  for (const RateGroup& group : groups) {
    std::string line;
    for (const auto& [key, value] : group.keys) line += Cell(value) + ",";
    const Interval wilson = WilsonInterval(group.grasped, group.trials);
    const Interval exact = ClopperPearsonInterval(group.grasped, group.trials);
    out.Print("{}{},{},{},{},{},{},{}", line, group.trials, group.grasped, RateOf(group), wilson.low,
              wilson.high, exact.low, exact.high);
  }
}

void PrintTable(const std::vector<std::string>& by, const std::vector<RateGroup>& groups, Output& out) {
  std::vector<size_t> widths;
  std::string head;
  for (size_t i = 0; i < by.size(); ++i) {
    const std::string name = HeadOf(by[i]);
    size_t width = name.size();
    for (const RateGroup& group : groups) width = std::max(width, group.keys[i].second.size());
    widths.push_back(width);
    head += fmt::format("{:<{}}  ", name, width);
  }
  out.Print("{}{:>6} {:>6}  {:>6}  {:<17} {:<17}", head, "n", "k", "rate", "95 % Wilson", "Clopper-Pearson");
  for (const RateGroup& group : groups) {
    std::string line;
    for (size_t i = 0; i < widths.size(); ++i) {
      line += fmt::format("{:<{}}  ", group.keys[i].second, widths[i]);
    }
    const Interval wilson = WilsonInterval(group.grasped, group.trials);
    const Interval exact = ClopperPearsonInterval(group.grasped, group.trials);
    out.Print("{}{:>6} {:>6}  {:6.3f}  {:.4f} .. {:.4f}  {:.4f} .. {:.4f}", line, group.trials, group.grasped,
              RateOf(group), wilson.low, wilson.high, exact.low, exact.high);
  }
}

// Why there is nothing to count: what the lab has instead.
Status ExplainNothing(const StatsCall& call, Lab& lab, Output& out) {
  const auto counts = JudgedByKind(lab);
  if (!counts.ok()) return counts.error();
  std::string others;
  bool same_kind = false;
  for (const auto& [kind, count] : counts.value()) {
    if (NameOf(kind) == call.kind) {
      same_kind = true;
    } else {
      others +=
          fmt::format("{}{} {} (--kind {})", others.empty() ? "" : ", ", count, NameOf(kind), NameOf(kind));
    }
  }
  if (same_kind) {
    out.Warn(fmt::format("no {} trial that counts fits --where", call.kind));
  } else if (others.empty()) {
    out.Warn("no trial of this lab counts yet: recorded, judged (`tendril trials outcome`) and not void");
  } else {
    out.Warn(
        fmt::format("no {} trial of this lab counts; judged trials of other kinds: {}", call.kind, others));
  }
  return Ok{};
}

Status RunStats(const StatsCall& call, Output& out) {
  if (call.csv && out.json()) {
    return Error{ErrorKind::kBadInput, "--csv and --json: expected one of them, not both"};
  }
  auto question = QuestionOf(call);
  if (!question.ok()) return question.error();
  auto lab = OpenLab(call.lab);
  if (!lab.ok()) return lab.error();
  if (const Status split = TellSplit(lab.value(), question.value(), out); !split.ok()) return split;
  const auto groups = CountGrasps(lab.value(), question.value());
  if (!groups.ok()) return groups.error();
  const auto left_out = TellLeftOut(lab.value(), question.value(), out);
  if (!left_out.ok()) return left_out.error();
  out.fields()["kind"] = call.kind;
  AddFields(groups.value(), out);
  if (groups.value().empty() && left_out.value() == 0) {
    if (Status said = ExplainNothing(call, lab.value(), out); !said.ok()) return said;
  }
  if (call.csv) {
    PrintCsv(question.value().by, groups.value(), out);
  } else if (!groups.value().empty()) {
    out.Print("success rates of {} trials", call.kind);
    PrintTable(question.value().by, groups.value(), out);
  }
  return Ok{};
}

}  // namespace

Command MakeStatsCommand() {
  auto call = std::make_shared<StatsCall>();
  std::string names;
  for (const RateKey& key : RateKeys()) {
    names += (names.empty() ? "" : ", ") + key.name;
    if (!key.unit.empty() && !key.name.ends_with("_deg")) names += " (" + key.unit + ")";
  }
  return {
      .path = "stats",
      .help = "success rates with 95 % intervals, grouped as asked",
      .example = "tendril stats --by design,distance --where medium=air",
      .declare =
          [call, names](CLI::App& app) {
            AddLabOption(app, call->lab);
            app.add_option("--by", call->by, "group by these, separated by commas: " + names)->delimiter(',');
            app.add_option("--where", call->where,
                           "only trials with NAME=VALUE, separated by commas; names and units as for --by")
                ->delimiter(',');
            app.add_option("--kind", call->kind, "kind of trial; kinds are never mixed")
                ->check(CLI::IsMember({"real", "virtual", "simulated", "published"}))
                ->capture_default_str();
            app.add_flag("--include-untrusted", call->include_untrusted,
                         "also count simulations whose contacts speak against them");
            app.add_flag("--csv", call->csv, "print CSV");
          },
      .run = [call](Output& out) { return RunStats(*call, out); },
  };
}

}  // namespace tendril::cli
