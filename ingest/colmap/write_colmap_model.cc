#include <cstdint>
#include <string>
#include <vector>

#include "ingest/colmap/colmap_ids.h"
#include "ingest/colmap/colmap_model_writer.h"
#include "ingest/colmap/write_colmap.h"

namespace cairn {
namespace {

constexpr std::array<uint8_t, 3> kGray = {128, 128, 128};
constexpr double kErrorPx = 0.5;

// The keypoints of each image, with COLMAP's ids of their points.
std::vector<std::vector<ColmapKeypoint>> KeypointsOf(const Reconstruction& reconstruction) {
  std::vector<std::vector<ColmapKeypoint>> keypoints;
  for (const ReconImage& image : reconstruction.images) {
    keypoints.emplace_back();
    for (const Keypoint& keypoint : image.features.keypoints) {
      keypoints.back().push_back({.x_px = keypoint.x_px, .y_px = keypoint.y_px});
    }
  }
  for (size_t i = 0; i < reconstruction.landmarks.size(); ++i) {
    for (const ReconObservation& observation : reconstruction.landmarks[i].observations) {
      keypoints[static_cast<size_t>(observation.image_idx)]
               [static_cast<size_t>(observation.keypoint_idx)]
                   .point_id = static_cast<int64_t>(kFirstColmapPointId + i);
    }
  }
  return keypoints;
}

}  // namespace

void WriteColmapModel(const Reconstruction& reconstruction, const std::string& dir,
                      ColmapModelFormat format) {
  ColmapModelWriter writer(dir, format);
  for (size_t i = 0; i < reconstruction.cameras.size(); ++i) {
    writer.AddCamera(kFirstColmapCameraId + static_cast<uint32_t>(i), reconstruction.cameras[i]);
  }
  const std::vector<std::vector<ColmapKeypoint>> keypoints = KeypointsOf(reconstruction);
  for (size_t i = 0; i < reconstruction.images.size(); ++i) {
    const ReconImage& image = reconstruction.images[i];
    writer.AddImage(kFirstColmapImageId + static_cast<uint32_t>(i), image.name,
                    kFirstColmapCameraId + static_cast<uint32_t>(image.camera_idx),
                    image.cam_from_world, keypoints[i]);
  }
  for (size_t i = 0; i < reconstruction.landmarks.size(); ++i) {
    const ReconLandmark& landmark = reconstruction.landmarks[i];
    std::vector<ColmapTrackElement> track;
    for (const ReconObservation& observation : landmark.observations) {
      track.push_back(
          {.image_id = kFirstColmapImageId + static_cast<uint32_t>(observation.image_idx),
           .keypoint_idx = static_cast<uint32_t>(observation.keypoint_idx)});
    }
    writer.AddPoint(kFirstColmapPointId + i, landmark.x_in_world, kGray, kErrorPx, track);
  }
  writer.Commit();
}

}  // namespace cairn
