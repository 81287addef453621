#include "capture/track/chain_descent.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "capture/track/chain_start.h"

namespace tendril {
namespace {

void FitViews(const ChainProblem& problem, const std::vector<FacetState>& facets, Linearised& at) {
  const ChainOptions& options = *problem.options;
  at.views.assign(problem.views.size(), std::nullopt);
  at.view_cost.assign(problem.views.size(), std::numeric_limits<double>::infinity());
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const TagView& view = problem.views[v];
    if (!view.corners_px.allFinite()) continue;
    const int facet = view.place->facet;
    const Eigen::Vector3d hole(0, 0, problem.model->layout.hole_z[facet]);
    const Eigen::Vector3d center = view.place->corners_in_sheet.rowwise().mean();
    const FacetState& state = facets[facet];
    at.views[v] = FitOfView(problem.cameras[view.camera], view.place->corners_in_sheet, view.corners_px,
                            SigmaOfView(view.sigma_px, options), state.rotation,
                            state.hole + state.rotation * (center - hole));
    if (at.views[v]) {
      at.view_cost[v] = WithSlop(*at.views[v], SlopOfTag(options, state.rotation)).cost;
    }
  }
}

void AddBase(const ChainProblem& problem, const FacetState& base, Linearised& at) {
  const ChainOptions& options = *problem.options;
  const FacetState& nominal = problem.nominal.front();
  // In axes along and across crease 0: about the crease the base turns with the fold.
  const bool hinged = !problem.creases.empty();
  const Eigen::Vector3d along = hinged ? problem.creases.front().along : Eigen::Vector3d::UnitY();
  Eigen::Matrix3d axes;
  axes << along, Eigen::Vector3d::UnitX(), along.cross(Eigen::Vector3d::UnitX());
  const Eigen::AngleAxisd off(Eigen::Matrix3d(nominal.rotation.transpose() * base.rotation));
  // Without the law nobody knows how far the base turns with the fold.
  const double sigma_fold = options.fold_law ? options.sigma_base_fold : options.sigma_free_opening;
  const double sigma_opening = options.fold_law ? options.sigma_opening : options.sigma_free_opening;
  const Eigen::Vector3d sigma_turn(sigma_fold, options.sigma_base_turn, options.sigma_base_turn);
  // Near the nominal pose a step w changes the rotation vector by w, to first order.
  const Eigen::Matrix3d by_turn = sigma_turn.cwiseInverse().asDiagonal() * axes.transpose();
  const Eigen::Vector3d turn = by_turn * (off.angle() * off.axis());
  const Eigen::Vector3d place = (base.hole - nominal.hole) / options.sigma_base_place;
  const Eigen::Vector2d opening = base.opening / sigma_opening;
  at.prior_cost += turn.squaredNorm() + place.squaredNorm() + opening.squaredNorm();
  at.gradient.front().head<3>() += by_turn.transpose() * turn;
  at.gradient.front().segment<3>(3) += place / options.sigma_base_place;
  at.gradient.front().tail<2>() += opening / sigma_opening;
  FacetMatrix& matrix = at.matrix.diagonal.front();
  matrix.topLeftCorner<3, 3>() += by_turn.transpose() * by_turn;
  matrix.diagonal().segment<3>(3).array() += 1 / (options.sigma_base_place * options.sigma_base_place);
  matrix.diagonal().tail<2>().array() += 1 / (sigma_opening * sigma_opening);
}

// Cauchy's loss on a view's chi-square, per view: what is far off hardly pulls.
double CauchyScale(const ChainOptions& options) { return kCornerNumbers * options.largest_chi_square / 2; }

}  // namespace

ChainProblem MakeChainProblem(const ChainModel& model, std::span<const Camera> cameras,
                              std::span<const TagView> views, const ChainOptions& options) {
  ChainProblem problem;
  problem.model = &model;
  problem.cameras = cameras;
  problem.views = views;
  problem.options = &options;
  const TentacleLayout& layout = model.layout;
  const int creases = static_cast<int>(layout.crease_z.size());
  const Eigen::VectorXd ease = layout.half_spacing.array() / layout.stiffness.array();
  for (int i = 0; i < creases; ++i) {
    problem.creases.push_back(GeometryOfCrease(layout, i));
    // A crease that the law has closed stays closed when the tendon is pulled a little more or less.
    const bool closed = model.expected_angle[i] > model.closed_angle - 1e-6;
    problem.priors.push_back(
        {.expected_angle = options.fold_law ? model.expected_angle[i] : 0.0,
         .compliance = !options.fold_law ? 1.0
                       : closed          ? 0.2
                                         : std::clamp(ease[i] / ease.mean(), 0.3, 3.0),
         .sigma_gap = {options.sigma_gap, options.sigma_gap_flat, options.sigma_gap_flat},
         .sigma_swing = options.sigma_swing,
         .sigma_angle = options.sigma_angle,
         .sigma_walk = options.fold_law ? options.sigma_opening_walk : options.sigma_free_walk});
  }
  const RecalledAngles& recalled = model.recalled;
  for (Eigen::Index i = 0; i < recalled.sigma.size(); ++i) {
    if (!(recalled.sigma[i] > 0)) continue;
    problem.priors[static_cast<std::size_t>(i)].recalled_angle = recalled.angle[i];
    problem.priors[static_cast<std::size_t>(i)].recalled_weight = 1 / recalled.sigma[i];
  }
  problem.nominal = NominalChain(model);
  if (!options.fold_law) {  // the base turns with the fold, which nobody knows: about a flat tentacle's
    ChainModel flat = model;
    flat.expected_angle.setZero();
    problem.nominal.front() = NominalChain(flat).front();
  }
  std::map<int, std::vector<int>> by_tag;
  for (int v = 0; v < static_cast<int>(views.size()); ++v) by_tag[views[v].place->id].push_back(v);
  for (auto& [id, members] : by_tag) problem.tags.push_back(std::move(members));
  return problem;
}

