// How the two holds of a base converge with the elements, and how the two forms keep the energy: a table, or
// with --figures FOLDER the plots of docs/validation.md (gnuplot).
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "db/files/safe_file.h"
#include "model/rods/rod_plain.h"
#include "model/rods/rod_static.h"
#include "model/scene/actuation.h"

namespace tendril {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

// A rod at rest under its loads, its first element held or its base's frame.
struct Case {
  const char* name;
  Rod (*make)(int elements, EndHold hold);
  Vector3d tip_force;
  Vector3d gravity;
};

Rod Make(int elements, EndHold hold, double taper) {
  RodDesign design;
  design.elements = elements;
  design.taper = taper;
  design.base = hold;
  design.direction = {1, 0, 0};
  design.normal = {0, 0, 1};
  return MakeRod(design).value();
}

const Case kCases[] = {
    {"tip load", [](int n, EndHold hold) { return Make(n, hold, 1); }, {0, 0, -0.02}, {0, 0, 0}},
    {"own weight, tapered", [](int n, EndHold hold) { return Make(n, hold, 0.5); }, {0, 0, 0}, {0, 0, -1}},
    {"rest curvature in space",
     [](int n, EndHold hold) {
       Rod rod = Make(n, hold, 0.5);
       rod.base.rest_curvature = {2, -6, 4};
       rod.rest_curvature.colwise() = rod.base.rest_curvature;
       return rod;
     },
     {0, 0, 0},
     {0, 0, -1}},
    {"the paper's tentacle, pull 0.3",
     [](int n, EndHold hold) {
       SceneGripper gripper;
       gripper.rod.elements = n;
       const auto actuation = TentacleActuation::Make(gripper, hold == EndHold::kFrame, 1, 0, 0).value();
       RodDesign design;
       design.elements = n;
       design.taper = gripper.design.taper;
       design.base = hold;
       design.direction = {0, 0, -1};
       Rod rod = MakeRod(design).value();
       const Matrix3Xd& entry = actuation.Entry(actuation.entries() - 1);
       rod.base.rest_curvature = entry.col(0);
       rod.rest_curvature = entry.rightCols(n - 1);
       return rod;
     },
     {0, 0, 0},
     {0, 0, -9.80665}},
};

// Where the rod's nodes at the 25ths of its length come to rest.
Matrix3Xd Settled(const Case& one, int elements, EndHold hold) {
  Rod rod = one.make(elements, hold);
  const Matrix3Xd curvature = rod.rest_curvature;
  const Vector3d base = rod.base.rest_curvature;
  for (int part = 1; part <= 20; ++part) {
    const double share = part / 20.0;
    rod.rest_curvature = share * curvature;
    rod.base.rest_curvature = share * base;
    Matrix3Xd force = one.gravity * rod.mass.transpose();
    force.rightCols<1>() += one.tip_force;
    if (!SettleRod(rod, share * force).ok()) return Matrix3Xd::Constant(3, 26, NAN);
  }
  Matrix3Xd at(3, 26);
  for (Index k = 0; k <= 25; ++k) at.col(k) = rod.position.col(k * elements / 25);
  return at;
}

double Apart(const Matrix3Xd& a, const Matrix3Xd& b) { return (a - b).colwise().norm().maxCoeff(); }

std::string ConvergenceTable() {
  std::string data;
  for (const Case& one : kCases) {
    const Matrix3Xd fine = Settled(one, 6400, EndHold::kFrame);
    fmt::print("{}\n  elements   element held   order   frame held   order     (mm of 750)\n", one.name);
    data += fmt::format("\"{}\"\n", one.name);
    double before[2] = {};
    for (const int elements : {25, 50, 100, 200, 400, 800}) {
      const double off[2] = {Apart(Settled(one, elements, EndHold::kElement), fine),
                             Apart(Settled(one, elements, EndHold::kFrame), fine)};
      const auto order = [&](int k) { return before[k] > 0 ? std::log2(before[k] / off[k]) : NAN; };
      fmt::print("  {:8} {:14.4f} {:7.2f} {:12.5f} {:7.2f}\n", elements, 1e3 * off[0], order(0), 1e3 * off[1],
                 order(1));
      data += fmt::format("{} {} {}\n", elements, 1e3 * off[0], 1e3 * off[1]);
      before[0] = off[0];
      before[1] = off[1];
    }
    data += "\n\n";
  }
  return data;
}

// A free rod that bends, stretches and twists, its energy over time.
std::string EnergyTable() {
  RodDesign design;
  design.elements = 40;
  design.length = 0.5;
  design.base_radius = 0.01;
  design.density = 500;
  design.youngs_modulus = 1e6;
  design.shear_modulus = 4e5;
  design.base = EndHold::kFree;
  const Rod start = [&] {
    Rod rod = MakeRod(design).value();
    for (Index i = 0; i < rod.velocity.cols(); ++i) {
      const double s = static_cast<double>(i) / 40;
      rod.velocity.col(i) = Vector3d(std::sin(3 * s), std::cos(5 * s), 0.5 * std::sin(7 * s));
    }
    for (auto w : rod.spin.colwise()) w << 0, 0, 20;
    return rod;
  }();
  fmt::print("\nswing of a free rod's energy over 1 s, % of it\n  step us   published   energy's gradient\n");
  std::string data;
  for (const RodForm form : {RodForm::kPaper, RodForm::kEnergy}) {
    Rod rod = start;
    const double whole = EnergyOf(rod).total();
    for (int step = 0; step < 20000; ++step) {
      StepPlain({&rod, 1}, step * 5e-5, {.form = form, .time_step = 5e-5});
      if (step % 40 == 0)
        data += fmt::format("{} {}\n", step * 5e-5, 100 * (EnergyOf(rod).total() / whole - 1));
    }
    data += "\n\n";
  }
  for (const double step : {4e-5, 2e-5, 1e-5}) {
    double swing[2] = {};
    for (const RodForm form : {RodForm::kPaper, RodForm::kEnergy}) {
      Rod rod = start;
      double low = HUGE_VAL, high = -HUGE_VAL;
      for (int k = 0; k * step < 1; ++k) {
        StepPlain({&rod, 1}, k * step, {.form = form, .time_step = step});
        const double now = EnergyOf(rod).total();
        low = std::min(low, now);
        high = std::max(high, now);
      }
      swing[form == RodForm::kPaper ? 0 : 1] = 100 * (high - low) / EnergyOf(start).total();
    }
    fmt::print("  {:7.0f} {:11.4f} {:19.6f}\n", 1e6 * step, swing[0], swing[1]);
  }
  return data;
}

int Draw(const std::string& folder, const std::string& convergence, const std::string& energy) {
  const std::string base = folder + "/";
  if (!WriteText(base + "convergence.dat", convergence).ok() ||
      !WriteText(base + "energy.dat", energy).ok()) {
    fmt::print(stderr, "{}: not a folder that can be written\n", folder);
    return 1;
  }
  const std::string script =
      "set terminal svg size 860,360 font 'sans,13' background '#ffffff'\n"
      "set output '" +
      base +
      "rod_convergence.svg'\n"
      "set multiplot layout 1,2\n"
      "set logscale xy; set xrange [20:1000]; set grid lc rgb '#dddddd'; set format y '10^{%T}'\n"
      "set xlabel 'elements'; set ylabel 'largest error of a node, mm of 750'; set key bottom left Left "
      "reverse samplen 2 font ',11'\n"
      "set title 'first element held (published)'; set yrange [1e-8:100]\n"
      "plot for [i=0:3] '" +
      base +
      "convergence.dat' index i using 1:2 with linespoints pt 7 ps 0.6 lw 2 lc i+1 "
      "title columnheader(1), 300/x with lines dt 2 lc rgb '#888888' title 'first order'\n"
      "set title 'frame at the base held'\n"
      "plot for [i=0:3] '" +
      base +
      "convergence.dat' index i using 1:3 with linespoints pt 7 ps 0.6 lw 2 lc i+1 "
      "title columnheader(1), 600/x**2 with lines dt 2 lc rgb '#888888' title 'second order'\n"
      "unset multiplot\n"
      "set terminal svg size 860,300 font 'sans,13' background '#ffffff'\n"
      "set output '" +
      base +
      "rod_energy.svg'\n"
      "unset logscale; set xrange [0:1]; set autoscale y; set format y '%g'; set key top left Left reverse\n"
      "set title \"energy of a free rod, steps of 50 us\"; set xlabel 'time, s'; set ylabel 'change, %'\n"
      "plot '" +
      base + "energy.dat' index 0 with lines lw 1.5 title 'published form', '" + base +
      "energy.dat' index 1 with lines lw 2 title \"loads are the energy's gradient\"\n";
  if (!WriteText(base + "plot.gp", script).ok()) return 1;
  const int code = std::system(("gnuplot '" + base + "plot.gp'").c_str());
  for (const char* name : {"convergence.dat", "energy.dat", "plot.gp"}) std::remove((base + name).c_str());
  return code == 0 ? 0 : 1;
}

int Main(int argc, char** argv) {
  const std::string convergence = ConvergenceTable(), energy = EnergyTable();
  if (argc == 3 && std::string(argv[1]) == "--figures") return Draw(argv[2], convergence, energy);
  return 0;
}

}  // namespace
}  // namespace tendril

int main(int argc, char** argv) { return tendril::Main(argc, argv); }
