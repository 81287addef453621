// tendril link: how much curves wind around themselves, each other and an object.
#include "cli/link_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/link/link_series.h"
#include "cli/lab_option.h"
#include "cli/link_bands_answer.h"
#include "cli/score_trial.h"
#include "db/files/curve_files.h"
#include "db/trial_query.h"

namespace tendril::cli {
namespace {

using Json = nlohmann::ordered_json;

struct LinkCall {
  std::string curves;
  std::string trial;
  std::string lab;
  std::string axis;
  std::string closure = "rays";
  std::string frame = "last";
  std::string accuracy;
  double self_offset_mm = 0;
  bool bands = false;
  int draws = 400;
};

std::optional<double> ParseNumber(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
  if (parsed.ec != std::errc{} || parsed.ptr != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

Result<Axis> ParseAxis(std::string_view text) {
  std::vector<double> numbers;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const auto number = ParseNumber(text.substr(begin, end - begin));
    if (!number) {
      return Error{ErrorKind::kBadInput,
                   fmt::format("--axis: '{}' is no finite number, expected \"x,y,z,dx,dy,dz\"",
                               text.substr(begin, end - begin))};
    }
    numbers.push_back(*number);
    begin = end + 1;
  }
  if (numbers.size() != 6) {
    return Error{
        ErrorKind::kBadInput,
        fmt::format("--axis has {} numbers, expected six: a point in m and a direction, \"x,y,z,dx,dy,dz\"",
                    numbers.size())};
  }
  const Axis axis{{numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]}};
  if (!(axis.direction.stableNorm() > 0)) {
    return Error{ErrorKind::kBadInput, "--axis: the direction dx,dy,dz is 0,0,0, expected one with a length"};
  }
  return axis;
}

void AddValue(Json& to, const std::string& name, const LinkValue& value) {
  to[name] = NumberOrNull(value.value);
  to[name + "_error"] = NumberOrNull(value.error);
}

Json ReportJson(const LinkReport& report, const std::vector<std::string>& names) {
  Json json;
  json["curves"] = Json::array();
  for (size_t i = 0; i < report.curves.size(); ++i) {
    const CurveLink& curve = report.curves[i];
    Json one;
    one["name"] = names[i];
    AddValue(one, "writhe", curve.writhe);
    one["twist"] = NumberOrNull(curve.twist);
    AddValue(one, "self_link", curve.self_link);
    one["self_link_offset_m"] = NumberOrNull(curve.self_offset);
    one["self_link_offset_influence"] = NumberOrNull(curve.offset_influence);
    AddValue(one, "object_link", curve.object_link);
    AddValue(one, "object_gauss", curve.object_gauss);
    one["flags"] = FlagNames(curve.writhe.flags | curve.self_link.flags | curve.object_link.flags |
                             curve.object_gauss.flags);
    json["curves"].push_back(one);
  }
  json["pairs"] = Json::array();
  for (const PairLink& pair : report.pairs) {
    Json one;
    one["a"] = names[static_cast<size_t>(pair.a)];
    one["b"] = names[static_cast<size_t>(pair.b)];
    AddValue(one, "link", pair.link);
    AddValue(one, "gauss", pair.gauss);
    one["flags"] = FlagNames(pair.link.flags | pair.gauss.flags);
    json["pairs"].push_back(one);
  }
  json["mutual_link"] = NumberOrNull(report.mutual_link);
  json["object_link"] = NumberOrNull(report.object_link);
  json["performance"] = NumberOrNull(report.performance);
  return json;
}

std::string Shown(double value) {
  if (!std::isfinite(value)) return "-";
  return std::abs(value) < 5e-7 ? "0.000000" : fmt::format("{:+.6f}", value);  // no "-0.000000"
}

std::string FlagText(LinkFlags flags) { return fmt::format("{}", fmt::join(FlagNames(flags), ", ")); }

void PrintReport(const LinkReport& report, const std::vector<std::string>& names, bool axis, Output& out) {
  size_t width = 5;
  for (const std::string& name : names) width = std::max(width, name.size());
  out.Print("{:<{}}  {:>11} {:>11} {:>11} {:>11} {:>11}", "curve", width, "writhe", "twist", "self link",
            "object link", "its gauss");
  for (size_t i = 0; i < report.curves.size(); ++i) {
    const CurveLink& curve = report.curves[i];
    LinkFlags flags =
        curve.writhe.flags | curve.self_link.flags | curve.object_link.flags | curve.object_gauss.flags;
    out.Print("{:<{}}  {:>11} {:>11} {:>11} {:>11} {:>11}  {}", names[i], width, Shown(curve.writhe.value),
              Shown(curve.twist), Shown(curve.self_link.value), Shown(curve.object_link.value),
              Shown(curve.object_gauss.value), FlagText(flags));
  }
  if (!report.pairs.empty()) {
    out.Print("");
    out.Print("{:<{}}  {:>11} {:>11}", "pair", 2 * width + 3, "link", "gauss");
    for (const PairLink& pair : report.pairs) {
      out.Print("{:<{}}  {:>11} {:>11}  {}",
                names[static_cast<size_t>(pair.a)] + " - " + names[static_cast<size_t>(pair.b)],
                2 * width + 3, Shown(pair.link.value), Shown(pair.gauss.value),
                FlagText(pair.link.flags | pair.gauss.flags));
    }
  }
  out.Print("");
  out.Print("mutual link (mean |link| over pairs)      {}", Shown(report.mutual_link));
  if (!axis) return;
  out.Print("object link (mean |object link|)          {}", Shown(report.object_link));
  out.Print("grasping performance (sum of both)        {}", Shown(report.performance));
}

void AddSeries(const LinkSeries& series, Output& out) {
  auto& fields = out.fields();
  fields["frames"] = Json::array();
  for (size_t k = 0; k < series.frames.size(); ++k) {
    Json frame;
    frame["frame"] = k;
    frame["time_s"] = series.time[static_cast<Eigen::Index>(k)];
    frame.update(ReportJson(series.frames[k], series.names));
    fields["frames"].push_back(frame);
  }
  fields["events"] = Json::array();
  for (const LinkEvent& event : series.events) {
    const bool body = event.kind == LinkEvent::Kind::kBodyPassed;
    Json json;
    json["kind"] = body ? "body_passed" : "ray_crossed";
    json["frame"] = event.frame;
    json["time_s"] = event.time;
    json["a"] = series.names[static_cast<size_t>(event.a)];
    json["b"] = event.b >= 0 ? Json(series.names[static_cast<size_t>(event.b)]) : Json("axis");
    json["jump"] = event.jump;
    fields["events"].push_back(json);
  }
  fields["at_pull_0"] = {{"mutual_link", NumberOrNull(series.AtPullZero().mutual_link)},
                         {"object_link", NumberOrNull(series.AtPullZero().object_link)},
                         {"performance", NumberOrNull(series.AtPullZero().performance)}};
  if (out.json()) return;
  out.Print("{:>6} {:>9}  {:>11} {:>11} {:>11}", "frame", "time (s)", "mutual", "object", "performance");
  for (size_t k = 0; k < series.frames.size(); ++k) {
    const LinkReport& report = series.frames[k];
    out.Print("{:>6} {:>9.3f}  {:>11} {:>11} {:>11}", k, series.time[static_cast<Eigen::Index>(k)],
              Shown(report.mutual_link), Shown(report.object_link), Shown(report.performance));
  }
  for (const LinkEvent& event : series.events) {
    out.Print("{:.3f} s: {} {} {} ({:+.3f})", event.time, series.names[static_cast<size_t>(event.a)],
              event.kind == LinkEvent::Kind::kBodyPassed ? "passed through" : "swept a ray over",
              event.b >= 0 ? series.names[static_cast<size_t>(event.b)] : "the axis", event.jump);
  }
  out.Print("");
}

// The frame asked for; nothing: all of them.
Result<std::optional<size_t>> ParseFrame(const std::string& text, size_t frames) {
  if (text == "all") return std::optional<size_t>();
  if (text == "last") return std::optional<size_t>(frames - 1);
  size_t number = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), number);
  if (parsed.ec != std::errc{} || parsed.ptr != text.data() + text.size() || number >= frames) {
    return Error{
        ErrorKind::kBadInput,
        fmt::format("--frame '{}': expected a frame number from 0 to {}, 'last' or 'all'", text, frames - 1)};
  }
  return std::optional<size_t>(number);
}

