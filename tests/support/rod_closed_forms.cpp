#include "tests/support/rod_closed_forms.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/ellint_2.hpp>
#include <cmath>
#include <functional>
#include <numbers>

namespace tendril::testing_support {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Where an ascending function is 0.
double Root(double low, double high, const std::function<double(double)>& value) {
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (value(middle) < 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

struct Shot {
  double x = 0, z = 0, theta = 0, slope = 0;
};
Shot HeavyShot(double weight, double slope) {
  constexpr int kSteps = 4000;
  constexpr double kStep = 1.0 / kSteps;
  const auto rate = [weight](double s, const Shot& y) {
    return Shot{std::cos(y.theta), std::sin(y.theta), y.slope, -weight * (1 - s) * std::cos(y.theta)};
  };
  const auto moved = [](const Shot& y, const Shot& by, double step) {
    return Shot{y.x + step * by.x, y.z + step * by.z, y.theta + step * by.theta, y.slope + step * by.slope};
  };
  Shot y{.slope = slope};
  for (int i = 0; i < kSteps; ++i) {
    const double s = i * kStep;
    const Shot a = rate(s, y), b = rate(s + 0.5 * kStep, moved(y, a, 0.5 * kStep)),
               c = rate(s + 0.5 * kStep, moved(y, b, 0.5 * kStep)), d = rate(s + kStep, moved(y, c, kStep));
    y = moved(moved(moved(moved(y, a, kStep / 6), b, kStep / 3), c, kStep / 3), d, kStep / 6);
  }
  return y;
}

struct ArcState {
  Vector3d position;
  Matrix3d directors;  // d1, d2, d3 as rows
  Vector3d moment;     // lab
};

ArcState ArcRate(const LoadedArc& arc, const Vector3d& load, const ArcState& y) {
  const Vector3d force = y.directors * load;  // the load is what every section carries
  const Vector3d strain(force.x() / arc.shear, force.y() / arc.shear, 1 + force.z() / arc.stretch);
  const Vector3d moment = y.directors * y.moment;
  const Vector3d turn(arc.curvature + moment.x() / arc.bend, moment.y() / arc.bend, moment.z() / arc.twist);
  const Vector3d turn_in_lab = y.directors.transpose() * turn;
  ArcState rate;
  rate.position = y.directors.transpose() * strain;
  for (int k = 0; k < 3; ++k) {
    rate.directors.row(k) = turn_in_lab.cross(Vector3d(y.directors.row(k).transpose())).transpose();
  }
  rate.moment = -rate.position.cross(load);
  return rate;
}

ArcState ArcShot(const LoadedArc& arc, const Matrix3d& base, const Vector3d& load, const Vector3d& moment) {
  constexpr int kSteps = 1000;
  const double h = arc.length / kSteps;
  const auto moved = [](const ArcState& y, const ArcState& by, double step) {
    return ArcState{y.position + step * by.position, y.directors + step * by.directors,
                    y.moment + step * by.moment};
  };
  ArcState y{Vector3d::Zero(), base, moment};
  for (int i = 0; i < kSteps; ++i) {
    const ArcState a = ArcRate(arc, load, y), b = ArcRate(arc, load, moved(y, a, 0.5 * h)),
                   c = ArcRate(arc, load, moved(y, b, 0.5 * h)), d = ArcRate(arc, load, moved(y, c, h));
    y = moved(moved(moved(moved(y, a, h / 6), b, h / 3), c, h / 3), d, h / 6);
  }
  return y;
}

}  // namespace

TipOf TipLoadedElastica(double load) {
  // k^2 in (1/2, 1): K(k) - F(theta1, k) = sqrt(load), sin theta1 = 1 / (k sqrt 2).
  const double root = std::sqrt(load);
  const auto theta = [](double k) { return std::asin(std::min(1.0, 1 / (k * std::numbers::sqrt2))); };
  const double k = Root(std::sqrt(0.5), 1, [&](double at) {
    return boost::math::ellint_1(at) - boost::math::ellint_1(at, theta(at)) - root;
  });
  const double drop = 1 - 2 / root * (boost::math::ellint_2(k) - boost::math::ellint_2(k, theta(k)));
  return {drop, 1 - std::sqrt(2.0) / root * std::sqrt(2 * k * k - 1)};
}

TipOf HeavyElastica(double weight) {
  // The slope left at the tip rises with the slope at the base.
  const double slope = Root(0, weight, [&](double at) { return HeavyShot(weight, at).slope; });
  const Shot tip = HeavyShot(weight, slope);
  return {tip.z, 1 - tip.x};
}

double BuckledColumn(double load_share) {
  const double root = std::sqrt(load_share);
  const double k = Root(0, 1 - 1e-15,
                        [&](double at) { return boost::math::ellint_1(at) - 0.5 * std::numbers::pi * root; });
  return 2 * k / (0.5 * std::numbers::pi * root);
}

double ClampedTwistMoment() {
  return 2 * Root(std::numbers::pi, 1.4999 * std::numbers::pi, [](double x) { return std::tan(x) - x; });
}

Vector3d TipOfLoadedArc(const LoadedArc& arc, const Matrix3d& base, const Vector3d& load) {
  Vector3d moment = Vector3d::Zero();
  // The load grows in parts, so that Newton's method starts near.
  constexpr int kParts = 40;
  for (int part = 1; part <= kParts; ++part) {
    const Vector3d now = load * part / kParts;
    for (int round = 0; round < 12; ++round) {
      const Vector3d left = ArcShot(arc, base, now, moment).moment;
      const double nudge = 1e-5 * (1 + moment.norm());
      Matrix3d slope;
      for (int k = 0; k < 3; ++k) {
        slope.col(k) = (ArcShot(arc, base, now, moment + nudge * Vector3d::Unit(k)).moment - left) / nudge;
      }
      const Vector3d by = slope.partialPivLu().solve(left);
      moment -= by;
      if (by.norm() < 1e-10 * moment.norm()) break;
    }
  }
  return ArcShot(arc, base, load, moment).position;
}

LocalisedHelix LocalisedHelixOf(double length, double bend, double twist, double turn, double slack) {
  // With x = m / 2: slack = 4 sqrt(B / T) sqrt(1 - x^2), turn = M L / C + 4 arccos x, M = 2 x sqrt(B T). Less
  // tilt: x above 1 / sqrt 2, where the turn falls with x.
  const auto tension = [&](double x) { return bend * 16 * (1 - x * x) / (slack * slack); };
  const auto moment = [&](double x) { return 2 * x * std::sqrt(bend * tension(x)); };
  const double x = Root(std::sqrt(0.5), 1,
                        [&](double at) { return turn - (moment(at) * length / twist + 4 * std::acos(at)); });
  return {tension(x), moment(x), std::sqrt(bend / tension(x)) / std::sqrt(1 - x * x),
          std::acos(2 * x * x - 1)};
}

}  // namespace tendril::testing_support
