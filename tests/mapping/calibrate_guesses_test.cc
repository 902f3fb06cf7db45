#include "mapping/matching/calibrate_guesses.h"

#include <gtest/gtest.h>

#include "mapping/facade_views.h"

namespace cairn {
namespace {

const std::vector<testing::FacadePhoto> kTourists = {{-8.0, 0.0, 1.0}, {-3.0, 4.0, 0.8},
                                                     {0.0, -6.0, 1.5}, {4.0, 0.0, 2.4},
                                                     {9.0, 2.0, 1.2},  {12.0, -3.0, 0.95}};

bool All(int, int, int) { return true; }

double FactorOf(const PhotoSet& set, const std::vector<MappingCamera>& found, size_t camera) {
  return found[camera].camera.focal_px() / set.cameras[camera].camera.focal_px();
}

TEST(CalibrateGuesses, TellsTheFocalLengthsOfManyCamerasTogether) {
  const testing::FacadeViews world = testing::MakeFacadeViews(kTourists, All);
  const std::vector<MappingCamera> found = CalibrateGuesses(world.set, world.views, 1);
  ASSERT_EQ(found.size(), kTourists.size());
  for (size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].source, FocalSource::kPhotos) << i;
    EXPECT_NEAR(FactorOf(world.set, found, i) / kTourists[i].focal_factor, 1.0, 0.1) << i;
    EXPECT_LT(found[i].focal.log_sigma, FocalPrior::kUnknownLogSigma) << i;
  }
}

TEST(CalibrateGuesses, OneWrongPairDoesNotDecide) {
  testing::FacadeViews world = testing::MakeFacadeViews(kTourists, All);
  // The inliers of a view that belong to nothing.
  std::vector<FeatureMatch>& inliers = world.views[0].inliers;
  for (size_t i = 0; i < inliers.size(); ++i) {
    inliers[i].b_idx = inliers[(7 * i + 3) % inliers.size()].b_idx;
  }
  const std::vector<MappingCamera> found = CalibrateGuesses(world.set, world.views, 1);
  for (size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(FactorOf(world.set, found, i) / kTourists[i].focal_factor, 1.0, 0.12) << i;
  }
}

TEST(CalibrateGuesses, LeavesWhatIsKnownAndWhatNothingTells) {
  testing::FacadeViews world = testing::MakeFacadeViews(kTourists, All);
  world.set.cameras[1].source = FocalSource::kExif;
  std::erase_if(world.views, [](const TwoView& view) { return view.a == 2 || view.b == 2; });
  for (TwoView& view : world.views) {
    view.inliers.resize(view.a == 3 || view.b == 3 ? 8 : view.inliers.size());
  }
  const std::vector<MappingCamera> found = CalibrateGuesses(world.set, world.views, 1);
  EXPECT_EQ(found[1].source, FocalSource::kExif);
  for (const size_t untouched : {1u, 2u}) {
    EXPECT_EQ(FactorOf(world.set, found, untouched), 1.0) << untouched;
  }
  EXPECT_EQ(found[2].source, FocalSource::kGuess);
  EXPECT_EQ(found[3].source, FocalSource::kGuess);
}

TEST(CalibrateGuesses, DoesNotDependOnThreads) {
  const testing::FacadeViews world = testing::MakeFacadeViews(kTourists, All);
  const auto one = CalibrateGuesses(world.set, world.views, 1);
  const auto three = CalibrateGuesses(world.set, world.views, 3);
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].camera.params(), three[i].camera.params());
  }
}

TEST(PairsForCalibration, AreFewOfOneCameraAndSpreadOverTheSet) {
  PhotoSet set;
  set.cameras.resize(2, {CameraOfUnknownFocal(640, 480), {}, FocalSource::kGuess});
  set.cameras[1].source = FocalSource::kExif;
  set.photos.resize(300);
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i + 2 < 300; ++i) {
    set.photos[i].camera_idx = i < 200 ? 0 : 1;
    pairs.emplace_back(i, i + 2);
  }
  set.photos[298].camera_idx = set.photos[299].camera_idx = 1;
  const auto chosen = PairsForCalibration(set, pairs);
  EXPECT_GE(chosen.size(), 20u);
  EXPECT_LE(chosen.size(), 60u);
  EXPECT_LT(chosen.front().first, 20);
  EXPECT_GT(chosen.back().first, 180);
  EXPECT_LT(chosen.back().first, 200);  // Photos whose focal length is known need none.
}

}  // namespace
}  // namespace cairn
