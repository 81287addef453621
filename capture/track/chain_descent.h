#pragma once
// The chain's least-squares problem and its descent: one weight per view, given or robust.
// Internal to SolveChain (chain_solve.h).

#include <optional>
#include <span>
#include <vector>

#include "capture/track/chain_matrix.h"
#include "capture/track/chain_solve.h"

namespace tendril {

inline constexpr double kCornerNumbers = 8;  // residuals of a view

// Everything that stays the same while the facets move.
struct ChainProblem {
  const ChainModel* model = nullptr;
  std::span<const Camera> cameras;
  std::span<const TagView> views;
  const ChainOptions* options = nullptr;
  std::vector<CreaseGeometry> creases;
  std::vector<CreasePrior> priors;
  std::vector<FacetState> nominal;
  std::vector<std::vector<int>> tags;  // views of the same tag belong together: they share its slop
};

ChainProblem MakeChainProblem(const ChainModel& model, std::span<const Camera> cameras,
                              std::span<const TagView> views, const ChainOptions& options);

// The problem's quadratic form about a guess, with one weight per view.
struct Linearised {
  std::vector<std::optional<ViewFit>> views;  // none: not usable here
  std::vector<double> view_cost;              // of each view alone, its tag's slop integrated out
  ChainMatrix matrix;
  std::vector<FacetVector> gradient;
  double cost = 0;        // with the weights
  double prior_cost = 0;  // its part without views
};

struct Descent {
  std::vector<FacetState> facets;
  Linearised at;
  std::vector<double> weight;
  int iterations = 0;
  bool converged = false;
};

// The views of one tag, weighted and added up; false if none of them counts.
bool SumOfViews(const Linearised& at, const std::vector<double>& weight, const std::vector<int>& members,
                ViewFit& sum);

// Adds up views (already fitted, with these weights), creases and base to at's matrix, gradient and costs.
void AddUp(const ChainProblem& problem, const std::vector<FacetState>& facets,
           const std::vector<double>& weight, Linearised& at);

// Levenberg-Marquardt under Cauchy's loss per view, the views' weights renewed after every accepted step
// (frozen: kept).
void Descend(const ChainProblem& problem, Descent& run, bool frozen);

}  // namespace tendril