void AddReport(const LinkSeries& series, const LinkOptions& options, Output& out) {
  auto& fields = out.fields();
  fields["closure"] = ClosureText(options.closure);
  fields["accuracy"] = options.method == LinkMethod::kExact ? "exact" : "fast";
  fields["time_s"] = series.EndTime();
  fields.update(ReportJson(series.AtEnd(), series.names));
}

// A trial of a lab: all frames, about the axis of its object, kept in the database.
Status RunLinkOfTrial(const LinkCall& call, const LinkOptions& options, Output& out) {
  Result<Lab> lab = OpenLab(call.lab);
  if (!lab.ok()) return lab.error();
  const Result<std::string> id = FindTrial(lab.value(), call.trial);
  if (!id.ok()) return id.error();
  const Result<LinkSeries> series = ScoreTrial(lab.value(), id.value(), options, out.ShowProgress("link"));
  if (!series.ok()) return series.error();
  out.fields()["trial"] = id.value();
  AddReport(series.value(), options, out);
  AddSeries(series.value(), out);
  const Result<TrialSpec> trial = LoadTrial(lab.value(), id.value());
  if (!trial.ok()) return trial.error();
  const bool axis = AxisOf(trial.value()).has_value();
  PrintReport(series.value().AtEnd(), series.value().names, axis, out);
  if (!axis) out.Print("no object link: a {} has no axis", trial.value().object.kind);
  if (!call.bands) return Ok{};
  const Result<std::vector<CurveSeries>> curves =
      CurvesAboutObject(lab.value().TrialFolder(id.value()), trial.value());
  if (!curves.ok()) return curves.error();
  LinkOptions about = options;
  about.axis = AxisOf(trial.value());
  return AnswerWithBands(curves.value(), series.value().end, about, call.draws, call.trial, out);
}

