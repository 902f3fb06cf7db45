#include "ingest/tiles/tile_shard.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace cairn {
namespace {

// The landmarks that the images see, ascending.
std::vector<uint32_t> LandmarksSeen(const PlacedSession& session, const std::vector<int>& images) {
  std::vector<uint32_t> landmarks;
  for (const int image_idx : images) {
    for (const PlacedObservation& observation : session.observations_of_image[image_idx]) {
      landmarks.push_back(observation.landmark_idx);
    }
  }
  std::sort(landmarks.begin(), landmarks.end());
  landmarks.erase(std::unique(landmarks.begin(), landmarks.end()), landmarks.end());
  return landmarks;
}

// The image with just the observed keypoints, in the order of the observations.
ReconImage CutImage(const ReconImage& image, const std::vector<PlacedObservation>& observations) {
  ReconImage cut;
  cut.name = image.name;
  for (const PlacedObservation& observation : observations) {
    cut.features.keypoints.push_back(image.features.keypoints[observation.keypoint_idx]);
  }
  cut.features.descriptors = image.features.descriptors.Rows(KeypointsOf(observations));
  return cut;
}

std::vector<PlacedObservation> Renumbered(const std::vector<PlacedObservation>& observations,
                                          const std::vector<uint32_t>& landmarks) {
  std::vector<PlacedObservation> renumbered;
  for (const PlacedObservation& observation : observations) {
    const auto at = std::lower_bound(landmarks.begin(), landmarks.end(), observation.landmark_idx);
    renumbered.push_back(
        {static_cast<uint32_t>(at - landmarks.begin()), static_cast<int>(renumbered.size())});
  }
  return renumbered;
}

}  // namespace

TileShard CutShard(const Reconstruction& reconstruction, const PlacedSession& session,
                   const std::vector<LandmarkId>& landmark_ids, TileId tile_id,
                   KeyframeId first_keyframe) {
  TileShard shard;
  shard.tile_id = tile_id;
  shard.reconstruction.descriptor_type = reconstruction.descriptor_type;
  const auto images = session.images_of_tile.find(tile_id);
  if (images == session.images_of_tile.end()) {
    return shard;
  }
  const std::vector<uint32_t> landmarks = LandmarksSeen(session, images->second);
  for (const uint32_t landmark_idx : landmarks) {
    shard.session.landmarks.push_back(session.landmarks[landmark_idx]);
    shard.session.landmarks.back().recon_idx = 0;
    shard.landmark_ids.push_back(landmark_ids[landmark_idx]);
  }
  for (const int image_idx : images->second) {
    const ReconImage& image = reconstruction.images[image_idx];
    const auto& observations = session.observations_of_image[image_idx];
    const auto new_idx = static_cast<int>(shard.keyframe_ids.size());
    shard.reconstruction.cameras.push_back(reconstruction.cameras[image.camera_idx]);
    shard.reconstruction.images.push_back(CutImage(image, observations));
    shard.reconstruction.images.back().camera_idx = new_idx;
    shard.keyframe_ids.push_back(KeyframeId(Value(first_keyframe) + new_idx));
    shard.session.cam_from_ecef.push_back(session.cam_from_ecef[image_idx]);
    shard.session.observations_of_image.push_back(Renumbered(observations, landmarks));
  }
  std::vector<int>& own_images = shard.session.images_of_tile[tile_id];
  own_images.resize(shard.reconstruction.images.size());
  std::iota(own_images.begin(), own_images.end(), 0);
  return shard;
}

}  // namespace cairn
