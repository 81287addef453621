#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <map>

#include "db/files/csv_read.h"
#include "db/files/curve_formats.h"
#include "db/files/safe_file.h"

namespace tendril {
namespace {

constexpr double kUnitTolerance =
    0.01;  // |normal| - 1: room for few printed digits, not for another quantity

// A curve while its rows come in.
struct Gathering {
  std::string name;
  std::int64_t frame = -1;
  std::vector<std::int64_t> frames;
  std::vector<double> times;
  std::vector<std::vector<Eigen::Vector3d>> points;
  std::vector<std::vector<Eigen::Vector3d>> normals;
};

Eigen::Matrix3Xd Columns(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Matrix3Xd out(3, static_cast<Eigen::Index>(points.size()));
  for (Eigen::Index i = 0; i < out.cols(); ++i) out.col(i) = points[static_cast<size_t>(i)];
  return out;
}

CurveSeries Finished(const Gathering& from, bool has_normals) {
  CurveSeries series;
  series.name = from.name;
  series.time =
      Eigen::Map<const Eigen::VectorXd>(from.times.data(), static_cast<Eigen::Index>(from.times.size()));
  for (size_t f = 0; f < from.points.size(); ++f) {
    FramedCurve curve;
    curve.points = Columns(from.points[f]);
    if (has_normals) curve.normals = Columns(from.normals[f]);
    series.curves.push_back(std::move(curve));
  }
  return series;
}

// Adds the row at hand; what is wrong with it waits in the reader's status.
void Take(CsvReader& csv, Gathering& into, bool timed, bool has_normals) {
  const size_t first = timed ? 2 : 0;  // column of `curve`
  const std::int64_t frame = timed ? csv.Integer(0, 0) : 0;
  const double time = timed ? csv.Number(1) : 0;
  const std::int64_t node = csv.Integer(first + 1, 0);
  if (into.points.empty() || frame != into.frame) {
    if (frame < into.frame) csv.Reject(0, fmt::format("a frame after {} of curve {}", into.frame, into.name));
    if (into.points.size() > 1 && into.points.back().size() != into.points.front().size()) {
      csv.Reject(first,
                 fmt::format("{} nodes in each frame: frame {} of curve {} has {}",
                             into.points.front().size(), into.frame, into.name, into.points.back().size()));
    }
    if (!into.times.empty() && time < into.times.back()) {
      csv.Reject(1, fmt::format("at least {} s, the time of the frame before", into.times.back()));
    }
    into.frame = frame;
    into.frames.push_back(frame);
    into.times.push_back(time);
    into.points.emplace_back();
    into.normals.emplace_back();
  } else if (time != into.times.back()) {
    csv.Reject(1, fmt::format("{} s, as in the rest of frame {}", into.times.back(), frame));
  }
  auto& points = into.points.back();
  if (node != static_cast<std::int64_t>(points.size())) {
    csv.Reject(first + 1, fmt::format("{}, for a curve's nodes run 0, 1, 2, ...", points.size()));
  }
  const auto vector = [&](size_t at) {
    const double x = csv.Number(at);
    const double y = csv.Number(at + 1);
    const double z = csv.Number(at + 2);
    return Eigen::Vector3d(x, y, z);
  };
  points.push_back(vector(first + 2));
  if (!has_normals) return;
  const Eigen::Vector3d normal = vector(first + 5);
  if (!(std::abs(normal.norm() - 1) <= kUnitTolerance)) {
    csv.Reject(first + 5, fmt::format("a unit vector, its length is {:.4g}", normal.norm()));
  }
  into.normals.back().push_back(normal);
}

}  // namespace

Result<std::vector<CurveSeries>> ReadCurvesCsv(const std::filesystem::path& file) {
  const std::string plain = "curve,node,x,y,z";
  const std::string timed_prefix = "frame,time,";
  const std::string normal_suffix = ",nx,ny,nz";
  auto opened = CsvReader::Open(
      file, {plain, plain + normal_suffix, timed_prefix + plain, timed_prefix + plain + normal_suffix},
      /*lines_end=*/false);
  if (!opened.ok()) return opened.error();
  CsvReader& csv = opened.value();
  const bool timed = csv.columns().front() == "frame";
  const bool has_normals = csv.columns().back() == "nz";

  std::vector<Gathering> curves;
  std::map<std::string, size_t, std::less<>> index;
  while (csv.Next()) {
    const std::string_view name = csv.Text(timed ? 2 : 0);
    if (name.empty()) csv.Reject(timed ? 2 : 0, "a name");
    auto found = index.find(name);
    if (found == index.end()) {
      found = index.emplace(name, curves.size()).first;
      curves.emplace_back().name = name;
    }
    Take(csv, curves[found->second], timed, has_normals);
  }
  if (csv.ok() && curves.empty()) csv.RejectFile("holds no curve, only a header");
  for (const Gathering& curve : curves) {
    if (!csv.ok()) break;
    if (curve.points.back().size() != curve.points.front().size()) {
      csv.RejectFile(
          fmt::format("curve {}: {} nodes in frame {}, expected {} as in its first frame (truncated?)",
                      curve.name, curve.points.back().size(), curve.frame, curve.points.front().size()));
    }
    if (curve.frames != curves.front().frames) {
      csv.RejectFile(
          fmt::format("curves {} and {} are not given at the same frames ({} and {} of them; truncated?)",
                      curves.front().name, curve.name, curves.front().frames.size(), curve.frames.size()));
    }
  }
  if (!csv.ok()) return csv.status().error();

  std::vector<CurveSeries> all;
  for (const Gathering& curve : curves) all.push_back(Finished(curve, has_normals));
  return all;
}

Status WriteCurvesCsv(const std::filesystem::path& file, std::span<const CurveSeries> curves) {
  const auto wrong = [&](const std::string& what) {
    return Error{ErrorKind::kBadInput, file.string() + ": " + what};
  };
  if (curves.empty() || curves.front().curves.empty()) return wrong("no curve to write");
  const bool has_normals = curves.front().curves.front().normals.cols() > 0;
  const size_t frames = curves.front().curves.size();
  for (const CurveSeries& series : curves) {
    if (series.curves.size() != frames) return wrong("curves of unequal frame counts; .h5 can hold them");
    if ((series.curves.front().normals.cols() > 0) != has_normals) {
      return wrong("some curves have normals and some have none; .h5 can hold them");
    }
  }
  std::string text = fmt::format("frame,time,curve,node,x,y,z{}\n", has_normals ? ",nx,ny,nz" : "");
  auto out = std::back_inserter(text);
  for (size_t f = 0; f < frames; ++f) {
    for (const CurveSeries& series : curves) {
      const FramedCurve& curve = series.curves[f];
      if (!curve.points.allFinite() || !curve.normals.allFinite()) {
        return wrong(
            fmt::format("curve {} has a gap in frame {}: CSV has no place for one, .h5 has", series.name, f));
      }
      for (Eigen::Index node = 0; node < curve.points.cols(); ++node) {
        const Eigen::Vector3d p = curve.points.col(node);
        fmt::format_to(out, "{},{},{},{},{},{},{}", f, series.time[static_cast<Eigen::Index>(f)], series.name,
                       node, p.x(), p.y(), p.z());
        if (has_normals) {
          const Eigen::Vector3d n = curve.normals.col(node);
          fmt::format_to(out, ",{},{},{}", n.x(), n.y(), n.z());
        }
        text += '\n';
      }
    }
  }
  return WriteText(file, text);
}

}  // namespace tendril
