// RemarksOn: what stands out of a trial's numbers, in words.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cli/link_bands_answer.h"
#include "cli/report_facts.h"

namespace tendril::cli {
namespace {

std::string CameraName(const CameraFacts& camera) {
  return camera.name.empty() ? fmt::format("camera {}", camera.number)
                             : fmt::format("camera {} ({})", camera.number, camera.name);
}

// What the cameras found, against the one that found most.
void CompareFinds(const std::vector<CameraFacts>& cameras, std::vector<std::string>& remarks) {
  if (cameras.size() < 2) return;
  const auto most = std::max_element(cameras.begin(), cameras.end(),
                                     [](const auto& a, const auto& b) { return a.found < b.found; });
  for (const CameraFacts& camera : cameras) {
    if (most->found == 0 || 3 * camera.found >= 2 * most->found) continue;
    remarks.push_back(
        fmt::format("{} found {} tags, {:.0f} % of the {} that {} found: look at its light, focus "
                    "and view.",
                    CameraName(camera), camera.found,
                    100.0 * static_cast<double>(camera.found) / static_cast<double>(most->found), most->found,
                    CameraName(*most)));
  }
}

// One camera against all others together. The chain follows what most tags say, so that the odd one shows.
void CompareResiduals(const std::vector<CameraFacts>& cameras, std::vector<std::string>& remarks) {
  constexpr long kFewest = 20;    // tags, below which nothing is said
  constexpr double kWorse = 1.5;  // times the others' RMS
  constexpr double kShift = 0.1;  // px, mean shift
  for (const CameraFacts& camera : cameras) {
    if (camera.used < kFewest) continue;
    double squares = 0;
    double tags = 0;
    for (const CameraFacts& other : cameras) {
      if (other.number == camera.number || other.used == 0) continue;
      squares += static_cast<double>(other.used) * other.rms_px * other.rms_px;
      tags += static_cast<double>(other.used);
    }
    if (tags >= kFewest && camera.rms_px > kWorse * std::sqrt(squares / tags)) {
      remarks.push_back(fmt::format(
          "{} fits the chain worse than the rest: {:.2f} px RMS against {:.2f} px. It may be sharp less "
          "often, or "
          "have moved since it was calibrated{}; `tendril calibrate cameras` tells.",
          CameraName(camera), camera.rms_px, std::sqrt(squares / tags),
          cameras.size() == 2 ? " (or the other has: with two cameras it cannot be told which)" : ""));
    }
    const double error = camera.shift_error_px.norm();
    if (camera.shift_px.norm() > kShift && camera.shift_px.norm() > 4 * error) {
      remarks.push_back(fmt::format(
          "In {} tags lie on average {:.2f} px {} and {:.2f} px {} where the chain has them (standard error "
          "{:.2f} "
          "px): its pose or lens is likely off, or the other cameras' are.",
          CameraName(camera), std::abs(camera.shift_px.x()), camera.shift_px.x() > 0 ? "right of" : "left of",
          std::abs(camera.shift_px.y()), camera.shift_px.y() > 0 ? "below" : "above", error));
    }
  }
}

void TellLeftOut(const std::vector<CameraFacts>& cameras, std::vector<std::string>& remarks) {
  for (const CameraFacts& camera : cameras) {
    if (20 * camera.left_out > camera.on_facet) {
      remarks.push_back(
          fmt::format("{}: {} of {} tags ({:.0f} %) contradict all else and were left out.",
                      CameraName(camera), camera.left_out, camera.on_facet,
                      100.0 * static_cast<double>(camera.left_out) / static_cast<double>(camera.on_facet)));
    }
    if (camera.dropped > 0) {
      remarks.push_back(fmt::format("{} lost {} pictures while recording; {} are there.", CameraName(camera),
                                    camera.dropped, camera.pictures));
    }
  }
}

void TellContradictions(const TrialFacts& facts, std::vector<std::string>& remarks) {
  constexpr long kFewest = 12;  // tags, below which nothing is said
  if (facts.shared < kFewest || 4 * facts.shared_contradicted < facts.shared) return;
  remarks.push_back(fmt::format(
      "Of {} tags that several cameras saw at once, {} ({:.0f} %) had a sighting left out: the cameras "
      "contradict each "
      "other. One may have moved since it was calibrated, or their pictures are not of one moment; `tendril "
      "calibrate cameras` "
      "tells.",
      facts.shared, facts.shared_contradicted,
      100.0 * static_cast<double>(facts.shared_contradicted) / static_cast<double>(facts.shared)));
}

// "3", "3 and 5", "3 to 7 and 9".
std::string Runs(const std::vector<int>& numbers) {
  std::vector<std::string> runs;
  for (std::size_t i = 0; i < numbers.size();) {
    std::size_t end = i;
    while (end + 1 < numbers.size() && numbers[end + 1] == numbers[end] + 1) ++end;
    runs.push_back(end == i ? fmt::format("{}", numbers[i])
                            : fmt::format("{} to {}", numbers[i], numbers[end]));
    i = end + 1;
  }
  std::string text;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == runs.size() ? " and " : ", ") + runs[i];
  }
  return text;
}

void TellTentacles(const std::vector<TentacleFacts>& tentacles, std::vector<std::string>& remarks) {
  for (const TentacleFacts& tentacle : tentacles) {
    if (tentacle.seen <= 0) {
      remarks.push_back(fmt::format("{}: no tag was seen; its curve is the model's alone.", tentacle.name));
    } else if (tentacle.seen < 0.3) {
      remarks.push_back(
          fmt::format("{}: {:.0f} % of its nodes were seen, {:.0f} % bridged by the model, {:.0f} % not "
                      "seen at all.",
                      tentacle.name, 100 * tentacle.seen, 100 * tentacle.bridged, 100 * tentacle.not_seen));
    }
    if (tentacle.seen > 0 && !tentacle.never_known.empty()) {
      remarks.push_back(
          fmt::format("{}: {} {} never known, in no frame.", tentacle.name,
                      (tentacle.never_known.size() == 1 ? "node " : "nodes ") + Runs(tentacle.never_known),
                      tentacle.never_known.size() == 1 ? "was" : "were"));
    }
  }
}

void TellUndecided(const TrialFacts& facts, std::vector<std::string>& remarks) {
  const LinkFacts& link = facts.link;
  if (link.bands.empty()) return;
  std::vector<std::string> names;
  for (const TentacleFacts& tentacle : facts.tentacles) names.push_back(tentacle.name);
  constexpr std::size_t kNamed = 3;  // the page lists all further down
  const auto& undecided = link.bands.back().undecided;
  for (std::size_t i = 0; i < std::min(kNamed, undecided.size()); ++i) {
    remarks.push_back(
        "At the end it is not decided who lies in front: " + UndecidedText(undecided[i], names) + ".");
  }
  if (undecided.size() > kNamed)
    remarks.push_back(
        fmt::format("So it is at {} more crossings, listed on the page.", undecided.size() - kNamed));
}

}  // namespace

std::vector<std::string> RemarksOn(const TrialFacts& facts) {
  std::vector<std::string> remarks;
  TellTentacles(facts.tentacles, remarks);
  CompareFinds(facts.cameras, remarks);
  CompareResiduals(facts.cameras, remarks);
  TellContradictions(facts, remarks);
  TellLeftOut(facts.cameras, remarks);
  TellUndecided(facts, remarks);
  for (const std::string& gap : facts.gaps) remarks.push_back("Missing: " + gap + ".");
  return remarks;
}

}  // namespace tendril::cli
