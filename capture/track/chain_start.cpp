#include "capture/track/chain_start.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>

#include "model/check.h"
#include "model/fold/facet_chain.h"

namespace tendril {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kViewBound = 60;   // chi-square beyond which a view says no more about a candidate
constexpr double kStepBound = 25;   // likewise of a pair of candidates
constexpr double kPassedOver = 20;  // price of a facet that has candidates and takes none
constexpr int kMostPassedOver = 4;  // in a row

Vector6 PoseStep(const Eigen::Vector3d& turn, const Eigen::Vector3d& move) {
  Vector6 step;
  step << turn, move;
  return step;
}

FacetState Moved(const FacetState& state, const Vector6& step) {
  FacetVector whole = FacetVector::Zero();
  whole.head<6>() = step;
  return Stepped(state, whole);
}

// The two poses (lab_from_sheet) in which a tag looks as this view shows it.
std::vector<FacetState> PosesOfView(const Camera& camera, const TagView& view, double hole_z) {
  const Eigen::Matrix<double, 3, 4>& corners = view.place->corners_in_sheet;
  const Eigen::Vector3d center = corners.rowwise().mean();
  Eigen::Matrix3d sheet_from_tag;
  sheet_from_tag.col(0) = (corners.col(1) - corners.col(0)).normalized();
  const Eigen::Vector3d up = corners.col(3) - corners.col(0);
  sheet_from_tag.col(1) = (up - sheet_from_tag.col(0) * sheet_from_tag.col(0).dot(up)).normalized();
  sheet_from_tag.col(2) = sheet_from_tag.col(0).cross(sheet_from_tag.col(1));

  std::vector<cv::Point3d> in_tag;
  std::vector<cv::Point2d> seen;
  for (int c = 0; c < 4; ++c) {
    const Eigen::Vector3d p = sheet_from_tag.transpose() * (corners.col(c) - center);
    in_tag.emplace_back(p.x(), p.y(), 0.0);
    const std::optional<Eigen::Vector3d> ray = RayOfPixel(camera, view.corners_px.col(c));
    if (!ray || !(ray->z() > 0.05)) return {};
    seen.emplace_back(ray->x() / ray->z(), ray->y() / ray->z());
  }
  std::vector<cv::Mat> turns;
  std::vector<cv::Mat> moves;
  try {
    cv::solvePnPGeneric(in_tag, seen, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), turns, moves, false,
                        cv::SOLVEPNP_IPPE);
  } catch (const cv::Exception&) {
    return {};  // corners that fold over each other are no tag
  }
  const Eigen::Isometry3d lab_from_camera = camera.camera_from_lab.inverse();
  std::vector<FacetState> poses;
  for (std::size_t k = 0; k < turns.size(); ++k) {
    const Eigen::Vector3d turn(turns[k].at<double>(0), turns[k].at<double>(1), turns[k].at<double>(2));
    const Eigen::Vector3d tag_in_camera(moves[k].at<double>(0), moves[k].at<double>(1),
                                        moves[k].at<double>(2));
    if (!turn.allFinite() || !tag_in_camera.allFinite() || !(tag_in_camera.z() > 0)) continue;
    FacetState state;
    state.rotation = lab_from_camera.linear() * RotationOf(turn) * sheet_from_tag.transpose();
    state.hole = lab_from_camera * tag_in_camera + state.rotation * (Eigen::Vector3d(0, 0, hole_z) - center);
    poses.push_back(state);
  }
  return poses;
}

// What a facet's views say about a pose: misfit (each view's bounded), and one Gauss-Newton step.
struct PoseFit {
  double cost = 0;
  Matrix6 hessian = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
};

