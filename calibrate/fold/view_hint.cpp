#include "calibrate/fold/view_hint.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "model/median.h"

namespace tendril {
namespace {

constexpr int kFewestRepeats = 8;
constexpr double kMostFrames = 2000;  // looked at; of more, some stand for all

// How a node's sigma depends on how many cameras saw its facet: medians of these data.
class SigmaByCameras {
 public:
  explicit SigmaByCameras(const FitFrames& frames) {
    std::map<int, std::vector<double>> by_count;
    for (const FitFrame& frame : frames.frames) {
      if (frame.observed->cameras.size() == 0) continue;
      for (Eigen::Index i = 0; i < frame.seen.index.size(); ++i) {
        const int count = frame.observed->cameras[frame.seen.index[i]];
        if (count > 0) by_count[count].push_back(frame.seen.sigma[i]);
      }
    }
    double least = std::numeric_limits<double>::infinity();
    for (auto& [count, sigmas] : by_count) {
      if (sigmas.size() < 20) continue;  // no median worth the name
      least = std::min(least, Median(std::move(sigmas)));
      median_[count] = least;  // another view never harms
    }
  }
  bool known() const { return !median_.empty(); }
  // Beyond what these data have, as of so many independent views.
  double At(int cameras) const {
    const auto above = median_.upper_bound(cameras);
    if (above == median_.begin()) return above->second;
    const auto& [count, sigma] = *std::prev(above);
    const double independent = sigma * std::sqrt(static_cast<double>(count) / cameras);
    return above == median_.end() ? independent : std::max(independent, above->second);
  }

 private:
  std::map<int, double> median_;
};

// So many seen nodes, not filled in.
SeenNodes Unfilled(std::size_t count) {
  const auto n = static_cast<Eigen::Index>(count);
  SeenNodes nodes;
  nodes.index.resize(n);
  nodes.sigma.resize(n);
  nodes.points.resize(3, n);
  return nodes;
}

// What is seen of a frame in one of the cases: as it is, perfectly, or with a place's views.
enum { kNow = -1, kPerfect = -2 };
SeenNodes SeenWith(const FitFrame& frame, const NodeMotion& motion, int place, const SigmaByCameras& sigmas) {
  if (place == kNow) return frame.seen;
  const int nodes = static_cast<int>(motion.nodes.cols());
  const FoldObservation& o = *frame.observed;
  if (place != kPerfect && (o.cameras.size() != nodes || o.further.cols() != nodes)) return frame.seen;
  std::vector<std::pair<int, double>> list;
  Eigen::Index at = 0;
  for (int node = 0; node < nodes; ++node) {
    const bool seen = at < frame.seen.index.size() && frame.seen.index[at] == node;
    double sigma = seen ? frame.seen.sigma[at++] : std::numeric_limits<double>::quiet_NaN();
    if (place == kPerfect) {
      sigma = 0;
    } else if (const int more = o.further(place, node); more > 0) {
      const int before = o.cameras[node];
      if (seen && before > 0) sigma *= sigmas.At(before + more) / sigmas.At(before);
      if (!seen) sigma = sigmas.At(std::max(before, 0) + more);
    }
    if (std::isfinite(sigma)) list.emplace_back(node, sigma);
  }
  SeenNodes with = Unfilled(list.size());
  for (Eigen::Index i = 0; i < with.index.size(); ++i) {
    const auto& [node, sigma] = list[static_cast<std::size_t>(i)];
    with.index[i] = node;
    with.sigma[i] = sigma;
    with.points.col(i) = motion.nodes.col(node);  // slopes do not depend on it
  }
  return with;
}

// Sums over the frames that share a nuisance.
struct NuisanceSums {
  SharedVector mixed = SharedVector::Zero();
  double information = 0;
};

// One case, first its information, then what the errors do to the parameter through it.
struct Outlook {
  Information information{};
  std::vector<NuisanceSums> nuisances;
  SharedVector influence = SharedVector::Zero();           // row of the inverse information
  double pictures = 0;                                     // variance by the stated sigmas
  std::map<std::pair<int, int>, Eigen::VectorXd> creases;  // by trial and tentacle: share of each crease

