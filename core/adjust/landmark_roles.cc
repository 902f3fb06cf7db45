#include "core/adjust/landmark_roles.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>

namespace cairn {
namespace {

constexpr int kPartsPerSide = 4;
constexpr int kEnoughOfPart = 32;
constexpr int kEnoughTies = 64;

// Sets of images, of which landmarks make larger ones.
class ImageSets {
 public:
  explicit ImageSets(int num_images) : parents_(num_images) {
    std::iota(parents_.begin(), parents_.end(), 0);
  }

  bool AreOne(std::span<const int> images) {
    return std::all_of(images.begin(), images.end(),
                       [&](int image) { return Find(image) == Find(images[0]); });
  }

  void Unite(std::span<const int> images) {
    for (const int image : images) {
      parents_[Find(image)] = Find(images[0]);
    }
  }

 private:
  int Find(int image) {
    while (parents_[image] != image) {
      image = parents_[image] = parents_[parents_[image]];
    }
    return image;
  }

  std::vector<int> parents_;
};

// Takes landmarks such that, however one divides the images in two, as many landmarks tie the
// halves as tie them in all, or kEnoughTies. A landmark goes to the first layer in which its images
// are not in one set yet (Nagamochi and Ibaraki, "A linear-time algorithm for finding a sparse
// k-connected spanning subgraph of a k-connected graph", 1992).
class Ties {
 public:
  explicit Ties(int num_images) : layers_(kEnoughTies, ImageSets(num_images)) {}

  // True if the landmark that these images see is taken.
  bool Take(std::span<const int> images) {
    // Images that are in one set of a layer are so in the layers before it.
    const auto layer = std::partition_point(layers_.begin(), layers_.end(),
                                            [&](ImageSets& sets) { return sets.AreOne(images); });
    if (layer == layers_.end()) {
      return false;
    }
    layer->Unite(images);
    return true;
  }

 private:
  std::vector<ImageSets> layers_;
};

class Selection {
 public:
  Selection(const Reconstruction& model, const AdjustPriors& priors)
      : model_(model),
        priors_(priors),
        num_taken_(model.images.size()),
        ties_(static_cast<int>(model.images.size()) + 1) {}

  // Takes the landmark, and returns true, if it is needed.
  bool TakeIfNeeded(int landmark) {
    const auto& observations = model_.landmarks[landmark].observations;
    const bool is_tie = ties_.Take(NodesOf(observations));
    const bool is_needed =
        is_tie || priors_.HoldsLandmark(landmark) ||
        std::any_of(observations.begin(), observations.end(), [&](auto& seen) {
          return !priors_.HoldsImage(seen.image_idx) && NumTaken(seen) < kEnoughOfPart;
        });
    if (is_needed) {
      for (const ReconObservation& seen : observations) {
        ++NumTaken(seen);
      }
    }
    return is_needed;
  }

 private:
  // Fixed images are one node.
  std::vector<int> NodesOf(const std::vector<ReconObservation>& observations) const {
    std::vector<int> nodes;
    for (const ReconObservation& seen : observations) {
      nodes.push_back(priors_.HoldsImage(seen.image_idx) ? static_cast<int>(model_.images.size())
                                                         : seen.image_idx);
    }
    return nodes;
  }

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
  Ties ties_;
};

}  // namespace

std::vector<LandmarkRole> RolesOfLandmarks(const Reconstruction& model, const AdjustPriors& priors,
                                           int64_t max_observations_of_all) {
  std::vector<LandmarkRole> roles(model.landmarks.size(), LandmarkRole::kIdle);
  std::vector<int> landmarks;  // That may decide.
  int64_t num_observations = 0;
  for (int i = 0; i < static_cast<int>(model.landmarks.size()); ++i) {
    const auto& observations = model.landmarks[i].observations;
    if (std::any_of(observations.begin(), observations.end(), [&](const ReconObservation& seen) {
          return !priors.HoldsImage(seen.image_idx);
        })) {
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
  Selection selection(model, priors);
  for (const int landmark : landmarks) {
    roles[landmark] =
        selection.TakeIfNeeded(landmark) ? LandmarkRole::kDecides : LandmarkRole::kFollows;
  }
  return roles;
}

}  // namespace cairn
