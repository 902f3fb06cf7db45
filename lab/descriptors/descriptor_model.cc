#include "lab/descriptors/descriptor_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "core/random.h"
#include "core/require.h"

namespace cairn {
namespace {

constexpr int kNormalTableBits = 16;
constexpr int kRun = 8;       // Normal values per contiguous read of the table.
constexpr int kNumWaves = 4;  // Random features of the view's effect.
// Number of an ornament's 64 bits that name its node, for each level of the tree.
constexpr std::array kLevelBits = {4, 6, 8};
constexpr int kSpreadLevel = 1;  // The level whose nodes differ in spread.

// Streams of random numbers that must stay separate.
constexpr uint64_t kOrnamentStream = 0x51;
constexpr uint64_t kNodeStream = 0x52;
constexpr uint64_t kInstanceStream = 0x53;
constexpr uint64_t kViewStream = 0x54;
constexpr uint64_t kModeStream = 0x55;
constexpr uint64_t kNoiseStream = 0x56;
constexpr uint64_t kClutterStream = 0x57;

// The mean of RootSIFT over all descriptors. Its elements are in this range; its norm is 0.81.
constexpr float kMinMean = 0.039f;
constexpr float kMaxMean = 0.164f;
constexpr float kMeanNorm = 0.81f;
constexpr float kRawNorm = 512.0f;
constexpr float kMaxRaw = 255.0f;

uint64_t Mix(uint64_t a, uint64_t b) { return HashWord(HashWord(a) ^ b); }

// A million landmarks use the same run of the normal table more than once. This order gives each
// run an equal share of the strong axes, so that a repetition has no visible effect.
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
          .between = std::lerp(below.between, above->between, t),
          .within = std::lerp(below.within, above->within, t)};
}

// In-place Walsh-Hadamard transform: an orthogonal change of axes times sqrt(kDim).
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

void RequireSpread(double value, const char* field) { RequireWithin(field, value, 0.0, 2.0); }

// Maps a standard normal value to a log-normal value with a mean square of one.
float LogNormal(double spread, float normal) {
  return std::exp(static_cast<float>(spread) * normal - static_cast<float>(spread * spread));
}

}  // namespace

std::vector<DescriptorAxis> DescriptorModelOptions::FittedAxes() {
  return {{0, 0.2190f, 0.179f},  {1, 0.1991f, 0.187f},  {2, 0.1854f, 0.172f},
          {3, 0.1571f, 0.188f},  {5, 0.1399f, 0.166f},  {7, 0.1175f, 0.178f},
          {11, 0.0889f, 0.158f}, {15, 0.0725f, 0.139f}, {23, 0.0485f, 0.118f},
          {31, 0.0322f, 0.098f}, {47, 0.0224f, 0.076f}, {63, 0.0131f, 0.062f},
          {95, 0.0055f, 0.043f}, {127, 0.0018f, 0.028f}};
}

void DescriptorModelOptions::Validate() const {
  RequireOption(
      !axes.empty() && axes.front().rank == 0 && axes.back().rank == DescriptorModel::kDim - 1,
      "axes must begin with rank 0 and end with rank 127");
  for (size_t i = 1; i < axes.size(); ++i) {
    RequireOption(axes[i].rank > axes[i - 1].rank, "axes must ascend by rank");
  }
  for (const DescriptorAxis& axis : axes) {
    RequireOption(axis.between >= 0.0f && axis.between < 1.0f, "axes' between must lie in [0, 1)");
    RequireOption(axis.within > 0.0f && axis.within <= 1.0f, "axes' within must lie in (0, 1]");
  }
  RequireOption(cluster_share >= 0.0 && kLevelBits.size() * cluster_share <= 1.0,
                "cluster_share must lie in [0, 1 / 3]");
  RequireSpread(log_cluster_spread, "log_cluster_spread");
  RequireSpread(log_landmark_spread, "log_landmark_spread");
  RequireSpread(noise_length, "noise_length");
  RequireSpread(view_length, "view_length");
  RequireSpread(mode_length, "mode_length");
  RequireSpread(instance_length, "instance_length");
  RequireSpread(log_look_spread, "log_look_spread");
  RequireSpread(log_stability_spread, "log_stability_spread");
  RequireOption(view_angle_scale_rad > 0.0, "view_angle_scale_rad must be positive");
  RequireOption(view_log2_scale > 0.0, "view_log2_scale must be positive");
}

