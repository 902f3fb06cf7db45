#include "core/adjust/landmark_roles.h"

#include <algorithm>
#include <array>

namespace cairn {
namespace {

constexpr int kPartsPerSide = 4;
constexpr int kEnoughOfPart = 32;

class Selection {
 public:
  Selection(const Reconstruction& model, const AdjustPriors& priors)
      : model_(model), priors_(priors), num_taken_(model.images.size()) {}

  bool Moves(const ReconObservation& seen) const {
    return priors_.image_is_fixed.empty() || priors_.image_is_fixed[seen.image_idx] == 0;
  }

  bool IsFixed(int landmark) const {
    return !priors_.landmark_is_fixed.empty() && priors_.landmark_is_fixed[landmark] != 0;
  }

  // Takes the landmark, and returns true, if an image needs it.
  bool TakeIfNeeded(int landmark) {
    const auto& observations = model_.landmarks[landmark].observations;
    const bool is_needed =
        IsFixed(landmark) || std::any_of(observations.begin(), observations.end(), [&](auto& seen) {
          return Moves(seen) && NumTaken(seen) < kEnoughOfPart;
        });
    if (is_needed) {
      for (const ReconObservation& seen : observations) {
        ++NumTaken(seen);
      }
    }
    return is_needed;
  }

 private:
  // In the part of the picture in which the observation lies.
  int& NumTaken(const ReconObservation& seen) {
    const ReconImage& image = model_.images[seen.image_idx];
    const Camera& camera = model_.cameras[image.camera_idx];
    const Keypoint& keypoint = image.features.keypoints[seen.keypoint_idx];
    const auto part_of = [](double at_px, int size_px) {
      return std::clamp(static_cast<int>(kPartsPerSide * at_px / size_px), 0, kPartsPerSide - 1);
    };
    return num_taken_[seen.image_idx][part_of(keypoint.y_px, camera.height_px()) * kPartsPerSide +
                                      part_of(keypoint.x_px, camera.width_px())];
  }

  const Reconstruction& model_;
  const AdjustPriors& priors_;
  std::vector<std::array<int, kPartsPerSide * kPartsPerSide>> num_taken_;  // Of each image.
};

}  // namespace

std::vector<LandmarkRole> RolesOfLandmarks(const Reconstruction& model, const AdjustPriors& priors,
                                           int64_t max_observations_of_all) {
  Selection selection(model, priors);
  std::vector<LandmarkRole> roles(model.landmarks.size(), LandmarkRole::kIdle);
  std::vector<int> landmarks;  // That may decide.
  int64_t num_observations = 0;
  for (int i = 0; i < static_cast<int>(model.landmarks.size()); ++i) {
    const auto& observations = model.landmarks[i].observations;
    if (std::any_of(observations.begin(), observations.end(),
                    [&](const ReconObservation& seen) { return selection.Moves(seen); })) {
      roles[i] = LandmarkRole::kDecides;
      landmarks.push_back(i);
      num_observations += static_cast<int64_t>(observations.size());
    }
  }
  if (num_observations <= max_observations_of_all) {
    return roles;
  }
  std::stable_sort(landmarks.begin(), landmarks.end(), [&](int a, int b) {
    return model.landmarks[a].observations.size() > model.landmarks[b].observations.size();
  });
  for (const int landmark : landmarks) {
    roles[landmark] =
        selection.TakeIfNeeded(landmark) ? LandmarkRole::kDecides : LandmarkRole::kFollows;
  }
  return roles;
}

}  // namespace cairn