Status RunLink(const LinkCall& call, Output& out) {
  LinkOptions options;
  auto closure = ParseClosure(call.closure);
  if (!closure.ok()) return std::move(closure).error().Within("--closure");
  options.closure = closure.value();
  if (!call.axis.empty()) {
    auto axis = ParseAxis(call.axis);
    if (!axis.ok()) return axis.error();
    options.axis = axis.value();
  }
  options.self_offset = 1e-3 * call.self_offset_mm;
  if (!call.trial.empty()) {
    options.method = call.accuracy == "exact" ? LinkMethod::kExact : LinkMethod::kFast;
    return RunLinkOfTrial(call, options, out);
  }
  if (call.curves.empty()) {
    return Error{ErrorKind::kBadInput, "nothing to measure: name a curves file, or a trial with --trial"};
  }
  auto curves = ReadCurves(call.curves);
  if (!curves.ok()) return curves.error();
  const size_t frames = curves.value().front().curves.size();
  const auto frame = ParseFrame(call.frame, frames);
  if (!frame.ok()) return frame.error();
  if (frame.value()) {
    // One moment is cheap: exact unless told otherwise. Many frames are fast unless told otherwise.
    options.method = call.accuracy == "fast" ? LinkMethod::kFast : LinkMethod::kExact;
    for (CurveSeries& curve : curves.value()) {
      if (*frame.value() >= curve.curves.size()) continue;  // MeasureLinkSeries says what is wrong
      const FramedCurve kept = curve.curves[*frame.value()];
      const double time = curve.time[static_cast<Eigen::Index>(*frame.value())];
      curve.curves = {kept};
      curve.time = Eigen::VectorXd::Constant(1, time);
      if (*frame.value() < curve.covariance_factor.size()) {
        curve.covariance_factor = {Eigen::MatrixXd(curve.covariance_factor[*frame.value()])};
      }
      if (*frame.value() < curve.turn_factor.size()) {
        curve.turn_factor = {Eigen::MatrixXd(curve.turn_factor[*frame.value()])};
      }
    }
  } else {
    options.method = call.accuracy == "exact" ? LinkMethod::kExact : LinkMethod::kFast;
  }

  const Progress progress = frame.value() ? Progress{} : out.ShowProgress("link");
  auto measured = MeasureLinkSeries(curves.value(), options, progress);
  if (!measured.ok()) return std::move(measured).error().Within(call.curves);
  const LinkSeries& series = measured.value();
  const LinkReport& report = series.AtEnd();

  AddReport(series, options, out);
  out.fields()["frame"] = frame.value().value_or(frames - 1);
  if (!frame.value()) AddSeries(series, out);
  PrintReport(report, series.names, options.axis.has_value(), out);
  for (const CurveLink& curve : report.curves) {
    if (curve.writhe.flags & kMissing) {
      out.Warn("a curve has nodes without a position: its values are not known (null), nor are the means");
      break;
    }
  }
  if (!call.bands) return Ok{};
  return AnswerWithBands(curves.value(), series.end, options, call.draws, call.curves, out);
}

}  // namespace

