#pragma once
// Shapes that are not exactly the model's, for testing the fit: a chain of its own (it shares no code with
// model/fold but the layout), with everything a little off, and a tracker's noise on top. One generator per
// trial, passed in.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "calibrate/fold/fold_fit.h"
#include "model/fold/design.h"

namespace tendril::test {

// 1-sigma unless it says uniform. Zero everywhere: the model itself.
struct Perturbation {
  double place = 0.15e-3;                              // of holes (along and across) and creases, m
  double crease_angle = 0.3 * std::numbers::pi / 180;  // rad
  double stiffness = 0.03;                             // of its logarithm, per crease
  double bend = 3.0 * std::numbers::pi / 180;  // of each facet about its width, creases making up for it, rad
  double wander = 0.3 * std::numbers::pi / 180;  // the same with nothing making up for it, rad
  double sag = 4.0 * std::numbers::pi / 180;     // largest turn toward gravity over the whole chain, rad
  double delay = 0.5;                            // s, uniform from 0, per tentacle
  double rate = 0.001875;                        // 1/s, uniform between minus and plus, per tentacle
};
inline constexpr Perturbation kExactly{0, 0, 0, 0, 0, 0, 0, 0};

struct TrackerNoise {
  double alone = 0.15e-3;  // per node and axis, m
  double along = 0.3e-3;   // per axis, correlated over `reach` nodes, m
  double reach = 8;
  double bridged = 0.08;  // share of nodes flagged interpolated, 1 mm worse
  double unseen = 0.02;   // share of nodes that are NaN
};
inline constexpr TrackerNoise kNoiseless{0, 0, 8, 0, 0};

struct TrialPlan {
  int tentacles = 4;
  double pull = 0.3;        // commanded at the end
  double pull_rate = 0.03;  // 1/s
  double frame_step = 1.2;  // s
  double duration = 13.2;   // s
};

struct FoldTruth {
  double pull_scale = 1;
  double stiffness_ratio = 1;
  double stiffness_exponent = 1;
};

using Random = std::mt19937_64;

inline double Normal(Random& random, double sigma) {
  return sigma == 0 ? 0 : std::normal_distribution<double>(0, sigma)(random);
}
inline double Uniform(Random& random, double low, double high) {
  return low == high ? low : std::uniform_real_distribution<double>(low, high)(random);
}

struct PerturbedTentacle {
  Eigen::VectorXd before, after;  // hole i to crease i; crease i to hole i+1, m      (creases)
  Eigen::VectorXd across;         // where hole i lies across the ribbon, m           (holes)
  Eigen::VectorXd angle;          // of the creases, rad
  Eigen::VectorXd lever;          // d_i / W_i
  Eigen::VectorXd bend, wander;   // rad                                              (facets)
  double sag = 0;                 // rad
  double closed_angle = 0;
};

inline PerturbedTentacle Draw(const TentacleDesign& design, const FoldTruth& truth, const Perturbation& how,
                              Random& random) {
  const TentacleLayout layout = LayOut(design).value();
  const Eigen::Index n = layout.crease_z.size();
  PerturbedTentacle t;
  t.closed_angle = design.closed_angle;
  t.before.resize(n);
  t.after.resize(n);
  t.angle.resize(n);
  t.lever.resize(n);
  t.across.resize(n + 1);
  t.bend.resize(n + 1);
  t.wander.resize(n + 1);
  Eigen::VectorXd hole = layout.hole_z;
  for (Eigen::Index i = 0; i <= n; ++i) {
    hole[i] += Normal(random, how.place);
    t.across[i] = Normal(random, how.place);
    t.bend[i] = Normal(random, how.bend);
    t.wander[i] = Normal(random, how.wander);
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const double crease = layout.crease_z[i] + Normal(random, how.place);
    t.before[i] = crease - hole[i];
    t.after[i] = hole[i + 1] - crease;
    t.angle[i] = layout.crease_angle[i] + Normal(random, how.crease_angle);
    const double width = design.base_width *
                         std::pow(layout.width[i] / design.base_width, truth.stiffness_exponent) *
                         (i % 2 == 1 ? truth.stiffness_ratio : 1.0) * std::exp(Normal(random, how.stiffness));
    t.lever[i] = layout.half_spacing[i] / width;
  }
  t.sag = Uniform(random, 0, how.sag);
  return t;
}

// Holes at the tendon's real pull, base at the origin pointing along +z, where gravity pulls too.
inline Eigen::Matrix3Xd HolesAt(const PerturbedTentacle& t, double pull) {
  const Eigen::Index n = t.lever.size();
  const auto shortening = [&](double k) {
    double sum = 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      sum += (t.before[i] + t.after[i]) * 2 *
             std::pow(std::sin(std::min(k * t.lever[i], t.closed_angle) / 2), 2);
    }
    return sum;
  };
  const double wanted = pull * (t.before + t.after).sum();
  double low = 0;
  double high = t.closed_angle / t.lever.minCoeff();
  for (int i = 0; i < 200; ++i) {
    const double middle = (low + high) / 2;
    (shortening(middle) < wanted ? low : high) = middle;
  }
  Eigen::Matrix3Xd holes(3, n + 1);
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  const auto rotation = [](double angle, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  };
  for (Eigen::Index i = 0; i <= n; ++i) {
    holes.col(i) = at + turn.col(1) * t.across[i];
    turn = turn * rotation(t.bend[i] + t.wander[i], Eigen::Vector3d::UnitY());
    const Eigen::Vector3d toward = turn.col(2).cross(Eigen::Vector3d::UnitZ());
    if (toward.norm() > 1e-12) {
      const double share = 2.0 * static_cast<double>(n - i) / static_cast<double>(n * n);
      turn = rotation(t.sag * share * toward.norm(), toward.normalized()) * turn;
    }
    if (i == n) break;
    at += turn.col(2) * t.before[i];
    const double phi = std::min(high * t.lever[i], t.closed_angle);
    turn = turn * rotation((i % 2 == 0 ? -2 : 2) * phi - 0.5 * (t.bend[i] + t.bend[i + 1]),
                           {0, std::sin(t.angle[i]), std::cos(t.angle[i])});
    at += turn.col(2) * t.after[i];
  }
  return holes;
}

