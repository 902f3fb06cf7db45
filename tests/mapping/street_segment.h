// A street as a segment of photos, for tests of the stages after the growth.
#ifndef CAIRN_TESTS_MAPPING_STREET_SEGMENT_H_
#define CAIRN_TESTS_MAPPING_STREET_SEGMENT_H_

#include <random>

#include "mapping/session/place_segment.h"
#include "support/reconstruction_builder.h"

namespace cairn::testing {

struct StreetSegment {
  PhotoSet set;
  Segment segment;
  PhotoPlaces places;  // True positions with noise.
  StreetWorld world;
};

inline StreetSegment MakeStreetSegment(double position_sigma_m) {
  StreetWorldOptions options;
  options.length_m = 45.0;
  options.num_landmarks = 600;
  StreetSegment street{.set = {}, .segment = {}, .places = {}, .world = StreetWorld(options)};
  street.segment.model = street.world.Reconstruct();
  Reconstruction& model = street.segment.model;
  street.set.cameras = {{model.cameras[0], {}, FocalSource::kCalibration}};
  std::mt19937_64 rng(3);
  std::normal_distribution<double> noise(0.0, position_sigma_m);
  for (size_t i = 0; i < model.images.size(); ++i) {
    ReconImage& image = model.images[i];
    MappingPhoto photo;
    photo.name = image.name;
    photo.keypoints = image.features.keypoints;
    photo.descriptors = *image.features.descriptors.as_bytes();
    street.set.photos.push_back(photo);
    image.features.descriptors = PackedDescriptors(ByteDescriptorMatrix(image.features.size(), 0));
    street.segment.photo_of_image.push_back(static_cast<int>(i));
    const Eigen::Vector3d x_in_ecef =
        EcefFromGeodetic(*image.gps) + Eigen::Vector3d(noise(rng), noise(rng), noise(rng));
    street.places.positions.push_back(
        CameraPosition{image.name, GeodeticFromEcef(x_in_ecef), 1.5 * position_sigma_m, true});
    street.places.orientations.push_back(1);
  }
  return street;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_MAPPING_STREET_SEGMENT_H_
