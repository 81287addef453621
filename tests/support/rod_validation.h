#pragma once
// What rods of known behaviour do here, next to what they should: the scenes of examples/scenes/validation,
// run and measured. Printed by bench/rod_validation.cpp, asserted by tests/db/rod_validation_test.cpp; the
// sources of the references are in docs/validation.md.

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "db/files/scene_toml.h"
#include "model/scene/simulate.h"

namespace tendril::testing_support {

struct Figure {
  std::string quantity;
  double ours = 0, reference = 0;  // NaN: there is none
  std::string level;
  int elements = 0;
  // Of convergence, from the figure at three numbers of elements, each twice the one before: log2 of its
  // first change over its second. Static: N, 2N and 4N; standard: N / 2, N and 2N. NaN: not looked at.
  double order = std::numeric_limits<double>::quiet_NaN();

  // NaN where there is no reference, and where it is 0, by which the figure itself is the error.
  double Error() const {
    return reference == 0 ? std::numeric_limits<double>::quiet_NaN() : std::abs(ours / reference - 1);
  }
};

struct ValidationCase {
  const char* name;
  //   quick  level static alone where there is one, else half the elements; no order
  std::vector<Figure> (*run)(bool quick);
  bool by_name_alone = false;  // takes minutes
};
const std::vector<ValidationCase>& ValidationCases();

// A scene of examples/scenes/validation, at a level, with its own number of elements times `finer`.
//   settings  path=value each (docs/formats.md)
Scene ValidationScene(const std::string& name, SimulationLevel level, double finer = 1,
                      const std::vector<std::string>& settings = {});
// As PlanScene plans it. A scene that does not run to its end is a programmer's error here.
Simulated RunScene(const Scene& scene, const std::vector<double>& times);
// Each rod at the end.
std::vector<Eigen::Matrix3Xd> RestingPoints(const Scene& scene);

double OrderOf(double coarse, double middle, double fine);

// The parts of ValidationCases.
std::vector<Figure> ElasticaFigures(bool quick);
std::vector<Figure> HeavyElasticaFigures(bool quick);
std::vector<Figure> ThickCantileverFigures(bool quick);
std::vector<Figure> TipCoupleFigures(bool quick);
std::vector<Figure> Bend45Figures(bool quick);
std::vector<Figure> ColumnFigures(bool quick);
std::vector<Figure> FirstModeFigures(bool quick);
std::vector<Figure> TwistBucklingFigures(bool quick);
std::vector<Figure> RingFigures(bool quick);
std::vector<Figure> HelixFigures(bool quick);
std::vector<Figure> LocalisedHelixFigures(bool quick);
std::vector<Figure> PlectonemeFigures(bool quick);
std::vector<Figure> ImpactFigures(bool quick);
std::vector<Figure> FreeRodFigures(bool quick);
std::vector<Figure> CapstanFigures(bool quick);
std::vector<Figure> InclineFigures(bool quick);
std::vector<Figure> RollingFigures(bool quick);
std::vector<Figure> StickSlipFigures(bool quick);
std::vector<Figure> TangleFigures(bool quick);
std::vector<Figure> SinkingFigures(bool quick);
std::vector<Figure> PendulumFigures(bool quick);
std::vector<Figure> CollisionFigures(bool quick);
std::vector<Figure> HeldFigures(bool quick);
// Nothing where quick.
std::vector<Figure> OverhandFigures(bool quick);
std::vector<Figure> ThinnerOverhandFigures(bool quick);

}  // namespace tendril::testing_support
