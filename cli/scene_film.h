#pragma once
// What a film of a scene's run shows: the scene and the run put together.

#include "analysis/link/link_series.h"
#include "cli/scene_video.h"
#include "model/scene/scene.h"
#include "model/scene/simulate.h"

namespace tendril::cli {

// A frame for each of the run's. Words are of the links, where there are any.
//   links  of the run's curves, a report each frame
SceneFilm FilmOf(const Scene& scene, const Simulated& done, const LinkSeries& links);

}  // namespace tendril::cli
