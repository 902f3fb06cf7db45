#include "eval/bench/synthetic_sift.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace cairn {
namespace {

constexpr int kNormalTableBits = 16;

// Standard deviations of RootSIFT along its principal axes: of all descriptors, and between
// observations of one landmark. Measured on the landmarks of two street reconstructions (12,000 and
// 5,000 landmarks, which agree within a tenth); in between, interpolated.
struct AxisSigmas {
  int axis;
  float all;
  float observations;
};
constexpr std::array kSpectrum = {
    AxisSigmas{0, 0.190f, 0.034f},  AxisSigmas{1, 0.170f, 0.035f},  AxisSigmas{2, 0.162f, 0.036f},
    AxisSigmas{3, 0.141f, 0.034f},  AxisSigmas{5, 0.127f, 0.033f},  AxisSigmas{7, 0.115f, 0.035f},
    AxisSigmas{11, 0.087f, 0.032f}, AxisSigmas{15, 0.075f, 0.028f}, AxisSigmas{23, 0.055f, 0.021f},
    AxisSigmas{31, 0.044f, 0.021f}, AxisSigmas{47, 0.033f, 0.017f}, AxisSigmas{63, 0.024f, 0.013f},
    AxisSigmas{95, 0.015f, 0.009f}, AxisSigmas{127, 0.007f, 0.005f}};
// Some observations are much noisier than others: the logarithm of their noise has this standard
// deviation (measured likewise).
constexpr float kLogNoiseSigma = 0.49f;
// The mean of RootSIFT over all descriptors: its elements lie in this range and its norm is 0.81.
constexpr float kMinMean = 0.039f;
constexpr float kMaxMean = 0.164f;
constexpr float kMeanNorm = 0.81f;

// SplitMix64 (Steele et al. 2014): neighbouring inputs give independent outputs.
uint64_t Mix(uint64_t value) {
  value += 0x9e3779b97f4a7c15;
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9;
  value = (value ^ (value >> 27)) * 0x94d049bb133111eb;
  return value ^ (value >> 31);
}

// kSpectrum at any axis.
AxisSigmas InterpolateSpectrum(int axis) {
  const auto above = std::find_if(kSpectrum.begin(), kSpectrum.end(),
                                  [axis](const AxisSigmas& known) { return known.axis >= axis; });
  if (above->axis == axis) {
    return *above;
  }
  const AxisSigmas& below = *(above - 1);
  const float t =
      static_cast<float>(axis - below.axis) / static_cast<float>(above->axis - below.axis);
  return {axis, std::lerp(below.all, above->all, t),
          std::lerp(below.observations, above->observations, t)};
}

// In-place Walsh-Hadamard transform: an orthogonal change of axes, times sqrt(kDim).
void HadamardTransform(SyntheticSift::Descriptor* values) {
  for (int half = 1; half < SyntheticSift::kDim; half *= 2) {
    for (int begin = 0; begin < SyntheticSift::kDim; begin += 2 * half) {
      for (int i = begin; i < begin + half; ++i) {
        const float a = (*values)[i];
        const float b = (*values)[i + half];
        (*values)[i] = a + b;
        (*values)[i + half] = a - b;
      }
    }
  }
}

}  // namespace

SyntheticSift::SyntheticSift(uint64_t seed) : seed_(Mix(seed)) {
  std::mt19937_64 generator(seed_);
  std::normal_distribution<float> normal;
  normal_table_.resize(size_t{1} << kNormalTableBits);
  std::generate(normal_table_.begin(), normal_table_.end(), [&] { return normal(generator); });

  std::uniform_real_distribution<float> mean(kMinMean, kMaxMean);
  std::bernoulli_distribution coin;
  for (int i = 0; i < kDim; ++i) {
    mean_[i] = mean(generator);
    signs_[i] = (coin(generator) ? 1.0f : -1.0f) / std::sqrt(static_cast<float>(kDim));
    const AxisSigmas sigmas = InterpolateSpectrum(i);
    observation_sigmas_[i] = sigmas.observations;
    landmark_sigmas_[i] =
        std::sqrt(sigmas.all * sigmas.all - sigmas.observations * sigmas.observations);
  }
  mean_ *= kMeanNorm / mean_.norm();
}

SyntheticSift::Descriptor SyntheticSift::Observe(uint64_t landmark, uint64_t observation) const {
  const uint64_t landmark_seed = Mix(seed_ ^ landmark);
  const uint64_t observation_seed = Mix(landmark_seed + 1 + observation);
  // The factor keeps the mean of the squared noise.
  const float noise_scale =
      std::exp(kLogNoiseSigma * Normal(Mix(observation_seed)) - kLogNoiseSigma * kLogNoiseSigma);
  Descriptor root = Descriptor::Zero();
  AddNoise(landmark_seed, landmark_sigmas_, 1.0f, &root);
  AddNoise(observation_seed, observation_sigmas_, noise_scale, &root);
  HadamardTransform(&root);
  root = (mean_ + root.cwiseProduct(signs_)).cwiseMax(0.0f);
  return root.cwiseAbs2();
}

float SyntheticSift::Normal(uint64_t bits) const {
  return normal_table_[bits & ((uint64_t{1} << kNormalTableBits) - 1)];
}

void SyntheticSift::AddNoise(uint64_t seed, const Descriptor& sigmas, float scale,
                             Descriptor* axes) const {
  constexpr int kDrawsPerWord = 64 / kNormalTableBits;
  for (int i = 0; i < kDim; i += kDrawsPerWord) {
    uint64_t bits = Mix(seed + static_cast<uint64_t>(i) * 0x2545f4914f6cdd1d);
    for (int j = i; j < i + kDrawsPerWord; ++j) {
      (*axes)[j] += scale * sigmas[j] * Normal(bits);
      bits >>= kNormalTableBits;
    }
  }
}

}  // namespace cairn
