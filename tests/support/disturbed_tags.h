#pragma once
// Drawn tags that something spoils: the exposure's motion blur, a lamp's glare, a cable in front.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/support/render_tag.h"

namespace tendril::testing_support {

enum class Disturbance { kNone, kSmear, kGlare, kCable };
inline constexpr const char* kDisturbanceNames[] = {"nothing", "smear", "glare", "cable"};

// Mean of the picture along a way of `length_px` in that direction, centred: light comes in evenly while it
// is open.
inline void Smear(Picture& picture, double length_px, double direction) {
  const int steps = std::max(1, static_cast<int>(std::ceil(4 * length_px)));
  Picture out(picture.width, picture.height, 0);
  const auto at = [&](double u, double v) {
    u = std::clamp(u, 0.0, picture.width - 1.001);
    v = std::clamp(v, 0.0, picture.height - 1.001);
    const int x = static_cast<int>(u), y = static_cast<int>(v);
    const double a = u - x, b = v - y;
    return (1 - b) * ((1 - a) * picture.At(x, y) + a * picture.At(x + 1, y)) +
           b * ((1 - a) * picture.At(x, y + 1) + a * picture.At(x + 1, y + 1));
  };
  for (int v = 0; v < picture.height; ++v) {
    for (int u = 0; u < picture.width; ++u) {
      double sum = 0;
      for (int i = 0; i < steps; ++i) {
        const double s = length_px * ((i + 0.5) / steps - 0.5);
        sum += at(u + s * std::cos(direction), v + s * std::sin(direction));
      }
      out.At(u, v) = sum / steps;
    }
  }
  picture = out;
}

// A blob of light of that radius: so many gray levels in the middle, falling off like a Gaussian, up to
// white.
inline void Shine(Picture& picture, const Eigen::Vector2d& at, double radius_px, double levels) {
  for (int v = 0; v < picture.height; ++v) {
    for (int u = 0; u < picture.width; ++u) {
      const double r = (Eigen::Vector2d(u, v) - at).norm() / radius_px;
      picture.At(u, v) = std::min(255.0, picture.At(u, v) + levels * std::exp(-r * r));
    }
  }
}

// A straight cable of one grey level across the whole picture, with soft edges.
inline void LayCable(Picture& picture, const Eigen::Vector2d& through, double direction, double width_px,
                     double gray) {
  const Eigen::Vector2d normal(-std::sin(direction), std::cos(direction));
  for (int v = 0; v < picture.height; ++v) {
    for (int u = 0; u < picture.width; ++u) {
      const double off = std::abs((Eigen::Vector2d(u, v) - through).dot(normal));
      const double share = std::clamp(0.5 + 0.5 * width_px - off, 0.0, 1.0);
      picture.At(u, v) += share * (gray - picture.At(u, v));
    }
  }
}

// One tag that moves evenly, spoilt from the fifth picture on. Everything is drawn from the seed: place,
// tilt, speed, size (footprint 20 to 25 px), blur 0.6 to 1 px, noise of 3 gray levels; smear of 1 to 5 px
// along the motion (as if exposed for up to the whole interval), a blob of 0.15 to 0.5 footprints and 60 to
// 500 gray levels, a cable of 2 to 8 px.
struct DisturbedFilm {
  static constexpr int kWidth = 112, kHeight = 112, kFrames = 10, kFrom = 5;
  std::vector<std::vector<unsigned char>> pictures;
  std::vector<Eigen::Matrix<double, 2, 4>> truth;  // at the middle of the exposure
  int id = 0;
};
inline DisturbedFilm FilmOf(Disturbance disturbance, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto from_to = [&](double a, double b) { return a + (b - a) * unit(random); };
  DisturbedFilm film;
  film.id = static_cast<int>(random() % 500);
  const TagPattern pattern = PatternOf("tag36h11", film.id).value();
  const double side = 0.8 * from_to(20, 25), tilt = from_to(0, 0.785), axis = from_to(0, 6.28),
               roll = from_to(0, 6.28);
  const double direction = from_to(0, 6.28), blur = from_to(0.6, 1.0);
  const double length = from_to(1, 5), radius = from_to(0.15, 0.5) * side / 0.8, width = from_to(2, 8);
  const double cable = from_to(0, 6.28), gray = unit(random) < 0.5 ? from_to(10, 60) : from_to(120, 220);
  const double levels = 60 * std::pow(500.0 / 60, unit(random));
  const Eigen::Vector2d aside(from_to(-0.5, 0.5) * side, from_to(-0.5, 0.5) * side);
  // Smear is the motion of one exposure, a frame's motion at most.
  const double speed = disturbance == Disturbance::kSmear ? std::max(length, from_to(1, 5)) : from_to(0, 2);
  const Eigen::Vector2d way = speed * Eigen::Vector2d(std::cos(direction), std::sin(direction));
  for (int f = 0; f < DisturbedFilm::kFrames; ++f) {
    const Eigen::Vector2d middle =
        Eigen::Vector2d(55.5, 55.5) + (f - 4.5) * way + Eigen::Vector2d(unit(random), 0);
    film.truth.push_back(TiltedCorners(middle, side, tilt, axis, roll));
    Picture picture(DisturbedFilm::kWidth, DisturbedFilm::kHeight, 80);
    DrawTag(picture, pattern, 8, film.truth.back());
    if (f >= DisturbedFilm::kFrom) {
      if (disturbance == Disturbance::kSmear) Smear(picture, length, direction);
      if (disturbance == Disturbance::kGlare) Shine(picture, middle + aside, radius, levels);
      if (disturbance == Disturbance::kCable) LayCable(picture, middle + aside, cable, width, gray);
    }
    Blur(picture, blur);
    AddNoise(picture, 3, random);
    film.pictures.push_back(picture.Bytes());
  }
  return film;
}

}  // namespace tendril::testing_support
