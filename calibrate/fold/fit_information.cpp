#include "calibrate/fold/fit_information.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

namespace tendril {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Sums over the frames that share a nuisance, or over a single frame that has none.
struct Block {
  SharedMatrix information = SharedMatrix::Zero();
  SharedVector score = SharedVector::Zero();
  SharedVector mixed = SharedVector::Zero();
  double nuisance_information = 0;
  double nuisance_score = 0;
  int trial = 0;
};

std::vector<int> Free(const HeldParameters& held) {
  std::vector<int> free;
  for (int i = 0; i < kShared; ++i) {
    if (!held[static_cast<std::size_t>(i)]) free.push_back(i);
  }
  return free;
}

// Inverse of the free part, NaN elsewhere; all NaN if that part is singular.
SharedMatrix InverseOfFree(const SharedMatrix& matrix, const std::vector<int>& free) {
  SharedMatrix inverse = SharedMatrix::Constant(kNaN);
  const Eigen::Index n = static_cast<Eigen::Index>(free.size());
  if (n == 0) return inverse;
  // Scaled to a unit diagonal, so that the parameters' units do not decide what is singular.
  Eigen::VectorXd scale(n);
  Eigen::MatrixXd part(n, n);
  for (Eigen::Index a = 0; a < n; ++a) {
    const double diagonal = matrix(free[static_cast<std::size_t>(a)], free[static_cast<std::size_t>(a)]);
    if (!(diagonal > 0)) return inverse;
    scale[a] = 1 / std::sqrt(diagonal);
  }
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b < n; ++b) {
      part(a, b) =
          scale[a] * scale[b] * matrix(free[static_cast<std::size_t>(a)], free[static_cast<std::size_t>(b)]);
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(part);
  if (!(eigen.eigenvalues().minCoeff() > 1e-12)) return inverse;
  const Eigen::MatrixXd& turned = eigen.eigenvectors();
  const Eigen::MatrixXd inverted =
      turned * eigen.eigenvalues().cwiseInverse().asDiagonal() * turned.transpose();
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b < n; ++b) {
      inverse(free[static_cast<std::size_t>(a)], free[static_cast<std::size_t>(b)]) =
          scale[a] * scale[b] * inverted(a, b);
    }
  }
  return inverse;
}

}  // namespace

const std::array<double, kShared>& LargestStandardErrors() {
  static constexpr std::array<double, kShared> kLargest = {0.1, 0.5, 0.5, 0.17, 0.25, 1, 3};
  return kLargest;
}

Information InformationAt(const FitFrames& frames, const SharedVector& parameters,
                          const std::vector<double>& nuisances, const ShapeResidualOptions& options,
                          double huber) {
  Information information;
  information.trials.resize(frames.trials.size());
  std::vector<Block> shared(nuisances.size());
  const auto add = [&](const Block& block) {
    TrialInformation& trial = information.trials[static_cast<std::size_t>(block.trial)];
    trial.information += block.information;
    trial.score += block.score;
    if (block.nuisance_information > 0) {
      trial.information -= block.mixed * block.mixed.transpose() / block.nuisance_information;
      trial.score -= block.mixed * (block.nuisance_score / block.nuisance_information);
    }
  };
  double squares = 0;
  double rows = 0;
  double nodes = 0;
  for (const FitFrame& frame : frames.frames) {
    const std::optional<FrameResidual> residual =
        EvaluateFrame(frame, parameters, NuisanceOf(frame, nuisances), options);
    if (!residual) continue;
    Block alone;
    Block& block = frame.nuisance < 0 ? alone : shared[static_cast<std::size_t>(frame.nuisance)];
    block.trial = frame.trial;
    for (Eigen::Index row = 0; row < residual->value.size(); row += residual->group) {
      const Eigen::Index n = residual->group;
      const Eigen::VectorXd r = residual->value.segment(row, n);
      const Eigen::MatrixXd slope = residual->slope.middleRows(row, n);
      const Eigen::VectorXd nuisance_slope = residual->nuisance_slope.segment(row, n);
      const double length = r.norm();
      const bool far = length > huber;
      const Eigen::VectorXd psi = far ? Eigen::VectorXd(r * (huber / length)) : r;
      Eigen::MatrixXd curvature = Eigen::MatrixXd::Identity(n, n);
      if (far) curvature = (huber / length) * (curvature - r * r.transpose() / (length * length));
      block.information += slope.transpose() * curvature * slope;
      block.score += slope.transpose() * psi;
      block.mixed += slope.transpose() * curvature * nuisance_slope;
      block.nuisance_information += nuisance_slope.dot(curvature * nuisance_slope);
      block.nuisance_score += nuisance_slope.dot(psi);
      squares += psi.squaredNorm();
    }
    rows += static_cast<double>(residual->value.size());
    nodes += static_cast<double>(frame.seen.index.size()) * residual->group;
    if (frame.nuisance < 0) add(alone);
  }
  for (const Block& block : shared) add(block);
  for (const TrialInformation& trial : information.trials) information.total += trial.information;
  if (rows > 0) {
    information.row_variance = squares / rows;
    information.repeats = std::max(1.0, rows / nodes);
  }
  return information;
}

