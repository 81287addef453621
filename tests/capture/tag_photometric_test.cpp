#include "capture/track/tag_photometric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/render_tag.h"

namespace tendril {
namespace {

using testing_support::AddNoise;
using testing_support::Blur;
using testing_support::DrawTag;
using testing_support::Picture;
using testing_support::TiltedCorners;

constexpr double kDegree = std::numbers::pi / 180;

TagLook Look(int id, const char* family = "tag36h11") { return LookOf(family, id).value(); }

// Share of white by samples of the blur, nothing else.
double BySamples(const TagPattern& pattern, const Eigen::Matrix2d& covariance, const Eigen::Vector2d& place) {
  const Eigen::Matrix2d root = covariance.llt().matrixL();
  double sum = 0, total = 0;
  for (int i = -120; i <= 120; ++i) {
    for (int k = -120; k <= 120; ++k) {
      const Eigen::Vector2d z(i / 24.0, k / 24.0);
      const Eigen::Vector2d at = place + root * z;
      const auto row = static_cast<Eigen::Index>(std::floor(at.y())),
                 column = static_cast<Eigen::Index>(std::floor(at.x()));
      const bool on = row >= 0 && column >= 0 && row < pattern.rows() && column < pattern.cols();
      const double weight = std::exp(-0.5 * z.squaredNorm());
      sum += weight * (on && pattern(row, column) > 127 ? 1 : 0);
      total += weight;
    }
  }
  return sum / total;
}

TEST(TagPhotometric, SeesWhatSamplesOfTheBlurSee) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(1, 9), size(0.15, 0.6), turn(0, std::numbers::pi);
  for (int trial = 0; trial < 60; ++trial) {
    const int id = trial;
    const double s = size(random), angle = turn(random);
    // As seen 45 degrees from the side, about any axis.
    const Eigen::Matrix2d q = Eigen::Rotation2Dd(angle).toRotationMatrix();
    const Eigen::Matrix2d covariance = s * s * q * Eigen::Vector2d(1, 2).asDiagonal() * q.transpose();
    Eigen::Matrix2Xd places(2, 1);
    places << place(random), place(random);
    const SeenTag seen = TagSeer(Look(id), covariance).See(places(0, 0), places(1, 0));
    const double expected = BySamples(PatternOf("tag36h11", id).value(), covariance, places.col(0));
    EXPECT_NEAR(seen.white, expected, 0.012) << trial;
  }
}

TEST(TagPhotometric, ItsDerivativesAreThoseOfWhatItSees) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(1, 9), size(0.2, 0.6);
  for (int trial = 0; trial < 200; ++trial) {
    const TagLook look = Look(trial);
    const double s = size(random);
    const Eigen::Matrix2d covariance = s * s * (Eigen::Matrix2d() << 1, 0.2, 0.2, 1.3).finished();
    const Eigen::Vector2d at(place(random), place(random));
    const auto value = [&](double u, double v, double scale) {
      Eigen::Matrix2Xd places(2, 1);
      places << u, v;
      return TagSeer(look, scale * scale * covariance).See(u, v).white;
    };
    Eigen::Matrix2Xd places(2, 1);
    places << at;
    const SeenTag seen = TagSeer(look, covariance).See(at.x(), at.y());
    constexpr double kStep = 1e-3;
    EXPECT_NEAR(seen.by_u,
                (value(at.x() + kStep, at.y(), 1) - value(at.x() - kStep, at.y(), 1)) / (2 * kStep), 1e-2);
    EXPECT_NEAR(seen.by_v,
                (value(at.x(), at.y() + kStep, 1) - value(at.x(), at.y() - kStep, 1)) / (2 * kStep), 0.08);
    EXPECT_NEAR(
        seen.by_blur,
        (value(at.x(), at.y(), std::exp(kStep)) - value(at.x(), at.y(), std::exp(-kStep))) / (2 * kStep),
        0.08);
  }
}

