#include "lab/experiments/runs/descriptor_looks.h"

#include <random>
#include <string>
#include <utility>

#include "core/scene/reconstruction.h"
#include "lab/descriptors/descriptor_model.h"

namespace cairn {
namespace {

constexpr int kLandmarksPerOrnament = 5;
// Larger than the numbers of the experiments' landmarks.
constexpr uint64_t kTrainingLandmark = uint64_t{1} << 40;
constexpr int kTrainingLandmarks = 15'000;
constexpr int kTrainingLooks = 3;
constexpr uint64_t kPhoneObservation = 1'000'000;
constexpr int kCarModes = 3;

DescriptorModel MakeModel(uint64_t seed) {
  DescriptorModelOptions options;
  options.seed = seed;
  return DescriptorModel(options);
}

DescriptorLook Landmark(uint64_t number) {
  DescriptorLook look;
  look.landmark = number;
  const uint64_t group = number / kLandmarksPerOrnament;
  look.ornament = group % 3 == 0 ? group : kTrainingLandmark + number;
  return look;
}

}  // namespace

DescriptorMatrix DescriptorLooks::ByCar(uint64_t first, int num_landmarks, int looks_each) const {
  const DescriptorModel model = MakeModel(seed_);
  DescriptorMatrix descriptors(Eigen::Index{num_landmarks} * looks_each, DescriptorModel::kDim);
  std::mt19937_64 generator(seed_ ^ first);
  std::normal_distribution<double> azimuth(0.0, 0.4), elevation(0.0, 0.15), scale(0.0, 0.5);
  for (Eigen::Index row = 0; row < descriptors.rows(); ++row) {
    DescriptorLook look = Landmark(first + static_cast<uint64_t>(row / looks_each));
    look.observation = static_cast<uint64_t>(row % looks_each);
    look.appearance_mode = static_cast<uint32_t>(generator() % kCarModes);
    look.view_azimuth_rad = azimuth(generator);
    look.view_elevation_rad = elevation(generator);
    look.log2_scale = scale(generator);
    descriptors.row(row) = model.Describe(look);
  }
  return descriptors;
}

DescriptorMatrix DescriptorLooks::ByPhone(uint64_t first, int num_landmarks) const {
  const DescriptorModel model = MakeModel(seed_);
  DescriptorMatrix descriptors(num_landmarks, DescriptorModel::kDim);
  std::mt19937_64 generator(seed_ ^ first ^ kPhoneObservation);
  std::normal_distribution<double> azimuth(0.0, 0.5), elevation(0.05, 0.2), scale(0.3, 0.6);
  for (int i = 0; i < num_landmarks; ++i) {
    DescriptorLook look = Landmark(first + static_cast<uint64_t>(i));
    look.observation = kPhoneObservation;
    look.appearance_mode = kCarModes + 1;
    look.view_azimuth_rad = azimuth(generator);
    look.view_elevation_rad = elevation(generator);
    look.log2_scale = scale(generator);
    descriptors.row(i) = model.Describe(look);
  }
  return descriptors;
}

Codebook DescriptorLooks::Train(const CodebookOptions& options) const {
  const DescriptorMatrix looks = ByCar(kTrainingLandmark, kTrainingLandmarks, kTrainingLooks);
  Reconstruction sample;
  sample.cameras.emplace_back();
  sample.images.resize(kTrainingLooks);
  sample.landmarks.resize(kTrainingLandmarks);
  for (int image = 0; image < kTrainingLooks; ++image) {
    FeatureSet features;
    sample.images[image].name = std::to_string(image);
    features.keypoints.resize(kTrainingLandmarks);
    features.descriptors.resize(kTrainingLandmarks, DescriptorModel::kDim);
    for (int i = 0; i < kTrainingLandmarks; ++i) {
      features.descriptors.row(i) = looks.row(Eigen::Index{i} * kTrainingLooks + image);
      sample.landmarks[i].x_in_world = Eigen::Vector3d::Zero();
      sample.landmarks[i].observations.push_back({image, i});
    }
    sample.images[image].features = std::move(features);
  }
  return TrainCodebook(sample, options);
}

}  // namespace cairn
