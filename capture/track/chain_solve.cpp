#include "capture/track/chain_solve.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "capture/track/chain_curve.h"
#include "capture/track/chain_matrix.h"
#include "capture/track/chain_start.h"
#include "model/check.h"

namespace tendril {
namespace {

constexpr double kCornerNumbers = 8;  // residuals of a view

// Everything that stays the same while the facets move.
struct Problem {
  const ChainModel* model = nullptr;
  std::span<const Camera> cameras;
  std::span<const TagView> views;
  const ChainOptions* options = nullptr;
  std::vector<CreaseGeometry> creases;
  std::vector<CreasePrior> priors;
  std::vector<FacetState> nominal;
  std::vector<std::vector<int>> tags;  // views of the same tag belong together: they share its slop
};

Problem MakeProblem(const ChainModel& model, std::span<const Camera> cameras, std::span<const TagView> views,
                    const ChainOptions& options) {
  Problem problem;
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
    problem.priors.push_back({.expected_angle = model.expected_angle[i],
                              .compliance = closed ? 0.2 : std::clamp(ease[i] / ease.mean(), 0.3, 3.0),
                              .sigma_gap = options.sigma_gap,
                              .sigma_swing = options.sigma_swing,
                              .sigma_angle = options.sigma_angle,
                              .sigma_walk = options.sigma_opening_walk});
  }
  problem.nominal = NominalChain(model);
  std::map<int, std::vector<int>> by_tag;
  for (int v = 0; v < static_cast<int>(views.size()); ++v) by_tag[views[v].place->id].push_back(v);
  for (auto& [id, members] : by_tag) problem.tags.push_back(std::move(members));
  return problem;
}

// The problem's quadratic form about a guess, with one weight per view.
struct Linearised {
  std::vector<std::optional<ViewFit>> views;  // none: not usable here
  std::vector<double> view_cost;              // of each view alone, its tag's slop integrated out
  ChainMatrix matrix;
  std::vector<FacetVector> gradient;
  double cost = 0;        // with the weights
  double prior_cost = 0;  // its part without views
};

void FitViews(const Problem& problem, const std::vector<FacetState>& facets, Linearised& at) {
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
    at.views[v] =
        FitOfView(problem.cameras[view.camera], view.place->corners_in_sheet, view.corners_px,
                  options.sigma_corner_px, state.rotation, state.hole + state.rotation * (center - hole));
    if (at.views[v]) {
      at.view_cost[v] = WithSlop(*at.views[v], options.sigma_tag_turn, options.sigma_tag_place).cost;
    }
  }
}

// The views of one tag, weighted and added up; false if none of them counts.
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

void AddBase(const Problem& problem, const FacetState& base, Linearised& at) {
  const ChainOptions& options = *problem.options;
  const FacetState& nominal = problem.nominal.front();
  // In axes along and across crease 0: about the crease the base turns with the fold.
  const bool hinged = !problem.creases.empty();
  const Eigen::Vector3d along = hinged ? problem.creases.front().along : Eigen::Vector3d::UnitY();
  Eigen::Matrix3d axes;
  axes << along, Eigen::Vector3d::UnitX(), along.cross(Eigen::Vector3d::UnitX());
  const Eigen::AngleAxisd off(Eigen::Matrix3d(nominal.rotation.transpose() * base.rotation));
  const Eigen::Vector3d sigma_turn(options.sigma_base_fold, options.sigma_base_turn, options.sigma_base_turn);
  // Near the nominal pose a step w changes the rotation vector by w, to first order.
  const Eigen::Matrix3d by_turn = sigma_turn.cwiseInverse().asDiagonal() * axes.transpose();
  const Eigen::Vector3d turn = by_turn * (off.angle() * off.axis());
  const Eigen::Vector3d place = (base.hole - nominal.hole) / options.sigma_base_place;
  const Eigen::Vector2d opening = base.opening / options.sigma_opening;
  at.prior_cost += turn.squaredNorm() + place.squaredNorm() + opening.squaredNorm();
  at.gradient.front().head<3>() += by_turn.transpose() * turn;
  at.gradient.front().segment<3>(3) += place / options.sigma_base_place;
  at.gradient.front().tail<2>() += opening / options.sigma_opening;
  FacetMatrix& matrix = at.matrix.diagonal.front();
  matrix.topLeftCorner<3, 3>() += by_turn.transpose() * by_turn;
  matrix.diagonal().segment<3>(3).array() += 1 / (options.sigma_base_place * options.sigma_base_place);
  matrix.diagonal().tail<2>().array() += 1 / (options.sigma_opening * options.sigma_opening);
}

