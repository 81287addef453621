// Rods at rest.
#include "tests/support/rod_validation.h"

#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <numbers>

#include "model/check.h"
#include "tests/support/rod_closed_forms.h"

namespace tendril::testing_support {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr SimulationLevel kStatic = SimulationLevel::kStatic, kStandard = SimulationLevel::kStandard;

double Bending(const SceneRod& rod) {
  return rod.design.youngs_modulus * pi / 4 * std::pow(rod.design.base_radius, 4);
}
double Area(const SceneRod& rod) { return pi * rod.design.base_radius * rod.design.base_radius; }

// The same figures of a scene at both levels, with the order of the static ones.
struct Measured {
  std::string quantity;
  double reference;
  std::function<double(const Matrix3Xd&)> of;
  std::size_t rod = 0;
};
std::vector<Figure> AtBothLevels(const std::string& name, const std::vector<Measured>& measured, bool quick,
                                 bool standard = true) {
  std::vector<std::vector<Matrix3Xd>> still;
  for (const double finer : {1.0, 2.0, 4.0}) {
    if (quick && finer > 1) break;
    still.push_back(RestingPoints(ValidationScene(name, kStatic, finer)));
  }
  std::vector<Matrix3Xd> moved;
  if (standard && !quick) moved = RestingPoints(ValidationScene(name, kStandard));
  std::vector<Figure> figures;
  for (const Measured& m : measured) {
    const double ours = m.of(still[0][m.rod]);
    const int elements = static_cast<int>(still[0][m.rod].cols()) - 1;
    Figure& figure = figures.emplace_back(Figure{m.quantity, ours, m.reference, "static", elements});
    if (!quick) figure.order = OrderOf(ours, m.of(still[1][m.rod]), m.of(still[2][m.rod]));
    if (!moved.empty()) {
      figures.push_back({m.quantity, m.of(moved[m.rod]), m.reference, "standard", elements});
    }
  }
  return figures;
}

double Drop(const Matrix3Xd& points) { return points(2, 0) - points(2, points.cols() - 1); }

}  // namespace

Scene ValidationScene(const std::string& name, SimulationLevel level, double finer,
                      const std::vector<std::string>& settings) {
  const std::string folder = std::string(TENDRIL_SOURCE_DIR) + "/examples/scenes/";
  const Result<Scene> read =
      ReadScene(folder + (name == "helix" ? name : "validation/" + name) + ".toml", settings);
  TENDRIL_CHECK(read.ok());
  Scene scene = read.value();
  scene.level = level;
  for (SceneRod& rod : scene.rods) {
    rod.design.elements = static_cast<int>(std::lround(finer * rod.design.elements));
  }
  return scene;
}

Simulated RunScene(const Scene& scene, const std::vector<double>& times) {
  const Result<SimulationPlan> plan = PlanScene(scene);
  TENDRIL_CHECK(plan.ok());
  Result<Simulated> run = Simulate(scene, plan.value(), times);
  TENDRIL_CHECK(run.ok());
  TENDRIL_CHECK(!run.value().diverged);
  return std::move(run).value();
}

std::vector<Matrix3Xd> RestingPoints(const Scene& scene) {
  std::vector<Matrix3Xd> points;
  for (const CurveSeries& rod : RunScene(scene, {scene.duration}).curves) {
    points.push_back(rod.curves.back().points);
  }
  return points;
}

double OrderOf(double coarse, double middle, double fine) {
  // Nothing but rounding is left.
  if (std::abs(coarse - middle) < 1e-9) return std::numeric_limits<double>::quiet_NaN();
  return std::log2(std::abs(coarse - middle) / std::abs(middle - fine));
}

std::vector<Figure> ElasticaFigures(bool quick) {
  const Scene scene = ValidationScene("elastica", kStatic);
  std::vector<Measured> measured;
  for (std::size_t r = 0; r < scene.rods.size(); ++r) {
    const double load = scene.rods[r].tip_force.norm() / Bending(scene.rods[r]);
    const TipOf tip = TipLoadedElastica(load);
    const std::string at = " at P L^2/EI = " + std::to_string(static_cast<int>(std::lround(load)));
    measured.push_back({"w/L" + at, tip.drop, Drop, r});
    measured.push_back(
        {"u/L" + at, tip.in, [](const Matrix3Xd& p) { return 1 - p(0, p.cols() - 1) + p(0, 0); }, r});
  }
  return AtBothLevels("elastica", measured, quick);
}

