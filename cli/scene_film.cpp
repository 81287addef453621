#include "cli/scene_film.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "model/scene/schedule.h"

namespace tendril::cli {
namespace {

// The circle through the tentacles' first nodes, about the carrier's axis; nothing where there is none. It
// grows with the pull where the carrier does.
Eigen::Matrix3Xd CarrierAt(const CarrierMotion& motion, const std::vector<CurveSeries>& curves, int tentacles,
                           std::size_t frame) {
  double radius = 0;
  for (int i = 0; i < tentacles; ++i) {
    const Eigen::Vector3d base = curves[static_cast<std::size_t>(i)].curves[frame].points.col(0);
    radius += (motion.turned.transpose() * (base - motion.offset)).head<2>().norm() / tentacles;
  }
  if (!(radius > 0) || !std::isfinite(radius)) return {};
  constexpr int kParts = 72;
  Eigen::Matrix3Xd ring(3, kParts + 1);
  for (int i = 0; i <= kParts; ++i) {
    const double angle = 2 * std::numbers::pi * i / kParts;
    ring.col(i) = motion.offset +
                  motion.turned * Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), 0);
  }
  return ring;
}

// Gravity in words where it is not the usual one.
std::string GravityText(const Eigen::Vector3d& gravity) {
  if (gravity.isZero(0)) return "no gravity";
  const Eigen::Vector3d along = gravity.normalized();
  if (along.z() < -0.999) return "";
  int axis = 0;
  const double most = along.cwiseAbs().maxCoeff(&axis);
  if (most < 0.999)
    return fmt::format("gravity along ({:.2f}, {:.2f}, {:.2f})", along.x(), along.y(), along.z());
  return fmt::format("gravity along {}{}", along[axis] < 0 ? '-' : '+', "xyz"[axis]);
}

// The published contact laws know a cylinder by its axis and radius alone.
SceneObject AsTouched(SceneObject object, const Contact& contact) {
  if (contact.law == ContactLaw::kHertzSegments) return object;
  for (Primitive& part : object.shape) {
    if (part.kind == PrimitiveKind::kCylinder) part.kind = PrimitiveKind::kCapsule;
  }
  return object;
}

}  // namespace

SceneFilm FilmOf(const Scene& scene, const Simulated& done, const LinkSeries& links) {
  SceneFilm film{.name = scene.name, .curves = done.curves};
  for (const CurveSeries& one : done.curves) {
    const bool tentacle =
        scene.gripper && film.radius.size() < static_cast<size_t>(scene.gripper->gripper.tentacles);
    const size_t plain =
        film.radius.size() - (scene.gripper ? static_cast<size_t>(scene.gripper->gripper.tentacles) : 0);
    const RodDesign& design = tentacle ? scene.gripper->rod : scene.rods[plain].design;
    const double taper = tentacle ? scene.gripper->design.taper : design.taper;
    film.radius.push_back(Eigen::VectorXd::LinSpaced(one.curves[0].points.cols(), design.base_radius,
                                                     design.base_radius * taper));
  }
  for (const SceneObject& object : scene.objects) film.objects.push_back(AsTouched(object, scene.contact));
  for (const ObjectSeries& object : done.objects) film.poses.push_back(object.poses);
  const Eigen::VectorXd& time = done.curves[0].time;
  std::optional<Schedule> schedule;
  if (!scene.phases.empty()) schedule.emplace(scene.phases);
  for (Eigen::Index f = 0; f < time.size(); ++f) {
    if (schedule) film.phases.push_back(schedule->phases()[schedule->PhaseAt(time[f])].name);
    if (!scene.gripper || scene.gripper->gripper.tentacles < 1) continue;
    film.carrier.push_back(CarrierAt(schedule ? schedule->At(time[f]) : CarrierMotion(), done.curves,
                                     scene.gripper->gripper.tentacles, static_cast<std::size_t>(f)));
  }
  const std::string gravity = GravityText(scene.gravity);
  for (const LinkReport& frame : links.frames) {
    std::vector<std::string>& lines = film.lines.emplace_back();
    if (!gravity.empty()) lines.push_back(gravity);
    if (done.curves.size() > 1) lines.push_back(fmt::format("mutual link {:.2f}", frame.mutual_link));
    if (std::isfinite(frame.object_link)) {
      lines.push_back(fmt::format("object link {:.2f}", frame.object_link));
    }
  }
  return film;
}

}  // namespace tendril::cli
