#pragma once
// A recorded stream of tag corners from several real cameras (tagslam_test's format, SOURCE.txt), and how
// well its tags triangulate. Shared by a test and by bench/multicamera_report.cpp.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "calibrate/rig_from_tags.h"
#include "capture/track/triangulate.h"

namespace tendril::testing_support {

struct TagStream {
  std::vector<Camera> cameras;  // intrinsics; poses are not known
  std::vector<TagView> views;   // stamp: ns
};

// cameras.yaml and tag_detections.csv.gz (unpacked by gzip). Empty if something is missing.
inline TagStream ReadTagStream(const std::filesystem::path& folder) {
  TagStream stream;
  std::map<std::string, int> camera_of_topic;
  std::ifstream yaml(folder / "cameras.yaml");
  for (std::string line; std::getline(yaml, line);) {
    char topic[200];
    if (line.rfind("cam", 0) == 0) {
      stream.cameras.emplace_back();
      stream.cameras.back().name = line.substr(0, line.find(':'));
      stream.cameras.back().distortion = Distortion::kEquidistant;
      continue;
    }
    if (stream.cameras.empty()) continue;
    Camera& c = stream.cameras.back();
    std::sscanf(line.c_str(), " intrinsics: [%lf, %lf, %lf, %lf]", &c.focal_x_px, &c.focal_y_px,
                &c.center_x_px, &c.center_y_px);
    std::sscanf(line.c_str(), " distortion_coeffs: [%lf, %lf, %lf, %lf]", &c.coefficients[0],
                &c.coefficients[1], &c.coefficients[2], &c.coefficients[3]);
    std::sscanf(line.c_str(), " resolution: [%d, %d]", &c.width_px, &c.height_px);
    if (std::sscanf(line.c_str(), " tagtopic: %199s", topic) == 1) {
      camera_of_topic[topic] = static_cast<int>(stream.cameras.size()) - 1;
    }
  }
  const std::string command = "gzip -dc '" + (folder / "tag_detections.csv.gz").string() + "'";
  const std::unique_ptr<FILE, int (*)(FILE*)> in(popen(command.c_str(), "r"), pclose);
  std::array<char, 500> line;
  while (in && std::fgets(line.data(), line.size(), in.get()) != nullptr) {
    TagView view;
    long long stamp = 0;
    char topic[200];
    Eigen::Matrix<double, 2, 4>& p = view.corners_px;
    if (std::sscanf(line.data(), "%199[^,],%lld,%d,%*[^,],%*d,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", topic, &stamp,
                    &view.tag, &p(0, 0), &p(1, 0), &p(0, 1), &p(1, 1), &p(0, 2), &p(1, 2), &p(0, 3),
                    &p(1, 3)) != 11) {
      continue;
    }
    view.stamp = stamp;
    view.camera = camera_of_topic.at(topic);
    stream.views.push_back(view);
  }
  return stream;
}

struct Spread {
  std::vector<double> values;
  double At(double fraction) const {
    if (values.empty()) return NAN;
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<size_t>(fraction * static_cast<double>(sorted.size() - 1))];
  }
};

struct MultiCameraReport {
  int stamps = 0;        // with at least one tag seen by two cameras or more
  int tags = 0;          // (stamp, tag) pairs triangulated
  int refused = 0;       // corners that could not be
  Spread residual_px;    // of a corner in a picture, length
  Spread side_error;     // a triangulated side less the stated one, m
  int pairs = 0;         // of tags, seen together at 20 stamps or more
  Spread distance_std;   // of the distance of a pair's centres over the stamps, m
  Spread distance_mean;  // m
};

