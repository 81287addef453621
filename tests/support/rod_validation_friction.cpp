// Rods and objects that rub.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numbers>
#include <span>

#include "model/check.h"
#include "model/rods/contact_plain.h"
#include "model/rods/press.h"
#include "model/rods/rod_plain.h"
#include "tests/support/rod_validation.h"

namespace tendril::testing_support {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr SimulationLevel kStandard = SimulationLevel::kStandard;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::string Setting(const std::string& path, double value) { return path + "=" + ShortNumber(value); }

// Lambda of the tension e^(Lambda theta) in a rod that slides about a drum (docs/validation.md).
double CapstanRate(double friction, double e) {
  const double a = e * friction, c = friction * (1 - e);
  return 2 * c / (1 + std::sqrt(1 + 4 * a * c));
}

// The incline's box and rod under gravity turned so that tan(theta) is a share of mu: how far each goes in
// the second half of the run, m.
std::array<double, 2> SlidesInSecondHalf(double share) {
  Scene scene = ValidationScene("incline", kStandard);
  const double slope = std::atan(share * scene.contact.friction);
  scene.gravity = scene.gravity.norm() * Vector3d(std::sin(slope), 0, -std::cos(slope));
  const Simulated run = RunScene(scene, {0.5 * scene.duration, scene.duration});
  const auto& box = run.objects[0].poses;
  const auto& rod = run.curves[0].curves;
  return {box[1].translation().x() - box[0].translation().x(),
          rod[1].points.row(0).mean() - rod[0].points.row(0).mean()};
}

// What contact between the rods stores, J.
double StoredInContact(const Contact& contact, std::span<const Rod> rods) {
  double stored = 0;
  const auto side = [](const Rod& rod, Index i) {
    return PressSide{rod.position.col(i), rod.position.col(i + 1), rod.radius[i], rod.rest_length[i]};
  };
  for (std::size_t a = 0; a < rods.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      for (Index i = 0; i < rods[a].elements(); ++i) {
        for (Index j = 0; j < rods[b].elements(); ++j) {
          stored += PressOf(contact.stiffness, contact.points, side(rods[a], i), side(rods[b], j)).energy;
        }
      }
    }
  }
  return stored;
}

}  // namespace

std::vector<Figure> CapstanFigures(bool quick) {
  std::vector<Figure> figures;
  // The less friction, the larger the small end's force, so that none of the others counts beside it.
  const std::pair<double, double> runs[] = {{0.1, 500}, {0.3, 50}, {0.6, 4}};
  for (const auto& [friction, load] : runs) {
    if (quick && friction != 0.3) continue;
    Scene scene = ValidationScene("capstan", kStandard, 1, {Setting("contact.friction", friction)});
    scene.rods[0].tip_force *= load;
    const RodDesign& rod = scene.rods[0].design;
    const double drum = scene.objects[0].body.radius;
    const double rate = CapstanRate(friction, rod.base_radius / (drum + rod.base_radius));
    const Simulated run = RunScene(scene, {scene.duration});
    const Matrix3Xd& points = run.curves[0].curves.back().points;
    // Of elements: logarithm of the tension but for a factor, and the angle turned from the base on.
    const Index n = points.cols() - 1;
    Eigen::VectorXd logs(n), turned = Eigen::VectorXd::Zero(n);
    Vector3d before = Vector3d::Zero();
    for (Index i = 0; i < n; ++i) {
      const Vector3d edge = points.col(i + 1) - points.col(i);
      logs[i] = std::log(edge.norm() * static_cast<double>(n) / rod.length - 1);
      if (i > 0) turned[i] = turned[i - 1] + std::atan2(before.cross(edge).norm(), before.dot(edge));
      before = edge;
    }
    const auto log_at = [&](double angle) {
      Index i = 1;
      while (i + 1 < n && turned[i] < angle) ++i;
      const double share = (angle - turned[i - 1]) / (turned[i] - turned[i - 1]);
      return (1 - share) * logs[i - 1] + share * logs[i];
    };
    // From where the rod slides on: with mu 0.6 the tip itself still sticks.
    const double last = turned[n - 1] - 1.6;
    for (const double turns : {0.5, 1.0, 2.0, 3.0}) {
      const double angle = 2 * pi * turns;
      figures.push_back({"T1/T0, " + ShortNumber(turns) + " turns, mu " + ShortNumber(friction),
                         std::exp(log_at(last - angle) - log_at(last)), std::exp(rate * angle), "standard",
                         static_cast<int>(n)});
    }
  }
  return figures;
}

std::vector<Figure> InclineFigures(bool /*quick*/) {
  const Scene scene = ValidationScene("incline", kStandard);
  const int n = scene.rods[0].design.elements;
  std::vector<Figure> figures;
  for (const std::size_t which : {0, 1}) {
    const std::string of = which == 0 ? "box" : "rod";
    // Slides where it goes a tenth as far as it would with friction's full force.
    const double weight = scene.gravity.norm(), half = 0.5 * scene.duration, mu = scene.contact.friction;
    const auto slides = [&](double share) {
      const double slope = std::atan(share * mu);
      const double a = weight * (std::sin(slope) - mu * std::cos(slope));
      return share > 1 && SlidesInSecondHalf(share)[which] > 0.1 * 1.5 * a * half * half;
    };
    double low = 0.98, high = 1.02;
    for (int k = 0; k < 6; ++k) {
      const double middle = 0.5 * (low + high);
      (slides(middle) ? high : low) = middle;
    }
    figures.push_back({of + ": tan of the slope where it slides / mu", high, 1, "standard", n});
    figures.push_back(
        {of + ": creep at 0.995 mu, m/s", SlidesInSecondHalf(0.995)[which] / half, 0, "standard", n});
  }
  return figures;
}

