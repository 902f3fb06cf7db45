// Descriptors with the statistics of SIFT, made from nothing: for maps that are too large to come
// from photos.
#ifndef CAIRN_EVAL_BENCH_SYNTHETIC_SIFT_H_
#define CAIRN_EVAL_BENCH_SYNTHETIC_SIFT_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/features.h"

namespace cairn {

// Raw 128-D descriptors in clusters: a landmark is a cluster centre (a sparse histogram, as SIFT's)
// plus an offset of its own, an observation is the landmark plus noise. Landmarks and observations
// are numbered, so that any of them can be made again. Immutable; safe to use from any thread.
class SyntheticSift {
 public:
  static constexpr int kDim = 128;
  using Descriptor = Eigen::Matrix<float, 1, kDim>;

  explicit SyntheticSift(uint64_t seed);

  // What image `observation` sees of the landmark: entries in [0, 255], as SIFT's bytes.
  Descriptor Observe(uint64_t landmark, uint64_t observation) const;

 private:
  // Adds standard normal noise times `amplitude`; the same for the same seed.
  void AddNoise(uint64_t seed, float amplitude, Descriptor* descriptor) const;

  uint64_t seed_;
  DescriptorMatrix centers_;         // num_clusters x kDim.
  std::vector<float> normal_table_;  // Standard normal values to draw from.
};

}  // namespace cairn

#endif  // CAIRN_EVAL_BENCH_SYNTHETIC_SIFT_H_
