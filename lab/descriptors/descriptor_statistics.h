// Statistics with which real descriptors and the model's are compared.
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
  float angle_rad = 0.0f;   // Length of (azimuth difference, elevation difference).
  float log2_scale = 0.0f;  // Absolute difference.
};

// Returns all pairs of looks at the same ornament. In the data, the two looks come from different
// images or, if the ornament has several landmarks, from different landmarks.
std::vector<LookPair> PairsOf(const std::vector<RealLook>& looks);

// Returns the squared RootSIFT distance of each pair.
std::vector<float> SqDistances(const DescriptorMatrix& root, const std::vector<LookPair>& pairs);

// Returns the rows of the first look at each ornament.
DescriptorMatrix FirstLooks(const RealLooks& looks);

// Returns the model's descriptors for the same looks.
RealLooks Simulate(const RealLooks& like, const DescriptorModel& model);
// Returns `count` RootSIFT descriptors of clutter.
DescriptorMatrix SimulateClutter(int count, const DescriptorModel& model);

// Returns the standard deviations along the principal axes, in descending order.
Eigen::VectorXf PrincipalSigmas(const DescriptorMatrix& root);
// Returns the root mean square of half the pairs' differences along the principal axes of `root`.
// The result is the spread of looks at one landmark, along the axes of the spread between
// landmarks. Leaves out pairs that are further apart than `max_distance`, most of which are
// accidental.
Eigen::VectorXf WithinSigmas(const DescriptorMatrix& root, const std::vector<LookPair>& pairs,
                             float max_distance);

// Returns, for each of some random rows, the distance to the nearest of `num_others` random other
// rows.
std::vector<float> NearestDistances(const DescriptorMatrix& root, int num_others, uint64_t seed);
// Returns distances between random rows.
std::vector<float> RandomDistances(const DescriptorMatrix& root, uint64_t seed);

// A cell of view differences. Medians of squared distances are taken per cell.
struct ViewCell {
  float min_angle_rad = 0.0f, max_angle_rad = 0.0f;
  float min_log2_scale = 0.0f, max_log2_scale = 0.0f;
  std::vector<int> pairs;  // Indices of pairs.
};
// Returns the cells that contain at least `min_pairs` of the pairs.
std::vector<ViewCell> ViewCells(const std::vector<LookPair>& pairs, int min_pairs);

// The inequality of landmarks and looks, measured over pairs of similar views.
struct NearSpread {
  // Interquartile range of the logarithm of the squared distances.
  float log_sq_distance_range = 0.0f;
  // Correlation of that logarithm between two pairs of one landmark that have no look in common.
  float landmark_correlation = 0.0f;
};
NearSpread SpreadOfNearViews(const std::vector<RealLook>& looks, const std::vector<LookPair>& pairs,
                             const std::vector<float>& sq_distances);

}  // namespace cairn

#endif  // CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_STATISTICS_H_