bool SumOfViews(const Linearised& at, const std::vector<double>& weight, const std::vector<int>& members,
                ViewFit& sum) {
  sum = {.cost = 0,
         .gradient = Eigen::Matrix<double, 6, 1>::Zero(),
         .hessian = Eigen::Matrix<double, 6, 6>::Zero()};
  bool any = false;
  for (const int v : members) {
    if (!at.views[v] || weight[v] <= 0) continue;
    any = true;
    sum.cost += weight[v] * at.views[v]->cost;
    sum.gradient += weight[v] * at.views[v]->gradient;
    sum.hessian += weight[v] * at.views[v]->hessian;
  }
  return any;
}

void AddUp(const ChainProblem& problem, const std::vector<FacetState>& facets,
           const std::vector<double>& weight, Linearised& at) {
  const ChainOptions& options = *problem.options;
  const std::size_t count = facets.size();
  at.matrix.diagonal.assign(count, FacetMatrix::Zero());
  at.matrix.below.assign(count - 1, FacetMatrix::Zero());
  at.gradient.assign(count, FacetVector::Zero());
  at.cost = 0;
  at.prior_cost = 0;
  for (const std::vector<int>& members : problem.tags) {
    ViewFit sum;
    if (!SumOfViews(at, weight, members, sum)) continue;
    const TagPlace& place = *problem.views[members.front()].place;
    const ViewFit tag = WithSlop(sum, SlopOfTag(options, facets[place.facet].rotation));
    at.cost += tag.cost;
    const Eigen::Vector3d hole(0, 0, problem.model->layout.hole_z[place.facet]);
    const Eigen::Vector3d center = place.corners_in_sheet.rowwise().mean();
    AddToFacet(tag, facets[place.facet].rotation, center - hole, at.gradient[place.facet],
               at.matrix.diagonal[place.facet]);
  }
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const CreaseFit fit =
        FitOfCrease(problem.creases[i], problem.priors[i], static_cast<int>(i), facets[i], facets[i + 1]);
    at.prior_cost += fit.cost;
    at.gradient[i] += fit.gradient.head<kFacetSize>();
    at.gradient[i + 1] += fit.gradient.tail<kFacetSize>();
    at.matrix.diagonal[i] += fit.hessian.topLeftCorner<kFacetSize, kFacetSize>();
    at.matrix.diagonal[i + 1] += fit.hessian.bottomRightCorner<kFacetSize, kFacetSize>();
    at.matrix.below[i] += fit.hessian.bottomLeftCorner<kFacetSize, kFacetSize>();
  }
  AddBase(problem, facets.front(), at);
  at.cost += at.prior_cost;
}

void Descend(const ChainProblem& problem, Descent& run, bool frozen) {
  const ChainOptions& options = *problem.options;
  const double scale = CauchyScale(options);
  const auto renew = [&] {
    if (frozen) return;
    for (std::size_t v = 0; v < run.weight.size(); ++v) {
      run.weight[v] = run.at.views[v] ? 1 / (1 + run.at.view_cost[v] / scale) : 0;
    }
  };
  FitViews(problem, run.facets, run.at);
  renew();
  AddUp(problem, run.facets, run.weight, run.at);
  // Robust weights settle slowly and are only to lead into the right valley: the frozen fit does the rest.
  const double enough = frozen ? 1e-4 : 1e-1;
  double damping = 1e-4;
  run.converged = false;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    ++run.iterations;
    const ChainCholesky cholesky(run.at.matrix, damping);
    if (!cholesky.ok()) {
      damping = std::max(10 * damping, 1e-6);
      if (damping > 1e8) return;
      continue;
    }
    const std::vector<FacetVector> step = cholesky.Solve(run.at.gradient);
    Descent next;
    next.facets.reserve(run.facets.size());
    double largest_turn = 0;
    double largest_move = 0;
    for (std::size_t i = 0; i < run.facets.size(); ++i) {
      FacetVector back = -step[i];
      // A turn by more than half a radian is beyond what the linear form knows.
      const double turn = back.head<3>().norm();
      if (turn > 0.5) back *= 0.5 / turn;
      largest_turn = std::max(largest_turn, back.head<3>().norm());
      largest_move = std::max(largest_move, back.segment<3>(3).norm());
      next.facets.push_back(Stepped(run.facets[i], back));
    }
    FitViews(problem, next.facets, next.at);
    AddUp(problem, next.facets, run.weight, next.at);
    const bool lost_a_view = [&] {
      for (std::size_t v = 0; v < run.weight.size(); ++v) {
        if (run.weight[v] > 0 && !next.at.views[v]) return true;
      }
      return false;
    }();
    if (lost_a_view || !(next.at.cost <= run.at.cost * (1 + 1e-12))) {
      if (largest_turn < 1e-7 && largest_move < 1e-8) {
        run.converged = true;
        return;
      }
      damping = std::max(8 * damping, 1e-6);
      if (damping > 1e8) return;
      continue;
    }
    damping = std::max(damping / 8, 1e-12);
    run.facets = std::move(next.facets);
    const double gain = run.at.cost - next.at.cost;
    run.at = std::move(next.at);
    renew();
    AddUp(problem, run.facets, run.weight, run.at);
    // Steps of a micrometre and of 20 microradians are far below any sigma.
    if ((largest_turn < 2e-5 && largest_move < 1e-6) || gain < enough * (1 + 1e-3 * run.at.cost)) {
      run.converged = true;
      return;
    }
  }
}

}  // namespace tendril