// Adds up views (already fitted), creases and base.
void Assemble(const Problem& problem, const std::vector<FacetState>& facets,
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
    const ViewFit tag = WithSlop(sum, options.sigma_tag_turn, options.sigma_tag_place);
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

// Cauchy's loss on a view's chi-square, per view: what is far off hardly pulls.
double CauchyScale(const ChainOptions& options) { return kCornerNumbers * options.largest_chi_square / 2; }

struct Descent {
  std::vector<FacetState> facets;
  Linearised at;
  std::vector<double> weight;
  int iterations = 0;
  bool converged = false;
};

// Levenberg-Marquardt with the views' weights renewed after every accepted step (frozen: kept).
void Descend(const Problem& problem, Descent& run, bool frozen) {
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
  Assemble(problem, run.facets, run.weight, run.at);
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
    Assemble(problem, next.facets, run.weight, next.at);
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
    Assemble(problem, run.facets, run.weight, run.at);
    // Steps of a micrometre and of 20 microradians are far below any sigma.
    if ((largest_turn < 2e-5 && largest_move < 1e-6) || gain < 1e-5 * (1 + 1e-3 * run.at.cost)) {
      run.converged = true;
      return;
    }
  }
}

// What one view adds to the form of its facet's pose, given the other views of its tag that count.
ViewFit ShareOfView(const Problem& problem, const Descent& run, const std::vector<int>& members, int view) {
  const ChainOptions& options = *problem.options;
  const TagPlace& place = *problem.views[view].place;
  const Eigen::Vector3d hole(0, 0, problem.model->layout.hole_z[place.facet]);
  const Eigen::Vector3d arm = place.corners_in_sheet.rowwise().mean() - hole;
  ViewFit share{.cost = 0,
                .gradient = Eigen::Matrix<double, 6, 1>::Zero(),
                .hessian = Eigen::Matrix<double, 6, 6>::Zero()};
  for (const bool with : {true, false}) {
    ViewFit sum = {.cost = 0,
                   .gradient = Eigen::Matrix<double, 6, 1>::Zero(),
                   .hessian = Eigen::Matrix<double, 6, 6>::Zero()};
    for (const int v : members) {
      const bool counts = v == view ? with : run.weight[v] > 0;
      if (!counts || !run.at.views[v]) continue;
      sum.cost += run.at.views[v]->cost;
      sum.gradient += run.at.views[v]->gradient;
      sum.hessian += run.at.views[v]->hessian;
    }
    const ViewFit tag = WithSlop(sum, options.sigma_tag_turn, options.sigma_tag_place);
    FacetVector gradient = FacetVector::Zero();
    FacetMatrix hessian = FacetMatrix::Zero();
    AddToFacet(tag, run.facets[place.facet].rotation, arm, gradient, hessian);
    const double sign = with ? 1 : -1;
    share.cost += sign * tag.cost;
    share.gradient += sign * gradient.head<6>();
    share.hessian += sign * hessian.topLeftCorner<6, 6>();
  }
  return share;
}

// How badly each view agrees with everything else: its chi-square (8 numbers) about what the fit without it
// predicts, with that prediction's own spread. Small for a view that only bends a loose chain a little, large
// for one that the chain had to stretch for. Infinite where it can't be seen at all.
std::vector<double> Disagreement(const Problem& problem, const Descent& run) {
  std::vector<double> disagreement(problem.views.size(), std::numeric_limits<double>::infinity());
  const ChainCholesky cholesky(run.at.matrix);
  if (!cholesky.ok()) return disagreement;
  const std::vector<Eigen::Matrix<double, 6, 6>> covariance = cholesky.PoseCovariances();
  for (const std::vector<int>& members : problem.tags) {
    const int facet = problem.views[members.front()].place->facet;
    const Eigen::Matrix<double, 6, 6> information = covariance[facet].inverse();
    for (const int v : members) {
      if (!run.at.views[v]) continue;
      const ViewFit share = ShareOfView(problem, run, members, v);
      const bool in = run.weight[v] > 0;
      // In: the cost that leaving it out would save. Out: the cost that taking it in would add.
      const Eigen::Matrix<double, 6, 6> moved = in ? Eigen::Matrix<double, 6, 6>(information - share.hessian)
                                                   : Eigen::Matrix<double, 6, 6>(information + share.hessian);
      const double by_moving = share.gradient.dot(moved.ldlt().solve(share.gradient));
      disagreement[v] = in ? share.cost + std::max(0.0, by_moving) : share.cost - by_moving;
    }
  }
  return disagreement;
}