// Triangulates every tag of `views` that two cameras or more see at once.
inline MultiCameraReport Report(const std::vector<Camera>& cameras, const std::vector<TagView>& views,
                                double border) {
  std::map<std::int64_t, std::map<int, std::vector<const TagView*>>> by_stamp;
  for (const TagView& view : views) by_stamp[view.stamp][view.tag].push_back(&view);
  MultiCameraReport report;
  std::map<std::pair<int, int>, std::vector<double>> distances;
  for (const auto& [stamp, tags] : by_stamp) {
    std::map<int, Eigen::Vector3d> centers;
    for (const auto& [tag, seen_by] : tags) {
      if (seen_by.size() < 2) continue;
      Eigen::Matrix<double, 3, 4> corners;
      std::vector<double> residuals;
      bool all = true;
      for (int i = 0; i < 4 && all; ++i) {
        std::vector<Sighting> sightings;
        for (const TagView* view : seen_by) sightings.push_back({view->camera, view->corners_px.col(i)});
        const auto point = Triangulate(cameras, sightings);
        all = point.has_value();
        if (!all) break;
        corners.col(i) = point->in_lab;
        for (const auto& r : point->residuals) residuals.push_back(r.norm());
      }
      if (!all) {
        ++report.refused;
        continue;
      }
      ++report.tags;
      report.residual_px.values.insert(report.residual_px.values.end(), residuals.begin(), residuals.end());
      for (int i = 0; i < 4; ++i) {
        report.side_error.values.push_back((corners.col((i + 1) % 4) - corners.col(i)).norm() - border);
      }
      centers[tag] = corners.rowwise().mean();
    }
    if (!centers.empty()) ++report.stamps;
    for (auto a = centers.begin(); a != centers.end(); ++a) {
      for (auto b = std::next(a); b != centers.end(); ++b) {
        distances[{a->first, b->first}].push_back((a->second - b->second).norm());
      }
    }
  }
  for (const auto& [pair, d] : distances) {
    if (d.size() < 20) continue;
    double mean = 0;
    for (const double x : d) mean += x / static_cast<double>(d.size());
    double sum2 = 0;
    for (const double x : d) sum2 += (x - mean) * (x - mean) / static_cast<double>(d.size() - 1);
    ++report.pairs;
    report.distance_std.values.push_back(std::sqrt(sum2));
    report.distance_mean.values.push_back(mean);
  }
  return report;
}

// A view with the velocity of its corners, from the same camera's pictures just before and after.
struct MovingView {
  TagView view;
  Eigen::Matrix<double, 2, 4> velocity;  // px/s
  double px_per_frame = 0;               // mean over the corners
};

inline std::vector<MovingView> Moving(const std::vector<TagView>& views) {
  std::map<std::tuple<int, int, std::int64_t>, const TagView*> at;
  std::set<std::int64_t> stamps;
  for (const TagView& view : views) {
    at[{view.camera, view.tag, view.stamp}] = &view;
    stamps.insert(view.stamp);
  }
  std::vector<MovingView> moving;
  for (const TagView& view : views) {
    const auto here = stamps.find(view.stamp);
    if (here == stamps.begin() || std::next(here) == stamps.end()) continue;
    const std::int64_t before = *std::prev(here);
    const std::int64_t after = *std::next(here);
    if (after - before > 80'000'000) continue;  // pictures are missing between
    const auto a = at.find({view.camera, view.tag, before});
    const auto b = at.find({view.camera, view.tag, after});
    if (a == at.end() || b == at.end()) continue;
    MovingView m{
        view, (b->second->corners_px - a->second->corners_px) / (1e-9 * static_cast<double>(after - before)),
        0};
    m.px_per_frame = m.velocity.colwise().norm().mean() * 0.5e-9 * static_cast<double>(after - before);
    moving.push_back(m);
  }
  return moving;
}

// The views whose corners move by less than `fastest` and at least `slowest` px from picture to picture.
inline std::vector<TagView> Between(const std::vector<MovingView>& moving, double slowest, double fastest) {
  std::vector<TagView> some;
  for (const MovingView& m : moving) {
    if (m.px_per_frame >= slowest && m.px_per_frame < fastest) some.push_back(m.view);
  }
  return some;
}

// Every second stamp, by rank: the rig is fitted to the even ones, the odd ones are new to it.
inline std::vector<TagView> Half(const std::vector<TagView>& views, int parity) {
  std::set<std::int64_t> stamps;
  for (const TagView& view : views) stamps.insert(view.stamp);
  std::map<std::int64_t, int> rank;
  for (const std::int64_t stamp : stamps) rank.emplace(stamp, static_cast<int>(rank.size()));
  std::vector<TagView> half;
  for (const TagView& view : views) {
    if (rank[view.stamp] % 2 == parity) half.push_back(view);
  }
  return half;
}

}  // namespace tendril::testing_support
