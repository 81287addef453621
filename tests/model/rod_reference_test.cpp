// model/rods' paper form against the simulator that the paper used (PyElastica), at its own steps: a coiling
// rod, a falling cantilever, a tip load and a free rod.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>

#include "model/rods/contact.h"
#include "model/rods/rod_plain.h"
#include "tests/support/shared_data.h"

namespace tendril {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

std::filesystem::path Reference(const char* file) {
  return testing_support::SharedFolder() / "reference" / file;
}

// Rows of numbers under a header line.
std::vector<std::vector<double>> ReadNumbers(const std::filesystem::path& file) {
  std::vector<std::vector<double>> rows;
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    rows.emplace_back();
    std::stringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

// Nodes of one rod by time, from a file of t,rod,node,x,y,z.
std::map<double, std::vector<Vector3d>> ReadNodes(const std::filesystem::path& file, int rod = 0) {
  std::map<double, std::vector<Vector3d>> nodes;
  for (const auto& row : ReadNumbers(file)) {
    if (static_cast<int>(row[1]) == rod) nodes[row[0]].emplace_back(row[3], row[4], row[5]);
  }
  return nodes;
}

double LargestDistance(const Rod& rod, const std::vector<Vector3d>& nodes) {
  EXPECT_EQ(rod.position.cols(), static_cast<Eigen::Index>(nodes.size()));
  double largest = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    largest = std::max(largest, (rod.position.col(static_cast<Eigen::Index>(i)) - nodes[i]).norm());
  }
  return largest;
}

RodDesign Uniform(double length, double radius, double modulus) {
  RodDesign design;
  design.length = length;
  design.base_radius = radius;
  design.youngs_modulus = modulus;
  design.shear_modulus = modulus / 3;
  return design;
}

TEST(PaperForm, CoilsAsThePeersRodDoes) {
  TENDRIL_SKIP_WITHOUT(Reference("R1_nodes.csv"));
  const auto expected = ReadNodes(Reference("R1_nodes.csv"));
  Rod rod = MakeRod(Uniform(0.75, 0.015, 1e6)).value();
  const PlainOptions options{.form = RodForm::kPaper, .time_step = 2e-5, .damping = 8};
  const auto ramp = [](double time, std::span<Rod> rods, auto) {
    rods[0].rest_curvature.colwise() = std::min(time, 1.0) * Vector3d(0, 12, 4);
  };
  int step = 0;
  for (const double until : {0.1, 0.25, 0.5, 1.0}) {
    for (; step < std::lround(until / options.time_step); ++step) {
      StepPlain({&rod, 1}, step * options.time_step, options, ramp);
    }
    EXPECT_LT(LargestDistance(rod, expected.at(until)), 1e-10) << "at " << until << " s";
  }
}

TEST(PaperForm, FallsAsThePeersCantileverDoes) {
  TENDRIL_SKIP_WITHOUT(Reference("R2_dynamic_tip.csv"));
  RodDesign design = Uniform(0.75, 0.02, 1e5);
  design.taper = 0.5;
  design.direction = Vector3d::UnitX();
  design.normal = Vector3d::UnitZ();
  Rod rod = MakeRod(design).value();
  const PlainOptions options{.form = RodForm::kPaper, .time_step = 1e-5, .gravity = {0, 0, -9.80665}};
  int step = 0;
  double largest = 0;
  for (const auto& row : ReadNumbers(Reference("R2_dynamic_tip.csv"))) {
    for (; step < std::lround(row[0] / options.time_step); ++step) {
      StepPlain({&rod, 1}, step * options.time_step, options);
    }
    largest = std::max(largest, (rod.position.col(100) - Vector3d(row[1], row[2], row[3])).norm());
    largest = std::max(largest, (rod.position.col(50) - Vector3d(row[4], row[5], row[6])).norm());
  }
  EXPECT_EQ(step, 50000);
  EXPECT_LT(largest, 1e-9);
}

TEST(PaperForm, SagsUnderATipLoadAsThePeersRodDoes) {
  TENDRIL_SKIP_WITHOUT(Reference("R3_G10000_nodes.csv"));
  for (const auto& [file, shear] :
       {std::pair{"R3_G333333_nodes.csv", 1e6 / 3}, {"R3_G10000_nodes.csv", 1e4}}) {
    RodDesign design = Uniform(0.75, 0.05, 1e6);
    design.shear_modulus = shear;
    design.direction = Vector3d::UnitX();
    design.normal = Vector3d::UnitZ();
    Rod rod = MakeRod(design).value();
    // Where it comes to rest does not depend on the step.
    const PlainOptions options{.form = RodForm::kPaper, .time_step = 6e-5, .damping = 10};
    for (int step = 0; step < 60000; ++step) {
      StepPlain({&rod, 1}, step * options.time_step, options, [](double, auto, std::span<Matrix3Xd> forces) {
        forces[0].rightCols(1).row(2).array() -= 0.01;
      });
    }
    EXPECT_LT(LargestDistance(rod, ReadNodes(Reference(file)).at(6)), 1e-9) << file;
  }
}

TEST(PaperForm, AFreeRodsEnergySwingsAsThePeersDoes) {
  TENDRIL_SKIP_WITHOUT(Reference("R4_energy_dt1e-5.csv"));
  RodDesign design = Uniform(0.5, 0.01, 1e6);
  design.elements = 50;
  design.density = 500;
  design.direction = Vector3d::UnitX();
  design.normal = Vector3d::UnitZ();
  design.base = EndHold::kFree;
  Rod rod = MakeRod(design).value();
  for (int i = 0; i <= 50; ++i) {
    const double s = std::numbers::pi * i / 50;
    rod.velocity.col(i) << 0.1 * std::cos(s), 0.3 * std::sin(3 * s), 0.5 * std::cos(2 * s);
    if (i < 50) rod.spin(2, i) = 5 * std::cos(std::numbers::pi * (i + 0.5) / 50);
  }
  const PlainOptions options{.form = RodForm::kPaper, .time_step = 1e-5};
  int step = 0;
  for (const auto& row : ReadNumbers(Reference("R4_energy_dt1e-5.csv"))) {
    for (; step < std::lround(row[0] / options.time_step); ++step) {
      StepPlain({&rod, 1}, step * options.time_step, options);
    }
    const RodEnergy energy = EnergyOf(rod);
    const double total = row[5];
    EXPECT_NEAR(energy.translation, row[1], 1e-8 * total) << "at " << row[0] << " s";
    // (The peer adds 1e-14 to lengths and angles: after 1e5 steps that is 2e-9 of the energy.)
    // In the paper's form a stretched element's inertia is J / e.
    double rotation = 0;
    for (Eigen::Index i = 0; i < rod.elements(); ++i) {
      const double stretch = (rod.position.col(i + 1) - rod.position.col(i)).norm() / rod.rest_length[i];
      rotation += 0.5 / stretch * rod.inertia.col(i).dot(rod.spin.col(i).cwiseAbs2());
    }
    EXPECT_NEAR(rotation, row[2], 1e-8 * total);
    EXPECT_NEAR(energy.bend, row[3], 1e-8 * total);
    EXPECT_NEAR(energy.shear, row[4], 1e-8 * total);
  }
  EXPECT_LT(LargestDistance(rod, ReadNodes(Reference("R4_final_nodes_dt1e-5.csv")).begin()->second), 1e-10);
}

// Its Hertz contact with the force shared equally (`pow` in its files).
TEST(PaperForm, RodsCollideAsThePeersDo) {
  TENDRIL_SKIP_WITHOUT(Reference("R5_pow_nodes.csv"));
  RodDesign design = Uniform(0.4, 0.01, 1e6);
  design.elements = 40;
  design.density = 500;
  design.base = EndHold::kFree;
  design.start = {-0.2, 0, 0};
  design.direction = Vector3d::UnitX();
  design.normal = Vector3d::UnitZ();
  RodDesign other = design;
  const double angle = 80 * std::numbers::pi / 180;
  other.direction = {std::cos(angle), std::sin(angle), 0};
  other.start = Vector3d(0.013, 0.021, 0.022) - 0.2 * other.direction;
  std::vector<Rod> rods = {MakeRod(design).value(), MakeRod(other).value()};
  rods[1].velocity.row(2).setConstant(-0.5);
  const PlainOptions options{.form = RodForm::kPaper, .time_step = 1e-5};
  const Contact contact{.law = ContactLaw::kHertzEqual, .stiffness = 1e4, .damping = 0.05};
  const auto touch = [&](double, std::span<Rod> r, std::span<Matrix3Xd> forces) {
    AddRodContact(contact, r[0], r[1], forces[0], forces[1]);
  };
  const auto first = ReadNodes(Reference("R5_pow_nodes.csv"), 0);
  const auto second = ReadNodes(Reference("R5_pow_nodes.csv"), 1);
  int step = 0;
  for (const auto& [time, nodes] : first) {
    for (; step < std::lround(time / options.time_step); ++step) {
      StepPlain(rods, step * options.time_step, options, touch);
    }
    EXPECT_LT(LargestDistance(rods[0], nodes), 1e-9) << time;
    EXPECT_LT(LargestDistance(rods[1], second.at(time)), 1e-9) << time;
  }
  EXPECT_EQ(step, 15000);
}

TEST(PaperForm, DrapesOverACylinderAsThePeersRodDoes) {
  TENDRIL_SKIP_WITHOUT(Reference("R6_pow_nodes.csv"));
  RodDesign design = Uniform(0.5, 0.012, 2e5);
  design.elements = 80;
  design.taper = 0.6;
  design.density = 200;
  design.start = {-0.1, 0.01, 0.06};
  design.direction = Vector3d::UnitX();
  design.normal = Vector3d::UnitZ();
  Rod rod = MakeRod(design).value();
  const PlainOptions options{
      .form = RodForm::kPaper, .time_step = 2e-5, .damping = 4, .gravity = {0, 0, -9.80665}};
  const Contact contact{.law = ContactLaw::kHertzEqual, .stiffness = 1e4};
  const FixedBody cylinder{.start = {0, -0.14, 0}, .end = {0, 0.14, 0}, .radius = 0.0225};
  int step = 0;
  for (const auto& [time, nodes] : ReadNodes(Reference("R6_pow_nodes.csv"))) {
    if (time > 1) break;
    for (; step < std::lround(time / options.time_step); ++step) {
      StepPlain({&rod, 1}, step * options.time_step, options,
                [&](double, auto r, auto forces) { AddBodyContact(contact, r[0], cylinder, forces[0]); });
    }
    EXPECT_LT(LargestDistance(rod, nodes), 1e-8) << time;
  }
  EXPECT_EQ(step, 50000);
}

TEST(PaperForm, TwoCoilingRodsEntangleAsThePeersDo) {
  TENDRIL_SKIP_WITHOUT(Reference("R8_pow_dt2e-05_nodes.csv"));
  RodDesign design;
  design.taper = 0.5;
  design.start = {0, -0.03, 0};
  design.direction = -Vector3d::UnitZ();
  design.normal = Vector3d::UnitY();
  RodDesign other = design;
  other.start = {0.004, 0.03, 0};
  other.normal = -Vector3d::UnitY();
  std::vector<Rod> rods = {MakeRod(design).value(), MakeRod(other).value()};
  const PlainOptions options{
      .form = RodForm::kPaper, .time_step = 2e-5, .damping = 2, .gravity = {0, 0, -9.80665}};
  const Contact contact{.law = ContactLaw::kHertzEqual, .stiffness = 1e4};
  double largest_force = 0;
  const auto middle = [&](double time, std::span<Rod> r, std::span<Matrix3Xd> forces) {
    for (int i = 0; i < 2; ++i) {
      const double share = std::clamp((time - 0.1 * i) / 1.5, 0.0, 1.0);
      r[static_cast<std::size_t>(i)].rest_curvature.colwise() = share * Vector3d(0, 12, 4);
    }
    AddRodContact(contact, r[0], r[1], forces[0], forces[1]);
    largest_force = std::max(largest_force, forces[0].cwiseAbs().maxCoeff());
  };
  const auto first = ReadNodes(Reference("R8_pow_dt2e-05_nodes.csv"), 0);
  const auto second = ReadNodes(Reference("R8_pow_dt2e-05_nodes.csv"), 1);
  int step = 0;
  for (const auto& [time, nodes] : first) {
    if (time > 1.5) break;
    for (; step < std::lround(time / options.time_step); ++step) {
      StepPlain(rods, step * options.time_step, options, middle);
    }
    EXPECT_LT(LargestDistance(rods[0], nodes), 1e-7) << time;
    EXPECT_LT(LargestDistance(rods[1], second.at(time)), 1e-7) << time;
  }
  EXPECT_GT(largest_force, 0);
}

}  // namespace
}  // namespace tendril