// Views are in or out: once the robust fit has settled, the final fit and its covariance use the good ones in
// full. The worst go first, one in a neighbourhood at a time, because a bad view spoils what its neighbours
// predict; one that was blamed wrongly comes back.
void Decide(const Problem& problem, Descent& run) {
  constexpr int kRounds = 12;
  constexpr int kNeighbourhood = 8;  // facets
  const double limit = kCornerNumbers * problem.options->largest_chi_square;
  std::vector<char> left_out(run.weight.size(), 0);
  for (std::size_t v = 0; v < run.weight.size(); ++v) {
    run.weight[v] = run.at.views[v] && run.at.view_cost[v] <= limit ? 1.0 : 0.0;
  }
  Descend(problem, run, true);
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<double> disagreement = Disagreement(problem, run);
    std::vector<int> order;
    for (int v = 0; v < static_cast<int>(run.weight.size()); ++v) {
      const bool in = run.weight[v] > 0;
      const bool leave = in && disagreement[v] > limit;
      const bool enter = !in && left_out[v] < 2 && disagreement[v] < 0.6 * limit;
      if (leave || enter) order.push_back(v);
    }
    if (order.empty()) return;
    std::sort(order.begin(), order.end(), [&](int a, int b) { return disagreement[a] > disagreement[b]; });
    std::vector<int> touched;
    for (const int v : order) {
      const int facet = problem.views[v].place->facet;
      const bool near = std::any_of(touched.begin(), touched.end(),
                                    [&](int other) { return std::abs(other - facet) < kNeighbourhood; });
      if (near) continue;
      touched.push_back(facet);
      if (run.weight[v] > 0) ++left_out[v];
      run.weight[v] = run.weight[v] > 0 ? 0 : 1;
    }
    Descend(problem, run, true);
  }
}

Descent DescentFrom(const Problem& problem, std::vector<FacetState> start) {
  Descent run;
  run.facets = std::move(start);
  run.weight.assign(problem.views.size(), 1.0);
  Descend(problem, run, false);
  Decide(problem, run);
  return run;
}

// To compare answers that leave out different views: a view left out costs what the worst one taken in may.
double CostWithRejects(const Problem& problem, const Descent& run) {
  const double limit = kCornerNumbers * problem.options->largest_chi_square;
  double cost = run.at.cost;
  for (const double weight : run.weight) cost += weight > 0 ? 0 : limit;
  return cost;
}

// Whether another start might lead to a better answer.
bool IsDoubtful(const Problem& problem, const Descent& run) {
  const double used = std::accumulate(run.weight.begin(), run.weight.end(), 0.0);
  const double total = static_cast<double>(run.weight.size());
  if (problem.views.empty()) return false;
  return !run.converged || used < 0.85 * total || run.at.cost > 0.8 * kCornerNumbers * used;
}

double RmsReprojection(const Problem& problem, const Descent& run) {
  const ChainOptions& options = *problem.options;
  double squares = 0;
  int corners = 0;
  for (const std::vector<int>& members : problem.tags) {
    ViewFit sum;
    if (!SumOfViews(run.at, run.weight, members, sum)) continue;
    squares += CostAtBestPlace(sum, options.sigma_tag_turn, options.sigma_tag_place);
    for (const int v : members) corners += run.weight[v] > 0 ? 4 : 0;
  }
  return corners > 0 ? std::sqrt(squares / corners) * options.sigma_corner_px
                     : std::numeric_limits<double>::quiet_NaN();
}

// Which nodes count as seen, bridged and not seen, from the holes' covariance.
void JudgeNodes(const Problem& problem, const std::vector<char>& facet_seen,
                const Eigen::MatrixXd& covariance, ChainSolution& solution) {
  const ChainOptions& options = *problem.options;
  const Eigen::VectorXd& hole_z = problem.model->layout.hole_z;
  const int count = static_cast<int>(hole_z.size());
  solution.sigma.resize(count);
  solution.interpolated.resize(count);
  for (int i = 0; i < count; ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    for (int j = 0; j < count; ++j) {
      if (facet_seen[j] != 0) nearest = std::min(nearest, std::abs(hole_z[i] - hole_z[j]));
    }
    solution.interpolated[i] = facet_seen[i] != 0 ? 0 : 1;
    solution.sigma[i] = std::sqrt(covariance.diagonal().segment<3>(3 * i).sum());
    if (facet_seen[i] == 0 &&
        (nearest > options.farthest_seen || solution.sigma[i] > options.largest_sigma)) {
      solution.sigma[i] = std::numeric_limits<double>::quiet_NaN();
    }
  }
}

}  // namespace

