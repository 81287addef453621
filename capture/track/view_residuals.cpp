#include "capture/track/view_residuals.h"

#include <limits>
#include <optional>

namespace tendril {

void AppendResiduals(std::span<const Camera> cameras, const TentacleLayout& layout,
                     std::span<const TagView> views, const ChainSolution& solution, std::int64_t frame,
                     std::vector<ResidualRow>& rows) {
  for (std::size_t v = 0; v < views.size(); ++v) {
    const TagView& view = views[v];
    const int facet = view.place->facet;
    const Eigen::Isometry3d lab_from_sheet =
        LabFromSheet(layout, solution.facets[static_cast<std::size_t>(facet)], facet);
    ResidualRow row{.camera = view.camera,
                    .frame = frame,
                    .tag = view.place->id,
                    .used = solution.used[v] != 0,
                    .corners_px = {}};
    for (int k = 0; k < 4; ++k) {
      const std::optional<Eigen::Vector2d> expected =
          Project(cameras[static_cast<std::size_t>(view.camera)],
                  lab_from_sheet * view.place->corners_in_sheet.col(k));
      if (expected) {
        row.corners_px.col(k) = view.corners_px.col(k) - *expected;
      } else {
        row.corners_px.col(k).setConstant(std::numeric_limits<double>::quiet_NaN());
      }
    }
    rows.push_back(row);
  }
}

}  // namespace tendril
