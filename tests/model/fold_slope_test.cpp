// model/fold/fold_slope.h: against differences of a program of its own in fifty digits, from the design to
// the holes.
#include "model/fold/fold_slope.h"

#include <gtest/gtest.h>

#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "model/fold/facet_chain.h"
#include "tests/support/random_design.h"

namespace tendril {
namespace {

using Digits50 = boost::multiprecision::cpp_bin_float_50;
using Vector = std::array<Digits50, 3>;

struct Parameter {
  const char* name;
  double TentacleDesign::*of_design;  // null: the pull
  double DesignChange::*of_change;
};

const std::vector<Parameter> kParameters = {
    {"length", &TentacleDesign::length, &DesignChange::length},
    {"base_width", &TentacleDesign::base_width, &DesignChange::base_width},
    {"taper", &TentacleDesign::taper, &DesignChange::taper},
    {"unit_length", &TentacleDesign::unit_length, &DesignChange::unit_length},
    {"spacing_ratio", &TentacleDesign::spacing_ratio, &DesignChange::spacing_ratio},
    {"alpha", &TentacleDesign::alpha, &DesignChange::alpha},
    {"beta", &TentacleDesign::beta, &DesignChange::beta},
    {"thickness", &TentacleDesign::thickness, &DesignChange::thickness},
    {"youngs_modulus", &TentacleDesign::youngs_modulus, &DesignChange::youngs_modulus},
    {"crease_length", &TentacleDesign::crease_length, &DesignChange::crease_length},
    {"rest_angle", &TentacleDesign::rest_angle, &DesignChange::rest_angle},
    {"stiffness_exponent", &TentacleDesign::stiffness_exponent, &DesignChange::stiffness_exponent},
    {"stiffness_ratio", &TentacleDesign::stiffness_ratio, &DesignChange::stiffness_ratio},
    {"pull", nullptr, &DesignChange::pull},
};

// A design in fifty digits, by parameter number.
struct Wide {
  std::vector<Digits50> p;
  const Digits50& operator[](const std::string& name) const {
    for (size_t i = 0; i < kParameters.size(); ++i) {
      if (name == kParameters[i].name) return p[i];
    }
    throw std::out_of_range(name);
  }
};

struct WideCrease {
  Digits50 d, a, width, stiffness;
};

std::vector<WideCrease> WideCreases(const Wide& design, int creases) {
  const Digits50 b = design["unit_length"] / (1 + design["spacing_ratio"]);
  const Digits50 c = design["unit_length"] - b;
  Digits50 used = 0;
  for (int i = 0; i < creases; ++i) used += i % 2 == 0 ? b : c;
  Digits50 z = (design["length"] - used) / 2;  // from the cut end
  std::vector<WideCrease> all;
  for (int i = 0; i < creases; ++i) {
    const Digits50 spacing = i % 2 == 0 ? b : c;
    WideCrease crease{spacing / 2, i % 2 == 0 ? design["alpha"] : design["beta"], 0, 0};
    const Digits50 place = z + spacing / 2;
    crease.width = design["base_width"] * (1 + (design["taper"] - 1) * place / design["length"]);
    crease.stiffness = design["base_width"] *
                       pow(crease.width / design["base_width"], design["stiffness_exponent"]) *
                       (i % 2 == 0 ? Digits50(1) : design["stiffness_ratio"]);
    z += spacing;
    all.push_back(crease);
  }
  return all;
}

// Root of a rising or falling function by the secant method, from a good start.
Digits50 Root(const std::function<Digits50(const Digits50&)>& f, const Digits50& start) {
  Digits50 x0 = start, x1 = start * (1 + Digits50("1e-9")) + Digits50("1e-30");
  Digits50 f0 = f(x0), f1 = f(x1);
  for (int i = 0; i < 40 && f1 != f0; ++i) {
    const Digits50 x2 = x1 - f1 * (x1 - x0) / (f1 - f0);
    x0 = x1;
    f0 = f1;
    x1 = x2;
    if (abs(x1 - x0) <= Digits50("1e-45") * abs(x1)) break;
    f1 = f(x1);
  }
  return x1;
}

std::vector<Digits50> WidePaper(const Wide& design, const Fold& start, double closed_angle) {
  const auto creases = WideCreases(design, static_cast<int>(start.angle.size()));
  const auto angles = [&](const Digits50& k) {
    std::vector<Digits50> phi;
    for (const WideCrease& c : creases) {
      const Digits50 angle = k * c.d / c.stiffness;
      phi.push_back(angle < closed_angle ? angle : Digits50(closed_angle));
    }
    return phi;
  };
  const Digits50 k = Root(
      [&](const Digits50& at) {
        const auto phi = angles(at);
        Digits50 off = 0;
        for (size_t i = 0; i < phi.size(); ++i) {
          off += 2 * creases[i].d * (cos(phi[i]) - (1 - design["pull"]));
        }
        return off;
      },
      start.scale);
  return angles(k);
}

// Creases that are flat or closed in `start` stay so.
std::vector<Digits50> WideExact(const Wide& design, const ExactFold& start, const TentacleDesign& narrow) {
  const auto creases = WideCreases(design, static_cast<int>(start.angle.size()));
  const auto distance = [](const WideCrease& c, const Digits50& phi) {
    const Digits50 s = sin(c.a) * sin(phi);
    return Digits50(2 * c.d * sqrt(1 - s * s));
  };
  const auto angles = [&](const Digits50& tension) {
    std::vector<Digits50> phi;
    for (size_t i = 0; i < creases.size(); ++i) {
      const WideCrease& c = creases[i];
      const double at = start.angle[static_cast<Eigen::Index>(i)];
      if (at == 0 || at == narrow.closed_angle) {
        phi.emplace_back(at);
        continue;
      }
      const Digits50 hinge = design["youngs_modulus"] * c.stiffness * pow(design["thickness"], 3) /
                             (12 * design["crease_length"] * sin(c.a));
      phi.push_back(Root(
          [&](const Digits50& x) {
            const Digits50 ss = sin(c.a) * sin(c.a);
            const Digits50 moment = ss * sin(x) * cos(x) / sqrt(1 - ss * sin(x) * sin(x));
            return Digits50(2 * hinge * (x - design["rest_angle"]) / (c.d * moment) - tension);
          },
          at));
    }
    return phi;
  };
  const Digits50 tension = Root(
      [&](const Digits50& at) {
        const auto phi = angles(at);
        Digits50 off = 0;
        for (size_t i = 0; i < phi.size(); ++i) {
          off += distance(creases[i], phi[i]) - (1 - design["pull"]) * 2 * creases[i].d;
        }
        return off;
      },
      start.tension);
  return angles(tension);
}

Vector Rotated(const Vector& axis, const Digits50& angle, const Vector& v) {
  const Digits50 c = cos(angle), s = sin(angle);
  const Digits50 dot = axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2];
  Vector out;
  for (size_t k = 0; k < 3; ++k) {
    const size_t l = (k + 1) % 3, m = (k + 2) % 3;
    out[k] = v[k] * c + (axis[l] * v[m] - axis[m] * v[l]) * s + axis[k] * dot * (1 - c);
  }
  return out;
}

// Folding crease by crease from the tip: each turns all that lies beyond it, as hands would do it.
std::vector<Vector> WideHoles(const Wide& design, const std::vector<Digits50>& phi) {
  const auto creases = WideCreases(design, static_cast<int>(phi.size()));
  std::vector<Digits50> hole = {0};
  for (const WideCrease& c : creases) hole.push_back(hole.back() + 2 * c.d);
  std::vector<Vector> at;
  for (const Digits50& z : hole) at.push_back({0, 0, z});
  Vector normal = {1, 0, 0};  // facet 0's, to be turned half-way about crease 0
  for (size_t i = phi.size(); i-- > 0;) {
    const WideCrease& c = creases[i];
    const Vector axis = {0, sin(c.a), cos(c.a)};
    const Digits50 angle = (i % 2 == 0 ? -2 : 2) * phi[i];
    const Digits50 centre = hole[i] + c.d;
    for (size_t k = i + 1; k < at.size(); ++k) {
      Vector from = at[k];
      from[2] -= centre;
      at[k] = Rotated(axis, angle, from);
      at[k][2] += centre;
    }
    if (i == 0) normal = Rotated(axis, angle / 2, normal);
  }
  // The frame of the first segment.
  const Digits50 length = sqrt(at[1][0] * at[1][0] + at[1][1] * at[1][1] + at[1][2] * at[1][2]);
  const Vector d3 = {at[1][0] / length, at[1][1] / length, at[1][2] / length};
  const Vector d2 = {d3[1] * normal[2] - d3[2] * normal[1], d3[2] * normal[0] - d3[0] * normal[2],
                     d3[0] * normal[1] - d3[1] * normal[0]};
  for (Vector& p : at) {
    const auto along = [&](const Vector& d) { return Digits50(d[0] * p[0] + d[1] * p[1] + d[2] * p[2]); };
    p = {along(normal), along(d2), along(d3)};
  }
  return at;
}

Wide WideOf(const TentacleDesign& design, double pull) {
  Wide wide;
  for (const Parameter& parameter : kParameters) {
    wide.p.emplace_back(parameter.of_design != nullptr ? design.*parameter.of_design : pull);
  }
  return wide;
}

using WideSolve = std::function<std::vector<Digits50>(const Wide&)>;

// Compares d phi and d holes along one parameter with central differences in fifty digits.
void Compare(const TentacleDesign& design, double pull, size_t parameter, const WideSolve& solve,
             const Eigen::VectorXd& angle_slope, const Eigen::Matrix3Xd& hole_slopes) {
  const Digits50 h("1e-17");
  Wide after = WideOf(design, pull), before = after;
  after.p[parameter] += h * abs(after.p[parameter]);
  before.p[parameter] -= h * abs(before.p[parameter]);
  const Digits50 step = after.p[parameter] - before.p[parameter];
  const auto phi_after = solve(after), phi_before = solve(before);
  const auto holes_after = WideHoles(after, phi_after), holes_before = WideHoles(before, phi_before);
  Eigen::VectorXd expected(angle_slope.size());
  for (Eigen::Index i = 0; i < expected.size(); ++i) {
    const auto k = static_cast<size_t>(i);
    expected[i] = static_cast<double>((phi_after[k] - phi_before[k]) / step);
  }
  Eigen::Matrix3Xd moves(3, hole_slopes.cols());
  for (Eigen::Index i = 0; i < moves.cols(); ++i) {
    for (Eigen::Index k = 0; k < 3; ++k) {
      const auto n = static_cast<size_t>(i), m = static_cast<size_t>(k);
      moves(k, i) = static_cast<double>((holes_after[n][m] - holes_before[n][m]) / step);
    }
  }
  // Per relative change of the parameter: rad and m.
  const auto size = std::abs(static_cast<double>(WideOf(design, pull).p[parameter]));
  const char* name = kParameters[parameter].name;
  EXPECT_LE(size * (angle_slope - expected).norm(), 1e-11 * size * expected.norm() + 1e-12) << name;
  EXPECT_LE(size * (hole_slopes - moves).norm(), 1e-11 * size * moves.norm() + 1e-13) << name;
}

std::vector<TentacleDesign> Designs() {
  TentacleDesign paper;
  paper.holes = 10;
  paper.length = 0.160;
  TentacleDesign oblique = paper;  // both families oblique, uneven stiffness
  oblique.alpha = 1.9;
  oblique.beta = 1.1;
  oblique.taper = 0.7;
  oblique.stiffness_exponent = 1.4;
  oblique.stiffness_ratio = 0.6;
  oblique.spacing_ratio = 0.8;
  TentacleDesign steep = paper;  // creases of very different load: some flat or closed
  steep.taper = 0.3;
  steep.closed_angle = 1.2;
  return {paper, oblique, steep};
}

TEST(SlopeOf, PaperLawsShapeAgainstFiftyDigits) {
  for (const TentacleDesign& design : Designs()) {
    for (const double pull : {1e-6, 0.3, 0.55}) {
      const TentacleLayout layout = LayOut(design).value();
      const Fold fold = SolveFold(design, pull).value();
      for (size_t p = 0; p < kParameters.size(); ++p) {
        if (std::string("rest_angle") == kParameters[p].name) continue;  // not of this law
        DesignChange change;
        change.*kParameters[p].of_change = 1;
        const FoldChange of = ChangeForPaperLaw(design, layout, change);
        const Eigen::VectorXd slope = SlopeOf(layout, fold, of);
        Compare(
            design, pull, p, [&](const Wide& w) { return WidePaper(w, fold, design.closed_angle); }, slope,
            HoleSlopes(layout, fold.angle, slope, of));
      }
    }
  }
}

TEST(SlopeOf, ExactLawsShapeAgainstFiftyDigits) {
  int flat = 0, closed = 0;
  for (TentacleDesign design : Designs()) {
    for (const double rest : {0.0, 0.2}) {
      design.rest_angle = rest;
      for (const double pull : {0.1, 0.3}) {
        const TentacleLayout layout = LayOut(design).value();
        const ExactFold fold = SolveExactFold(design, pull).value();
        ASSERT_FALSE(fold.slack);
        flat += (fold.angle.array() == 0).count() > 0 ? 1 : 0;
        closed += fold.closed.empty() ? 0 : 1;
        if (fold.angle[0] == design.closed_angle) continue;
        for (size_t p = 0; p < kParameters.size(); ++p) {
          if (rest == 0 && std::string("rest_angle") == kParameters[p].name) continue;  // one-sided
          DesignChange change;
          change.*kParameters[p].of_change = 1;
          const FoldChange of = ChangeForExactLaw(design, layout, change);
          const ExactSlope slope = SlopeOf(layout, fold, rest, design.closed_angle, of);
          Compare(
              design, pull, p, [&](const Wide& w) { return WideExact(w, fold, design); }, slope.angle,
              HoleSlopes(layout, fold.angle, slope.angle, of));
        }
      }
    }
  }
  EXPECT_GE(flat, 3);
  EXPECT_GE(closed, 2);
}

// The forward error is a rounding error's consequence: 1e-14 times how much the answer moves for a relative
// change of the pull. Pulls come as close to where creases begin to fold as doubles tell.
TEST(SolveExactFold, ForwardErrorIsRoundingTimesTheConditionNumber) {
  TentacleDesign design;
  design.holes = 10;
  design.length = 0.160;
  design.taper = 1;
  design.beta = design.alpha;
  const TentacleLayout layout = LayOut(design).value();
  // The short creases begin at T = 2 B / d_short, where the long ones closed: 5 of them, each 20 mm.
  const double begins = 5 * 0.02 / FlatTendonLength(layout);
  double worst = 0, largest_condition = 0;
  for (const double beyond : {1e-3, 1e-6, 1e-9, 1e-12, 1e-14}) {
    const double pull = begins * (1 + beyond);
    const ExactFold fold = SolveExactFold(design, pull).value();
    const auto truth = WideExact(WideOf(design, pull), fold, design);
    DesignChange change;
    change.pull = 1;
    const ExactSlope slope =
        SlopeOf(layout, fold, 0, design.closed_angle, ChangeForExactLaw(design, layout, change));
    for (Eigen::Index i = 0; i < fold.angle.size(); ++i) {
      if (fold.angle[i] == 0 || fold.angle[i] == design.closed_angle) continue;
      const double exact = static_cast<double>(truth[static_cast<size_t>(i)]);
      const double condition = std::abs(pull * slope.angle[i] / exact);
      const double error = std::abs(fold.angle[i] - exact) / exact;
      EXPECT_LE(error, 1e-14 * (1 + condition)) << "crease " << i << ", " << beyond;
      worst = std::max(worst, error);
      largest_condition = std::max(largest_condition, condition);
    }
  }
  EXPECT_GT(largest_condition, 1e9) << "the start of a fold was not met";
  EXPECT_LT(worst, 0.1);
}

// Against central differences, extrapolated once, of the solver itself.
TEST(SlopeOf, ExactLawsIsTheDifferencesLimitOverTheExtremes) {
  std::mt19937_64 random(31);
  int compared = 0;
  for (int trial = 0; trial < 40; ++trial) {
    TentacleDesign design = test::RandomDesign(random);
    design.stiffness_ratio = 0.6 + 0.2 * (trial % 5);
    const TentacleLayout layout = LayOut(design).value();
    const Eigen::VectorXd stiffness = HingeStiffness(design, layout);
    const double rest = trial % 2 == 0 ? 0 : 0.15;
    const double pull = 0.7 * LargestExactPull(layout, design.closed_angle);
    FoldChange change;
    change.pull = 0.3 * pull;
    change.log_stiffness = Eigen::VectorXd::Random(stiffness.size());
    change.rest_angle = rest > 0 ? 0.2 : 0;
    const auto at = [&](double h) {
      return SolveExactFold(layout, stiffness.array() * (h * change.log_stiffness.array()).exp(),
                            rest + h * change.rest_angle, design.closed_angle, pull + h * change.pull)
          .value();
    };
    const ExactFold fold = at(0);
    if (fold.slack || !std::isfinite(fold.tension)) continue;
    const auto difference = [&](double h) -> Eigen::VectorXd {
      return (at(h).angle - at(-h).angle) / (2 * h);
    };
    // A crease that begins or closes within the step has no difference to compare.
    const double h = 1e-5;
    bool smooth = at(h).closed == at(-h).closed;
    for (Eigen::Index i = 0; i < fold.angle.size(); ++i) {
      smooth = smooth && (at(h).angle[i] > rest) == (at(-h).angle[i] > rest) &&
               (fold.angle[i] == rest || fold.angle[i] - rest > 0.02);
    }
    if (!smooth) continue;
    ++compared;
    const ExactSlope slope = SlopeOf(layout, fold, rest, design.closed_angle, change);
    const Eigen::VectorXd expected = (4 * difference(0.5 * h) - difference(h)) / 3;
    EXPECT_LT((slope.angle - expected).norm(), 1e-7 * expected.norm()) << trial;
    EXPECT_NEAR(slope.log_tension, std::log(at(h).tension / at(-h).tension) / (2 * h),
                1e-6 * (1 + std::abs(slope.log_tension)));
  }
  EXPECT_GE(compared, 20);
}

}  // namespace
}  // namespace tendril
