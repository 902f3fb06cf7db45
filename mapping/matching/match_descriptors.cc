#include "mapping/matching/match_descriptors.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

#include "core/simd.h"
#include "engine/index/blocked_rows.h"

namespace cairn {
namespace {

constexpr float kStepsOfUnit = 512.0f;
constexpr int32_t kNothingNear = std::numeric_limits<int32_t>::max();

ByteDescriptorMatrix RootSift(const ByteDescriptorMatrix& raw) {
  ByteDescriptorMatrix result(raw.rows(), raw.cols());
  for (Eigen::Index i = 0; i < raw.rows(); ++i) {
    const float sum = std::max(1.0f, raw.row(i).cast<float>().sum());
    for (Eigen::Index j = 0; j < raw.cols(); ++j) {
      const float steps = kStepsOfUnit * std::sqrt(static_cast<float>(raw(i, j)) / sum);
      result(i, j) = static_cast<uint8_t>(std::min(255.0f, std::round(steps)));
    }
  }
  return result;
}

BlockedRows MakeRows(const ByteDescriptorMatrix& descriptors) {
  std::vector<uint32_t> order(descriptors.rows());
  std::iota(order.begin(), order.end(), 0u);
  return BlockedRows(descriptors.data(), static_cast<int>(descriptors.cols()), order);
}

struct NearestTwo {
  int nearest = -1;
  int32_t sq_distance = kNothingNear;
  int32_t second_sq_distance = kNothingNear;
};

CAIRN_EXACT_VECTOR_CLONES int32_t SmallestOf(const int32_t* values, int count) {
  int32_t smallest = kNothingNear;
  for (int i = 0; i < count; ++i) {
    smallest = std::min(smallest, values[i]);
  }
  return smallest;
}

CAIRN_EXACT_VECTOR_CLONES void LowerTo(const int32_t* values, int count, int32_t* smallest) {
  for (int i = 0; i < count; ++i) {
    smallest[i] = std::min(smallest[i], values[i]);
  }
}

NearestTwo FindNearestTwo(int32_t* sq_distances, int count) {
  NearestTwo two;
  two.sq_distance = SmallestOf(sq_distances, count);
  two.nearest = static_cast<int>(std::find(sq_distances, sq_distances + count, two.sq_distance) -
                                 sq_distances);
  sq_distances[two.nearest] = kNothingNear;
  two.second_sq_distance = SmallestOf(sq_distances, count);
  sq_distances[two.nearest] = two.sq_distance;
  return two;
}

}  // namespace

std::vector<FeatureMatch> MatchDescriptors(const ByteDescriptorMatrix& a,
                                           const ByteDescriptorMatrix& b,
                                           const DescriptorMatchOptions& options) {
  if (a.rows() == 0 || b.rows() == 0) {
    return {};
  }
  const ByteDescriptorMatrix root_a = RootSift(a);
  const BlockedRows rows = MakeRows(RootSift(b));
  const std::vector<int16_t> steps(root_a.data(), root_a.data() + root_a.size());
  const BlockQueries queries(steps, rows.centers());

  const int num_a = static_cast<int>(a.rows()), num_b = static_cast<int>(b.rows());
  std::vector<int32_t> sq_distances(rows.padded_size());
  std::vector<int32_t> smallest_of_b(num_b, kNothingNear);
  std::vector<NearestTwo> nearest(num_a);
  for (int i = 0; i < num_a; ++i) {
    rows.Scan(queries[i], sq_distances.data());
    nearest[i] = FindNearestTwo(sq_distances.data(), num_b);
    LowerTo(sq_distances.data(), num_b, smallest_of_b.data());
  }

  const double sq_ratio = options.max_ratio * options.max_ratio;
  const double max_steps = options.max_distance * kStepsOfUnit;
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < num_a; ++i) {
    const NearestTwo& two = nearest[i];
    if (two.sq_distance <= max_steps * max_steps &&
        two.sq_distance <= sq_ratio * two.second_sq_distance &&
        two.sq_distance == smallest_of_b[two.nearest]) {
      matches.push_back(
          {i, two.nearest, std::sqrt(static_cast<float>(two.sq_distance)) / kStepsOfUnit});
    }
  }
  // Several descriptors of `a` may be equally near to one of `b`; the first keeps it.
  std::vector<uint8_t> is_taken(num_b, 0);
  std::erase_if(matches, [&](const FeatureMatch& match) {
    return std::exchange(is_taken[match.b_idx], uint8_t{1}) != 0;
  });
  return matches;
}

}  // namespace cairn