  double OfCreases() const {
    double sum = 0;
    for (const auto& [key, share] : creases) sum += share.squaredNorm();
    return sum;
  }
};

void AddInformation(const FitFrame& frame, const FrameResidual& at, Outlook& outlook) {
  const SharedMatrix own = at.slope.transpose() * at.slope;
  outlook.information.total += own;
  if (frame.nuisance < 0) return;
  NuisanceSums& sums = outlook.nuisances[static_cast<std::size_t>(frame.nuisance)];
  sums.mixed += at.slope.transpose() * at.nuisance_slope;
  sums.information += at.nuisance_slope.squaredNorm();
}

bool Close(const HeldParameters& held, int parameter, Outlook& outlook) {
  for (const NuisanceSums& sums : outlook.nuisances) {
    if (sums.information > 0)
      outlook.information.total -= sums.mixed * sums.mixed.transpose() / sums.information;
  }
  const SharedMatrix inverse = NaiveCovariance(outlook.information, 1, held);
  for (int i = 0; i < kShared; ++i) {
    outlook.influence[i] = held[static_cast<std::size_t>(i)] ? 0 : inverse(parameter, i);
  }
  return outlook.influence.allFinite();
}

// How the estimate follows each row.
Eigen::VectorXd WeightOfRows(const FitFrame& frame, const FrameResidual& at, const Outlook& outlook) {
  Eigen::VectorXd weight = at.slope * outlook.influence;
  if (frame.nuisance < 0) return weight;
  const NuisanceSums& sums = outlook.nuisances[static_cast<std::size_t>(frame.nuisance)];
  if (sums.information > 0)
    weight -= outlook.influence.dot(sums.mixed) / sums.information * at.nuisance_slope;
  return weight;
}

// How the estimate follows each seen node: weight of the rows through their directions.
//   places  of the nodes, whatever frame the answer is wanted in                              (3, seen)
Eigen::Matrix3Xd FollowedNodes(const std::vector<NodePair>& pairs, const Eigen::VectorXd& weight,
                               const Eigen::VectorXd& row_sigma, const Eigen::Matrix3Xd& places) {
  Eigen::Matrix3Xd followed = Eigen::Matrix3Xd::Zero(3, places.cols());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Eigen::Index row = static_cast<Eigen::Index>(p);
    const Eigen::Vector3d direction = (places.col(pairs[p].b) - places.col(pairs[p].a)).normalized();
    followed.col(pairs[p].a) += weight[row] / row_sigma[row] * direction;
    followed.col(pairs[p].b) -= weight[row] / row_sigma[row] * direction;
  }
  return followed;
}

double VarianceAlone(const Eigen::Matrix3Xd& followed, const SeenNodes& seen) {
  return (followed.colwise().squaredNorm().transpose().array() * seen.sigma.array().square()).sum();
}

// By the covariance of a frame as it was seen.
double VarianceTogether(const Eigen::Matrix3Xd& followed, const SeenNodes& seen,
                        const Eigen::MatrixXd& factor) {
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(factor.cols());
  for (Eigen::Index i = 0; i < seen.index.size(); ++i)
    sum += followed.col(i).transpose() * factor.middleRows(3 * seen.index[i], 3);
  return sum.squaredNorm();
}

Eigen::VectorXd RowSigma(const std::vector<NodePair>& pairs, const SeenNodes& seen, double model_error) {
  Eigen::VectorXd sigma(static_cast<Eigen::Index>(pairs.size()));
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const double a = seen.sigma[pairs[p].a];
    const double b = seen.sigma[pairs[p].b];
    sigma[static_cast<Eigen::Index>(p)] = std::sqrt(a * a + b * b + 2 * model_error * model_error);
  }
  return sigma;
}

Eigen::Matrix3Xd ModelNodes(const SeenNodes& seen, const NodeMotion& motion) {
  Eigen::Matrix3Xd nodes(3, seen.index.size());
  for (Eigen::Index i = 0; i < seen.index.size(); ++i) nodes.col(i) = motion.nodes.col(seen.index[i]);
  return nodes;
}

// Rows span few creases, so one direction of motion can stand for every kFoldDirections-th crease.
NodeMotion MotionByCreases(const FitFrame& frame, FoldTangent fold) {
  fold.slope.setZero();
  for (Eigen::Index i = 0; i < fold.angle.size(); ++i) fold.slope(i, i % kFoldDirections) = fold.angle[i];
  return MoveNodes(*frame.layout, fold);
}

void AddCreases(const std::vector<NodePair>& pairs, const Eigen::VectorXd& weight,
                const Eigen::VectorXd& row_sigma, const SeenNodes& seen, const NodeMotion& by_crease,
                Eigen::VectorXd& share) {
  if (share.size() == 0) share.setZero(by_crease.nodes.cols() - 1);
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Eigen::Index row = static_cast<Eigen::Index>(p);
    const int a = seen.index[pairs[p].a];
    const int b = seen.index[pairs[p].b];
    const Eigen::Vector3d direction = (by_crease.nodes.col(b) - by_crease.nodes.col(a)).normalized();
    for (int crease = a; crease < b; ++crease) {
      const Eigen::Matrix3Xd& velocity =
          by_crease.velocity[static_cast<std::size_t>(crease % kFoldDirections)];
      share[crease] += weight[row] / row_sigma[row] * direction.dot(velocity.col(b) - velocity.col(a));
    }
  }
}

std::pair<int, int> TentacleOf(const FitFrame& frame) { return {frame.trial, frame.observed->tentacle}; }

