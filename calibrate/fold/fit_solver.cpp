#include "calibrate/fold/fit_solver.h"

#include <ceres/ceres.h>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <numbers>
#include <optional>

namespace tendril {
namespace {

constexpr double kLargestFriction = 3;

// One frame. A group of residuals longer than `huber` counts linearly: it is shortened so that half its
// square is Huber's loss, which keeps the problem a plain least-squares one.
class FrameCost final : public ceres::CostFunction {
 public:
  FrameCost(const FitFrame& frame, const ShapeResidualOptions& options, double huber)
      : frame_(frame), options_(options), huber_(huber) {
    set_num_residuals(ResidualRows(frame.seen, frame.observed->design.holes, options));
    mutable_parameter_block_sizes()->push_back(kShared);
    if (frame.nuisance >= 0) mutable_parameter_block_sizes()->push_back(1);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const double nuisance = frame_.nuisance >= 0 ? parameters[1][0] : 0;
    std::optional<FrameResidual> at = EvaluateFrame(frame_, SharedVector(parameters[0]), nuisance, options_);
    if (!at) return false;
    for (Eigen::Index row = 0; row < at->value.size(); row += at->group) {
      const double length = at->value.segment(row, at->group).norm();
      if (length <= huber_) continue;
      const double root = std::sqrt(huber_ * (2 * length - huber_));
      const double factor = root / length;
      const double factor_slope = huber_ / (root * length) - root / (length * length);
      const Eigen::VectorXd r = at->value.segment(row, at->group);
      const Eigen::MatrixXd change = factor * Eigen::MatrixXd::Identity(at->group, at->group) +
                                     (factor_slope / length) * r * r.transpose();
      const Eigen::MatrixXd slope = change * at->slope.middleRows(row, at->group);
      const Eigen::VectorXd nuisance_slope = change * at->nuisance_slope.segment(row, at->group);
      at->slope.middleRows(row, at->group) = slope;
      at->nuisance_slope.segment(row, at->group) = nuisance_slope;
      at->value.segment(row, at->group) = factor * r;
    }
    Eigen::Map<Eigen::VectorXd>(residuals, at->value.size()) = at->value;
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, kShared, Eigen::RowMajor>>(
          jacobians[0], at->value.size(), kShared) = at->slope;
    }
    if (frame_.nuisance >= 0 && jacobians[1] != nullptr) {
      Eigen::Map<Eigen::VectorXd>(jacobians[1], at->value.size()) = at->nuisance_slope;
    }
    return true;
  }

 private:
  const FitFrame& frame_;
  const ShapeResidualOptions& options_;
  double huber_;
};

class AskToGoOn final : public ceres::IterationCallback {
 public:
  AskToGoOn(const Progress& progress, double from, double to, int most)
      : progress_(progress), from_(from), to_(to), most_(most) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (!progress_) return ceres::SOLVER_CONTINUE;
    const double share = std::min(1.0, static_cast<double>(summary.iteration) / most_);
    return progress_(from_ + (to_ - from_) * share) ? ceres::SOLVER_CONTINUE : ceres::SOLVER_ABORT;
  }

 private:
  const Progress& progress_;
  double from_;
  double to_;
  int most_;
};

}  // namespace

Status SolveFit(const FitFrames& frames, const HeldParameters& held, double huber, const Solving& how,
                Solution& solution) {
  try {
    ceres::Problem problem;
    problem.AddParameterBlock(solution.parameters.data(), kShared);
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    ordering->AddElementToGroup(solution.parameters.data(), 1);
    bool eliminates = false;
    for (const FitFrame& frame : frames.frames) {
      std::vector<double*> blocks = {solution.parameters.data()};
      if (frame.nuisance >= 0) {
        double* const nuisance = &solution.nuisances[static_cast<std::size_t>(frame.nuisance)];
        blocks.push_back(nuisance);
        ordering->AddElementToGroup(nuisance, 0);
        eliminates = true;
      }
      problem.AddResidualBlock(new FrameCost(frame, how.options.residual, huber), nullptr, blocks);
      if (frame.source == PullSource::kFree) {
        problem.SetParameterLowerBound(blocks[1], 0, 1e-9);
        problem.SetParameterUpperBound(blocks[1], 0, frame.reach);
      }
    }
    if (!held[kRestAngle]) {
      double most = std::numbers::pi / 2;
      for (const FitFrame& frame : frames.frames) most = std::min(most, frame.observed->design.closed_angle);
      problem.SetParameterLowerBound(solution.parameters.data(), kRestAngle, 0);
      problem.SetParameterUpperBound(solution.parameters.data(), kRestAngle, 0.95 * most);
    }
    if (!held[kFriction]) {
      problem.SetParameterLowerBound(solution.parameters.data(), kFriction, 0);
      problem.SetParameterUpperBound(solution.parameters.data(), kFriction, kLargestFriction);
    }
    std::vector<int> constant;
    for (int i = 0; i < kShared; ++i) {
      if (held[static_cast<std::size_t>(i)]) constant.push_back(i);
    }
    if (constant.size() == kShared) {
      problem.SetParameterBlockConstant(solution.parameters.data());
    } else if (!constant.empty()) {
      problem.SetManifold(solution.parameters.data(), new ceres::SubsetManifold(kShared, constant));
    }
    ceres::Solver::Options options;
    options.linear_solver_type = eliminates ? ceres::DENSE_SCHUR : ceres::DENSE_QR;
    if (eliminates) options.linear_solver_ordering = ordering;
    // The paper's law is smooth; with the others the cost has a kink wherever a crease begins to fold or the
    // tendon runs straight past a hole, about which the last digits cost most of the time.
    const FoldModel& model = how.options.model;
    const bool smooth = model.law == FoldLaw::kPaper && !model.friction;
    options.max_num_iterations =
        smooth ? how.options.iterations : std::min(how.options.iterations, how.most_iterations);
    options.function_tolerance = smooth ? 1e-13 : 1e-7;
    options.gradient_tolerance = 1e-13;
    options.parameter_tolerance = smooth ? 1e-11 : 1e-7;
    options.logging_type = ceres::SILENT;
    options.num_threads = 1;
    AskToGoOn ask(how.progress, how.from, how.to, how.options.iterations);
    options.callbacks.push_back(&ask);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (summary.termination_type == ceres::USER_FAILURE) {
      return Error{ErrorKind::kStopped, "the fit was asked to stop"};
    }
    solution.iterations += static_cast<int>(summary.iterations.size());
    solution.converged = summary.termination_type == ceres::CONVERGENCE;
    solution.message = summary.message;
  } catch (const std::exception& error) {
    return Error{ErrorKind::kIo, fmt::format("the solver failed: {}", error.what())};
  }
  return Ok{};
}

}  // namespace tendril
