#include "lab/descriptors/street_codebook.h"

#include <utility>
#include <vector>

#include "cli/demo/street/reconstruct_known_poses.h"
#include "cli/demo/street/street_scene.h"
#include "core/require.h"
#include "ingest/codebook/train_codebook.h"

namespace cairn {
namespace {

constexpr int kNumTrees = 8;
// The default of CodebookOptions is for single sessions, whose training should take seconds.
constexpr int kMaxTrainingDescriptors = 200'000;

Reconstruction ReconstructStreet(const StreetCodebookOptions& options, int street_idx) {
  StreetOptions street;
  street.length_m = options.length_m;
  street.num_trees = street_idx % 2 == 1 ? kNumTrees : 0;
  street.seed = options.seed + static_cast<uint64_t>(street_idx);
  const StreetScene scene(street);
  KnownPoseOptions known_poses;
  known_poses.num_threads = options.num_threads;
  return ReconstructWithKnownPoses(
      scene.camera(), scene.TakePhotos(scene.MappingPoses(), "map_", options.num_threads),
      known_poses);
}

// Adds images and landmarks. The places of the streets overlap, which training does not see.
void Append(Reconstruction&& street, Reconstruction* all) {
  const auto first_image = static_cast<int>(all->images.size());
  const auto first_camera = static_cast<int>(all->cameras.size());
  for (const Camera& camera : street.cameras) {
    all->cameras.push_back(camera);
  }
  for (ReconImage& image : street.images) {
    image.camera_idx += first_camera;
    all->images.push_back(std::move(image));
  }
  for (ReconLandmark& landmark : street.landmarks) {
    for (ReconObservation& observation : landmark.observations) {
      observation.image_idx += first_image;
    }
    all->landmarks.push_back(std::move(landmark));
  }
}

}  // namespace

void StreetCodebookOptions::Validate() const {
  RequireWithin("num_streets", num_streets, 1, 1000);
  RequireOption(num_threads >= 1, "num_threads must be at least 1");
}

Codebook TrainStreetCodebook(const StreetCodebookOptions& options,
                             const StreetCodebookProgress& progress) {
  options.Validate();
  Reconstruction all;
  for (int street_idx = 0; street_idx < options.num_streets; ++street_idx) {
    Append(ReconstructStreet(options, street_idx), &all);
    if (progress) {
      progress(street_idx + 1, options.num_streets);
    }
  }
  CodebookOptions training;
  training.max_training_descriptors = kMaxTrainingDescriptors;
  training.seed = options.seed;
  return TrainCodebook(all, training);
}

}  // namespace cairn
