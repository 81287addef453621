// Rods that move, lose their stability, wind about themselves and meet.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numbers>

#include "analysis/link/link.h"
#include "model/check.h"
#include "model/rods/rod_plain.h"
#include "tests/support/rod_closed_forms.h"
#include "tests/support/rod_validation.h"

namespace tendril::testing_support {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr SimulationLevel kStandard = SimulationLevel::kStandard;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::vector<double> Times(double from, double until, int count) {
  std::vector<double> times;
  for (int i = 0; i <= count; ++i) times.push_back(from + (until - from) * i / count);
  return times;
}

// Twice the angle's rate over as many whole swings of the first bending mode as there are.
double FirstModeRate(double finer) {
  const Scene scene = ValidationScene("first_mode", kStandard, finer);
  const Simulated run = RunScene(scene, Times(0, scene.duration, 2000));
  const double root = 1.875104068711961;
  const double ratio = (std::cosh(root) + std::cos(root)) / (std::sinh(root) + std::sin(root));
  std::vector<double> crossings;
  double before = 0, before_time = 0;
  for (std::size_t f = 0; f < run.curves[0].curves.size(); ++f) {
    const Matrix3Xd& points = run.curves[0].curves[f].points;
    double share = 0;  // of the mode, by its product with the deflection
    for (Index i = 0; i < points.cols(); ++i) {
      const double x = root * static_cast<double>(i) / static_cast<double>(points.cols() - 1);
      const double mode = std::cosh(x) - std::cos(x) - ratio * (std::sinh(x) - std::sin(x));
      share += (i + 1 == points.cols() ? 0.5 : 1) * mode * points(2, i);
    }
    const double time = run.curves[0].time[static_cast<Index>(f)];
    if (f > 0 && before < 0 && share >= 0) {
      crossings.push_back(before_time + (time - before_time) * before / (before - share));
    }
    before = share;
    before_time = time;
  }
  TENDRIL_CHECK(crossings.size() > 2);
  return 2 * pi * static_cast<double>(crossings.size() - 1) / (crossings.back() - crossings.front());
}

// How fast what each rod is off its equilibrium grows, 1/s: the slope of the logarithm of how far it moves
// between pictures, so that where the equilibrium lies does not count.
std::vector<double> GrowthRates(const Scene& scene, double from) {
  const Simulated run = RunScene(scene, Times(from, scene.duration, 50));
  std::vector<double> rates;
  for (const CurveSeries& rod : run.curves) {
    const Index count = rod.time.size() - 1;
    Eigen::VectorXd logs(count);
    for (Index f = 0; f < count; ++f) {
      const auto k = static_cast<std::size_t>(f);
      logs[f] = std::log((rod.curves[k + 1].points - rod.curves[k].points).norm());
    }
    const Eigen::VectorXd time = rod.time.head(count);
    const Eigen::VectorXd at = time.array() - time.mean();
    rates.push_back(at.dot(logs) / at.squaredNorm());
  }
  return rates;
}

// The twist, as a share of the reference, at which offsets neither grow nor fade: r (r + damping) is the
// mode's stiffness by its mass, with its sign changed; the cubic through four of them.
double CriticalShare(const Scene& scene, const std::vector<double>& shares,
                     const std::vector<double>& rates) {
  const auto cubic = [&](double x) {
    double sum = 0;
    for (std::size_t i = 0; i < shares.size(); ++i) {
      double term = rates[i] * (rates[i] + scene.rods[i].damping);
      for (std::size_t j = 0; j < shares.size(); ++j) {
        if (j != i) term *= (x - shares[j]) / (shares[i] - shares[j]);
      }
      sum += term;
    }
    return sum;
  };
  double low = shares.front(), high = shares.back();
  TENDRIL_CHECK(cubic(low) < 0 && cubic(high) > 0);
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (cubic(middle) < 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double StiffnessRatio(const SceneRod& rod) {
  return rod.design.youngs_modulus / (2 * rod.design.shear_modulus);
}

double TwistBuckling(double finer) {
  const Scene scene = ValidationScene("twist_buckling", kStandard, finer);
  const double reference = ClampedTwistMoment() * StiffnessRatio(scene.rods[0]);
  std::vector<double> shares;
  for (const SceneRod& rod : scene.rods) shares.push_back(rod.design.start_curvature.z() / reference);
  return CriticalShare(scene, shares, GrowthRates(scene, 0.5)) * reference;
}

double RingTwist(double finer) {
  const Scene scene = ValidationScene("ring", kStandard, finer);
  const double reference = 2 * pi * std::sqrt(3.0) * StiffnessRatio(scene.rods[0]);
  std::vector<double> shares;
  for (const SceneRod& rod : scene.rods) {
    shares.push_back(rod.tip_motion.spin.norm() * rod.tip_motion.until / reference);
  }
  return CriticalShare(scene, shares, GrowthRates(scene, 0.8)) * reference;
}

Figure WithOrder(bool quick, const std::string& quantity, double reference, int elements,
                 double (*of)(double)) {
  const double coarse = of(0.5);
  if (quick) return {quantity, coarse, reference, "standard", elements / 2};
  const double ours = of(1);
  return {quantity, ours, reference, "standard", elements, OrderOf(coarse, ours, of(2))};
}

// Tilts of the elements against the rod's line.
Eigen::VectorXd Tilts(const Matrix3Xd& points) {
  const Index n = points.cols() - 1;
  Eigen::VectorXd tilts(n);
  for (Index i = 0; i < n; ++i) {
    const Vector3d edge = points.col(i + 1) - points.col(i);
    tilts[i] = std::atan2(edge.tail<2>().norm(), edge.x());
  }
  return tilts;
}

// The top of the parabola through the largest and its neighbours.
double Peak(const Eigen::VectorXd& values) {
  Index at = 0;
  values.segment(1, values.size() - 2).maxCoeff(&at);
  const double left = values[at], top = values[at + 1], right = values[at + 2];
  return top + 0.125 * (right - left) * (right - left) / (2 * top - left - right);
}

}  // namespace

std::vector<Figure> FirstModeFigures(bool quick) {
  const SceneRod rod = ValidationScene("first_mode", kStandard).rods[0];
  const double wave =
      0.5 * rod.design.base_radius * std::sqrt(rod.design.youngs_modulus / rod.design.density);
  return {WithOrder(quick, "omega, rad/s", std::pow(1.875104068711961, 2) * wave, rod.design.elements,
                    FirstModeRate)};
}

std::vector<Figure> TwistBucklingFigures(bool quick) {
  const SceneRod rod = ValidationScene("twist_buckling", kStandard).rods[0];
  return {WithOrder(quick, "critical turn, rad", ClampedTwistMoment() * StiffnessRatio(rod),
                    rod.design.elements, TwistBuckling)};
}

std::vector<Figure> RingFigures(bool quick) {
  const SceneRod rod = ValidationScene("ring", kStandard).rods[0];
  return {WithOrder(quick, "critical turn, rad", 2 * pi * std::sqrt(3.0) * StiffnessRatio(rod),
                    rod.design.elements, RingTwist)};
}

std::vector<Figure> LocalisedHelixFigures(bool quick) {
  std::vector<Figure> figures;
  for (const double finer : {1.0, 2.0}) {
    if (quick && finer > 1) break;
    const Scene scene = ValidationScene("localised_helix", kStandard, finer);
    const SceneRod& rod = scene.rods[0];
    const double second_moment = pi / 4 * std::pow(rod.design.base_radius, 4), length = rod.design.length;
    const double turn = rod.base_motion.spin.norm() * rod.base_motion.until;
    const double slack = rod.tip_motion.velocity.norm() * (rod.tip_motion.until - rod.tip_motion.from);
    const double bend = rod.design.youngs_modulus * second_moment;
    const double twist = 2 * rod.design.shear_modulus * second_moment;
    const double stretch = rod.design.youngs_modulus * pi * rod.design.base_radius * rod.design.base_radius;
    LocalisedHelix helix = LocalisedHelixOf(length, bend, twist, turn, slack);
    // What the rod stretches by is more slack.
    for (int i = 0; i < 5; ++i) {
      helix = LocalisedHelixOf(length, bend, twist, turn, slack + helix.tension * length / stretch);
    }
    const Simulated run = RunScene(scene, {0.9 * scene.duration, scene.duration});
    const Eigen::VectorXd before = Tilts(run.curves[0].curves[0].points);
    const Eigen::VectorXd tilts = Tilts(run.curves[0].curves[1].points);
    // The middle by 1 - cos theta as a weight.
    const Eigen::ArrayXd weight = 1 - tilts.array().cos();
    const Index n = tilts.size();
    const Eigen::ArrayXd s =
        (Eigen::ArrayXd::LinSpaced(n, 0, static_cast<double>(n - 1)) + 0.5) * length / static_cast<double>(n);
    const double middle = (s * weight).sum() / weight.sum();
    const Eigen::ArrayXd sech = ((s - middle) / helix.width).cosh().inverse();
    const Eigen::ArrayXd expected = (1 - (1 - std::cos(helix.largest_tilt)) * sech.square()).acos();
    const double off = std::sqrt((tilts.array() - expected).square().mean());
    const double rms = std::sqrt(expected.square().mean());
    const int elements = static_cast<int>(n);
    figures.push_back({"largest tilt, rad", Peak(tilts), helix.largest_tilt, "standard", elements});
    figures.push_back(
        {"its change in the last tenth, rad", Peak(tilts) - Peak(before), 0, "standard", elements});
    figures.push_back({"profile off, rms / rms", off / rms, 0, "standard", elements});
  }
  return figures;
}

std::vector<Figure> PlectonemeFigures(bool /*quick*/) {
  const Scene scene = ValidationScene("plectoneme", kStandard);
  const SceneRod& rod = scene.rods[0];
  const double turns = rod.base_motion.spin.norm() * rod.base_motion.until / (2 * pi);
  const Simulated run = RunScene(scene, Times(rod.base_motion.until, scene.duration, 40));
  double off = 0, writhe = 0, twist = 0;
  for (const FramedCurve& curve : run.curves[0].curves) {
    const CurveLink link = MeasureLink({&curve, 1}, {}).value().curves[0];
    writhe = std::abs(link.writhe.value);
    twist = std::abs(link.twist);
    off = std::max(off, std::abs(std::abs(link.writhe.value + link.twist) - turns));
  }
  const int n = rod.design.elements;
  return {{"writhe + twist at the end, turns", writhe + twist, turns, "standard", n},
          {"largest deviation on the way, turns", off, 0, "standard", n},
          {"of it writhe, turns", writhe, kNone, "standard", n},
          {"least distance of axes / 2 r", run.least_axis_share, kNone, "standard", n},
          {"nothing passed", run.nothing_passed.value_or(false) ? 1.0 : 0.0, 1, "standard", n}};
}

std::vector<Figure> ImpactFigures(bool /*quick*/) {
  const Scene scene = ValidationScene("impact", kStandard);
  const SceneRod& coming = scene.rods[1];
  const double r = coming.design.base_radius, speed = coming.velocity.norm();
  const double mass = 0.5 * coming.design.density * pi * r * r * coming.design.length;
  const double hertz = std::pow(5 * mass * speed * speed / (4 * scene.contact.stiffness), 0.4);
  // The law's next term, -1.75 depth / (radii's sum) of the force (press.h), by the energy it leaves.
  double depth = hertz;
  for (int i = 0; i < 30; ++i) depth = hertz * std::pow(1 - 1.25 * depth / (2 * r), -0.4);
  const double late = 0.9 * scene.duration;
  const Simulated run = RunScene(scene, {late, scene.duration});
  // The first rod's middle after the impact; it may ring about it.
  const auto height = [&](std::size_t f) { return run.curves[0].curves[f].points.row(2).mean(); };
  const double after = (height(1) - height(0)) / (scene.duration - late);
  const int n = coming.design.elements;
  return {{"depth, m", 2 * r - run.least_axis_distance, depth, "standard", n},
          {"speed passed on, m/s", -after, speed, "standard", n}};
}

std::vector<Figure> FreeRodFigures(bool /*quick*/) {
  Scene scene = ValidationScene("free_rod", kStandard);
  std::vector<Figure> figures;
  const auto momentum = [](const Rod& rod) { return Vector3d(rod.velocity * rod.mass); };
  const auto angular = [](const Rod& rod) {
    Vector3d sum = Vector3d::Zero();
    for (Index i = 0; i < rod.mass.size(); ++i) {
      sum += rod.mass[i] * Vector3d(rod.position.col(i)).cross(Vector3d(rod.velocity.col(i)));
    }
    for (Index i = 0; i < rod.elements(); ++i) {
      sum += rod.directors[static_cast<std::size_t>(i)].transpose() *
             rod.inertia.col(i).cwiseProduct(rod.spin.col(i));
    }
    return sum;
  };
  for (const RodForm form : {RodForm::kEnergy, RodForm::kPaper}) {
    std::array<double, 3> swings{};
    double momentum_off = 0, angular_off = 0;
    for (const std::size_t k : {0, 1, 2}) {
      Rod rod = MakeRods(scene, 0).value()[0].rod;
      const double step = 1e-4 / std::pow(2.0, static_cast<double>(k));
      const Rod start = rod;
      const double energy = EnergyOf(rod).total();
      for (int i = 0; i * step < scene.duration; ++i) {
        StepPlain({&rod, 1}, i * step, {.form = form, .time_step = step});
        swings[k] = std::max(swings[k], std::abs(EnergyOf(rod).total() / energy - 1));
      }
      momentum_off = (momentum(rod) - momentum(start)).norm() / momentum(start).norm();
      angular_off = (angular(rod) - angular(start)).norm() / angular(start).norm();
    }
    const bool ours = form == RodForm::kEnergy;
    const std::string of = ours ? "standard's loads" : "paper's loads";
    const int n = static_cast<int>(scene.rods[0].design.elements);
    figures.push_back({"energy swing at 100 us", swings[0], 0, of, n});
    figures.push_back({"energy swing at 50 us", swings[1], 0, of, n});
    figures.push_back({"energy swing at 25 us", swings[2], 0, of, n});
    figures.push_back({"momentum drift", momentum_off, 0, of, n});
    figures.push_back({"angular momentum drift", angular_off, 0, of, n});
  }
  return figures;
}

}  // namespace tendril::testing_support
