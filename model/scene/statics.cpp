#include "model/scene/statics.h"

#include <algorithm>
#include <cmath>

#include "model/rods/rod_static.h"
#include "model/scene/plan.h"

namespace tendril {
namespace {

using Eigen::Matrix3Xd;

// Between two equilibria the rest shape turns by at most this much in all, rad.
constexpr double kTurningStep = 1.0;

}  // namespace

Result<StaticSolver> StaticSolver::Make(const Scene& scene, std::vector<Driven> rods) {
  for (const Driven& d : rods) {
    if (d.rod.base.hold == EndHold::kFrame && d.rod.tip.hold == EndHold::kFree) continue;
    return Error{
        ErrorKind::kBadInput,
        "rod " + d.name + ": level static needs a base that is held and a free tip (clamp = \"base\")"};
  }
  return StaticSolver(scene, std::move(rods));
}

Status StaticSolver::Settle(Driven& d, double time) {
  const Matrix3Xd before = d.rod.rest_curvature;
  ApplyDrive(DriveAt(scene_, d, CarrierGrowthAt(scene_, rods_, time), time), d, d.rod);
  const Matrix3Xd after = d.rod.rest_curvature;
  Matrix3Xd force = scene_.gravity * d.rod.mass.transpose();
  force.rightCols<1>() += d.tip_force;
  const double turning = (after - before).colwise().norm().sum() * d.rod.rest_length[0];
  const int parts = std::max(started_ ? 1 : 10, static_cast<int>(std::ceil(turning / kTurningStep)));
  for (int part = 1; part <= parts; ++part) {
    const double share = static_cast<double>(part) / parts;
    d.rod.rest_curvature = before + share * (after - before);
    // At the start the loads grow too.
    const Result<StaticAccount> settled = SettleRod(d.rod, started_ ? force : share * force);
    ++solved_;
    if (!settled.ok()) {
      return Error(settled.error()).Within("at " + ShortNumber(time) + " s, rod " + d.name);
    }
  }
  return Ok{};
}

Result<std::vector<Rod>> StaticSolver::At(double time) {
  std::vector<Rod> rods;
  for (Driven& d : rods_) {
    if (Status s = Settle(d, time); !s.ok()) return s.error();
    rods.push_back(d.rod);
  }
  started_ = true;
  return rods;
}

}  // namespace tendril
