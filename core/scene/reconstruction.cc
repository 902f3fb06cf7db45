#include "core/scene/reconstruction.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/printable.h"

namespace cairn {
namespace {

[[noreturn]] void ThrowBadInput(const std::string& what) {
  throw Error(ErrorCode::kBadInput, "reconstruction: " + what);
}

void ValidateImage(const ReconImage& image, size_t num_cameras, Eigen::Index descriptor_dim) {
  if (image.camera_idx < 0 || static_cast<size_t>(image.camera_idx) >= num_cameras) {
    ThrowBadInput(fmt::format("image {} refers to camera {} of {}", Excerpt(image.name),
                              image.camera_idx, num_cameras));
  }
  const Rigid3d& pose = image.cam_from_world;
  if (!pose.translation.allFinite() || std::abs(pose.rotation.norm() - 1.0) > 1e-6) {
    ThrowBadInput(fmt::format("the pose of image {} is not finite", Excerpt(image.name)));
  }
  ValidateFeatures(image.features, Excerpt(image.name).c_str());
  if (image.features.space != DescriptorSpace::kRaw) {
    ThrowBadInput(fmt::format("image {} has projected descriptors; raw ones are needed",
                              Excerpt(image.name)));
  }
  if (image.features.size() > 0 && image.features.descriptors.cols() != descriptor_dim) {
    ThrowBadInput(fmt::format("image {} has {}-D descriptors, but other images have {}-D",
                              Excerpt(image.name), image.features.descriptors.cols(),
                              descriptor_dim));
  }
  if (image.gps) {
    ValidateGeodetic(*image.gps, Excerpt(image.name).c_str());
  }
  if (image.gps_accuracy_m && !(*image.gps_accuracy_m > 0.0)) {
    ThrowBadInput(
        fmt::format("the accuracy of the GPS of image {} is not positive", Excerpt(image.name)));
  }
  if (image.down_in_cam && !(std::abs(image.down_in_cam->norm() - 1.0) <= 1e-6)) {
    ThrowBadInput(fmt::format("the gravity of image {} is no unit vector", Excerpt(image.name)));
  }
}

}  // namespace

void Reconstruction::Validate() const {
  const Eigen::Index dim = descriptor_dim();
  for (const ReconImage& image : images) {
    ValidateImage(image, cameras.size(), dim);
  }
  std::vector<size_t> last_landmark_of_image(images.size(), landmarks.size());
  for (size_t i = 0; i < landmarks.size(); ++i) {
    if (!landmarks[i].x_in_world.allFinite()) {
      ThrowBadInput(fmt::format("the position of landmark {} is not finite", i));
    }
    for (const ReconObservation& observation : landmarks[i].observations) {
      if (observation.image_idx < 0 ||
          static_cast<size_t>(observation.image_idx) >= images.size()) {
        ThrowBadInput(fmt::format("landmark {} refers to image {} of {}", i, observation.image_idx,
                                  images.size()));
      }
      const ReconImage& image = images[observation.image_idx];
      if (observation.keypoint_idx < 0 || observation.keypoint_idx >= image.features.size()) {
        ThrowBadInput(fmt::format("landmark {} refers to keypoint {} of {} in image {}", i,
                                  observation.keypoint_idx, image.features.size(),
                                  Excerpt(image.name)));
      }
      if (last_landmark_of_image[observation.image_idx] == i) {
        ThrowBadInput(
            fmt::format("landmark {} is observed twice in image {}", i, Excerpt(image.name)));
      }
      last_landmark_of_image[observation.image_idx] = i;
    }
  }
}

int Reconstruction::descriptor_dim() const {
  for (const ReconImage& image : images) {
    if (image.features.size() > 0) {
      return static_cast<int>(image.features.descriptors.cols());
    }
  }
  return 0;
}

Reconstruction SelectImages(const Reconstruction& all, const std::vector<int>& image_idxs) {
  Reconstruction selected;
  selected.descriptor_type = all.descriptor_type;
  selected.cameras = all.cameras;
  std::vector<int> new_idx(all.images.size(), -1);
  for (const int image_idx : image_idxs) {
    new_idx[image_idx] = static_cast<int>(selected.images.size());
    selected.images.push_back(all.images[image_idx]);
  }
  for (const ReconLandmark& landmark : all.landmarks) {
    ReconLandmark seen = {landmark.x_in_world, {}};
    for (const ReconObservation& observation : landmark.observations) {
      if (const int image_idx = new_idx[observation.image_idx]; image_idx >= 0) {
        seen.observations.push_back({image_idx, observation.keypoint_idx});
      }
    }
    if (!seen.observations.empty()) {
      selected.landmarks.push_back(std::move(seen));
    }
  }
  return selected;
}

}  // namespace cairn