std::vector<Figure> RollingFigures(bool /*quick*/) {
  const Scene scene = ValidationScene("rolling", kStandard);
  const Simulated run = RunScene(scene, {0.5 * scene.duration, scene.duration});
  std::vector<Figure> figures;
  for (std::size_t r = 0; r < scene.rods.size(); ++r) {
    const auto x = [&](std::size_t f) { return run.curves[r].curves[f].points.row(0).mean(); };
    // From rest: x = a t^2 / 2.
    const double a = (x(1) - x(0)) / (0.5 * 0.75 * scene.duration * scene.duration);
    figures.push_back({scene.rods[r].name + ": a, m/s^2", a, scene.gravity.x() / 1.5, "standard",
                       scene.rods[r].design.elements});
  }
  return figures;
}

std::vector<Figure> StickSlipFigures(bool /*quick*/) {
  const Scene scene = ValidationScene("stick_slip", kStandard);
  const SceneRod& rod = scene.rods[0];
  const SceneObject& block = scene.objects[0].name == "block" ? scene.objects[0] : scene.objects[1];
  const std::size_t which = &block == &scene.objects[0] ? 0 : 1;
  const int count = 6000;
  std::vector<double> times;
  for (int i = 0; i <= count; ++i) times.push_back(scene.duration * i / count);
  const Simulated run = RunScene(scene, times);
  const auto& series = run.objects[which];
  const auto x = [&](int i) { return series.poses[static_cast<std::size_t>(i)].translation().x(); };
  const auto push = [&](int i) { return series.forces[static_cast<std::size_t>(i)].x(); };
  // A leap begins where it overtakes the drive, and is over within 50 ms.
  const double speed = rod.base_motion.velocity.x(), every = scene.duration / count;
  std::vector<int> starts;
  for (int i = 1; i <= count; ++i) {
    if (x(i) - x(i - 1) < speed * every) continue;
    if (starts.empty() || every * (i - starts.back()) > 0.15) starts.push_back(i);
  }
  // The first comes after a start from rest.
  TENDRIL_CHECK(starts.size() > 4);
  const auto leaps = static_cast<double>(starts.size() - 2);
  const double period = every * (starts.back() - starts[1]) / leaps;
  double rate = 0, swing = 0;
  for (std::size_t k = 1; k + 1 < starts.size(); ++k) {
    const int long_ago = starts[k + 1] - starts[k];
    const int from = starts[k] + long_ago / 2, until = starts[k + 1] - long_ago / 20;
    rate += (push(until) - push(from)) / (every * (until - from)) / leaps;
    double most = push(starts[k]), least = most;
    for (int i = starts[k] - long_ago / 20; i < from; ++i) {
      most = std::max(most, push(i));
      least = std::min(least, push(i));
    }
    swing += (most - least) / leaps;
  }
  const double stiffness = rate / speed;
  TENDRIL_CHECK(stiffness > 0);  // else it was not pushed
  const double weight = block.mass * scene.gravity.norm();
  const double omega = std::sqrt(stiffness / block.mass);
  const double drop = (scene.contact.static_friction - scene.contact.friction) * weight / stiffness;
  const double slipping = 2 / omega * (pi - std::atan(omega * drop / speed));
  const int n = rod.design.elements;
  return {{"k that it feels, N/m", stiffness, kNone, "standard", n},
          {"period by that k, s", period, 2 * drop / speed + slipping, "standard", n},
          {"swing of the push, N", swing, 2 * stiffness * std::hypot(drop, speed / omega), "standard", n}};
}

std::vector<Figure> TangleFigures(bool /*quick*/) {
  const Scene scene = ValidationScene("tangle", kStandard);
  const SimulationPlan plan = PlanScene(scene).value();
  Contact contact = scene.contact;
  contact.points = plan.contact_points;
  std::vector<Rod> rods;
  const std::vector<Driven> made = MakeRods(scene, 0).value();
  for (const Driven& driven : made) rods.push_back(driven.rod);
  PlainContact touch(contact, {.rods = true, .selves = false, .bodies = false});
  const double step = 0.5 * plan.time_step;
  const int count = static_cast<int>(scene.duration / step);
  double start = 0, least = 0, rise = 0, end = 0;
  for (int i = 0; i <= count; ++i) {
    if (i % 20 == 0) {
      double energy = StoredInContact(contact, rods) + touch.StoredBySprings();
      for (const Rod& rod : rods) energy += EnergyOf(rod).total();
      if (i == 0) start = least = energy;
      rise = std::max(rise, energy - least);
      least = std::min(least, energy);
      end = energy;
    }
    std::vector<RodLoads> loads(rods.size());
    for (std::size_t r = 0; r < rods.size(); ++r) {
      DriftPlain(rods[r], RodForm::kEnergy, 0.5 * step);
      loads[r].force.setZero(3, rods[r].elements() + 1);
      loads[r].couple.setZero(3, rods[r].elements());
    }
    touch.Add(rods, {}, step, loads, {});
    for (std::size_t r = 0; r < rods.size(); ++r) {
      KickPlain(rods[r], {.time_step = step}, loads[r].force, loads[r].couple);
      DriftPlain(rods[r], RodForm::kEnergy, 0.5 * step);
    }
  }
  const int n = scene.rods[0].design.elements;
  return {{"largest rise of energy / energy at the start", rise / start, 0, "standard", n},
          {"energy at the end / at the start", end / start, kNone, "standard", n}};
}

}  // namespace tendril::testing_support
