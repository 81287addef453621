#include "capture/track/chain_solve.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "capture/track/chain_angles.h"
#include "capture/track/chain_calibration.h"
#include "capture/track/chain_curve.h"
#include "capture/track/chain_descent.h"
#include "capture/track/chain_judge.h"
#include "capture/track/chain_start.h"
#include "capture/track/chain_turn.h"
#include "model/check.h"

namespace tendril {
namespace {

Descent DescentFrom(const ChainProblem& problem, std::vector<FacetState> start) {
  Descent run;
  run.facets = std::move(start);
  run.weight.assign(problem.views.size(), 1.0);
  Descend(problem, run, false);
  DecideViews(problem, run);
  return run;
}

// To compare answers that leave out different views: a view left out costs what the worst one taken in may.
double CostWithRejects(const ChainProblem& problem, const Descent& run) {
  const double limit = kCornerNumbers * problem.options->largest_chi_square;
  double cost = run.at.cost;
  for (const double weight : run.weight) cost += weight > 0 ? 0 : limit;
  return cost;
}

// Creases that another moment tells of.
int RecalledCount(const ChainModel& model) {
  return static_cast<int>((model.recalled.sigma.array() > 0).count());
}

// Whether another start might lead to a better answer.
bool IsDoubtful(const ChainProblem& problem, const Descent& run) {
  const double used = std::accumulate(run.weight.begin(), run.weight.end(), 0.0);
  const double total = static_cast<double>(run.weight.size());
  if (problem.views.empty()) return false;
  return !run.converged || used < 0.85 * total ||
         run.at.cost > 1.5 * (kCornerNumbers * used + RecalledCount(*problem.model));
}

// Whether two cameras see at least half of the facets that are seen.
bool SeenByTwo(std::span<const TagView> views, int facets) {
  std::vector<int> camera(static_cast<std::size_t>(facets), -1);
  std::vector<char> twice(camera.size(), 0);
  for (const TagView& view : views) {
    const auto facet = static_cast<std::size_t>(view.place->facet);
    if (camera[facet] >= 0 && camera[facet] != view.camera) twice[facet] = 1;
    camera[facet] = view.camera;
  }
  const auto seen = std::count_if(camera.begin(), camera.end(), [](int c) { return c >= 0; });
  return 2 * std::count(twice.begin(), twice.end(), 1) >= seen && seen > 0;
}

// Whether half of the tags' centres lie within kNear of where the frame before has them.
bool IsNear(const ChainProblem& problem, const std::vector<FacetState>& facets) {
  constexpr double kNear = 20;  // px
  std::size_t near = 0;
  for (const TagView& view : problem.views) {
    const FacetState& facet = facets[static_cast<std::size_t>(view.place->facet)];
    const Eigen::Vector3d hole(0, 0, problem.model->layout.hole_z[view.place->facet]);
    const Eigen::Vector3d center = view.place->corners_in_sheet.rowwise().mean();
    const auto pixel = Project(problem.cameras[static_cast<std::size_t>(view.camera)],
                               facet.hole + facet.rotation * (center - hole));
    if (pixel && (*pixel - view.corners_px.rowwise().mean()).norm() < kNear) ++near;
  }
  return 2 * near >= problem.views.size();
}

// Of the corners about their tags, each tag at its most probable place, as the cameras are calibrated.
double RmsReprojection(const ChainProblem& problem, const Descent& run) {
  double squares = 0;
  int corners = 0;
  for (const std::vector<int>& members : problem.tags) {
    ViewFit sum;
    if (!SumOfViews(run.at, run.weight, members, sum)) continue;
    const TagPlace& place = *problem.views[members.front()].place;
    const FacetState& facet = run.facets[place.facet];
    const auto step = MostProbableStep(sum, SlopOfTag(*problem.options, facet.rotation));
    const Eigen::Vector3d hole(0, 0, problem.model->layout.hole_z[place.facet]);
    const Eigen::Vector3d middle = place.corners_in_sheet.rowwise().mean();
    const Eigen::Vector3d center = facet.hole + facet.rotation * (middle - hole) + step.tail<3>();
    const Eigen::Matrix3d rotation = facet.rotation * RotationOf(step.head<3>());
    for (const int v : members) {
      if (!run.at.views[v] || !(run.weight[v] > 0)) continue;
      const Camera& camera = problem.cameras[problem.views[v].camera];
      for (int c = 0; c < 4; ++c) {
        const auto pixel = Project(camera, center + rotation * (place.corners_in_sheet.col(c) - middle));
        if (!pixel) continue;
        squares += (*pixel - problem.views[v].corners_px.col(c)).squaredNorm();
        ++corners;
      }
    }
  }
  return corners > 0 ? std::sqrt(squares / corners) : std::numeric_limits<double>::quiet_NaN();
}

// Which nodes count as seen, bridged and not seen, from the holes' covariance.
void JudgeNodes(const ChainProblem& problem, const std::vector<char>& facet_seen,
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
  TENDRIL_CHECK(holes >= 2 && model.expected_angle.size() == holes - 1);
  TENDRIL_CHECK(model.recalled.angle.size() == model.recalled.sigma.size() &&
                (model.recalled.sigma.size() == 0 || model.recalled.sigma.size() == holes - 1));
  for (const TagView& view : views) {
    TENDRIL_CHECK(view.place != nullptr && view.place->facet >= 0 && view.place->facet < holes);
    TENDRIL_CHECK(view.camera >= 0 && view.camera < static_cast<int>(cameras.size()));
  }
  const ChainProblem problem = MakeChainProblem(model, cameras, views, options);

  // Where two cameras see most of what is seen, no tag has two poses, and what the frame before found is the
  // best start. Otherwise all candidates are looked at; other starts cost time, so they are tried only while
  // what has been found looks doubtful.
  const bool has_previous = previous != nullptr && static_cast<int>(previous->facets.size()) == holes;
  std::optional<Descent> best;
  int iterations = 0;
  const auto consider = [&](std::vector<FacetState> start) {
    Descent other = DescentFrom(problem, std::move(start));
    iterations += other.iterations;
    if (!best || CostWithRejects(problem, other) < CostWithRejects(problem, *best)) best = std::move(other);
  };
  const auto doubtful = [&] { return !best || IsDoubtful(problem, *best); };
  const bool follows = has_previous && SeenByTwo(views, holes) && IsNear(problem, previous->facets);
  if (follows) consider(previous->facets);
  if (doubtful()) {
    const std::vector<std::vector<FacetCandidate>> candidates =
        CandidatesOfFacets(model, cameras, views, options);
    consider(StartOfChain(model, candidates, options, 0.20));
    if (doubtful()) consider(StartOfChain(model, candidates, options, 0.06));
    if (has_previous && !follows && doubtful()) consider(previous->facets);
    if (doubtful()) consider(problem.nominal);
  }
  best->iterations = iterations;

  ChainSolution solution;
  solution.facets = best->facets;
  solution.iterations = best->iterations;
  solution.converged = best->converged;
  std::vector<char> facet_seen(holes, 0);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const bool used = best->weight[v] > 0;
    solution.used.push_back(used ? 1 : 0);
    if (used) facet_seen[views[v].place->facet] = 1;
    solution.views_used += used ? 1 : 0;
  }
  solution.views_rejected = static_cast<int>(views.size()) - solution.views_used;
  for (const char seen : facet_seen) solution.facets_seen += seen;
  solution.rms_reprojection_px = RmsReprojection(problem, *best);
  // Degrees of freedom: the facets' own numbers cancel against creases, base and openings.
  const double freedom =
      solution.views_used > 0 ? kCornerNumbers * solution.views_used + RecalledCount(model) : 0;
  solution.chi_square = freedom > 0 ? best->at.cost / freedom : 0;

