#include "calibrate/fold/shape_residual.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace tendril {
namespace {

constexpr int kFewestInWindow = 4;  // three nodes have a shape too, but one outlier spoils it

struct Span {
  Eigen::Index first = 0;  // into the seen nodes
  Eigen::Index count = 0;
};

// Windows of node numbers [start, start + window), each as the run of seen nodes inside it.
std::vector<Span> Windows(const SeenNodes& seen, int nodes, int window) {
  std::vector<Span> spans;
  const int width = std::min(window, nodes);
  const int stride = std::max(1, width / 2);
  const int* begin = seen.index.data();
  const int* end = begin + seen.index.size();
  for (int start = 0; start < nodes; start += stride) {
    const int from = std::min(start, nodes - width);
    const int* low = std::lower_bound(begin, end, from);
    const int* high = std::lower_bound(begin, end, from + width);
    if (high - low >= kFewestInWindow) spans.push_back({low - begin, high - low});
    if (from + width >= nodes) break;
  }
  return spans;
}

struct Pose {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d model_center;
  Eigen::Vector3d seen_center;
};

// Weighted best rigid motion of model onto seen (Kabsch); proper rotations only.
Pose Align(const Eigen::Matrix3Xd& model, const Eigen::Matrix3Xd& seen, const Eigen::VectorXd& weight) {
  const double sum = weight.sum();
  Pose pose;
  pose.model_center = model * weight / sum;
  pose.seen_center = seen * weight / sum;
  const Eigen::Matrix3d cross = (model.colwise() - pose.model_center) * weight.asDiagonal() *
                                (seen.colwise() - pose.seen_center).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1, 1, (svd.matrixV() * svd.matrixU().transpose()).determinant() < 0 ? -1 : 1);
  pose.rotation = svd.matrixV() * sign.asDiagonal() * svd.matrixU().transpose();
  return pose;
}

Eigen::VectorXd InverseSigma(const SeenNodes& seen, double model_error) {
  return (seen.sigma.array().square() + model_error * model_error).sqrt().inverse().matrix();
}

ShapeResidual WindowResidual(const NodeMotion& model, const SeenNodes& seen,
                             const ShapeResidualOptions& options) {
  const std::vector<Span> windows = Windows(seen, static_cast<int>(model.nodes.cols()), options.window);
  Eigen::Index rows = 0;
  for (const Span& span : windows) rows += 3 * span.count;
  ShapeResidual residual;
  residual.group = 3;
  residual.value.resize(rows);
  residual.sigma.resize(rows);
  residual.slope.setZero(rows, kShapeDirections);
  const Eigen::VectorXd inverse = InverseSigma(seen, options.model_error);

  Eigen::Index row = 0;
  for (const Span& span : windows) {
    const Eigen::Index n = span.count;
    const Eigen::VectorXd scale = inverse.segment(span.first, n);
    Eigen::Matrix3Xd nodes(3, n);
    for (Eigen::Index i = 0; i < n; ++i) nodes.col(i) = model.nodes.col(seen.index[span.first + i]);
    const Eigen::Matrix3Xd points = seen.points.middleCols(span.first, n);
    const Pose pose = Align(nodes, points, scale.array().square().matrix());
    const Eigen::Matrix3Xd turned = pose.rotation * (nodes.colwise() - pose.model_center);

    // What a small rigid motion does to the rows: the shape's slopes are taken orthogonal to it.
    Eigen::Matrix<double, Eigen::Dynamic, 6> rigid(3 * n, 6);
    Eigen::Matrix<double, Eigen::Dynamic, kFoldDirections> slope(3 * n, static_cast<int>(kFoldDirections));
    const double length = std::max(turned.norm() / std::sqrt(static_cast<double>(n)), 1e-300);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Vector3d at = turned.col(i) / length;
      Eigen::Matrix3d cross;
      cross << 0, at.z(), -at.y(), -at.z(), 0, at.x(), at.y(), -at.x(), 0;
      rigid.block<3, 3>(3 * i, 0) = scale[i] * Eigen::Matrix3d::Identity();
      rigid.block<3, 3>(3 * i, 3) = scale[i] * cross;
      residual.value.segment<3>(row + 3 * i) =
          scale[i] * (turned.col(i) - (points.col(i) - pose.seen_center));
      residual.sigma.segment<3>(row + 3 * i).setConstant(1 / scale[i]);
      for (std::size_t k = 0; k < kFoldDirections; ++k) {
        slope.block<3, 1>(3 * i, static_cast<Eigen::Index>(k)) =
            scale[i] * (pose.rotation * model.velocity[k].col(seen.index[span.first + i]));
      }
    }
    // A straight window leaves the turn about itself free: the rank says so.
    Eigen::ColPivHouseholderQR<Eigen::Matrix<double, Eigen::Dynamic, 6>> qr;
    qr.setThreshold(1e-10);
    qr.compute(rigid);
    Eigen::MatrixXd turned_slope = qr.householderQ().transpose() * slope;
    turned_slope.topRows(qr.rank()).setZero();
    turned_slope.applyOnTheLeft(qr.householderQ());
    residual.slope.block(row, 0, 3 * n, kFoldDirections) = turned_slope;
    row += 3 * n;
  }
  return residual;
}