Command MakeLinkCommand() {
  auto call = std::make_shared<LinkCall>();
  return {
      .path = "link",
      .help = "link, writhe and twist of curves: around themselves, each other and an object's axis",
      .example = "tendril link curves.csv --axis \"0,0,-0.15,1,0,0\" --json",
      .declare =
          [call](CLI::App& app) {
            CLI::Option* const curves =
                app.add_option("curves", call->curves, "curves file (.csv or .h5; metres)");
            CLI::Option* const trial = app.add_option(
                "--trial", call->trial,
                "measure a tracked trial instead (label or id): all frames, about its object's axis; "
                "the database keeps the result");
            trial->excludes(curves);
            AddLabOption(app, call->lab);
            trial->excludes(app.add_option(
                "--axis", call->axis,
                "the object's axis as \"x,y,z,dx,dy,dz\": a point on it (m) and its direction (any length)"));
            app.add_option(
                   "--closure", call->closure,
                   "how open curves go on: rays (to infinity), none, or straight ends of K arc lengths: "
                   "next_tangent:K, end_to_end:K, net_tangent:K")
                ->capture_default_str();
            trial->excludes(app.add_option("--frame", call->frame,
                                           "frame number (from 0), last, or all (then also over time)")
                                ->capture_default_str());
            app.add_option(
                   "--accuracy", call->accuracy,
                   "exact (pair by pair, with error bounds; the default for one frame) or fast (vector "
                   "registers, within 1e-12 turns; the default for all frames)")
                ->check(CLI::IsMember({"exact", "fast"}));
            app.add_option("--self-offset", call->self_offset_mm,
                           "offset of the self-link's second curve (mm); 0: 1 % of the shortest segment")
                ->check(CLI::NonNegativeNumber);
            app.add_flag("--bands", call->bands,
                         "how sure: bands over curves drawn from their covariance, and crossings of which it "
                         "is not known who lies in front (the last frame, or --frame's)");
            app.add_option("--draws", call->draws, "draws of --bands (count)")
                ->check(CLI::Range(2, 1000000))
                ->capture_default_str();
          },
      .run = [call](Output& out) { return RunLink(*call, out); },
  };
}

}  // namespace tendril::cli