// What a tracker would report of these holes.
inline void Observe(const Eigen::Matrix3Xd& holes, const TrackerNoise& noise, Random& random,
                    FoldObservation& o) {
  const Eigen::Index n = holes.cols();
  o.curve.points = holes;
  o.sigma.setConstant(n, std::max(1e-6, std::hypot(noise.alone, noise.along)));
  o.interpolated.setZero(n);
  const double keep = std::exp(-1 / noise.reach);
  Eigen::Vector3d drift(Normal(random, noise.along), Normal(random, noise.along),
                        Normal(random, noise.along));
  for (Eigen::Index i = 0; i < n; ++i) {
    const double step = noise.along * std::sqrt(1 - keep * keep);
    drift = keep * drift + Eigen::Vector3d(Normal(random, step), Normal(random, step), Normal(random, step));
    o.curve.points.col(i) += drift + Eigen::Vector3d(Normal(random, noise.alone), Normal(random, noise.alone),
                                                     Normal(random, noise.alone));
    const double lot = Uniform(random, 0, 1);
    if (lot < noise.bridged) {
      o.interpolated[i] = 1;
      o.curve.points.col(i) +=
          Eigen::Vector3d(Normal(random, 1e-3), Normal(random, 1e-3), Normal(random, 1e-3));
      o.sigma[i] = 1e-3;
    } else if (lot < noise.bridged + noise.unseen) {
      o.curve.points.col(i).setConstant(std::numeric_limits<double>::quiet_NaN());
      o.sigma[i] = std::numeric_limits<double>::quiet_NaN();
    }
  }
}

// A trial as a tracker would report it: pull ramps up and then stands still.
inline void AddTrial(const std::string& name, const TentacleDesign& design, const FoldTruth& truth,
                     const TrialPlan& plan, const Perturbation& how, const TrackerNoise& noise,
                     Random& random, std::vector<FoldObservation>& observations) {
  const double ramp_end = plan.pull / plan.pull_rate;
  for (int tentacle = 0; tentacle < plan.tentacles; ++tentacle) {
    FoldObservation o;
    o.trial = name;
    o.tentacle = tentacle;
    o.design = design;
    if (tentacle % 2 == 1) {
      o.design.alpha = std::numbers::pi - design.alpha;
      o.design.beta = std::numbers::pi - design.beta;
    }
    const PerturbedTentacle shape = Draw(o.design, truth, how, random);
    const double delay = Uniform(random, 0, how.delay);
    const double rate = plan.pull_rate + Uniform(random, -how.rate, how.rate);
    const Eigen::Matrix3d lab_turn =
        Eigen::Quaterniond(Normal(random, 1), Normal(random, 1), Normal(random, 1), Normal(random, 1))
            .normalized()
            .toRotationMatrix();
    const Eigen::Vector3d lab_place(Uniform(random, -1, 1), Uniform(random, -1, 1), Uniform(random, -1, 1));
    for (int frame = 0; frame * plan.frame_step <= plan.duration + 1e-9; ++frame) {
      o.time = frame * plan.frame_step;
      o.commanded_pull = std::min(plan.pull_rate * o.time, plan.pull);
      o.settled_for = o.time > ramp_end ? o.time - ramp_end : frame == 0 ? 1e9 : 0;
      o.steady_for = o.time > ramp_end ? o.time - ramp_end : frame == 0 ? 1e9 : o.time;
      const double pull = truth.pull_scale * std::clamp(rate * (o.time - delay), 0.0, plan.pull);
      const Eigen::Matrix3Xd holes = (lab_turn * HolesAt(shape, pull)).colwise() + lab_place;
      Observe(holes, noise, random, o);
      observations.push_back(o);
    }
  }
}

}  // namespace tendril::test