std::vector<Figure> HeavyElasticaFigures(bool quick) {
  const Scene scene = ValidationScene("heavy_elastica", kStatic);
  std::vector<Measured> measured;
  for (std::size_t r = 0; r < scene.rods.size(); ++r) {
    const SceneRod& rod = scene.rods[r];
    const double weight = rod.design.density * Area(rod) * scene.gravity.norm() / Bending(rod);
    const TipOf tip = HeavyElastica(weight);
    measured.push_back({"H/W at rho A g L^3/EI = " + std::to_string(std::lround(weight)),
                        tip.drop / (1 - tip.in),
                        [](const Matrix3Xd& p) { return Drop(p) / (p(0, p.cols() - 1) - p(0, 0)); }, r});
  }
  return AtBothLevels("heavy_elastica", measured, quick);
}

std::vector<Figure> ThickCantileverFigures(bool quick) {
  const Scene scene = ValidationScene("thick_cantilever", kStatic);
  const SceneRod& rod = scene.rods[0];
  const double load = rod.tip_force.norm();
  const double deflection =
      load / (3 * Bending(rod)) + load / (27.0 / 28.0 * rod.design.shear_modulus * Area(rod));
  return AtBothLevels("thick_cantilever", {{"deflection / L", deflection, Drop}}, quick);
}

std::vector<Figure> TipCoupleFigures(bool quick) {
  const auto farthest = [](const Matrix3Xd& p) {
    return (p.colwise() - p.col(0)).colwise().norm().maxCoeff();
  };
  const auto gap = [](const Matrix3Xd& p) { return (p.rightCols<1>() - p.col(0)).norm(); };
  return AtBothLevels("tip_couple", {{"diameter / L", 1 / pi, farthest}, {"gap / L", 0, gap}}, quick);
}

std::vector<Figure> Bend45Figures(bool quick) {
  const Scene scene = ValidationScene("bend45", kStatic);
  std::vector<Measured> measured;
  for (std::size_t r = 0; r < scene.rods.size(); ++r) {
    const SceneRod& rod = scene.rods[r];
    const LoadedArc arc{rod.design.length,
                        rod.design.start_curvature.x(),
                        Bending(rod),
                        2 * Bending(rod) * rod.design.shear_modulus / rod.design.youngs_modulus,
                        27.0 / 28.0 * rod.design.shear_modulus * Area(rod),
                        rod.design.youngs_modulus * Area(rod)};
    Eigen::Matrix3d base;
    base << rod.design.normal.transpose(), rod.design.direction.cross(rod.design.normal).transpose(),
        rod.design.direction.transpose();
    const Vector3d tip = TipOfLoadedArc(arc, base, rod.tip_force);
    for (const Index k : {0, 1, 2}) {
      measured.push_back(
          {std::string("tip ") + "xyz"[k] + " under " + std::to_string(std::lround(rod.tip_force.norm())),
           tip[k], [k](const Matrix3Xd& p) { return p(k, p.cols() - 1) - p(k, 0); }, r});
    }
  }
  return AtBothLevels("bend45", measured, quick);
}

namespace {

// The load, by Euler's, at which the first rod of the scene would give way without limit: one over its
// sideways motion under a hundred-thousandth of the load falls to 0 there; the parabola through three loads
// below.
double CriticalShare(double finer) {
  Scene scene = ValidationScene("column", kStatic, finer);
  scene.rods.resize(1);
  const double euler = pi * pi * Bending(scene.rods[0]) / 4;
  const std::array<double, 3> shares = {0.97, 0.98, 0.99};
  std::array<double, 3> stiffness{};
  for (std::size_t k = 0; k < 3; ++k) {
    scene.rods[0].tip_force = euler * shares[k] * Vector3d(1e-5, 0, -1);
    const Matrix3Xd points = RestingPoints(scene)[0];
    stiffness[k] = shares[k] / (points(0, points.cols() - 1) - points(0, 0));
  }
  const double step = 0.01, slope = (stiffness[2] - stiffness[0]) / (2 * step);
  const double bend = (stiffness[2] - 2 * stiffness[1] + stiffness[0]) / (2 * step * step);
  // 0 = stiffness + slope x + bend x^2, from the middle load on.
  const double root = std::sqrt(slope * slope - 4 * bend * stiffness[1]);
  return shares[1] + 2 * stiffness[1] / (root - slope);
}

}  // namespace

