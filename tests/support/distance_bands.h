#pragma once
// Distances of tags that are fixed to each other, as cameras that are not triggered together triangulate
// them, against bands: what the bands are made of is estimated on some stamps and looked at on others
// (bench/distance_bands.cpp).

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "tests/support/multicamera.h"

namespace tendril::testing_support {

constexpr int kDrawnCameras = 100;
constexpr int kWindow = 50;  // stamps over which an offset is taken as constant

// Cameras as the calibration's own covariance says that they may be.
inline std::vector<std::vector<Camera>> DrawnCameras(const CameraCalibration& fit, int draws) {
  const BundleCovariance& sure = fit.covariance;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> split(sure.covariance);
  const Eigen::MatrixXd factor =
      split.eigenvectors() * split.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  std::vector<std::vector<Camera>> drawn;
  for (int d = 0; d < draws; ++d) {
    const Eigen::VectorXd step =
        factor * Eigen::VectorXd::NullaryExpr(factor.cols(), [&] { return normal(random); });
    drawn.push_back(fit.cameras);
    for (size_t c = 0; c < fit.cameras.size(); ++c) {
      Camera& camera = drawn.back()[c];
      const Eigen::Index at = sure.intrinsics_at[c];
      double* first[4] = {&camera.focal_x_px, &camera.focal_y_px, &camera.center_x_px, &camera.center_y_px};
      for (Eigen::Index i = 0; i < IntrinsicsOf(camera.distortion); ++i)
        (i < 4 ? *first[i] : camera.coefficients[static_cast<size_t>(i - 4)]) += step[at + i];
      if (sure.pose_at[c] < 0) continue;
      Eigen::Isometry3d lab_from_camera = camera.camera_from_lab.inverse();
      const Eigen::Vector3d turn = step.segment<3>(sure.pose_at[c] + 3);
      lab_from_camera.translation() += step.segment<3>(sure.pose_at[c]);
      lab_from_camera.linear() =
          Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * lab_from_camera.linear();
      camera.camera_from_lab = lab_from_camera.inverse();
    }
  }
  return drawn;
}

using CameraPair = std::pair<int, int>;

// Error of a tag's centre in a picture, by where it comes from.
struct BandModel {
  double center_px = 0;                  // of each view for itself
  std::map<CameraPair, double> pair_px;  // what is beyond that and the cameras' covariance, by pair
  struct Offset {
    double seconds = 0;  // by which the second camera's pictures would have to be later
    double sigma = 0;    // s
  };
  std::map<std::pair<CameraPair, int>, Offset> offset;  // by pair and window
  Offset elsewhere;                                     // where no window tells
  double factor = 1;                                    // on every sigma of a distance
  struct Residual {
    double speed = 0;  // mean of both views, px per picture
    double rim = 0;    // of the view further out: from the picture's centre, px
    double px = 0;     // once the offset is taken out
  };
  std::vector<Residual> residuals;  // that it was estimated from
  Offset OffsetOf(CameraPair pair, int rank) const {
    const auto found = offset.find({pair, rank / kWindow});
    return found == offset.end() ? elsewhere : found->second;
  }
};

// A tag at a moment as two cameras or more see it, rising by camera.
struct SeenTag {
  int tag = 0;
  int rank = 0;  // of the stamp
  std::vector<const MovingTag*> by;
  double Speed() const {  // px per picture
    double sum = 0;
    for (const MovingTag* m : by) sum += m->px_per_picture / static_cast<double>(by.size());
    return sum;
  }
};

// Those of the stamps whose rank has this parity; they point into `moving`.
inline std::vector<SeenTag> SeenTags(const std::vector<MovingTag>& moving,
                                     const std::map<std::int64_t, int>& rank, int parity) {
  std::map<std::pair<int, int>, std::vector<const MovingTag*>> together;
  for (const MovingTag& m : moving) {
    const int at = rank.at(m.seen.stamp);
    if (at % 2 == parity) together[{at, m.seen.tag}].push_back(&m);
  }
  std::vector<SeenTag> seen;
  for (auto& [key, by] : together) {
    if (by.size() < 2) continue;
    std::sort(by.begin(), by.end(), [](auto* a, auto* b) { return a->seen.camera < b->seen.camera; });
    seen.push_back({.tag = key.second, .rank = key.first, .by = by});
  }
  return seen;
}

// Centres in the pictures, those of the second camera and on moved to the first one's moment.
//   later  sigmas of the offset to add
inline std::vector<Sighting> CentersAtOnce(const SeenTag& tag, const BandModel& model, double later = 0) {
  std::vector<Sighting> seen;
  for (const MovingTag* m : tag.by) {
    Eigen::Vector2d at = m->seen.corners_px.rowwise().mean();
    if (m != tag.by.front()) {
      const auto offset = model.OffsetOf({tag.by.front()->seen.camera, m->seen.camera}, tag.rank);
      at += 1e9 * (offset.seconds + later * offset.sigma) * m->velocity.rowwise().mean();
    }
    seen.push_back({m->seen.camera, at});
  }
  return seen;
}

// Tags moved along their velocity to the moment of the first camera that their window's offsets link them to.
// Those of cameras that nothing links are left out.
inline std::vector<TagInPicture> OnOneClock(const std::vector<MovingTag>& moving,
                                            const std::map<std::int64_t, int>& rank, const BandModel& model,
                                            int cameras) {
  std::map<int, std::vector<std::optional<double>>> clocks;  // by window: what to add, s
  for (const MovingTag& m : moving) clocks[rank.at(m.seen.stamp) / kWindow];
  for (auto& [window, add] : clocks) {
    add.resize(static_cast<std::size_t>(cameras));
    for (const auto& [key, offset] : model.offset) {
      const auto [first, second] = key.first;
      auto& of_first = add[static_cast<std::size_t>(first)];
      auto& of_second = add[static_cast<std::size_t>(second)];
      if (key.second != window) continue;
      const bool none = std::none_of(add.begin(), add.end(), [](const auto& a) { return a.has_value(); });
      if (none) of_first = 0;  // pairs come in rising order
      if (of_first && !of_second) of_second = *of_first + offset.seconds;
      if (of_second && !of_first) of_first = *of_second - offset.seconds;
    }
  }
  std::vector<TagInPicture> moved;
  for (const MovingTag& m : moving) {
    const auto& add = clocks[rank.at(m.seen.stamp) / kWindow][static_cast<std::size_t>(m.seen.camera)];
    if (!add) continue;
    moved.push_back(m.seen);
    moved.back().corners_px += 1e9 * *add * m.velocity;
  }
  return moved;
}

inline Eigen::Vector4d ResidualOf(const TriangulatedPoint& point) {
  return (Eigen::Vector4d() << point.residuals[0], point.residuals[1]).finished();
}

// From residuals of what exactly two cameras see: one number each, across the epipolar line. Offsets by least
// squares per pair and window, from what moves; what the residuals then have beyond the centres' own error
// and the cameras' covariance is the pair's. Nothing here looks at distances.
inline BandModel EstimateBands(const CameraCalibration& fit, const std::vector<SeenTag>& seen,
                               double center_px) {
  BandModel model{
      .center_px = center_px, .pair_px = {}, .offset = {}, .elsewhere = {0, 0.015}, .residuals = {}};
  struct Row {
    CameraPair pair;
    int window;
    Eigen::Vector4d residual, per_second;
    double camera_variance;
    BandModel::Residual kept;
  };
  const auto drawn = DrawnCameras(fit, kDrawnCameras);
  std::vector<Row> rows;
  for (const SeenTag& tag : seen) {
    if (tag.by.size() != 2) continue;
    auto views = CentersAtOnce(tag, {});
    const auto point = Triangulate(fit.cameras, views);
    if (!point) continue;
    double camera_variance = 0;
    for (const auto& cameras : drawn) {
      const auto other = Triangulate(cameras, views);
      if (other) camera_variance += (ResidualOf(*other) - ResidualOf(*point)).squaredNorm() / kDrawnCameras;
    }
    constexpr double kStep = 1e-3;  // s
    views[1].pixel += 1e9 * kStep * tag.by[1]->velocity.rowwise().mean();
    const auto later = Triangulate(fit.cameras, views);
    if (!later) continue;
    double rim = 0;
    for (std::size_t v = 0; v < 2; ++v) {
      const Camera& camera = fit.cameras[static_cast<std::size_t>(views[v].camera)];
      rim = std::max(rim, (tag.by[v]->seen.corners_px.rowwise().mean() -
                           Eigen::Vector2d(camera.center_x_px, camera.center_y_px))
                              .norm());
    }
    rows.push_back({.pair = {views[0].camera, views[1].camera},
                    .window = tag.rank / kWindow,
                    .residual = ResidualOf(*point),
                    .per_second = (ResidualOf(*later) - ResidualOf(*point)) / kStep,
                    .camera_variance = camera_variance,
                    .kept = {.speed = tag.Speed(), .rim = rim}});
  }
  std::map<std::pair<CameraPair, int>, std::vector<const Row*>> windows;
  for (const Row& row : rows) windows[{row.pair, row.window}].push_back(&row);
  std::map<CameraPair, std::pair<double, int>> left;
  for (const auto& [key, in] : windows) {
    if (in.size() < 10) continue;
    double squares = 0;
    double products = 0;
    for (const Row* row : in) {
      squares += row->per_second.squaredNorm();
      products -= row->per_second.dot(row->residual);
    }
    const double seconds = products / squares;
    double sum2 = 0;
    for (const Row* row : in) {
      const double left_over = (row->residual + seconds * row->per_second).squaredNorm();
      sum2 += left_over;
      model.residuals.push_back(row->kept);
      model.residuals.back().px = std::sqrt(left_over);
      left[key.first].first += left_over - row->camera_variance - center_px * center_px;
      ++left[key.first].second;
    }
    // Residuals of one window are not independent: as if there were one for each tag and five stamps.
    const double variance = sum2 / static_cast<double>(in.size()) / squares;
    model.offset[key] = {seconds, std::sqrt(5 * variance)};
  }
  for (const auto& [pair, sum] : left) model.pair_px[pair] = std::sqrt(std::max(0.0, sum.first / sum.second));
  return model;
}

struct BandedDistance {
  std::pair<int, int> tags;
  double metres = 0;
  double sigma = 0;  // stated, m
  double speed = 0;  // of the faster tag, px per picture
};

inline std::vector<BandedDistance> BandedDistances(const CameraCalibration& fit,
                                                   const std::vector<SeenTag>& seen, const BandModel& model) {
  const auto drawn = DrawnCameras(fit, kDrawnCameras);
  struct Center {
    const SeenTag* tag;
    TriangulatedPoint point;
    Eigen::Vector3d later;               // with offsets larger by their sigma
    std::vector<Eigen::Vector3d> drawn;  // with the drawn cameras
  };
  std::map<int, std::vector<Center>> moments;
  for (const SeenTag& tag : seen) {
    const auto views = CentersAtOnce(tag, model);
    double variance = 0;
    for (std::size_t v = 1; v < views.size(); ++v) {
      const auto pair = model.pair_px.find({views[0].camera, views[v].camera});
      const double own = pair == model.pair_px.end() ? 0 : pair->second;
      variance += (model.center_px * model.center_px + own * own) / static_cast<double>(views.size() - 1);
    }
    const auto point = Triangulate(fit.cameras, views, std::sqrt(variance));
    const auto later = Triangulate(fit.cameras, CentersAtOnce(tag, model, 1));
    if (!point || !later) continue;
    Center center{&tag, *point, later->in_lab, {}};
    for (const auto& cameras : drawn) {
      const auto other = Triangulate(cameras, views);
      center.drawn.push_back(other ? other->in_lab : point->in_lab);
    }
    moments[tag.rank].push_back(std::move(center));
  }
  std::vector<BandedDistance> distances;
  for (const auto& [rank, centers] : moments) {
    for (std::size_t a = 0; a < centers.size(); ++a) {
      for (std::size_t b = a + 1; b < centers.size(); ++b) {
        const Center& p = centers[a];
        const Center& q = centers[b];
        const double metres = (p.point.in_lab - q.point.in_lab).norm();
        const Eigen::Vector3d along = (p.point.in_lab - q.point.in_lab) / metres;
        double variance = along.dot((p.point.covariance + q.point.covariance) * along);
        // Pictures of both tags are late by the same.
        variance += std::pow((p.later - q.later).norm() - metres, 2);
        for (std::size_t d = 0; d < drawn.size(); ++d) {
          variance += std::pow((p.drawn[d] - q.drawn[d]).norm() - metres, 2) / kDrawnCameras;
        }
        distances.push_back({.tags = {p.tag->tag, q.tag->tag},
                             .metres = metres,
                             .sigma = model.factor * std::sqrt(variance),
                             .speed = std::max(p.tag->Speed(), q.tag->Speed())});
      }
    }
  }
  return distances;
}

struct BandShares {
  int pairs = 0;  // with five distances or more
  int distances = 0;
  int in68 = 0;  // about their pair's weighted mean
  int in95 = 0;
  double median_sigma = 0;  // stated, m
  double scatter = 0;       // root mean square about the mean, m
  double z2 = 0;            // mean square of what is off the mean, by its sigma
};

inline BandShares SharesInside(const std::vector<BandedDistance>& all, double slowest, double fastest) {
  std::map<std::pair<int, int>, std::vector<const BandedDistance*>> pairs;
  for (const BandedDistance& d : all) {
    if (d.speed >= slowest && d.speed < fastest) pairs[d.tags].push_back(&d);
  }
  BandShares shares;
  Spread sigma;
  for (const auto& [tags, of] : pairs) {
    if (of.size() < 5) continue;
    double weights = 0;
    double mean = 0;
    for (const BandedDistance* d : of) weights += 1 / (d->sigma * d->sigma);
    for (const BandedDistance* d : of) mean += d->metres / (d->sigma * d->sigma) / weights;
    ++shares.pairs;
    for (const BandedDistance* d : of) {
      const double off = d->metres - mean;
      const double z = std::abs(off) / std::sqrt(d->sigma * d->sigma - 1 / weights);
      ++shares.distances;
      shares.in68 += z < 0.99446 ? 1 : 0;
      shares.in95 += z < 1.95996 ? 1 : 0;
      shares.scatter += off * off;
      shares.z2 += z * z;
      sigma.values.push_back(d->sigma);
    }
  }
  const int count = std::max(1, shares.distances);
  shares.median_sigma = sigma.At(0.5);
  shares.scatter = std::sqrt(shares.scatter / count);
  shares.z2 /= count;
  return shares;
}

}  // namespace tendril::testing_support
