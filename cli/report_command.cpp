// tendril report: a page about each tracked trial, for people.
#include "cli/report_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "capture/track/overlay.h"
#include "cli/lab_option.h"
#include "cli/report_facts.h"
#include "cli/report_figures.h"
#include "cli/report_json.h"
#include "cli/report_page.h"
#include "db/files/safe_file.h"
#include "db/trial_query.h"

namespace tendril::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct ReportCall {
  std::vector<std::string> trials;
  bool all = false;
  std::string lab;
  std::string out;
  int draws = 400;
};

// The frame whose used tags lie farthest from the chain, over all cameras; -1: not known.
int FrameOfLargestMisfit(const TrialFacts& facts) {
  int frame = -1;
  double largest = -1;
  for (const CameraFacts& camera : facts.cameras) {
    for (std::size_t f = 0; f < camera.rms_by_frame.size(); ++f) {
      if (!(camera.rms_by_frame[f] > largest)) continue;
      largest = camera.rms_by_frame[f];
      frame = static_cast<int>(f);
    }
  }
  return frame;
}

Result<std::vector<PageStill>> StillsOf(const fs::path& folder, const TrialFacts& facts,
                                        const Progress& progress) {
  std::vector<PageStill> pages;
  for (std::size_t c = 0; c < facts.cameras.size(); ++c) {
    if (!fs::exists(folder / fmt::format("cam{}.mkv", c))) return pages;
  }
  if (facts.cameras.empty() || !fs::exists(folder / "detections.csv")) return pages;
  const int last = static_cast<int>(facts.curves.front().curves.size()) - 1;
  const int misfit = FrameOfLargestMisfit(facts);
  std::vector<std::pair<int, std::string>> wanted = {
      {0, "first frame"}, {last / 2, "middle"}, {last, "last frame"}};
  if (misfit >= 0) wanted.emplace_back(misfit, "largest misfit");
  std::sort(wanted.begin(), wanted.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<int> frames;
  for (const auto& [frame, why] : wanted) {
    if (frames.empty() || frames.back() != frame) frames.push_back(frame);
  }
  const Result<std::vector<OverlayStill>> stills = DrawStills(folder, frames, 960, progress);
  if (!stills.ok()) return stills.error();
  for (const OverlayStill& still : stills.value()) {
    PageStill page{.camera = still.camera,
                   .frame = still.frame,
                   .time = still.time,
                   .why = {},
                   .jpeg = {},
                   .width_px = still.picture.cols,
                   .height_px = still.picture.rows};
    for (const auto& [frame, why] : wanted) {
      if (frame == still.frame) page.why += (page.why.empty() ? "" : ", ") + why;
    }
    std::vector<unsigned char> bytes;
    try {
      cv::imencode(".jpg", still.picture, bytes, {cv::IMWRITE_JPEG_QUALITY, 82});
    } catch (const cv::Exception& error) {
      return Error{ErrorKind::kIo,
                   fmt::format("{}: a still could not be packed: {}", folder.string(), error.err)};
    }
    page.jpeg.assign(bytes.begin(), bytes.end());
    pages.push_back(std::move(page));
  }
  return pages;
}

// A page's name: the label where that is a plain file name, else the id.
std::string PageName(const TrialOverview& trial) {
  const bool plain = !trial.label.empty() && trial.label.front() != '.' && trial.label != "index" &&
                     std::all_of(trial.label.begin(), trial.label.end(), [](unsigned char c) {
                       return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.';
                     });
  return (plain ? trial.label : trial.id) + ".html";
}

Status MakeFolder(const fs::path& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (!failed) return Ok{};
  return Error{ErrorKind::kIo,
               fmt::format("{}: the folder cannot be made ({})", folder.string(), failed.message())};
}

Result<TrialFacts> WritePage(Lab& lab, const std::string& id, const fs::path& file, const ReportCall& call,
                             const Progress& progress) {
  const fs::path folder = lab.TrialFolder(id);
  Result<TrialFacts> facts = CollectFacts(lab, id, {.draws = call.draws}, PartOf(progress, 0, 0.5));
  if (!facts.ok()) return facts;
  const Result<std::vector<PageStill>> stills = StillsOf(folder, facts.value(), PartOf(progress, 0.5, 0.75));
  if (!stills.ok()) return stills.error();
  const Result<PageFigures> figures = DrawPageFigures(facts.value(), PartOf(progress, 0.75, 1));
  if (!figures.ok()) return figures.error();
  if (call.out.empty()) {  // a named folder must be there, the lab's own is made
    if (Status s = MakeFolder(file.parent_path()); !s.ok()) return s.error();
  }
  if (Status s = WriteText(file, PageOf(facts.value(), figures.value(), stills.value())); !s.ok())
    return s.error();
  return facts;
}

void PrintFacts(const TrialFacts& facts, const fs::path& file, Output& out) {
  const IndexRow key = KeyFigures(facts);
  out.Print(
      "{}: {} frames, {:.0f} % of the nodes seen{}{}", facts.details.overview.label, key.frames,
      100 * key.seen,
      std::isfinite(key.median_sigma) ? fmt::format(", sigma {:.2f} mm", 1e3 * key.median_sigma) : "",
      std::isfinite(key.worst_camera_px) ? fmt::format(", worst camera {:.2f} px", key.worst_camera_px) : "");
  for (const std::string& remark : facts.remarks) out.Print("  {}", remark);
  out.Print("  {}", file.string());
}

Status ReportOne(const ReportCall& call, Lab& lab, const std::string& id, Output& out) {
  const Result<TrialDetails> details = TrialDetailsOf(lab, id);
  if (!details.ok()) return details.error();
  fs::path file = call.out;
  if (call.out.empty()) {
    file = lab.folder() / "reports" / PageName(details.value().overview);
  } else if (fs::is_directory(file)) {
    file /= PageName(details.value().overview);
  }
  const Result<TrialFacts> facts = WritePage(lab, id, file, call, out.ShowProgress("report"));
  if (!facts.ok()) return facts.error();
  out.fields() = FactsAsJson(facts.value());
  out.fields()["page"] = file.string();
  PrintFacts(facts.value(), file, out);
  return Ok{};
}

// A page each and an index. Trials without tracking are listed without a page under --all, else an error.
Status ReportSeveral(const ReportCall& call, Lab& lab, const std::vector<std::string>& ids, Output& out) {
  const fs::path folder = call.out.empty() ? lab.folder() / "reports" : fs::path(call.out);
  if (folder.extension() == ".html") {
    return Error{ErrorKind::kBadInput, fmt::format("--out {}: {} trials make a page each; expected a folder",
                                                   call.out, ids.size())};
  }
  if (Status s = MakeFolder(folder); !s.ok()) return s;
  const Progress progress = out.ShowProgress("reports");
  std::vector<IndexRow> rows;
  out.fields()["reports"] = Json::array();
  out.fields()["left_out"] = Json::array();
  for (std::size_t i = 0; i < ids.size(); ++i) {
    Result<TrialDetails> details = TrialDetailsOf(lab, ids[i]);
    if (!details.ok()) return details.error();
    const TrialOverview& overview = details.value().overview;
    const auto leave_out = [&](const std::string& why) {
      IndexRow none;
      none.trial = overview;
      none.why_none = why;
      rows.push_back(none);
      out.fields()["left_out"].push_back({{"trial", overview.id}, {"why", why}});
    };
    if (call.all && !IsTracked(details.value(), lab.TrialFolder(ids[i]))) {
      if (overview.kind != TrialKind::kSimulated) leave_out("not tracked: tendril track " + overview.label);
      continue;
    }
    const fs::path file = folder / PageName(overview);
    const auto share = [&](std::size_t k) {
      return static_cast<double>(k) / static_cast<double>(ids.size());
    };
    const Result<TrialFacts> facts =
        WritePage(lab, ids[i], file, call, PartOf(progress, share(i), share(i + 1)));
    if (!facts.ok() && call.all && facts.error().kind == ErrorKind::kBadInput) {
      out.Warn(facts.error().message);
      leave_out(facts.error().message);
      continue;
    }
    if (!facts.ok()) return facts.error();
    rows.push_back(KeyFigures(facts.value()));
    rows.back().file = file.filename().string();
    Json json = FactsAsJson(facts.value());
    json["page"] = file.string();
    out.fields()["reports"].push_back(std::move(json));
    PrintFacts(facts.value(), file, out);
  }
  const fs::path index = folder / "index.html";
  if (Status s = WriteText(index, IndexOf(fs::absolute(lab.folder()).filename().string(), rows)); !s.ok())
    return s;
  out.fields()["index"] = index.string();
  out.Print("index: {}", index.string());
  return Ok{};
}

Status RunReport(const ReportCall& call, Output& out) {
  if (call.trials.empty() && !call.all) {
    return Error{ErrorKind::kBadInput, "nothing to report: name one or more trials, or --all"};
  }
  Result<Lab> lab = OpenLab(call.lab);
  if (!lab.ok()) return lab.error();
  std::vector<std::string> ids;
  for (const std::string& name : call.trials) {
    const Result<std::string> id = FindTrial(lab.value(), name);
    if (!id.ok()) return id.error();
    if (std::find(ids.begin(), ids.end(), id.value()) == ids.end()) ids.push_back(id.value());
  }
  if (call.all) {
    const Result<std::vector<TrialOverview>> trials = ListTrials(lab.value());
    if (!trials.ok()) return trials.error();
    ids.clear();
    for (const TrialOverview& trial : trials.value()) ids.push_back(trial.id);
    if (ids.empty())
      return Error{ErrorKind::kNotFound, "this lab has no trial to report; make one with: tendril record"};
  }
  if (!call.all && ids.size() == 1) return ReportOne(call, lab.value(), ids.front(), out);
  return ReportSeveral(call, lab.value(), ids, out);
}

}  // namespace

Command MakeReportCommand() {
  auto call = std::make_shared<ReportCall>();
  return {
      .path = "report",
      .help =
          "a page about each tracked trial: pictures, fold angles, what was seen, residuals, links with "
          "bands",
      .example = "tendril report bending-50mm-1 --lab mylab --out bending-50mm-1.html",
      .declare =
          [call](CLI::App& app) {
            CLI::Option* const trials =
                app.add_option("trials", call->trials, "trials: labels, ids, or unique beginnings of ids");
            app.add_flag("--all", call->all, "all tracked trials of the lab, and an index page")
                ->excludes(trials);
            app.add_option(
                "--out", call->out,
                "page to write (.html), or of several trials the folder for their pages and index.html "
                "(default: reports/ in the lab)");
            app.add_option("--draws", call->draws,
                           "draws of the curves for each moment's bands of the links (count)")
                ->check(CLI::Range(2, 1000000))
                ->capture_default_str();
            AddLabOption(app, call->lab);
          },
      .run = [call](Output& out) { return RunReport(*call, out); },
  };
}

}  // namespace tendril::cli