DescriptorModel::DescriptorModel(const DescriptorModelOptions& options)
    : options_(options), seed_(HashWord(options.seed)) {
  options.Validate();
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
    between_sigmas_[i] = axis.between;
    within_sigmas_[i] = axis.within;
  }
  mean_ *= kMeanNorm / mean_.matrix().norm();
  within_sigmas_ /= within_sigmas_.matrix().norm();
  node_weight_ = static_cast<float>(std::sqrt(options.cluster_share));
  leaf_weight_ =
      static_cast<float>(std::sqrt(std::max(0.0, 1.0 - kLevelBits.size() * options.cluster_share)));
}

DescriptorModel::Descriptor DescriptorModel::Describe(const DescriptorLook& look) const {
  const uint64_t ornament_seed = Mix(seed_ ^ kOrnamentStream, look.ornament);
  const uint64_t landmark_seed = Mix(seed_ ^ kInstanceStream, look.landmark);
  const uint64_t noise_seed = Mix(landmark_seed ^ kNoiseStream, look.observation);
  Axes axes = Axes::Zero();
  AddOrnament(ornament_seed, &axes);

  const float stability = LogNormal(options_.log_stability_spread, Normal(ornament_seed));
  const auto length = [stability](double value) { return stability * static_cast<float>(value); };
  AddNormal(landmark_seed, within_sigmas_, length(options_.instance_length), &axes);
  AddView(HashWord(ornament_seed ^ kViewStream), look, length(options_.view_length), &axes);
  AddNormal(Mix(ornament_seed ^ kModeStream, look.appearance_mode), within_sigmas_,
            length(options_.mode_length), &axes);
  AddNormal(noise_seed, within_sigmas_,
            LogNormal(options_.log_look_spread, Normal(HashWord(noise_seed))) *
                length(options_.noise_length),
            &axes);
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
    uint64_t bits = HashWord(seed + static_cast<uint64_t>(i) * 0x2545f4914f6cdd1d);
    for (int j = i; j < i + kRun * kRunsPerWord; j += kRun) {
      const float* values = &normal_table_[bits & ((uint64_t{1} << kNormalTableBits) - 1)];
      for (int k = 0; k < kRun; ++k) {
        (*axes)[j + k] += weight * sigmas[j + k] * values[k];
      }
      bits >>= kNormalTableBits;
    }
  }
}

void DescriptorModel::AddOrnament(uint64_t seed, Axes* axes) const {
  const uint64_t path = HashWord(seed ^ kNodeStream);
  float leaf_weight = leaf_weight_ * LogNormal(options_.log_landmark_spread, Normal(path));
  for (size_t level = 0; level < kLevelBits.size(); ++level) {
    const uint64_t node = path >> (64 - kLevelBits[level]);
    const uint64_t node_seed = Mix(seed_ ^ kNodeStream, node | uint64_t{1} << kLevelBits[level]);
    AddNormal(node_seed, between_sigmas_, node_weight_, axes);
    if (level == kSpreadLevel) {
      leaf_weight *= LogNormal(options_.log_cluster_spread, Normal(HashWord(node_seed)));
    }
  }
  AddNormal(seed, between_sigmas_, leaf_weight, axes);
}

void DescriptorModel::AddView(uint64_t seed, const DescriptorLook& look, float length,
                              Axes* axes) const {
  const Eigen::Vector3f view =
      Eigen::Vector3d(look.view_azimuth_rad / options_.view_angle_scale_rad,
                      look.view_elevation_rad / options_.view_angle_scale_rad,
                      look.log2_scale / options_.view_log2_scale)
          .cast<float>();
  const float amplitude = length / std::sqrt(static_cast<float>(kNumWaves));
  for (int wave = 0; wave < kNumWaves; ++wave) {
    const uint64_t wave_seed = HashWord(seed + static_cast<uint64_t>(wave));
    // Draws frequencies whose mean cosine is exp(-|difference of views|): a Cauchy distribution in
    // three dimensions, which is a normal vector divided by an independent normal value.
    const Eigen::Vector3f direction(Normal(wave_seed), Normal(wave_seed >> 16),
                                    Normal(wave_seed >> 32));
    const float phase = direction.dot(view) / std::max(1e-3f, std::abs(Normal(wave_seed >> 48)));
    AddNormal(Mix(wave_seed, 1), within_sigmas_, amplitude * std::cos(phase), axes);
    AddNormal(Mix(wave_seed, 2), within_sigmas_, amplitude * std::sin(phase), axes);
  }
}

DescriptorModel::Descriptor DescriptorModel::ToRaw(Axes axes) const {
  HadamardTransform(&axes);
  const Axes squares = (mean_ + axes * signs_).max(0.0f).square();
  const float norm = squares.matrix().norm();
  if (norm == 0.0f) {
    return Descriptor::Zero();
  }
  const Axes raw = (kRawNorm / norm * squares + 0.5f).min(kMaxRaw + 0.5f);
  return raw.cast<int>().cast<float>().matrix();
}

}  // namespace cairn
