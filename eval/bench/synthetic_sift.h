// Descriptors with the statistics of SIFT, made from nothing: for maps that are too large to come
// from photos.
#ifndef CAIRN_EVAL_BENCH_SYNTHETIC_SIFT_H_
#define CAIRN_EVAL_BENCH_SYNTHETIC_SIFT_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace cairn {

// Raw 128-D descriptors whose RootSIFT form is Gaussian about a mean, with the spectrum that photos
// of streets have: the variances between landmarks and between observations of one landmark, along
// 128 principal axes. Landmarks and observations are numbered, so that any of them can be made
// again. Immutable; safe to use from any thread.
class SyntheticSift {
 public:
  static constexpr int kDim = 128;
  using Descriptor = Eigen::Matrix<float, 1, kDim>;

  explicit SyntheticSift(uint64_t seed);

  // What image `observation` sees of the landmark. Not negative.
  Descriptor Observe(uint64_t landmark, uint64_t observation) const;

 private:
  // Adds a standard normal value per axis times `sigmas` times `scale`; the same for the same seed.
  void AddNoise(uint64_t seed, const Descriptor& sigmas, float scale, Descriptor* axes) const;
  // A standard normal value, by 16 random bits.
  float Normal(uint64_t bits) const;

  uint64_t seed_;
  Descriptor mean_;
  Descriptor signs_;               // Make the principal axes random; +-1 / sqrt(kDim).
  Descriptor landmark_sigmas_;     // Per axis, between landmarks,
  Descriptor observation_sigmas_;  // and between observations of a landmark.
  std::vector<float> normal_table_;
};

}  // namespace cairn

#endif  // CAIRN_EVAL_BENCH_SYNTHETIC_SIFT_H_