// The nodes that both have, with a common sigma; points of the first.
SeenNodes Common(const SeenNodes& first, const SeenNodes& second) {
  std::vector<std::pair<Eigen::Index, Eigen::Index>> both;
  for (Eigen::Index i = 0, j = 0; i < first.index.size() && j < second.index.size();) {
    if (first.index[i] == second.index[j]) both.emplace_back(i, j);
    const bool advance_first = first.index[i] <= second.index[j];
    const bool advance_second = second.index[j] <= first.index[i];
    i += advance_first ? 1 : 0;
    j += advance_second ? 1 : 0;
  }
  SeenNodes common = Unfilled(both.size());
  for (Eigen::Index i = 0; i < common.index.size(); ++i) {
    const auto& [a, b] = both[static_cast<std::size_t>(i)];
    common.index[i] = first.index[a];
    common.points.col(i) = first.points.col(a);
    common.sigma[i] = std::sqrt(0.5 * (first.sigma[a] * first.sigma[a] + second.sigma[b] * second.sigma[b]));
  }
  return common;
}

// By how much the pictures' errors are larger (in variance) than the stated sigmas, as independent errors,
// would have them. None: hardly a frame repeats.
std::optional<double> MeasuredNoise(const FitRun& run, const FoldFitOptions& options, const Outlook& now) {
  std::map<std::pair<int, int>, const FitFrame*> last;
  double squares = 0;
  double foretold = 0;
  int repeats = 0;
  for (const FitFrame& frame : run.frames.frames) {
    if (frame.source != PullSource::kSettled) continue;
    const FitFrame*& before = last[TentacleOf(frame)];
    if (before != nullptr && before->commanded_pull == frame.commanded_pull && frame.commanded_pull > 0) {
      const std::optional<FoldTangent> fold = FoldOf(frame, run.solution.parameters, 0);
      FitFrame one = frame;
      FitFrame other = *before;
      one.seen = Common(frame.seen, before->seen);
      other.seen = Common(before->seen, frame.seen);
      const std::vector<NodePair> pairs = PairsOf(one.seen, options.residual.creases);
      if (fold && !pairs.empty()) {
        const NodeMotion motion = MoveNodes(*frame.layout, *fold);
        const FrameResidual at = ResidualOfFrame(one, motion, run.solution.parameters, 0, options.residual);
        const FrameResidual then =
            ResidualOfFrame(other, motion, run.solution.parameters, 0, options.residual);
        const Eigen::VectorXd weight = WeightOfRows(frame, at, now);
        const auto bounded = [&](const Eigen::VectorXd& value) {
          return value.cwiseMax(-run.huber).cwiseMin(run.huber).eval();
        };
        const double apart = weight.dot(bounded(at.value) - bounded(then.value));
        squares += apart * apart;
        const Eigen::Matrix3Xd followed =
            FollowedNodes(pairs, weight, RowSigma(pairs, one.seen, options.residual.model_error),
                          ModelNodes(one.seen, motion));
        foretold += 2 * VarianceAlone(followed, one.seen);
        ++repeats;
      }
    }
    before = &frame;
  }
  if (repeats < kFewestRepeats || !(foretold > 0)) return std::nullopt;
  return squares / foretold;
}

// The same by the covariance that frames state along the curve. None: no frame states it.
std::optional<double> StatedNoise(const FitRun& run, const FoldFitOptions& options, const Outlook& now) {
  double together = 0;
  double alone = 0;
  for (const FitFrame& frame : run.frames.frames) {
    const Eigen::MatrixXd& factor = frame.observed->covariance_factor;
    if (factor.size() == 0) continue;
    const double nuisance = NuisanceOf(frame, run.solution.nuisances);
    const std::optional<FoldTangent> fold = FoldOf(frame, run.solution.parameters, nuisance);
    if (!fold) continue;
    const NodeMotion motion = MoveNodes(*frame.layout, *fold);
    const std::vector<NodePair> pairs = PairsOf(frame.seen, options.residual.creases);
    const Eigen::VectorXd weight = WeightOfRows(
        frame, ResidualOfFrame(frame, motion, run.solution.parameters, nuisance, options.residual), now);
    const Eigen::VectorXd sigma = RowSigma(pairs, frame.seen, options.residual.model_error);
    alone += VarianceAlone(FollowedNodes(pairs, weight, sigma, ModelNodes(frame.seen, motion)), frame.seen);
    together += VarianceTogether(FollowedNodes(pairs, weight, sigma, frame.seen.points), frame.seen, factor);
  }
  if (!(alone > 0)) return std::nullopt;
  return together / alone;
}

}  // namespace

