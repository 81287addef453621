#include "cli/fold_answer.h"

#include "model/fold/exact_law.h"
#include "model/fold/fold.h"
#include "model/fold/tendon_friction.h"

namespace tendril::cli {
namespace {

// From flat through the path to the pull.
Result<FoldAnswer> AnswerWithFriction(const TentacleDesign& design, const std::vector<double>& path,
                                      double pull) {
  Result<FrictionTendon> tendon = FrictionTendon::Make(design);
  if (!tendon.ok()) return tendon.error();
  for (const double before : path) {
    if (const auto on_the_way = tendon.value().MoveTo(before); !on_the_way.ok()) return on_the_way.error();
  }
  const Result<FrictionFold> fold = tendon.value().MoveTo(pull);
  if (!fold.ok()) return fold.error();
  const FrictionFold& f = fold.value();
  FoldAnswer answer{f.angle, {},          f.tendon_length, std::nullopt, f.tension.tail<1>()[0],
                    f.slack, f.tension[0]};
  for (Eigen::Index i = 0; i < f.angle.size(); ++i) {
    if (f.angle[i] >= design.closed_angle) answer.closed.push_back(static_cast<int>(i));
  }
  return answer;
}

}  // namespace

Result<FoldAnswer> AnswerFold(const std::string& law, const TentacleDesign& design,
                              const TentacleLayout& layout, const std::vector<double>& path, double pull) {
  if (law == "paper") {
    const Result<Fold> fold = SolveFold(layout, design.base_width, design.closed_angle, pull);
    if (!fold.ok()) return fold.error();
    const Fold& f = fold.value();
    return FoldAnswer{f.angle, f.closed, f.tendon_length, f.scale, std::nullopt, std::nullopt, std::nullopt};
  }
  if (design.tendon_friction > 0) return AnswerWithFriction(design, path, pull);
  const Result<ExactFold> fold =
      SolveExactFold(layout, HingeStiffness(design, layout), design.rest_angle, design.closed_angle, pull);
  if (!fold.ok()) return fold.error();
  const ExactFold& f = fold.value();
  return FoldAnswer{f.angle, f.closed, f.tendon_length, std::nullopt, f.tension, f.slack, std::nullopt};
}

}  // namespace tendril::cli
