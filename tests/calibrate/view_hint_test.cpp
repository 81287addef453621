// calibrate/fold/view_hint.h: what a further camera is foretold to be worth, against campaigns that have it.
#include "calibrate/fold/view_hint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "tests/support/seen_by_cameras.h"

namespace tendril {
namespace {

using test::CameraCampaign;
using test::CameraStudies;
using test::CameraStudy;
using ::testing::HasSubstr;

TentacleDesign Short() {
  TentacleDesign design;
  design.length = 0.32;
  design.holes = 21;
  return design;
}

const test::FoldTruth kTruth{0.93, 1.4, 1.3};

CameraStudy Study(const std::string& part) {
  for (const CameraStudy& study : CameraStudies()) {
    if (study.name.find(part) != std::string::npos) return study;
  }
  ADD_FAILURE() << "no study " << part;
  return {};
}

FoldFitOptions WithPlace() {
  FoldFitOptions options;
  options.places = {"a camera more"};
  return options;
}

// Mean over campaigns: one campaign's standard errors are themselves known to a fifth only.
void ForetoldIsWhatComesOut(const std::string& part, std::uint64_t seed, double tolerance) {
  const CameraStudy study = Study(part);
  std::array<double, 3> foretold{}, before{}, after{};
  constexpr int kCampaigns = 12;
  for (int campaign = 0; campaign < kCampaigns; ++campaign) {
    const CameraCampaign drawn =
        DrawCampaign(study, Short(), kTruth, seed + 1000 * static_cast<std::uint64_t>(campaign));
    const auto without = RunFit(drawn.before, WithPlace(), {});
    const auto with = RunFit(drawn.after, WithPlace(), {});
    ASSERT_TRUE(without.ok() && with.ok());
    for (std::size_t i = 0; i < 3; ++i) {
      const auto hint = ViewHintOf(without.value(), WithPlace(), static_cast<int>(i));
      ASSERT_TRUE(hint.has_value());
      EXPECT_EQ(hint->known_from, PictureErrors::kRepeats);
      EXPECT_LE(hint->perfect_ratio, hint->error_ratio[0] + 0.02);
      foretold[i] += hint->error_ratio[0] / kCampaigns;
      before[i] += without.value().fit.parameters[i].standard_error;
      after[i] += with.value().fit.parameters[i].standard_error;
    }
  }
  double falls = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(foretold[i], after[i] / before[i], tolerance)
        << part << ", parameter " << i << ", seed " << seed;
    falls += (1 - after[i] / before[i]) / 3;
  }
  EXPECT_GT(falls, 1.2 * tolerance) << "nothing fell: the check above says nothing";
}

TEST(ViewHint, ACameraThatSeesTheHiddenHalfSharpensAsForetold) {
  ForetoldIsWhatComesOut("half hidden", 5'200'000, 0.12);
}

TEST(ViewHint, ACameraMoreOnCoarsePicturesSharpensAsForetold) {
  ForetoldIsWhatComesOut("tentacles alike", 5'300'000, 0.12);
}

TEST(ViewHint, SigmasStatedWrongAreMendedByWhatRepeats) {
  CameraStudy study = Study("tentacles alike");
  const CameraCampaign stated = DrawCampaign(study, Short(), kTruth, 11);
  // A tracker that states a third of its error: by its sigmas alone the pictures would have a ninth of their
  // share.
  study.stated = 1.0 / 3;
  const CameraCampaign too_small = DrawCampaign(study, Short(), kTruth, 11);
  const auto right = RunFit(stated.before, WithPlace(), {});
  const auto wrong = RunFit(too_small.before, WithPlace(), {});
  ASSERT_TRUE(right.ok() && wrong.ok());
  const auto of_right = ViewHintOf(right.value(), WithPlace(), kEffectivePull);
  const auto of_wrong = ViewHintOf(wrong.value(), WithPlace(), kEffectivePull);
  ASSERT_TRUE(of_right && of_wrong);
  EXPECT_GT(of_right->picture_share, 0.3);
  EXPECT_NEAR(of_wrong->picture_share, of_right->picture_share, 0.4 * of_right->picture_share);
}

TEST(ViewHint, TentaclesThatDifferAskForTrialsAndNotForCameras) {
  const auto fit = FitFold(DrawCampaign(Study("sharp"), Short(), kTruth, 5'400'000).before, WithPlace());
  ASSERT_TRUE(fit.ok());
  ASSERT_TRUE(fit.value().hint && fit.value().hint->view);
  const ViewHint& view = *fit.value().hint->view;
  EXPECT_LT(view.picture_share, 0.3);
  EXPECT_GT(view.error_ratio[0],
            *std::min_element(fit.value().hint->error_ratio.begin(), fit.value().hint->error_ratio.end()));
  EXPECT_THAT(view.sentence, HasSubstr("of tentacles that differ"));
  EXPECT_THAT(view.sentence, ::testing::AnyOf(HasSubstr("hardly help"), HasSubstr("less than that trial")));
}

TEST(ViewHint, CoarsePicturesOfTentaclesAlikeAskForACamera) {
  const auto fit =
      FitFold(DrawCampaign(Study("tentacles alike"), Short(), kTruth, 5'400'000).before, WithPlace());
  ASSERT_TRUE(fit.ok());
  ASSERT_TRUE(fit.value().hint && fit.value().hint->view);
  EXPECT_THAT(fit.value().hint->view->sentence, HasSubstr("help more than that trial: with a camera more"));
}

TEST(ViewHint, WithoutCamerasItSaysWhatPerfectPicturesWouldDo) {
  std::vector<FoldObservation> observations = DrawCampaign(Study("sharp"), Short(), kTruth, 5'400'000).before;
  for (FoldObservation& o : observations) {
    o.cameras.resize(0);
    o.further.resize(0, 0);
  }
  const auto fit = FitFold(observations, WithPlace());
  ASSERT_TRUE(fit.ok() && fit.value().hint && fit.value().hint->view);
  const ViewHint& view = *fit.value().hint->view;
  EXPECT_EQ(view.best, -1);
  EXPECT_TRUE(view.error_ratio.empty());
  EXPECT_GT(view.perfect_ratio, 0);
  EXPECT_LE(view.perfect_ratio, 1);
  EXPECT_THAT(view.sentence, HasSubstr("every node seen without error"));
}

TEST(ViewHint, OneTrialCannotTellPicturesFromTentacles) {
  CameraStudy study = Study("sharp");
  study.trials = 1;
  const auto fit = FitFold(DrawCampaign(study, Short(), kTruth, 7).before, WithPlace());
  ASSERT_TRUE(fit.ok() && fit.value().hint);
  EXPECT_FALSE(fit.value().hint->view.has_value());
}

TEST(ViewHint, NoisesShareIsThatOfTheStatedSigmasWhereNothingRepeats) {
  std::vector<FoldObservation> observations =
      DrawCampaign(Study("tentacles alike"), Short(), kTruth, 5'400'000).before;
  std::erase_if(observations, [](const FoldObservation& o) { return o.time > 3; });
  const auto fit = FitFold(observations, WithPlace());
  ASSERT_TRUE(fit.ok() && fit.value().hint && fit.value().hint->view);
  EXPECT_EQ(fit.value().hint->view->known_from, PictureErrors::kStatedSigma);
  EXPECT_THAT(fit.value().hint->view->sentence, HasSubstr("by the stated sigmas up to"));
}

TEST(ViewHint, ErrorsThatNeighboursShareAreNoErrorsOfDistances) {
  std::vector<FoldObservation> observations =
      DrawCampaign(Study("tentacles alike"), Short(), kTruth, 5'400'000).before;
  std::erase_if(observations, [](const FoldObservation& o) { return o.time > 3; });
  const auto share_with = [&](double together) {
    for (FoldObservation& o : observations) {
      const Eigen::VectorXd sigma = o.sigma.array().isFinite().select(o.sigma, 0);
      o.covariance_factor.setZero(3 * sigma.size(), 3 * sigma.size() + 3);
      for (Eigen::Index i = 0; i < sigma.size(); ++i) {
        for (int axis = 0; axis < 3; ++axis) {
          o.covariance_factor(3 * i + axis, 3 * i + axis) = std::sqrt(1 - together) * sigma[i];
          o.covariance_factor(3 * i + axis, 3 * sigma.size() + axis) = std::sqrt(together) * sigma[i];
        }
      }
    }
    const FitRun run = RunFit(observations, WithPlace(), {}).value();
    const auto hint = ViewHintOf(run, WithPlace(), kEffectivePull);
    EXPECT_EQ(hint->known_from, PictureErrors::kCovariance);
    return hint->picture_share;
  };
  const FitRun run = RunFit(observations, WithPlace(), {}).value();
  const double by_sigma = ViewHintOf(run, WithPlace(), kEffectivePull)->picture_share;
  ASSERT_LT(by_sigma, 1);  // not cut: the shares below can be compared
  EXPECT_NEAR(share_with(0), by_sigma, 0.02 * by_sigma);
  // All nodes moved alike leave the distances as they are.
  EXPECT_NEAR(share_with(0.75), 0.25 * by_sigma, 0.05 * by_sigma);
}

}  // namespace
}  // namespace tendril
