// What real descriptors and those of the model are compared by.
#ifndef CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_STATISTICS_H_
#define CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_STATISTICS_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/features.h"
#include "lab/descriptors/descriptor_model.h"
#include "lab/descriptors/real_looks.h"

namespace cairn {

// Two looks at one ornament.
struct LookPair {
  int a = 0, b = 0;
  float angle_rad = 0.0f;   // Length of the difference of azimuth and elevation.
  float log2_scale = 0.0f;  // Absolute difference.
};

// All pairs of looks at an ornament that were not made in the same image, or, if the ornament has
// several landmarks, of different landmarks.
std::vector<LookPair> PairsOf(const std::vector<RealLook>& looks);

// Squared RootSIFT distance of each pair.
std::vector<float> SqDistances(const DescriptorMatrix& root, const std::vector<LookPair>& pairs);

// Rows of the first look at each ornament.
DescriptorMatrix FirstLooks(const RealLooks& looks);

// Descriptors of the model for the same looks.
RealLooks Simulate(const RealLooks& like, const DescriptorModel& model);
// `count` descriptors of clutter, RootSIFT.
DescriptorMatrix SimulateClutter(int count, const DescriptorModel& model);

// A quantile, `share` in [0, 1]; `values` must not be empty.
float Quantile(std::vector<float> values, double share);

// Standard deviations along the principal axes, descending.
Eigen::VectorXf PrincipalSigmas(const DescriptorMatrix& root);
// Root mean square halves of the pairs' differences along the principal axes of `root`: how looks
// at one landmark spread along the axes along which landmarks do. Pairs further apart than
// `max_distance` are left out: most are there by chance.
Eigen::VectorXf WithinSigmas(const DescriptorMatrix& root, const std::vector<LookPair>& pairs,
                             float max_distance);

// For each of some random rows the distance to the nearest of `num_others` random others.
std::vector<float> NearestDistances(const DescriptorMatrix& root, int num_others, uint64_t seed);
// Distances between random rows.
std::vector<float> RandomDistances(const DescriptorMatrix& root, uint64_t seed);

// Medians of squared distances over a grid of view differences.
struct ViewCell {
  float min_angle_rad = 0.0f, max_angle_rad = 0.0f;
  float min_log2_scale = 0.0f, max_log2_scale = 0.0f;
  std::vector<int> pairs;  // Indices.
};
// Cells with at least `min_pairs` of the pairs.
std::vector<ViewCell> ViewCells(const std::vector<LookPair>& pairs, int min_pairs);

// How unequal landmarks and looks are, over pairs of similar views.
struct NearSpread {
  // Interquartile range of the logarithm of squared distances.
  float log_sq_distance_range = 0.0f;
  // Correlation of that logarithm between two pairs of one landmark that share no look.
  float landmark_correlation = 0.0f;
};
NearSpread SpreadOfNearViews(const std::vector<RealLook>& looks, const std::vector<LookPair>& pairs,
                             const std::vector<float>& sq_distances);

}  // namespace cairn

#endif  // CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_STATISTICS_H_
