#include "capture/track/tag_search.h"

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "capture/track/tag_fit_problem.h"

namespace tendril {

std::optional<Eigen::Vector2d> SearchTag(const GrayImage& image, const TagLook& look,
                                         const Eigen::Matrix<double, 2, 4>& corners_px, int reach) {
  if (!corners_px.allFinite() || corners_px.cwiseAbs().maxCoeff() > 1e6) return std::nullopt;
  const Eigen::Vector2d middle = corners_px.rowwise().mean();
  const auto h = tag_fit::HomographyTo(corners_px.colwise() - middle);
  if (!h) return std::nullopt;

  struct Sample {
    int x, y;
    float white;  // less the mean
  };
  std::vector<Sample> samples;
  float mean = 0;
  for (int row = 0; row < look.modules; ++row) {
    double level = 0;
    std::size_t step = 0;
    const std::vector<TagLook::Step>& steps = look.steps[static_cast<std::size_t>(row)];
    for (int column = 0; column < look.modules; ++column) {
      for (; step < steps.size() && steps[step].at <= column; ++step) level += steps[step].rise;
      const double x = (2 * column + 1 - look.modules) / static_cast<double>(look.border_width);
      const double y = (2 * row + 1 - look.modules) / static_cast<double>(look.border_width);
      const double depth = (*h)[6] * x + (*h)[7] * y + 1;
      const double u = ((*h)[0] * x + (*h)[1] * y + (*h)[2]) / depth + middle.x();
      const double v = ((*h)[3] * x + (*h)[4] * y + (*h)[5]) / depth + middle.y();
      if (!(std::abs(u) < 1e6 && std::abs(v) < 1e6)) return std::nullopt;
      samples.push_back(
          {static_cast<int>(std::lround(u)), static_cast<int>(std::lround(v)), static_cast<float>(level)});
      mean += static_cast<float>(level);
    }
  }
  const auto count = static_cast<float>(samples.size());
  mean /= count;
  float spread = 0;
  for (Sample& sample : samples) {
    sample.white -= mean;
    spread += sample.white * sample.white;
  }

  float best = 0.5f;
  std::optional<Eigen::Vector2d> found;
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      float sum = 0, squares = 0, both = 0;
      bool inside = true;
      for (const Sample& sample : samples) {
        const int x = sample.x + dx, y = sample.y + dy;
        if (x < 0 || y < 0 || x >= image.width || y >= image.height) {
          inside = false;
          break;
        }
        const float gray = image.pixels[static_cast<std::ptrdiff_t>(y) * image.stride + x];
        sum += gray;
        squares += gray * gray;
        both += gray * sample.white;
      }
      if (!inside) continue;
      const float variance = squares - sum * sum / count;
      if (!(variance > 0)) continue;
      const float correlation = both / std::sqrt(variance * spread);
      if (correlation <= best) continue;
      best = correlation;
      found = Eigen::Vector2d(dx, dy);
    }
  }
  return found;
}

}  // namespace tendril
