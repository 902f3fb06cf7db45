// The pose of a photo from landmarks that its keypoints see, some of them wrongly.
#ifndef CAIRN_MAPPING_GROWTH_LOCALIZE_PHOTO_H_
#define CAIRN_MAPPING_GROWTH_LOCALIZE_PHOTO_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/rigid3.h"
#include "core/scene/triangulate.h"
#include "mapping/photo_set.h"

namespace cairn {

// A keypoint and the landmark that it sees.
struct LandmarkObservation {
  int keypoint_idx = 0;
  Eigen::Vector2d pixel;
  float scale_px = 1.0F;                                        // Of the keypoint.
  double SigmaPx() const { return KeypointSigmaPx(scale_px); }  // Of the pixel, per axis.
  Eigen::Vector3d x_in_world;
};

// An observation is an inlier up to this error in standard deviations: twice what an adjusted model
// allows, because neither the landmarks of a draft nor its cameras are adjusted to this photo.
inline constexpr double kMaxDraftSigmas = 8.0;

struct LocalizedPhoto {
  Rigid3d cam_from_world;
  Camera camera;
  int num_inliers = 0;
};

// Finds the pose with the most inliers by P3P and RANSAC and refines it. `cameras` has the
// candidates for the intrinsics of the photo; the one with the most inliers wins, the first if
// several have as many. Nothing if fewer than `min_inliers` observations agree. Deterministic by
// seed.
std::optional<LocalizedPhoto> LocalizePhoto(std::span<const Camera> cameras,
                                            const std::vector<LandmarkObservation>& observations,
                                            int min_inliers, uint64_t seed);

// Adjusts the pose of a photo that may be cropped together with its camera, about which `known` is
// known: the unknown principal point bent the pose. Nothing changes if that explains no more
// observations.
void FitPart(const MappingCamera& known, const std::vector<LandmarkObservation>& observations,
             LocalizedPhoto* photo);

}  // namespace cairn

#endif  // CAIRN_MAPPING_GROWTH_LOCALIZE_PHOTO_H_
