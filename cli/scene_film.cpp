#include "cli/scene_film.h"

#include <fmt/format.h>

#include <cmath>

namespace tendril::cli {

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
  film.objects = scene.objects;
  for (const LinkReport& frame : links.frames) {
    std::vector<std::string>& lines = film.lines.emplace_back();
    if (done.curves.size() > 1) lines.push_back(fmt::format("mutual link {:.2f}", frame.mutual_link));
    if (std::isfinite(frame.object_link)) {
      lines.push_back(fmt::format("object link {:.2f}", frame.object_link));
    }
  }
  return film;
}

}  // namespace tendril::cli