PoseFit FitOfPose(const ChainModel& model, std::span<const Camera> cameras, std::span<const TagView> views,
                  const std::vector<int>& members, const ChainOptions& options, const FacetState& state) {
  PoseFit fit;
  const TagSlop slop = SlopOfTag(options, state.rotation);
  for (const int v : members) {
    const TagView& view = views[v];
    const Eigen::Vector3d hole(0, 0, model.layout.hole_z[view.place->facet]);
    const Eigen::Vector3d arm = view.place->corners_in_sheet.rowwise().mean() - hole;
    const std::optional<ViewFit> seen =
        FitOfView(cameras[view.camera], view.place->corners_in_sheet, view.corners_px,
                  SigmaOfView(view.sigma_px, options), state.rotation, state.hole + state.rotation * arm);
    if (!seen) {
      fit.cost += kViewBound;
      continue;
    }
    ViewFit loose = WithSlop(*seen, slop);
    fit.cost += kViewBound * loose.cost / (kViewBound + loose.cost);
    // The bounded cost's own weight (Geman-McClure): a view that disagrees hardly pulls.
    const double root = kViewBound / (kViewBound + loose.cost);
    loose.gradient *= root * root;
    loose.hessian *= root * root;
    FacetVector gradient = FacetVector::Zero();
    FacetMatrix hessian = FacetMatrix::Zero();
    AddToFacet(loose, state.rotation, arm, gradient, hessian);
    fit.gradient += gradient.head<6>();
    fit.hessian += hessian.topLeftCorner<6, 6>();
  }
  return fit;
}

FacetCandidate Refined(const ChainModel& model, std::span<const Camera> cameras,
                       std::span<const TagView> views, const std::vector<int>& members,
                       const ChainOptions& options, FacetState state) {
  constexpr int kSteps = 4;
  Matrix6 weak = Matrix6::Zero();  // keeps what no view tells from running away: 1 rad, 0.1 m
  weak.diagonal() << 1, 1, 1, 100, 100, 100;
  PoseFit fit = FitOfPose(model, cameras, views, members, options, state);
  for (int k = 0; k < kSteps; ++k) {
    Vector6 step = -(fit.hessian + weak).ldlt().solve(fit.gradient);
    const double turn = step.head<3>().norm();
    if (turn > 0.3) step *= 0.3 / turn;
    const FacetState next = Moved(state, step);
    const PoseFit there = FitOfPose(model, cameras, views, members, options, next);
    if (!(there.cost < fit.cost)) break;
    const double gain = fit.cost - there.cost;
    state = next;
    fit = there;
    if (gain < 0.1) break;
  }
  return {.state = state, .covariance = (fit.hessian + weak).inverse(), .cost = fit.cost};
}

bool Alike(const FacetState& a, const FacetState& b) {
  const double cosine = 0.5 * ((a.rotation.transpose() * b.rotation).trace() - 1);
  return cosine > std::cos(0.05) && (a.hole - b.hole).norm() < 0.002;
}

// Chi-square of candidate `b` at facet j following candidate `a` at facet i <= j, bounded.
double PriceOfStep(const ChainModel& model, const std::vector<FacetState>& nominal,
                   const std::vector<CreaseGeometry>& creases, const ChainOptions& options, double doubt,
                   int i, const FacetCandidate& a, int j, const FacetCandidate& b) {
  Vector6 off;
  Matrix6 spread = Matrix6::Zero();
  double price = 0;
  if (j == i + 1) {
    // Both carry the crease between them: its centre and its direction must agree.
    const CreaseGeometry& crease = creases[i];
    const auto by_step = [](const FacetState& state, const Eigen::Vector3d& arm,
                            const Eigen::Vector3d& along) {
      Matrix6 jacobian = Matrix6::Zero();
      jacobian.topLeftCorner<3, 3>() = -state.rotation * CrossMatrix(arm);
      jacobian.topRightCorner<3, 3>().setIdentity();
      jacobian.bottomLeftCorner<3, 3>() = -state.rotation * CrossMatrix(along);
      return jacobian;
    };
    off = PoseStep(b.state.hole + b.state.rotation * crease.arm_after - a.state.hole -
                       a.state.rotation * crease.arm_before,
                   b.state.rotation * crease.along - a.state.rotation * crease.along);
    const Matrix6 by_a = by_step(a.state, crease.arm_before, crease.along);
    const Matrix6 by_b = by_step(b.state, crease.arm_after, crease.along);
    spread = by_a * a.covariance * by_a.transpose() + by_b * b.covariance * by_b.transpose();
    spread.diagonal().head<3>().array() += 4 * options.sigma_gap * options.sigma_gap;
    spread.diagonal().tail<3>().array() += 4 * options.sigma_swing * options.sigma_swing;
    const double angle = FoldAngleBetween(crease, a.state.rotation, b.state.rotation);
    const double turn_variance =
        a.covariance.topLeftCorner<3, 3>().trace() + b.covariance.topLeftCorner<3, 3>().trace();
    const double sigma = std::sqrt(doubt * doubt + 0.25 * turn_variance);
    price += std::pow((angle - model.expected_angle[i]) / sigma, 2);
  } else {
    // The fold law bridges the gap, the less surely the longer it is.
    const FacetState& before = nominal[i];
    const FacetState& after = nominal[j];
    const Eigen::Matrix3d rotation = a.state.rotation * before.rotation.transpose() * after.rotation;
    const Eigen::Vector3d arm = a.state.rotation * before.rotation.transpose() * (after.hole - before.hole);
    const Eigen::AngleAxisd turned(Eigen::Matrix3d(rotation * b.state.rotation.transpose()));
    off = PoseStep(turned.angle() * turned.axis(), b.state.hole - a.state.hole - arm);
    const double gap = model.layout.hole_z[j] - model.layout.hole_z[i];
    const double turn = 2 * doubt * std::sqrt(static_cast<double>(j - i));
    spread.diagonal().head<3>().setConstant(turn * turn + a.covariance.topLeftCorner<3, 3>().trace() +
                                            b.covariance.topLeftCorner<3, 3>().trace());
    const double move = 0.5 * turn * gap;
    spread.diagonal().tail<3>().setConstant(move * move + a.covariance.bottomRightCorner<3, 3>().trace() +
                                            b.covariance.bottomRightCorner<3, 3>().trace());
  }
  price += off.dot(spread.ldlt().solve(off));
  return std::isfinite(price) ? kStepBound * price / (kStepBound + price) : kStepBound;
}