Eigen::Isometry3d LabFromSheet(const TentacleLayout& layout, const FacetState& facet, int number) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = facet.rotation;
  pose.translation() = facet.hole - facet.rotation * Eigen::Vector3d(0, 0, layout.hole_z[number]);
  return pose;
}

ChainSolution SolveChain(const ChainModel& model, std::span<const Camera> cameras,
                         std::span<const TagView> views, const ChainOptions& options,
                         const ChainSolution* previous) {
  const auto begin = std::chrono::steady_clock::now();
  const int holes = static_cast<int>(model.layout.hole_z.size());
  TENDRIL_CHECK(holes >= 1 && model.expected_angle.size() == holes - 1);
  for (const TagView& view : views) {
    TENDRIL_CHECK(view.place != nullptr && view.place->facet >= 0 && view.place->facet < holes);
    TENDRIL_CHECK(view.camera >= 0 && view.camera < static_cast<int>(cameras.size()));
  }
  const Problem problem = MakeProblem(model, cameras, views, options);

  const std::vector<std::vector<FacetCandidate>> candidates =
      CandidatesOfFacets(model, cameras, views, options);
  // Other starts cost time, so they are tried only while what has been found looks doubtful.
  Descent best = DescentFrom(problem, StartOfChain(model, candidates, options, 0.20));
  int iterations = best.iterations;
  const auto consider = [&](std::vector<FacetState> start) {
    Descent other = DescentFrom(problem, std::move(start));
    iterations += other.iterations;
    if (CostWithRejects(problem, other) < CostWithRejects(problem, best)) best = std::move(other);
  };
  if (IsDoubtful(problem, best)) consider(StartOfChain(model, candidates, options, 0.06));
  const bool has_previous = previous != nullptr && static_cast<int>(previous->facets.size()) == holes;
  if (has_previous && IsDoubtful(problem, best)) consider(previous->facets);
  if (IsDoubtful(problem, best)) consider(problem.nominal);
  best.iterations = iterations;

  ChainSolution solution;
  solution.facets = best.facets;
  solution.iterations = best.iterations;
  solution.converged = best.converged;
  std::vector<char> facet_seen(holes, 0);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const bool used = best.weight[v] > 0;
    solution.used.push_back(used ? 1 : 0);
    if (used) facet_seen[views[v].place->facet] = 1;
    solution.views_used += used ? 1 : 0;
  }
  solution.views_rejected = static_cast<int>(views.size()) - solution.views_used;
  for (const char seen : facet_seen) solution.facets_seen += seen;
  solution.rms_reprojection_px = RmsReprojection(problem, best);
  // Degrees of freedom: the facets' own numbers cancel against creases, base and openings.
  const double freedom = kCornerNumbers * solution.views_used;
  solution.chi_square = freedom > 0 ? best.at.cost / freedom : 0;

  solution.angle.resize(holes - 1);
  for (int i = 0; i + 1 < holes; ++i) {
    solution.angle[i] =
        FoldAngleBetween(problem.creases[i], best.facets[i].rotation, best.facets[i + 1].rotation);
  }
  solution.curve = CurveOfFacets(model.layout, solution.facets);

  const ChainCholesky cholesky(best.at.matrix);
  // Where the misfit is larger than the sigmas explain, they are too small by that much.
  const double inflation = std::max(1.0, solution.chi_square);
  Eigen::MatrixXd covariance;
  if (cholesky.ok()) {
    covariance = inflation * cholesky.HoleCovariance();
    covariance.diagonal().array() += options.sigma_hole * options.sigma_hole;
  } else {
    covariance = Eigen::MatrixXd::Constant(3 * holes, 3 * holes, 0);
    covariance.diagonal().setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  JudgeNodes(problem, facet_seen, covariance, solution);
  if (options.covariance_rank > 0 && cholesky.ok()) {
    solution.covariance_factor = FactorOfCovariance(covariance, options.covariance_rank);
  }
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
  solution.seconds = spent.count();
  return solution;
}

}  // namespace tendril
