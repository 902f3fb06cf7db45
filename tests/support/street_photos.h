// The photos of a synthetic street as the stages of mapping take them.
#ifndef CAIRN_TESTS_SUPPORT_STREET_PHOTOS_H_
#define CAIRN_TESTS_SUPPORT_STREET_PHOTOS_H_

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "core/geodesy.h"
#include "core/rigid3.h"
#include "mapping/photo_set.h"
#include "support/reconstruction_builder.h"

namespace cairn::testing {

// One camera, with known intrinsics.
inline PhotoSet PhotosOf(const Reconstruction& street) {
  PhotoSet set;
  for (const Camera& camera : street.cameras) {
    set.cameras.push_back({camera, {}, FocalSource::kCalibration});
  }
  for (const ReconImage& image : street.images) {
    MappingPhoto photo;
    photo.name = image.name;
    photo.camera_idx = image.camera_idx;
    photo.keypoints = image.features.keypoints;
    photo.descriptors = *image.features.descriptors.as_bytes();
    set.photos.push_back(std::move(photo));
  }
  return set;
}

// Gives the photos the positions of the street with a normal error along each axis of ECEF.
inline void AddNoisyPositions(const Reconstruction& street, double sigma_m, double accuracy_m,
                              uint64_t seed, PhotoSet* set) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> noise(0.0, sigma_m);
  for (size_t i = 0; i < set->photos.size(); ++i) {
    const Eigen::Vector3d x_in_ecef = EcefFromGeodetic(*street.images[i].gps) +
                                      Eigen::Vector3d(noise(rng), noise(rng), noise(rng));
    set->photos[i].gps = GeodeticFromEcef(x_in_ecef);
    set->photos[i].gps_accuracy_m = accuracy_m;
  }
}

// The largest distance between true centers and centers of a segment under the similarity that fits
// them best, in units of the true world.
inline double WorstError(const Reconstruction& truth, const Reconstruction& model,
                         const std::vector<int>& photo_of_image) {
  Eigen::Matrix3Xd found(3, model.images.size()), wanted(3, model.images.size());
  for (size_t i = 0; i < model.images.size(); ++i) {
    found.col(i) = model.images[i].cam_from_world.Inverse().translation;
    wanted.col(i) = truth.images[photo_of_image[i]].cam_from_world.Inverse().translation;
  }
  const Eigen::Matrix4d fit = Eigen::umeyama(found, wanted, true);
  double worst = 0.0;
  for (Eigen::Index i = 0; i < found.cols(); ++i) {
    const Eigen::Vector3d placed = (fit * found.col(i).homogeneous()).head<3>();
    worst = std::max(worst, (placed - wanted.col(i)).norm());
  }
  return worst;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_STREET_PHOTOS_H_
