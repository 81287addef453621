#pragma once
// A recorded stream of tag corners from several real cameras (tagslam_test's format, SOURCE.txt), and how
// well its tags triangulate. Shared by a test and by bench/multicamera_report.cpp.

#include <Eigen/Geometry>
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
#include <vector>

#include "calibrate/cameras/calibrate_from_tags.h"
#include "capture/track/triangulate.h"

namespace tendril::testing_support {

struct TagStream {
  std::vector<Camera> cameras;      // intrinsics; poses are not known
  std::vector<TagInPicture> views;  // stamp: ns
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
    TagInPicture view;
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
inline MultiCameraReport Report(const std::vector<Camera>& cameras, const std::vector<TagInPicture>& views,
                                double border) {
  std::map<std::int64_t, std::map<int, std::vector<const TagInPicture*>>> by_stamp;
  for (const TagInPicture& view : views) by_stamp[view.stamp][view.tag].push_back(&view);
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
        for (const TagInPicture* view : seen_by) sightings.push_back({view->camera, view->corners_px.col(i)});
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

// The views whose corners move by less than `fastest` and at least `slowest` px from picture to picture.
inline std::vector<TagInPicture> Between(const std::vector<MovingTag>& moving, double slowest,
                                         double fastest) {
  std::vector<TagInPicture> some;
  for (const MovingTag& m : moving) {
    if (m.px_per_picture >= slowest && m.px_per_picture < fastest) some.push_back(m.seen);
  }
  return some;
}

// Every second stamp, by rank: the rig is fitted to the even ones, the odd ones are new to it.
inline std::vector<TagInPicture> Half(const std::vector<TagInPicture>& views, int parity) {
  std::set<std::int64_t> stamps;
  for (const TagInPicture& view : views) stamps.insert(view.stamp);
  std::map<std::int64_t, int> rank;
  for (const std::int64_t stamp : stamps) rank.emplace(stamp, static_cast<int>(rank.size()));
  std::vector<TagInPicture> half;
  for (const TagInPicture& view : views) {
    if (rank[view.stamp] % 2 == parity) half.push_back(view);
  }
  return half;
}

// How far two answers about one camera are apart.
struct PoseOff {
  double metres = 0;
  double degrees = 0;
};
inline PoseOff PoseDifference(const Camera& a, const Camera& b) {
  const Eigen::Isometry3d lab_from_a = a.camera_from_lab.inverse();
  const Eigen::Isometry3d lab_from_b = b.camera_from_lab.inverse();
  return {(lab_from_a.translation() - lab_from_b.translation()).norm(),
          Eigen::AngleAxisd(lab_from_a.linear().transpose() * lab_from_b.linear()).angle() * 180 / M_PI};
}

// Centres of a sheet's tags 0 .. 34, five to a row, against the regular grid that fits them best.
struct GridOff {
  double pitch = 0;         // m
  double in_plane_rms = 0;  // of a centre, in x and y, m
  double off_plane_rms = 0;
};
inline GridOff CompareWithGrid(const TagBody& body) {
  const auto n = static_cast<Eigen::Index>(body.tags.size());
  Eigen::Matrix3Xd seen(3, n);
  Eigen::Matrix3Xd grid(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const int tag = body.tags[static_cast<size_t>(i)];
    seen.col(i) = body.points.middleCols<4>(4 * i).rowwise().mean();
    grid.col(i) = Eigen::Vector3d(tag % 5, -(tag / 5), 0);
  }
  const Eigen::Matrix4d fit = Eigen::umeyama(grid, seen, true);
  GridOff off;
  off.pitch = std::cbrt(fit.topLeftCorner<3, 3>().determinant());
  const Eigen::Matrix3Xd left =
      fit.topLeftCorner<3, 3>().transpose() / off.pitch *
      (seen - ((fit.topLeftCorner<3, 3>() * grid).colwise() + fit.topRightCorner<3, 1>()));
  off.in_plane_rms = std::sqrt(left.topRows<2>().squaredNorm() / static_cast<double>(n));
  off.off_plane_rms = std::sqrt(left.row(2).squaredNorm() / static_cast<double>(n));
  return off;
}

}  // namespace tendril::testing_support
