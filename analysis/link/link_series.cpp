#include "analysis/link/link_series.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <cmath>
#include <iterator>

namespace tendril {
namespace {

constexpr double kJump = 0.5;  // turns between two frames: more than shapes change, less than a passage

// What changed from one frame to the next in a value and in its bodies' part. NaN compares false: no event
// beside a frame that is not known.
void NoteJumps(const LinkValue& link, const LinkValue& gauss, const LinkValue& link_before,
               const LinkValue& gauss_before, LinkEvent event, std::vector<LinkEvent>& events) {
  const double body = gauss.value - gauss_before.value;
  const double rays = link.value - link_before.value - body;
  if (std::abs(body) > kJump) {
    event.kind = LinkEvent::Kind::kBodyPassed;
    event.jump = body;
    events.push_back(event);
  }
  if (std::abs(rays) > kJump) {
    event.kind = LinkEvent::Kind::kRayCrossed;
    event.jump = rays;
    events.push_back(event);
  }
}

void NoteEvents(const LinkReport& before, const LinkReport& now, int frame, double time,
                std::vector<LinkEvent>& events) {
  for (size_t k = 0; k < now.pairs.size(); ++k) {
    const PairLink& pair = now.pairs[k];
    const PairLink& earlier = before.pairs[k];
    NoteJumps(pair.link, pair.gauss, earlier.link, earlier.gauss,
              {.frame = frame, .time = time, .a = pair.a, .b = pair.b}, events);
  }
  for (size_t k = 0; k < now.curves.size(); ++k) {
    const CurveLink& curve = now.curves[k];
    const CurveLink& earlier = before.curves[k];
    NoteJumps(curve.object_link, curve.object_gauss, earlier.object_link, earlier.object_gauss,
              {.frame = frame, .time = time, .a = static_cast<int>(k)}, events);
  }
}

std::string FlagList(LinkFlags flags) { return fmt::format("{}", fmt::join(FlagNames(flags), ",")); }

}  // namespace

void LinkSeries::EndBy(double last_time) {
  constexpr double kRounding = 1e-9;  // s, of frames' times
  end = 0;
  while (end + 1 < frames.size() && time[static_cast<Eigen::Index>(end) + 1] <= last_time + kRounding) ++end;
}

Result<LinkSeries> MeasureLinkSeries(std::span<const CurveSeries> curves, const LinkOptions& options,
                                     const Progress& progress) {
  if (curves.empty()) return Error{ErrorKind::kBadInput, "there is no curve, a link needs one or more"};
  const size_t frames = curves[0].curves.size();
  if (frames == 0) return Error{ErrorKind::kBadInput, fmt::format("curve '{}' has no frame", curves[0].name)};
  LinkSeries series;
  series.time = curves[0].time;
  for (const CurveSeries& curve : curves) {
    if (curve.curves.size() != frames || static_cast<size_t>(curve.time.size()) != frames) {
      return Error{
          ErrorKind::kBadInput,
          fmt::format("curve '{}' has {} frames and {} times, curve '{}' has {} frames, expected as many",
                      curve.name, curve.curves.size(), curve.time.size(), curves[0].name, frames)};
    }
    series.names.push_back(curve.name);
  }
  std::vector<FramedCurve> moment(curves.size());
  for (size_t frame = 0; frame < frames; ++frame) {
    for (size_t k = 0; k < curves.size(); ++k) moment[k] = curves[k].curves[frame];
    auto report = MeasureLink(moment, options);
    if (!report.ok()) return std::move(report).error().Within(fmt::format("frame {}", frame));
    series.frames.push_back(std::move(report).value());
    if (frame > 0) {
      NoteEvents(series.frames[frame - 1], series.frames[frame], static_cast<int>(frame),
                 series.time[static_cast<Eigen::Index>(frame)], series.events);
    }
    if (progress && !progress(static_cast<double>(frame + 1) / static_cast<double>(frames))) {
      return Error{ErrorKind::kStopped, fmt::format("stopped after frame {} of {}", frame, frames)};
    }
  }
  series.end = frames - 1;
  return series;
}

LinkRows RowsOf(const LinkSeries& series) {
  LinkRows rows;
  for (size_t frame = 0; frame < series.frames.size(); ++frame) {
    const LinkReport& report = series.frames[frame];
    const int number = static_cast<int>(frame);
    const double time = series.time[static_cast<Eigen::Index>(frame)];
    for (size_t k = 0; k < report.curves.size(); ++k) {
      const CurveLink& curve = report.curves[k];
      rows.tentacles.push_back({number, time, static_cast<int>(k), curve.self_link.value,
                                curve.object_link.value, curve.object_gauss.value,
                                FlagList(curve.writhe.flags | curve.self_link.flags |
                                         curve.object_link.flags | curve.object_gauss.flags)});
    }
    for (const PairLink& pair : report.pairs) {
      rows.pairs.push_back({number, time, pair.a, pair.b, pair.link.value, pair.gauss.value,
                            FlagList(pair.link.flags | pair.gauss.flags)});
    }
  }
  rows.mutual_link = series.AtEnd().mutual_link;
  rows.object_link = series.AtEnd().object_link;
  rows.performance = series.AtEnd().performance;
  rows.mutual_link_at_zero = series.AtPullZero().mutual_link;
  rows.object_link_at_zero = series.AtPullZero().object_link;
  rows.performance_at_zero = series.AtPullZero().performance;
  return rows;
}

}  // namespace tendril
