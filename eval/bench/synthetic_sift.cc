#include "eval/bench/synthetic_sift.h"

#include <algorithm>
#include <random>

namespace cairn {
namespace {

constexpr int kNumClusters = 4096;
constexpr int kNormalTableBits = 16;
// SIFT scales unit vectors by 512.
constexpr float kDescriptorNorm = 512.0f;
// Amplitudes per dimension. With them the median distance of two observations of a landmark is to
// the distance of the nearest of 10,000 other landmarks as in maps of real photos (see the codebook
// statistics of `cairn bench`).
constexpr float kLandmarkAmplitude = 22.0f;
constexpr float kObservationAmplitude = 12.0f;

// SplitMix64 (Steele et al. 2014): neighbouring inputs give independent outputs.
uint64_t Mix(uint64_t value) {
  value += 0x9e3779b97f4a7c15;
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9;
  value = (value ^ (value >> 27)) * 0x94d049bb133111eb;
  return value ^ (value >> 31);
}

}  // namespace

SyntheticSift::SyntheticSift(uint64_t seed) : seed_(Mix(seed)) {
  std::mt19937_64 generator(seed_);
  std::normal_distribution<float> normal;
  normal_table_.resize(size_t{1} << kNormalTableBits);
  std::generate(normal_table_.begin(), normal_table_.end(), [&] { return normal(generator); });

  std::exponential_distribution<float> exponential;
  centers_.resize(kNumClusters, kDim);
  for (int i = 0; i < centers_.size(); ++i) {
    // The square of an exponential value has the heavy tail of gradient histograms.
    const float value = exponential(generator);
    centers_.data()[i] = value * value;
  }
  centers_.rowwise().normalize();
  centers_ *= kDescriptorNorm;
}

SyntheticSift::Descriptor SyntheticSift::Observe(uint64_t landmark, uint64_t observation) const {
  const uint64_t landmark_seed = Mix(seed_ ^ landmark);
  Descriptor descriptor = centers_.row(static_cast<int>(landmark_seed % kNumClusters));
  AddNoise(landmark_seed, kLandmarkAmplitude, &descriptor);
  AddNoise(Mix(landmark_seed + 1 + observation), kObservationAmplitude, &descriptor);
  return descriptor.cwiseMax(0.0f).cwiseMin(255.0f);
}

void SyntheticSift::AddNoise(uint64_t seed, float amplitude, Descriptor* descriptor) const {
  constexpr int kDrawsPerWord = 64 / kNormalTableBits;
  constexpr uint64_t kTableMask = (uint64_t{1} << kNormalTableBits) - 1;
  for (int i = 0; i < kDim; i += kDrawsPerWord) {
    uint64_t bits = Mix(seed + static_cast<uint64_t>(i) * 0x2545f4914f6cdd1d);
    for (int j = i; j < i + kDrawsPerWord; ++j) {
      (*descriptor)[j] += amplitude * normal_table_[bits & kTableMask];
      bits >>= kNormalTableBits;
    }
  }
}

}  // namespace cairn
