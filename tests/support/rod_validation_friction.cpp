// Rods and objects that rub.
#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

#include "model/check.h"
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

}  // namespace tendril::testing_support