// Fills facets first+1 .. last-1 between two that are set: by the fold law from either side, the nearer side
// counting more.
void Bridge(const std::vector<FacetState>& nominal, int first, int last, std::vector<FacetState>& facets) {
  const auto carried = [&](int from, int to) {
    FacetState state;
    const Eigen::Matrix3d turn = facets[from].rotation * nominal[from].rotation.transpose();
    state.rotation = turn * nominal[to].rotation;
    state.hole = facets[from].hole + turn * (nominal[to].hole - nominal[from].hole);
    return state;
  };
  const int count = static_cast<int>(facets.size());
  for (int i = std::max(first + 1, 0); i < std::min(last, count); ++i) {
    if (first < 0) {
      facets[i] = carried(last, i);
    } else if (last >= count) {
      facets[i] = carried(first, i);
    } else {
      const FacetState low = carried(first, i);
      const FacetState high = carried(last, i);
      const double share = static_cast<double>(i - first) / (last - first);
      facets[i].hole = (1 - share) * low.hole + share * high.hole;
      facets[i].rotation =
          Eigen::Quaterniond(low.rotation).slerp(share, Eigen::Quaterniond(high.rotation)).toRotationMatrix();
    }
  }
}

}  // namespace

std::vector<FacetState> NominalChain(const ChainModel& model) {
  const FacetChain chain = FoldChain(model.layout, model.expected_angle);
  std::vector<FacetState> facets;
  for (std::size_t i = 0; i < chain.tentacle_from_sheet.size(); ++i) {
    const Eigen::Isometry3d pose = model.lab_from_tentacle * chain.tentacle_from_sheet[i];
    FacetState state;
    state.rotation = pose.linear();
    state.hole = pose * Eigen::Vector3d(0, 0, model.layout.hole_z[static_cast<Eigen::Index>(i)]);
    facets.push_back(state);
  }
  return facets;
}

std::vector<std::vector<FacetCandidate>> CandidatesOfFacets(const ChainModel& model,
                                                            std::span<const Camera> cameras,
                                                            std::span<const TagView> views,
                                                            const ChainOptions& options, int most) {
  const std::size_t count = static_cast<std::size_t>(model.layout.hole_z.size());
  std::vector<std::vector<int>> members(count);
  for (int v = 0; v < static_cast<int>(views.size()); ++v) {
    if (views[v].corners_px.allFinite()) members[views[v].place->facet].push_back(v);
  }
  std::vector<std::vector<FacetCandidate>> candidates(count);
  for (std::size_t facet = 0; facet < count; ++facet) {
    const double hole_z = model.layout.hole_z[static_cast<Eigen::Index>(facet)];
    std::vector<FacetCandidate>& found = candidates[facet];
    for (const int v : members[facet]) {
      for (const FacetState& pose : PosesOfView(cameras[views[v].camera], views[v], hole_z)) {
        const FacetCandidate candidate = Refined(model, cameras, views, members[facet], options, pose);
        const auto twin = std::find_if(found.begin(), found.end(), [&](const FacetCandidate& other) {
          return Alike(other.state, candidate.state);
        });
        if (twin == found.end()) {
          found.push_back(candidate);
        } else if (candidate.cost < twin->cost) {
          *twin = candidate;
        }
      }
    }
    std::sort(found.begin(), found.end(),
              [](const FacetCandidate& a, const FacetCandidate& b) { return a.cost < b.cost; });
    if (static_cast<int>(found.size()) > most) found.resize(static_cast<std::size_t>(most));
  }
  return candidates;
}