ShapeResidual DistanceResidual(const NodeMotion& model, const SeenNodes& seen,
                               const ShapeResidualOptions& options, const Scatter& scatter) {
  const std::vector<NodePair> pairs = PairsOf(seen, options.creases);
  ShapeResidual residual;
  residual.group = 1;
  residual.value.resize(static_cast<Eigen::Index>(pairs.size()));
  residual.sigma.resize(residual.value.size());
  residual.slope.setZero(static_cast<Eigen::Index>(pairs.size()), kShapeDirections);
  const double error2 = options.model_error * options.model_error;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const NodePair& pair = pairs[p];
    const Eigen::Index row = static_cast<Eigen::Index>(p);
    const int a = seen.index[pair.a];
    const int b = seen.index[pair.b];
    const double sigma2 =
        seen.sigma[pair.a] * seen.sigma[pair.a] + seen.sigma[pair.b] * seen.sigma[pair.b] + 2 * error2;
    const double sigma = std::sqrt(sigma2);
    residual.sigma[row] = sigma;
    const Eigen::Vector3d chord = model.nodes.col(b) - model.nodes.col(a);
    const double folded = model.folded.segment(a, b - a).mean();
    const double square = chord.squaredNorm() + scatter.flat * sigma2 + scatter.folded * folded * error2;
    // Negative scatter never takes more of a distance than leaves a tenth of the model error.
    const double least = 0.01 * error2;
    const double length = std::sqrt(std::max(square, least));
    residual.value[row] = (length - (seen.points.col(pair.b) - seen.points.col(pair.a)).norm()) / sigma;
    if (square <= least) continue;
    const double factor = 1 / (length * sigma);
    for (int k = 0; k < kFoldDirections; ++k) {
      const Eigen::Matrix3Xd& velocity = model.velocity[static_cast<std::size_t>(k)];
      const double folded_slope = model.folded_slope.col(k).segment(a, b - a).mean();
      residual.slope(row, k) = factor * (chord.dot(velocity.col(b) - velocity.col(a)) +
                                         0.5 * error2 * scatter.folded * folded_slope);
    }
    residual.slope(row, kFoldDirections) = 0.5 * factor * sigma2;
    residual.slope(row, kFoldDirections + 1) = 0.5 * factor * error2 * folded;
  }
  return residual;
}

}  // namespace

std::vector<NodePair> PairsOf(const SeenNodes& seen, int creases) {
  std::vector<NodePair> pairs;
  for (Eigen::Index a = 0; a < seen.index.size(); ++a) {
    for (Eigen::Index b = a + 1; b < seen.index.size() && seen.index[b] - seen.index[a] <= creases; ++b) {
      pairs.push_back({a, b});
    }
  }
  return pairs;
}

int ResidualRows(const SeenNodes& seen, int nodes, const ShapeResidualOptions& options) {
  if (options.kind == ShapeResidualKind::kLocalDistances)
    return static_cast<int>(PairsOf(seen, options.creases).size());
  Eigen::Index rows = 0;
  for (const Span& span : Windows(seen, nodes, options.window)) rows += 3 * span.count;
  return static_cast<int>(rows);
}

ShapeResidual ResidualOf(const NodeMotion& model, const SeenNodes& seen, const ShapeResidualOptions& options,
                         const Scatter& scatter) {
  return options.kind == ShapeResidualKind::kLocalDistances ? DistanceResidual(model, seen, options, scatter)
                                                            : WindowResidual(model, seen, options);
}

double AlignedRms(const Eigen::Ref<const Eigen::Matrix3Xd>& model_nodes, const SeenNodes& seen) {
  const Eigen::Index n = seen.index.size();
  if (n == 0) return 0;
  Eigen::Matrix3Xd nodes(3, n);
  for (Eigen::Index i = 0; i < n; ++i) nodes.col(i) = model_nodes.col(seen.index[i]);
  const Pose pose = Align(nodes, seen.points, Eigen::VectorXd::Ones(n));
  const Eigen::Matrix3Xd off =
      pose.rotation * (nodes.colwise() - pose.model_center) - (seen.points.colwise() - pose.seen_center);
  return off.norm() / std::sqrt(static_cast<double>(n));
}

}  // namespace tendril