SharedMatrix NaiveCovariance(const Information& information, double row_variance,
                             const HeldParameters& held) {
  return row_variance * information.repeats * InverseOfFree(information.total, Free(held));
}

SharedVector ChangeWithout(const Information& information, std::size_t trial, const HeldParameters& held,
                           const SharedVector& mean_score) {
  const std::vector<int> free = Free(held);
  const TrialInformation& one = information.trials[trial];
  const SharedMatrix inverse = InverseOfFree(information.total - one.information, free);
  SharedVector change = SharedVector::Zero();
  for (const int a : free) {
    for (const int b : free) change[a] += inverse(a, b) * (one.score[b] - mean_score[b]);
  }
  return change;
}

SharedMatrix ClusteredCovariance(const Information& information, const HeldParameters& held,
                                 const HeldParameters& at_bound) {
  const std::vector<int> free = Free(held);
  SharedMatrix covariance = SharedMatrix::Constant(kNaN);
  double contributing = 0;
  SharedVector mean = SharedVector::Zero();
  for (const TrialInformation& trial : information.trials) {
    contributing += trial.information.trace() > 0 ? 1 : 0;
    mean += trial.score;
  }
  if (contributing < 2) return covariance;
  mean /= contributing;
  for (int i = 0; i < kShared; ++i) {
    if (!at_bound[static_cast<std::size_t>(i)]) mean[i] = 0;
  }
  for (const int a : free) {
    for (const int b : free) covariance(a, b) = 0;
  }
  for (std::size_t g = 0; g < information.trials.size(); ++g) {
    if (!(information.trials[g].information.trace() > 0)) continue;
    const SharedVector change = ChangeWithout(information, g, held, mean);
    for (const int a : free) {
      for (const int b : free) covariance(a, b) += (contributing - 1) / contributing * change[a] * change[b];
    }
  }
  return covariance;
}

std::vector<Unidentified> FindUnidentified(const Information& information, double row_variance,
                                           HeldParameters held) {
  std::vector<Unidentified> found;
  const SharedVector largest(LargestStandardErrors().data());
  const double noise = row_variance * information.repeats;
  for (std::vector<int> free = Free(held); !free.empty(); free = Free(held)) {
    const Eigen::Index n = static_cast<Eigen::Index>(free.size());
    Eigen::MatrixXd part(n, n);
    for (Eigen::Index a = 0; a < n; ++a) {
      for (Eigen::Index b = 0; b < n; ++b) {
        const int i = free[static_cast<std::size_t>(a)];
        const int j = free[static_cast<std::size_t>(b)];
        part(a, b) = information.total(i, j) * largest[i] * largest[j];
      }
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(part);
    const double weakest = eigen.eigenvalues()[0];
    if (weakest > noise && weakest > 1e-12 * eigen.eigenvalues()[n - 1]) break;
    Eigen::VectorXd share = eigen.eigenvectors().col(0).cwiseAbs();
    Eigen::Index worst = 0;
    share.maxCoeff(&worst);
    Unidentified one;
    one.parameter = free[static_cast<std::size_t>(worst)];
    one.standard_error = weakest > 0 ? largest[one.parameter] * std::sqrt(noise / weakest)
                                     : std::numeric_limits<double>::infinity();
    share[worst] = 0;
    Eigen::Index second = 0;
    if (n > 1 && share.maxCoeff(&second) > 0.3) one.twin = free[static_cast<std::size_t>(second)];
    held[static_cast<std::size_t>(one.parameter)] = true;
    found.push_back(one);
  }
  return found;
}

}  // namespace tendril
