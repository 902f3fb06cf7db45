// A reconstruction in memory: what every reader produces and every ingest consumes.
#ifndef CAIRN_INGEST_SFM_RECONSTRUCTION_H_
#define CAIRN_INGEST_SFM_RECONSTRUCTION_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/features.h"
#include "core/geodesy.h"
#include "core/rigid3.h"

namespace cairn {

// One registered image. Features hold all keypoints of the image, with raw descriptors.
struct ReconImage {
  std::string name;
  int camera_idx = 0;
  Rigid3d cam_from_world;
  FeatureSet features;
  // A position prior that came with the image; its height is as it came, with photos above mean sea
  // level.
  std::optional<Geodetic> gps;
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

  // Of the first image that has features; 0 if none has.
  int descriptor_dim() const;

  // Throws Error(kBadInput) if an index is out of range, a number is not finite, a landmark has two
  // observations in one image, or descriptor dimensions differ between images.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_SFM_RECONSTRUCTION_H_
