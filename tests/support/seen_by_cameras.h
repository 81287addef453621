#pragma once
// Campaigns in which each node is seen by some of several cameras, for testing what a further camera is said
// to be worth: the same tentacles, moments and errors with the cameras that there are and with one more.

#include <cmath>
#include <string>
#include <vector>

#include "tests/support/perturbed_tentacle.h"

namespace tendril::test {

struct CameraStudy {
  std::string name;
  Perturbation how{};                     // of the tentacles
  double sigma = 0.3e-3;                  // of a node's place from one camera, each axis, m
  double stated = 1;                      // times the true sigma
  std::vector<double> sees = {0.9, 0.9};  // share of the nodes that each camera sees, one block per tentacle
  double further_sees = 0.9;              // that one more would see
  int trials = 12;
  double pull = 0.3;
};

struct CameraCampaign {
  std::vector<FoldObservation> before;  // with `cameras`, and `further` of one place
  std::vector<FoldObservation> after;   // one camera more
};

// Two nodes in three frames of a hold, two while the pull rises, one flat. A camera sees a run of nodes,
// other runs in other tentacles and trials.
inline CameraCampaign DrawCampaign(const CameraStudy& study, const TentacleDesign& design,
                                   const FoldTruth& truth, std::uint64_t seed) {
  CameraCampaign campaign;
  for (int trial = 0; trial < study.trials; ++trial) {
    Random random(seed + static_cast<std::uint64_t>(trial));
    const PerturbedTentacle shape = Draw(design, truth, study.how, random);
    const int nodes = design.holes;
    std::vector<Eigen::VectorXi> sight;  // cameras, the further one last
    std::vector<double> shares = study.sees;
    shares.push_back(study.further_sees);
    for (const double share : shares) {
      Eigen::VectorXi sees = Eigen::VectorXi::Zero(nodes);
      const int run = static_cast<int>(std::lround(share * nodes));
      const int first = static_cast<int>(Uniform(random, 0, nodes));
      for (int i = 0; i < run; ++i) sees[(first + i) % nodes] = 1;
      sight.push_back(sees);
    }
    for (int frame = 0; frame < 6; ++frame) {
      FoldObservation o;
      o.trial = "t" + std::to_string(trial);
      o.design = design;
      o.time = frame;
      o.commanded_pull = study.pull * std::min(frame, 3) / 3.0;
      o.settled_for = frame == 0 || frame >= 3 ? 10 : 0;
      o.steady_for = frame == 0 || frame >= 3 ? 10 : 0.1;
      const Eigen::Matrix3Xd holes = HolesAt(shape, truth.pull_scale * o.commanded_pull);
      // Errors of each camera, whether it sees the node or not: so both campaigns have the same.
      std::vector<Eigen::Matrix3Xd> errors;
      for (std::size_t c = 0; c < sight.size(); ++c) {
        Eigen::Matrix3Xd error(3, nodes);
        for (Eigen::Index i = 0; i < error.size(); ++i) error(i) = Normal(random, study.sigma);
        errors.push_back(error);
      }
      for (const bool more : {false, true}) {
        FoldObservation& with = more ? campaign.after.emplace_back(o) : campaign.before.emplace_back(o);
        with.curve.points = holes;
        with.sigma.setConstant(nodes, std::numeric_limits<double>::quiet_NaN());
        with.interpolated.setOnes(nodes);
        with.cameras.setZero(nodes);
        for (std::size_t c = 0; c + (more ? 0 : 1) < sight.size(); ++c) with.cameras += sight[c];
        if (!more) with.further = sight.back().transpose();
        for (int i = 0; i < nodes; ++i) {
          if (with.cameras[i] == 0) continue;
          Eigen::Vector3d error = Eigen::Vector3d::Zero();
          for (std::size_t c = 0; c + (more ? 0 : 1) < sight.size(); ++c)
            error += sight[c][i] * errors[c].col(i) / with.cameras[i];
          with.curve.points.col(i) += error;
          with.sigma[i] = study.stated * study.sigma / std::sqrt(with.cameras[i]);
          with.interpolated[i] = 0;
        }
      }
    }
  }
  return campaign;
}

inline std::vector<CameraStudy> CameraStudies() {
  Perturbation alike;
  alike.stiffness = alike.place = alike.crease_angle = 0;
  return {
      {.name = "tentacles differ, sharp pictures", .sigma = 0.15e-3},
      {.name = "tentacles differ, coarse pictures", .sigma = 1e-3},
      {.name = "tentacles alike, coarse pictures", .how = alike, .sigma = 1e-3, .sees = {0.9}},
      {.name = "the same, stated sigma 3 times too large",
       .how = alike,
       .sigma = 0.7e-3,
       .stated = 3,
       .sees = {0.9}},
      {.name = "tentacles differ, half hidden", .sigma = 0.3e-3, .sees = {0.3, 0.3}, .further_sees = 0.5}};
}

}  // namespace tendril::test