std::vector<Figure> ColumnFigures(bool quick) {
  const Scene scene = ValidationScene("column", kStatic);
  const double critical = CriticalShare(1);
  std::vector<Figure> figures{
      {"buckling load / (pi^2 EI / 4 L^2)", critical, 1, "static", scene.rods[0].design.elements}};
  if (!quick) figures[0].order = OrderOf(critical, CriticalShare(2), CriticalShare(4));
  std::vector<Measured> measured;
  for (std::size_t r = 0; r < scene.rods.size(); ++r) {
    const double share = -scene.rods[r].tip_force.z() / (pi * pi * Bending(scene.rods[r]) / 4);
    measured.push_back({"w/L at " + std::to_string(share).substr(0, 3) + " of that load",
                        BuckledColumn(share), [](const Matrix3Xd& p) { return p(0, p.cols() - 1) - p(0, 0); },
                        r});
  }
  for (Figure& figure : AtBothLevels("column", measured, quick, false)) figures.push_back(std::move(figure));
  return figures;
}

std::vector<Figure> HelixFigures(bool quick) {
  const SceneRod rod = ValidationScene("helix", kStatic).rods[0];
  const double kappa = rod.rest_curvature.y(), tau = rod.rest_curvature.z();
  const double square = kappa * kappa + tau * tau;
  // Equal chords that turn about one axis by one angle.
  struct Turn {
    double angle, radius, pitch;
  };
  const auto turn_of = [](const Matrix3Xd& p) {
    const Index i = p.cols() / 2;
    const Vector3d a = p.col(i) - p.col(i - 1), b = p.col(i + 1) - p.col(i), c = p.col(i + 2) - p.col(i + 1);
    const Vector3d axis = (b - a).cross(c - b).normalized();
    const double rise = axis.dot(b);
    const Vector3d across = b - rise * axis, next = c - axis.dot(c) * axis;
    const double angle = std::atan2(axis.dot(across.cross(next)), across.dot(next));
    return Turn{angle, across.norm() / (2 * std::sin(0.5 * angle)), 2 * pi * rise / angle};
  };
  return AtBothLevels(
      "helix",
      {{"radius, m", kappa / square, [&](const Matrix3Xd& p) { return turn_of(p).radius; }},
       {"pitch, m", 2 * pi * tau / square, [&](const Matrix3Xd& p) { return std::abs(turn_of(p).pitch); }}},
      quick);
}

const std::vector<ValidationCase>& ValidationCases() {
  static const std::vector<ValidationCase> cases = {{"elastica", ElasticaFigures},
                                                    {"heavy_elastica", HeavyElasticaFigures},
                                                    {"thick_cantilever", ThickCantileverFigures},
                                                    {"tip_couple", TipCoupleFigures},
                                                    {"bend45", Bend45Figures},
                                                    {"column", ColumnFigures},
                                                    {"helix", HelixFigures},
                                                    {"first_mode", FirstModeFigures},
                                                    {"twist_buckling", TwistBucklingFigures},
                                                    {"ring", RingFigures},
                                                    {"localised_helix", LocalisedHelixFigures},
                                                    {"plectoneme", PlectonemeFigures},
                                                    {"impact", ImpactFigures},
                                                    {"free_rod", FreeRodFigures},
                                                    {"capstan", CapstanFigures},
                                                    {"incline", InclineFigures},
                                                    {"rolling", RollingFigures},
                                                    {"stick_slip", StickSlipFigures},
                                                    {"tangle", TangleFigures},
                                                    {"sinking", SinkingFigures},
                                                    {"pendulum", PendulumFigures},
                                                    {"collision", CollisionFigures},
                                                    {"held", HeldFigures},
                                                    {"overhand", OverhandFigures},
                                                    {"overhand_thinner", ThinnerOverhandFigures, true}};
  return cases;
}

}  // namespace tendril::testing_support
