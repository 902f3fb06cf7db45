#include "core/adjust/landmark_roles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace cairn {
namespace {

constexpr int kNumImages = 10;

// Each image sees about 2,500 landmarks anywhere in its picture, each landmark at least twice.
Reconstruction MakeModel() {
  std::mt19937_64 rng{5};
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  Reconstruction model;
  model.cameras = {{CameraModel::kPinhole, 640, 480, {500.0, 500.0, 320.0, 240.0}}};
  model.images.resize(kNumImages);
  for (int i = 0; i < 4000; ++i) {
    ReconLandmark landmark;
    for (int image = 0; image < kNumImages; ++image) {
      std::vector<Keypoint>& keypoints = model.images[image].features.keypoints;
      if (uniform(rng) < 0.63f) {
        landmark.observations.push_back({image, static_cast<int>(keypoints.size())});
        keypoints.push_back({640.0f * uniform(rng), 480.0f * uniform(rng), 2.0f, 0.0f});
      }
    }
    if (landmark.observations.size() >= 2) {
      model.landmarks.push_back(landmark);
    }
  }
  return model;
}

TEST(LandmarkRoles, LandmarksDecideUntilEachPartOfEachPictureHasEnough) {
  const Reconstruction model = MakeModel();
  const auto num_landmarks = static_cast<std::ptrdiff_t>(model.landmarks.size());
  AdjustPriors priors;
  const auto count = [&](LandmarkRole role, int max_observations_of_all) {
    const auto roles = RolesOfLandmarks(model, priors, max_observations_of_all);
    return std::count(roles.begin(), roles.end(), role);
  };
  EXPECT_EQ(count(LandmarkRole::kDecides, 1'000'000), num_landmarks);
  const std::ptrdiff_t for_all_pictures = count(LandmarkRole::kDecides, 1000);
  EXPECT_GT(for_all_pictures, 400);
  EXPECT_LT(for_all_pictures, num_landmarks / 2);
  // One picture asks for fewer, and what no picture that moves shows has nothing to decide.
  priors.image_is_fixed.assign(kNumImages, 1);
  EXPECT_EQ(count(LandmarkRole::kIdle, 1000), num_landmarks);
  priors.image_is_fixed[3] = 0;
  EXPECT_LE(count(LandmarkRole::kDecides, 1000), 16 * 32);
  EXPECT_GT(count(LandmarkRole::kFollows, 1000), 1000);
  priors.landmark_is_fixed.assign(model.landmarks.size(), 1);
  EXPECT_EQ(count(LandmarkRole::kFollows, 1000), 0);
}

// Two halves of a walk share no landmark but some thirty, which only photos 4 and 5 see.
TEST(LandmarkRoles, FewLandmarksThatTieTwoPartsDecide) {
  Reconstruction model = MakeModel();
  int num_ties = 0;
  std::vector<bool> is_tie(model.landmarks.size());
  for (size_t i = 0; i < model.landmarks.size(); ++i) {
    const bool may_tie = i % 40 == 0;
    auto& observations = model.landmarks[i].observations;
    std::erase_if(observations, [&](const ReconObservation& seen) {
      return may_tie ? seen.image_idx < 4 || seen.image_idx > 5
                     : (seen.image_idx < 5) == (i % 2 == 0);
    });
    is_tie[i] = may_tie && observations.size() == 2;
    num_ties += is_tie[i] ? 1 : 0;
  }
  EXPECT_GT(num_ties, 25);
  EXPECT_LT(num_ties, 64);
  const auto roles = RolesOfLandmarks(model, {}, 1000);
  EXPECT_LT(std::count(roles.begin(), roles.end(), LandmarkRole::kDecides), std::ssize(roles) / 2);
  for (size_t i = 0; i < roles.size(); ++i) {
    EXPECT_TRUE(!is_tie[i] || roles[i] == LandmarkRole::kDecides) << i;
  }
}

}  // namespace
}  // namespace cairn
