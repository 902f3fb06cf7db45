#include "eval/city/descriptors/descriptor_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "core/error.h"

namespace cairn {
namespace {

constexpr int kNormalTableBits = 16;
constexpr int kRun = 8;       // Normal values that are read from the table in one go.
constexpr int kNumWaves = 4;  // Random features of the view's effect.

// Streams of random numbers that must not meet.
constexpr uint64_t kOrnamentStream = 0x51;
constexpr uint64_t kInstanceStream = 0x52;
constexpr uint64_t kViewStream = 0x53;
constexpr uint64_t kModeStream = 0x54;
constexpr uint64_t kNoiseStream = 0x55;
constexpr uint64_t kClutterStream = 0x56;

// The mean of RootSIFT over all descriptors: its elements lie in this range and its norm is 0.81.
constexpr float kMinMean = 0.039f;
constexpr float kMaxMean = 0.164f;
constexpr float kMeanNorm = 0.81f;
constexpr float kRawNorm = 512.0f;

// SplitMix64 (Steele et al. 2014): neighbouring inputs give independent outputs.
uint64_t Mix(uint64_t value) {
  value += 0x9e3779b97f4a7c15;
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9;
  value = (value ^ (value >> 27)) * 0x94d049bb133111eb;
  return value ^ (value >> 31);
}

uint64_t Mix(uint64_t a, uint64_t b) { return Mix(Mix(a) ^ b); }

// Runs of the normal table repeat among a million landmarks; this order gives each run an equal
// share of the strong axes, so that no repetition matters.
int RankOf(int row) { return row % kRun * (DescriptorModel::kDim / kRun) + row / kRun; }

DescriptorAxis Interpolate(const std::vector<DescriptorAxis>& axes, int rank) {
  const auto above = std::find_if(
      axes.begin(), axes.end(), [rank](const DescriptorAxis& known) { return known.rank >= rank; });
  if (above->rank == rank) {
    return *above;
  }
  const DescriptorAxis& below = *(above - 1);
  const float t =
      static_cast<float>(rank - below.rank) / static_cast<float>(above->rank - below.rank);
  return {.rank = rank,
          .landmark = std::lerp(below.landmark, above->landmark, t),
          .instance = std::lerp(below.instance, above->instance, t),
          .view = std::lerp(below.view, above->view, t),
          .mode = std::lerp(below.mode, above->mode, t),
          .noise = std::lerp(below.noise, above->noise, t)};
}

// In-place Walsh-Hadamard transform: an orthogonal change of axes, times sqrt(kDim).
void HadamardTransform(Eigen::Array<float, 1, DescriptorModel::kDim>* values) {
  for (int half = 1; half < DescriptorModel::kDim; half *= 2) {
    for (int begin = 0; begin < DescriptorModel::kDim; begin += 2 * half) {
      for (int i = begin; i < begin + half; ++i) {
        const float a = (*values)[i];
        const float b = (*values)[i + half];
        (*values)[i] = a + b;
        (*values)[i + half] = a - b;
      }
    }
  }
}

void Require(bool ok, const char* what) {
  if (!ok) {
    throw Error(ErrorCode::kInvalidArgument, fmt::format("DescriptorModelOptions: {}", what));
  }
}

}  // namespace

std::vector<DescriptorAxis> DescriptorModelOptions::FittedAxes() {
  constexpr float kViewShare = 0.6f;
  constexpr float kModeShare = 0.8f;
  constexpr float kInstanceShare = 0.8f;
  struct Sigmas {
    int rank;
    float all, within;
  };
  constexpr std::array kMeasured = {
      Sigmas{0, 0.190f, 0.034f},  Sigmas{1, 0.170f, 0.035f},  Sigmas{2, 0.162f, 0.036f},
      Sigmas{3, 0.141f, 0.034f},  Sigmas{5, 0.127f, 0.033f},  Sigmas{7, 0.115f, 0.035f},
      Sigmas{11, 0.087f, 0.032f}, Sigmas{15, 0.075f, 0.028f}, Sigmas{23, 0.055f, 0.021f},
      Sigmas{31, 0.044f, 0.021f}, Sigmas{47, 0.033f, 0.017f}, Sigmas{63, 0.024f, 0.013f},
      Sigmas{95, 0.015f, 0.009f}, Sigmas{127, 0.007f, 0.005f}};
  std::vector<DescriptorAxis> axes;
  for (const Sigmas& s : kMeasured) {
    axes.push_back({.rank = s.rank,
                    .landmark = std::sqrt(s.all * s.all - s.within * s.within),
                    .instance = kInstanceShare * s.within,
                    .view = kViewShare * s.within,
                    .mode = kModeShare * s.within,
                    .noise = std::sqrt(1 - kViewShare * kViewShare) * s.within});
  }
  return axes;
}

void DescriptorModelOptions::Validate() const {
  Require(!axes.empty() && axes.front().rank == 0 && axes.back().rank == DescriptorModel::kDim - 1,
          "axes must begin with rank 0 and end with rank 127");
  for (size_t i = 1; i < axes.size(); ++i) {
    Require(axes[i].rank > axes[i - 1].rank, "axes must ascend by rank");
  }
  for (const DescriptorAxis& axis : axes) {
    for (const float sigma : {axis.landmark, axis.instance, axis.view, axis.mode, axis.noise}) {
      Require(sigma >= 0.0f && sigma < 1.0f, "standard deviations must lie in [0, 1)");
    }
  }
  Require(log_noise_sigma >= 0.0 && log_noise_sigma <= 2.0, "log_noise_sigma must lie in [0, 2]");
  for (const double scale : {view_azimuth_scale_rad, view_elevation_scale_rad, view_log2_scale}) {
    Require(scale > 0.0 && scale < 1e6, "view scales must be positive");
  }
}

DescriptorModel::DescriptorModel(const DescriptorModelOptions& options)
    : seed_(Mix(options.seed)), log_noise_sigma_(static_cast<float>(options.log_noise_sigma)) {
  options.Validate();
  view_frequency_ =
      Eigen::Vector3d(1.0 / options.view_azimuth_scale_rad, 1.0 / options.view_elevation_scale_rad,
                      1.0 / options.view_log2_scale)
          .cast<float>();
  std::mt19937_64 generator(seed_);
  std::normal_distribution<float> normal;
  normal_table_.resize((size_t{1} << kNormalTableBits) + kRun);
  std::generate(normal_table_.begin(), normal_table_.end(), [&] { return normal(generator); });

  std::uniform_real_distribution<float> mean(kMinMean, kMaxMean);
  std::bernoulli_distribution coin;
  for (int i = 0; i < kDim; ++i) {
    mean_[i] = mean(generator);
    signs_[i] = (coin(generator) ? 1.0f : -1.0f) / std::sqrt(static_cast<float>(kDim));
    const DescriptorAxis axis = Interpolate(options.axes, RankOf(i));
    landmark_sigmas_[i] = axis.landmark;
    instance_sigmas_[i] = axis.instance;
    view_sigmas_[i] = axis.view;
    mode_sigmas_[i] = axis.mode;
    noise_sigmas_[i] = axis.noise;
  }
  mean_ *= kMeanNorm / mean_.matrix().norm();
}

DescriptorModel::Descriptor DescriptorModel::Describe(const DescriptorLook& look) const {
  const uint64_t ornament_seed = Mix(seed_ ^ kOrnamentStream, look.ornament);
  const uint64_t landmark_seed = Mix(seed_ ^ kInstanceStream, look.landmark);
  const uint64_t noise_seed = Mix(landmark_seed ^ kNoiseStream, look.observation);
  Axes axes = Axes::Zero();
  AddNormal(ornament_seed, landmark_sigmas_, 1.0f, &axes);
  AddNormal(landmark_seed, instance_sigmas_, 1.0f, &axes);
  AddView(Mix(ornament_seed ^ kViewStream), look, &axes);
  if (look.appearance_mode != 0) {
    AddNormal(Mix(landmark_seed ^ kModeStream, look.appearance_mode), mode_sigmas_, 1.0f, &axes);
  }
  // The factor keeps the mean of the squared noise.
  const float noise_scale =
      std::exp(log_noise_sigma_ * Normal(Mix(noise_seed)) - log_noise_sigma_ * log_noise_sigma_);
  AddNormal(noise_seed, noise_sigmas_, noise_scale, &axes);
  return ToRaw(axes);
}

DescriptorModel::Descriptor DescriptorModel::DescribeClutter(uint64_t number) const {
  const uint64_t clutter = Mix(seed_ ^ kClutterStream, number);
  return Describe({.ornament = clutter, .landmark = clutter});
}

float DescriptorModel::Normal(uint64_t bits) const {
  return normal_table_[bits & ((uint64_t{1} << kNormalTableBits) - 1)];
}

void DescriptorModel::AddNormal(uint64_t seed, const Axes& sigmas, float weight, Axes* axes) const {
  constexpr int kRunsPerWord = 64 / kNormalTableBits;
  for (int i = 0; i < kDim; i += kRun * kRunsPerWord) {
    uint64_t bits = Mix(seed + static_cast<uint64_t>(i) * 0x2545f4914f6cdd1d);
    for (int j = i; j < i + kRun * kRunsPerWord; j += kRun) {
      const float* values = &normal_table_[bits & ((uint64_t{1} << kNormalTableBits) - 1)];
      for (int k = 0; k < kRun; ++k) {
        (*axes)[j + k] += weight * sigmas[j + k] * values[k];
      }
      bits >>= kNormalTableBits;
    }
  }
}

void DescriptorModel::AddView(uint64_t seed, const DescriptorLook& look, Axes* axes) const {
  const Eigen::Vector3f view(static_cast<float>(look.view_azimuth_rad),
                             static_cast<float>(look.view_elevation_rad),
                             static_cast<float>(look.log2_scale));
  const float amplitude = 1.0f / std::sqrt(static_cast<float>(kNumWaves));
  for (int wave = 0; wave < kNumWaves; ++wave) {
    const uint64_t wave_seed = Mix(seed + static_cast<uint64_t>(wave));
    const Eigen::Vector3f direction(Normal(wave_seed), Normal(wave_seed >> 16),
                                    Normal(wave_seed >> 32));
    const float phase = direction.cwiseProduct(view_frequency_).dot(view);
    AddNormal(Mix(wave_seed, 1), view_sigmas_, amplitude * std::cos(phase), axes);
    AddNormal(Mix(wave_seed, 2), view_sigmas_, amplitude * std::sin(phase), axes);
  }
}

DescriptorModel::Descriptor DescriptorModel::ToRaw(Axes axes) const {
  HadamardTransform(&axes);
  const Axes raw = (mean_ + axes * signs_).max(0.0f).square();
  const float norm = raw.matrix().norm();
  return norm > 0.0f ? Descriptor((kRawNorm / norm * raw).matrix()) : Descriptor::Zero();
}

}  // namespace cairn
