#include "core/adjust/pose_solver.h"

#include <algorithm>
#include <cmath>

namespace cairn {
namespace {

// Above this, the poses' system is solved by iterations. An image that shares landmarks with d
// others costs a factorization about d * d blocks, so photos of one place cost the cube of their
// number. Iterations cost as much as there are observations, times a number that is small if many
// images see the same, and large if the images are a chain.
constexpr double kMaxNeighborsToFactor = 400.0;

// A system of which more than this is filled is factored as a dense one.
constexpr double kMaxFilledIfSparse = 0.5;

// To order a sparse system, Ceres holds, for each observation, all images that see its landmark, in
// some 30 bytes each: 0.8 GB for 300 photos of one wall. With more pairs, the system is solved by
// iterations, unless so little of it is filled that the images may be a chain.
// docs/decisions/0073-photos-of-one-place-have-a-dense-system.md has the figures.
constexpr double kMaxPairsToOrder = 1e7;
constexpr double kMinFilledIfIterated = 0.2;

// Counts of the poses' system. Only images and landmarks that move count, and of these landmarks
// the ones that decide.
struct PoseSystem {
  double num_images = 0.0;
  // The number of others with which an image shares landmarks; root mean square.
  double num_neighbors = 0.0;
  // A pair is an observation and an image that sees its landmark.
  double num_pairs = 0.0;
};

PoseSystem MeasureSystem(const Reconstruction& model, const std::vector<LandmarkRole>& roles,
                         const AdjustPriors& priors) {
  const auto moves = [&](const ReconObservation& seen) {
    return !priors.HoldsImage(seen.image_idx);
  };
  PoseSystem system;
  std::vector<std::vector<int>> landmarks_of_image(model.images.size());
  for (size_t i = 0; i < model.landmarks.size(); ++i) {
    if (roles[i] != LandmarkRole::kDecides || priors.HoldsLandmark(i)) {
      continue;
    }
    double num_moving = 0.0;
    for (const ReconObservation& seen : model.landmarks[i].observations) {
      if (moves(seen)) {
        landmarks_of_image[seen.image_idx].push_back(static_cast<int>(i));
        num_moving += 1.0;
      }
    }
    system.num_pairs += num_moving * num_moving;
  }
  std::vector<int> last_met(model.images.size(), -1);
  double sum_sq = 0.0;
  for (int image = 0; image < static_cast<int>(model.images.size()); ++image) {
    double count = 0.0;
    last_met[image] = image;
    for (const int landmark : landmarks_of_image[image]) {
      for (const ReconObservation& seen : model.landmarks[landmark].observations) {
        count += moves(seen) && last_met[seen.image_idx] != image ? 1.0 : 0.0;
        last_met[seen.image_idx] = image;
      }
    }
    sum_sq += count * count;
    system.num_images += landmarks_of_image[image].empty() ? 0.0 : 1.0;
  }
  system.num_neighbors = std::sqrt(sum_sq / std::max(1.0, system.num_images));
  return system;
}

PoseSolver SolverFor(const PoseSystem& system) {
  if (system.num_neighbors > kMaxNeighborsToFactor) {
    return PoseSolver::kIterations;
  }
  if (system.num_neighbors > kMaxFilledIfSparse * system.num_images) {
    return PoseSolver::kDense;
  }
  const bool may_iterate = system.num_neighbors > kMinFilledIfIterated * system.num_images;
  return may_iterate && system.num_pairs > kMaxPairsToOrder ? PoseSolver::kIterations
                                                            : PoseSolver::kSparse;
}

}  // namespace

PoseSolver SolverOfPoses(const Reconstruction& model, const std::vector<LandmarkRole>& roles,
                         const AdjustPriors& priors) {
  return SolverFor(MeasureSystem(model, roles, priors));
}

}  // namespace cairn