std::vector<FacetState> StartOfChain(const ChainModel& model,
                                     const std::vector<std::vector<FacetCandidate>>& candidates,
                                     const ChainOptions& options, double doubt) {
  std::vector<FacetState> nominal = NominalChain(model);
  std::vector<CreaseGeometry> creases;
  for (int i = 0; i < model.layout.crease_z.size(); ++i) creases.push_back(GeometryOfCrease(model.layout, i));
  std::vector<int> occupied;  // facets that have candidates
  for (int i = 0; i < static_cast<int>(candidates.size()); ++i) {
    if (!candidates[i].empty()) occupied.push_back(i);
  }
  if (occupied.empty()) return nominal;

  // The base stands before the first facet as one more candidate, at the gripper.
  FacetCandidate base;
  base.state = nominal.front();
  base.covariance = Matrix6::Zero();
  base.covariance.diagonal().head<3>().setConstant(0.1 * 0.1);
  base.covariance.diagonal().tail<3>().setConstant(0.005 * 0.005);

  // Cheapest way to have chosen candidate c of the k-th occupied facet, and the choice before it.
  struct Choice {
    double price = std::numeric_limits<double>::infinity();
    int before = -1;  // index into `occupied`; -1: the base
    int candidate = -1;
  };
  const int steps = static_cast<int>(occupied.size());
  std::vector<std::vector<Choice>> best(steps);
  const auto passed = [&](int from, int to) {  // the price of what lies between two choices
    double views_passed = 0;
    for (int k = from + 1; k < to; ++k) {
      views_passed += kPassedOver + candidates[occupied[k]].front().cost;
    }
    return views_passed;
  };
  for (int k = 0; k < steps; ++k) {
    const int facet = occupied[k];
    best[k].resize(candidates[facet].size());
    for (std::size_t c = 0; c < candidates[facet].size(); ++c) {
      const FacetCandidate& here = candidates[facet][c];
      Choice& choice = best[k][c];
      if (k <= kMostPassedOver) {
        const double price = PriceOfStep(model, nominal, creases, options, doubt, 0, base, facet, here);
        choice = {.price = passed(-1, k) + price + here.cost, .before = -1, .candidate = -1};
      }
      for (int before = std::max(0, k - 1 - kMostPassedOver); before < k; ++before) {
        const double between = passed(before, k) + here.cost;
        for (std::size_t d = 0; d < best[before].size(); ++d) {
          if (best[before][d].price + between >= choice.price) continue;
          const double price = best[before][d].price + between +
                               PriceOfStep(model, nominal, creases, options, doubt, occupied[before],
                                           candidates[occupied[before]][d], facet, here);
          if (price < choice.price) {
            choice = {.price = price, .before = before, .candidate = static_cast<int>(d)};
          }
        }
      }
    }
  }
  int last = -1;
  int last_candidate = -1;
  double cheapest = std::numeric_limits<double>::infinity();
  for (int k = std::max(0, steps - 1 - kMostPassedOver); k < steps; ++k) {
    for (std::size_t c = 0; c < best[k].size(); ++c) {
      const double price = best[k][c].price + passed(k, steps);
      if (price < cheapest) {
        cheapest = price;
        last = k;
        last_candidate = static_cast<int>(c);
      }
    }
  }
  std::vector<FacetState> facets = nominal;
  int after = static_cast<int>(candidates.size());
  while (last >= 0) {
    const int facet = occupied[last];
    facets[facet] = candidates[facet][last_candidate].state;
    Bridge(nominal, facet, after, facets);
    after = facet;
    const Choice& choice = best[last][last_candidate];
    last = choice.before;
    last_candidate = choice.candidate;
  }
  if (after > 0) {
    // Facet 0 is where the gripper holds it.
    facets.front() = nominal.front();
    Bridge(nominal, 0, after, facets);
  }
  return facets;
}

}  // namespace tendril
