#include "capture/track/chain_judge.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

namespace tendril {
namespace {

// What one view adds to the form of its facet's pose, given the other views of its tag that count.
ViewFit ShareOfView(const ChainProblem& problem, const Descent& run, const std::vector<int>& members,
                    int view) {
  const ChainOptions& options = *problem.options;
  const TagPlace& place = *problem.views[view].place;
  const Eigen::Vector3d hole(0, 0, problem.model->layout.hole_z[place.facet]);
  const Eigen::Vector3d arm = place.corners_in_sheet.rowwise().mean() - hole;
  ViewFit share{.cost = 0,
                .gradient = Eigen::Matrix<double, 6, 1>::Zero(),
                .hessian = Eigen::Matrix<double, 6, 6>::Zero()};
  const TagSlop slop = SlopOfTag(options, run.facets[place.facet].rotation);
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
    const ViewFit tag = WithSlop(sum, slop);
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
std::vector<double> Disagreement(const ChainProblem& problem, const Descent& run) {
  std::vector<double> disagreement(problem.views.size(), std::numeric_limits<double>::infinity());
  const ChainCholesky cholesky(run.at.matrix);
  if (!cholesky.ok()) return disagreement;
  const std::vector<NearCovariance> covariance = cholesky.NearCovariances();
  for (const std::vector<int>& members : problem.tags) {
    const int facet = problem.views[members.front()].place->facet;
    const Eigen::Matrix<double, 6, 6> information = covariance[facet].own.topLeftCorner<6, 6>().inverse();
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

}  // namespace

void DecideViews(const ChainProblem& problem, Descent& run) {
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

}  // namespace tendril