  solution.angle.resize(holes - 1);
  for (int i = 0; i + 1 < holes; ++i) {
    solution.angle[i] =
        FoldAngleBetween(problem.creases[i], best->facets[i].rotation, best->facets[i + 1].rotation);
  }
  solution.curve = CurveOfFacets(model.layout, solution.facets);

  const ChainCholesky cholesky(best->at.matrix);
  // Where the misfit is larger than the sigmas explain, they are too small by that much.
  const double inflation = std::max(1.0, solution.chi_square);
  Eigen::MatrixXd covariance;  // of the points, then of the normals' turns
  solution.angle_sigma = Eigen::VectorXd::Constant(holes - 1, std::numeric_limits<double>::quiet_NaN());
  solution.angle_by_pictures = Eigen::VectorXd::Zero(holes - 1);
  if (cholesky.ok()) {
    AngleKnowledge angles = KnowledgeOfAngles(problem, *best, cholesky, inflation);
    solution.angle_sigma = std::move(angles.sigma);
    solution.angle_by_pictures = std::move(angles.by_pictures);
    Eigen::MatrixXd poses = inflation * cholesky.PoseCovariance();
    if (options.sigma_calibration_px > 0 && solution.views_used > 0) {
      const Eigen::MatrixXd moved = PosesByCalibration(problem, *best, cholesky);
      poses.noalias() += moved * moved.transpose();
    }
    const Eigen::SparseMatrix<double> curve = CurveOfSteps(model.layout, solution.facets);
    const Eigen::MatrixXd half = curve * poses;
    covariance = curve * half.transpose();
    for (int i = 0; i < holes; ++i) {
      covariance.block<3, 3>(3 * i, 3 * i) += HoleSlop(options, best->facets[i].rotation, facet_seen[i] != 0);
    }
  } else {
    covariance = Eigen::MatrixXd::Constant(4 * holes, 4 * holes, 0);
    covariance.diagonal().setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  JudgeNodes(problem, facet_seen, covariance, solution);
  if (options.covariance_rank > 0 && cholesky.ok()) {
    CurveFactors factors = FactorsOfCurve(covariance, options.covariance_rank);
    solution.covariance_factor = std::move(factors.points);
    solution.turn_factor = std::move(factors.turns);
  }
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
  solution.seconds = spent.count();
  return solution;
}

}  // namespace tendril