std::optional<ViewHint> ViewHintOf(const FitRun& run, const FoldFitOptions& options, int parameter) {
  if (!run.fit.clustered || options.residual.kind != ShapeResidualKind::kLocalDistances ||
      options.residual.creases > kFoldDirections) {
    return std::nullopt;
  }
  const SharedMatrix clustered = ClusteredCovariance(run.information, run.held, run.at_bound);
  const double variance = clustered(parameter, parameter);
  if (!(variance > 0)) return std::nullopt;
  const SigmaByCameras sigmas(run.frames);

  std::vector<int> places = {kNow, kPerfect};
  for (int place = 0; sigmas.known() && place < static_cast<int>(options.places.size()); ++place)
    places.push_back(place);
  std::vector<Outlook> outlooks(places.size());
  for (Outlook& outlook : outlooks) outlook.nuisances.resize(run.solution.nuisances.size());
  // Spread by the golden ratio, which beats with no number of frames per trial.
  std::vector<const FitFrame*> chosen;
  const double part = kMostFrames / static_cast<double>(run.frames.frames.size());
  for (std::size_t f = 0; f < run.frames.frames.size(); ++f) {
    const double turns = 0.6180339887498949 * static_cast<double>(f);
    if (turns - std::floor(turns) < part) chosen.push_back(&run.frames.frames[f]);
  }
  const double share = static_cast<double>(chosen.size()) / static_cast<double>(run.frames.frames.size());
  const auto each = [&](const auto& deed, const auto& per_frame) {
    for (const FitFrame* const of_run : chosen) {
      const FitFrame& frame = *of_run;
      const double nuisance = NuisanceOf(frame, run.solution.nuisances);
      const std::optional<FoldTangent> fold = FoldOf(frame, run.solution.parameters, nuisance);
      if (!fold) continue;
      const NodeMotion motion = MoveNodes(*frame.layout, *fold);
      const NodeMotion by_crease = per_frame(frame, *fold);
      FitFrame with = frame;
      for (std::size_t i = 0; i < places.size(); ++i) {
        with.seen = SeenWith(frame, motion, places[i], sigmas);
        deed(with, motion, by_crease,
             ResidualOfFrame(with, motion, run.solution.parameters, nuisance, options.residual), outlooks[i]);
      }
    }
  };
  each([](const FitFrame& frame, const NodeMotion&, const NodeMotion&, const FrameResidual& at,
          Outlook& outlook) { AddInformation(frame, at, outlook); },
       [](const FitFrame&, const FoldTangent&) { return NodeMotion{}; });
  for (Outlook& outlook : outlooks) {
    if (!Close(run.held, parameter, outlook)) return std::nullopt;
  }
  const double model_error = options.residual.model_error;
  each(
      [&](const FitFrame& frame, const NodeMotion& motion, const NodeMotion& by_crease,
          const FrameResidual& at, Outlook& outlook) {
        const std::vector<NodePair> pairs = PairsOf(frame.seen, options.residual.creases);
        const Eigen::VectorXd weight = WeightOfRows(frame, at, outlook);
        const Eigen::VectorXd sigma = RowSigma(pairs, frame.seen, model_error);
        const Eigen::Matrix3Xd followed = FollowedNodes(pairs, weight, sigma, ModelNodes(frame.seen, motion));
        outlook.pictures += VarianceAlone(followed, frame.seen);
        AddCreases(pairs, weight, sigma, frame.seen, by_crease, outlook.creases[TentacleOf(frame)]);
      },
      MotionByCreases);

  ViewHint hint;
  const Outlook& now = outlooks[0];
  const std::optional<double> measured = MeasuredNoise(run, options, now);
  double factor = 1;
  if (measured) {
    hint.known_from = PictureErrors::kRepeats;
    factor = *measured;
  } else if (const std::optional<double> stated = StatedNoise(run, options, now)) {
    hint.known_from = PictureErrors::kCovariance;
    factor = *stated;
  }
  // All frames have errors of their own, not only those that were looked at. The trials' scatter is known
  // from few trials: by chance it may be less than the pictures alone would give.
  hint.picture_share = std::min(1.0, factor * share * now.pictures / variance);
  const auto ratio = [&](const Outlook& then) {
    const double of_creases = now.OfCreases() > 0 ? then.OfCreases() / now.OfCreases() : 1;
    return std::sqrt((1 - hint.picture_share) * of_creases +
                     hint.picture_share * (now.pictures > 0 ? then.pictures / now.pictures : 1));
  };
  hint.perfect_ratio = ratio(outlooks[1]);
  for (std::size_t i = 2; i < outlooks.size(); ++i) {
    hint.error_ratio.push_back(ratio(outlooks[i]));
    const int place = static_cast<int>(i) - 2;
    if (hint.best < 0 || hint.error_ratio.back() < hint.error_ratio[static_cast<std::size_t>(hint.best)])
      hint.best = place;
  }
  return hint;
}

}  // namespace tendril