struct Sample {
  Picture picture;
  Eigen::Matrix<double, 2, 4> truth;
};
Sample Draw(int id, double side, double tilt, double blur, double noise, std::mt19937& random,
            const char* family = "tag36h11") {
  std::uniform_real_distribution<double> any(0, 2 * std::numbers::pi), part(-0.5, 0.5);
  Sample s{Picture(80, 80, 60), {}};
  s.truth = TiltedCorners({39.5 + part(random), 39.5 + part(random)}, side, tilt, any(random), any(random));
  DrawTag(s.picture, PatternOf(family, id).value(), FamilyOf(family).value().border_width, s.truth);
  Blur(s.picture, blur);
  AddNoise(s.picture, noise, random);
  return s;
}
TagFit FitSample(const Sample& s, const TagLook& look, double off, std::mt19937& random,
                 const TagFitOptions& options = {}) {
  std::uniform_real_distribution<double> shift(-off, off);
  const Eigen::Vector2d all(shift(random), shift(random));
  Eigen::Matrix<double, 2, 4> start = s.truth.colwise() + all;
  for (int i = 0; i < 8; ++i) start.data()[i] += 0.3 * shift(random);
  const std::vector<unsigned char> bytes = s.picture.Bytes();
  return FitTag({bytes.data(), s.picture.width, s.picture.height, s.picture.width}, look, start, options);
}

TEST(TagPhotometric, CornersOfSmallTiltedTagsAreFoundToATenthOfAPixel) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  double squares = 0;
  int found = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const int id = trial % 587;
    // Footprints of 20 to 25 px: borders of 0.8 of that.
    const double side = 0.8 * (20 + 5 * unit(random)), tilt = 45 * kDegree * unit(random);
    const double blur = 0.5 + unit(random);
    const Sample s = Draw(id, side, tilt, blur, 3, random);
    const TagFit fit = FitSample(s, Look(id), 1, random);
    if (fit.fault != TagFitFault::kNone) continue;
    ++found;
    const Eigen::Matrix<double, 2, 4> error = fit.corners_px - s.truth;
    squares += error.squaredNorm() / 8;
  }
  EXPECT_GE(found, 297);
  EXPECT_LT(std::sqrt(squares / found), 0.05);
}

TEST(TagPhotometric, TheTableFitsAsThePlainFormDoes) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int trial = 0; trial < 100; ++trial) {
    const double blur = 0.6 + 0.6 * unit(random);
    const Sample s = Draw(trial, 16 + 6 * unit(random), 0.7 * unit(random), blur, 3, random);
    const std::vector<unsigned char> bytes = s.picture.Bytes();
    const GrayImage image{bytes.data(), 80, 80, 80};
    const TagLook look = Look(trial);
    const Eigen::Matrix<double, 2, 4> start = s.truth.colwise() + Eigen::Vector2d(unit(random) - 0.5, 0.4);
    TagFitOptions options;
    options.blur_px = std::sqrt(blur * blur + 1.0 / 12) * (1 + 0.1 * (unit(random) - 0.5));
    const TagFit plain = FitTag(image, look, start, options);
    TagFollow follow;
    for (int again = 0; again < 2; ++again) {
      const TagFit fast = FitTag(image, look, start, options, follow);
      ASSERT_EQ(plain.fault, TagFitFault::kNone);
      ASSERT_EQ(fast.fault, TagFitFault::kNone) << trial;
      const double sigma = std::sqrt(plain.covariance.diagonal().maxCoeff());
      EXPECT_LT((fast.corners_px - plain.corners_px).cwiseAbs().maxCoeff(), 0.6 * sigma + 2e-3) << trial;
      EXPECT_NEAR(fast.blur_px, plain.blur_px, 0.05);
    }
  }
}

TEST(TagPhotometric, TagsTooTiltedToBeDecodedAreKept) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(0, 1);
  int kept = 0;
  double squares = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Sample s = Draw(trial, 0.8 * 20, 60 * kDegree, 0.5 + unit(random), 3, random);
    const TagFit fit = FitSample(s, Look(trial), 0.5, random);
    if (fit.fault != TagFitFault::kNone) continue;
    ++kept;
    squares += (fit.corners_px - s.truth).squaredNorm() / 8;
  }
  EXPECT_GE(kept, 196);
  EXPECT_LT(std::sqrt(squares / kept), 0.10);
}

