#include "core/adjust/pose_solver.h"

#include <gtest/gtest.h>

#include <vector>

namespace cairn {
namespace {

struct Visibility {
  Reconstruction model;
  AdjustPriors priors;

  explicit Visibility(int num_images) { model.images.resize(num_images); }

  // Adds landmarks that all images from `first` to `last` see.
  void Add(int num_landmarks, int first, int last) {
    ReconLandmark landmark;
    for (int image = first; image <= last; ++image) {
      landmark.observations.push_back({image, 0});
    }
    model.landmarks.insert(model.landmarks.end(), num_landmarks, landmark);
  }

  PoseSolver Solver() const {
    const std::vector<LandmarkRole> roles(model.landmarks.size(), LandmarkRole::kDecides);
    return SolverOfPoses(model, roles, priors);
  }
};

Visibility Walk(int num_images, int num_landmarks_each, int num_images_of_landmark) {
  Visibility walk(num_images);
  for (int i = 0; i + num_images_of_landmark <= num_images; ++i) {
    walk.Add(num_landmarks_each, i, i + num_images_of_landmark - 1);
  }
  return walk;
}

TEST(SolverOfPoses, IsDenseForPhotosOfOnePlace) {
  Visibility place(300);
  place.Add(5, 0, 299);
  EXPECT_EQ(place.Solver(), PoseSolver::kDense);
}

TEST(SolverOfPoses, IsSparseForAWalk) { EXPECT_EQ(Walk(300, 5, 10).Solver(), PoseSolver::kSparse); }

TEST(SolverOfPoses, FactorsALongWalkHoweverMuchItTakesToOrder) {
  EXPECT_EQ(Walk(1000, 20, 30).Solver(), PoseSolver::kSparse);
}

TEST(SolverOfPoses, IteratesForVeryManyPhotosOfOnePlace) {
  Visibility place(402);
  place.Add(1, 0, 401);
  EXPECT_EQ(place.Solver(), PoseSolver::kIterations);
}

// Each photo shares landmarks with 99 to 198 of 400, and each landmark has 10,000 pairs.
TEST(SolverOfPoses, IteratesIfAnOrderTakesMuchMemory) {
  EXPECT_EQ(Walk(400, 1, 100).Solver(), PoseSolver::kSparse);
  EXPECT_EQ(Walk(400, 4, 100).Solver(), PoseSolver::kIterations);
}

TEST(SolverOfPoses, CountsWhatMovesAndDecides) {
  Visibility place(402);
  place.Add(1, 0, 401);
  place.priors.image_is_fixed.assign(402, 0);
  place.priors.image_is_fixed[0] = 1;
  EXPECT_EQ(place.Solver(), PoseSolver::kDense);

  Visibility walk = Walk(300, 5, 10);
  walk.Add(1, 0, 299);
  EXPECT_EQ(walk.Solver(), PoseSolver::kDense);
  std::vector<LandmarkRole> roles(walk.model.landmarks.size(), LandmarkRole::kDecides);
  roles.back() = LandmarkRole::kFollows;
  EXPECT_EQ(SolverOfPoses(walk.model, roles, walk.priors), PoseSolver::kSparse);
  walk.priors.landmark_is_fixed.assign(walk.model.landmarks.size(), 0);
  walk.priors.landmark_is_fixed.back() = 1;
  EXPECT_EQ(walk.Solver(), PoseSolver::kSparse);
}

}  // namespace
}  // namespace cairn
