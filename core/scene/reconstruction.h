// A reconstruction in memory: the output of every reader and the input of every ingest.
#ifndef CAIRN_CORE_SCENE_RECONSTRUCTION_H_
#define CAIRN_CORE_SCENE_RECONSTRUCTION_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/geodesy.h"
#include "core/packed_features.h"
#include "core/rigid3.h"

namespace cairn {

// One registered image with all of its keypoints and their raw descriptors.
struct ReconImage {
  std::string name;
  int camera_idx = 0;
  Rigid3d cam_from_world;
  PackedFeatures features;
  // The position prior of the image. The height is unchanged; for photos it is above mean sea
  // level.
  std::optional<Geodetic> gps;
  std::optional<double> gps_accuracy_m;        // 68 % radius of `gps`, if the source states it.
  std::optional<Eigen::Vector3d> down_in_cam;  // Unit vector along gravity, if a sensor felt it.
};

struct ReconObservation {
  int image_idx = 0;
  int keypoint_idx = 0;
};

struct ReconLandmark {
  Eigen::Vector3d x_in_world;
  std::vector<ReconObservation> observations;  // At most one per image.
};

struct Reconstruction {
  std::string descriptor_type = "sift";
  std::vector<Camera> cameras;
  std::vector<ReconImage> images;
  std::vector<ReconLandmark> landmarks;

  // The descriptor dimension of the first image with features; 0 if no image has features.
  int descriptor_dim() const;

  // Throws Error(kBadInput) if an index is out of range, a number is not finite, a landmark has two
  // observations in one image, or images differ in descriptor dimension.
  void Validate() const;
};

// Returns these images in this order, with all cameras, and the landmarks that are seen in them.
Reconstruction SelectImages(const Reconstruction& all, const std::vector<int>& image_idxs);

}  // namespace cairn

#endif  // CAIRN_CORE_SCENE_RECONSTRUCTION_H_