TEST(TagPhotometric, FamiliesWithDataOutsideTheirBorderAreFitted) {
  std::mt19937 random(5);
  for (const char* family : {"tagStandard41h12", "tagCustom48h12", "tagCircle49h12"}) {
    const TagFamily known = FamilyOf(family).value();
    double squares = 0;
    for (int trial = 0; trial < 20; ++trial) {
      const double side = 25.0 * known.border_width / known.total_width;
      const Sample s = Draw(trial, side, 0.4, 0.8, 3, random, family);
      const TagFit fit = FitSample(s, Look(trial, family), 0.5, random);
      EXPECT_EQ(fit.fault, TagFitFault::kNone) << family << ": " << NameOf(fit.fault);
      squares += (fit.corners_px - s.truth).squaredNorm() / 8;
    }
    EXPECT_LT(std::sqrt(squares / 20), 0.06) << family;
  }
}

TEST(TagPhotometric, AnotherTagOrAHandBeforeItIsNotThisTag) {
  std::mt19937 random(6);
  int taken = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const Sample s = Draw(trial, 18, 0.3, 0.8, 3, random);
    taken += FitSample(s, Look(trial + 100), 0.5, random).fault == TagFitFault::kNone ? 1 : 0;
    Sample hidden = s;
    for (int v = 0; v < 80; ++v) {
      for (int u = 39; u < 80; ++u) hidden.picture.At(u, v) = 90;
    }
    EXPECT_NE(FitSample(hidden, Look(trial), 0.5, random).fault, TagFitFault::kNone);
  }
  EXPECT_EQ(taken, 0);
}

TEST(TagPhotometric, WhatCannotBeFittedIsNamed) {
  std::mt19937 random(7);
  const Sample s = Draw(3, 18, 0, 0.8, 3, random);
  const std::vector<unsigned char> bytes = s.picture.Bytes();
  const GrayImage image{bytes.data(), 80, 80, 80};
  const TagLook look = Look(3);
  const Eigen::Matrix<double, 2, 4> away = s.truth.colwise() + Eigen::Vector2d(45, 0);
  EXPECT_EQ(FitTag(image, look, away).fault, TagFitFault::kOutside);
  EXPECT_EQ(FitTag(image, look, Eigen::Matrix<double, 2, 4>::Constant(40)).fault, TagFitFault::kTooSmall);
  EXPECT_EQ(FitTag(image, look, Eigen::Matrix<double, 2, 4>::Constant(std::nan(""))).fault,
            TagFitFault::kTooSmall);
  const Eigen::Matrix<double, 2, 4> mirrored = s.truth.rowwise().reverse();
  EXPECT_NE(FitTag(image, look, mirrored).fault, TagFitFault::kNone);
  const std::vector<unsigned char> flat(80 * 80, 128);
  EXPECT_EQ(FitTag({flat.data(), 80, 80, 80}, look, s.truth).fault, TagFitFault::kNoContrast);
  std::vector<unsigned char> negative = bytes;
  for (unsigned char& g : negative) g = static_cast<unsigned char>(255 - g);
  EXPECT_EQ(FitTag({negative.data(), 80, 80, 80}, look, s.truth).fault, TagFitFault::kNoContrast);
}

TEST(TagPhotometric, StatedCovarianceCoversTheError) {
  std::mt19937 random(8);
  int inside = 0, count = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Sample s = Draw(trial, 20, 0.5, 0.8, 4, random);
    const TagFit fit = FitSample(s, Look(trial), 0.3, random);
    ASSERT_EQ(fit.fault, TagFitFault::kNone);
    const Eigen::Matrix<double, 2, 4> error = fit.corners_px - s.truth;
    const Eigen::Map<const Eigen::Matrix<double, 8, 1>> e(error.data());
    // 95 % of chi^2 of eight.
    inside += e.dot(fit.covariance.ldlt().solve(e)) < 15.51 ? 1 : 0;
    ++count;
  }
  EXPECT_GE(inside, 0.90 * count);
  EXPECT_LE(inside, 0.99 * count);
}

}  // namespace
}  // namespace tendril
