#include "mapping/matching/match_descriptors.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "core/simd.h"
#include "engine/index/blocked_rows.h"

namespace cairn {
namespace {

constexpr float kStepsOfUnit = 512.0f;
// The largest center about which two bytes of 0 are a narrow pair (BlockQuery). All pairs are
// narrow in 99 of 100 descriptors of Lund and of KITTI.
constexpr uint8_t kRootSiftCenter = 63;
// Keypoints nearer to each other than this are one place: SIFT finds a corner at several scales and
// orientations.
constexpr float kSamePlacePx = 10.0f;
// What the second photo shows is a copy of something if the first one has two places that resemble
// it, the nearer one by more than this share of the other. Copies differ by little more than noise;
// 0.8, as in the other direction, costs a seventh of the two views of a street (Lund), 0.9 a
// twentieth.
constexpr double kMaxTwinRatio = 0.9;
constexpr int kQueriesAtOnce = 8;  // Their distances to 4,000 descriptors fill 128 kB.
constexpr int32_t kNothingNear = std::numeric_limits<int32_t>::max();

// The root of each number's share of the sum, in steps of 1 / kStepsOfUnit.
CAIRN_EXACT_VECTOR_CLONES void RootSift(const uint8_t* raw, int size, uint8_t* root) {
  int sum = 0;
  for (int i = 0; i < size; ++i) {
    sum += raw[i];
  }
  const float divisor = static_cast<float>(std::max(1, sum));
  for (int i = 0; i < size; ++i) {
    const float steps = kStepsOfUnit * std::sqrt(static_cast<float>(raw[i]) / divisor);
    root[i] = static_cast<uint8_t>(static_cast<int>(std::min(255.0f, steps + 0.5f)));
  }
}

ByteDescriptorMatrix RootSift(const ByteDescriptorMatrix& raw) {
  ByteDescriptorMatrix result(raw.rows(), raw.cols());
  for (Eigen::Index i = 0; i < raw.rows(); ++i) {
    RootSift(raw.row(i).data(), static_cast<int>(raw.cols()), result.row(i).data());
  }
  return result;
}

BlockedRows MakeRows(const ByteDescriptorMatrix& descriptors) {
  std::vector<uint32_t> order(descriptors.rows());
  std::iota(order.begin(), order.end(), 0u);
  return BlockedRows(descriptors.data(), static_cast<int>(descriptors.cols()), order,
                     kRootSiftCenter);
}

struct NearestTwo {
  int nearest = -1;
  int32_t sq_distance = kNothingNear;
  int32_t second_sq_distance = kNothingNear;  // Of what lies apart from the nearest.
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

// For each keypoint, those of its photo within kSamePlacePx, itself included.
class Neighborhoods {
 public:
  Neighborhoods(std::span<const Keypoint> keypoints, int count) : of_keypoint_(count) {
    std::vector<int> by_x(keypoints.size());
    std::iota(by_x.begin(), by_x.end(), 0);
    std::sort(by_x.begin(), by_x.end(), [&](int p, int q) {
      return std::pair(keypoints[p].x_px, p) < std::pair(keypoints[q].x_px, q);
    });
    for (size_t i = 0; i < by_x.size(); ++i) {
      const Keypoint& one = keypoints[by_x[i]];
      for (size_t k = i + 1; k < by_x.size() && keypoints[by_x[k]].x_px - one.x_px <= kSamePlacePx;
           ++k) {
        const Keypoint& other = keypoints[by_x[k]];
        if (std::hypot(other.x_px - one.x_px, other.y_px - one.y_px) <= kSamePlacePx) {
          of_keypoint_[by_x[i]].push_back(by_x[k]);
          of_keypoint_[by_x[k]].push_back(by_x[i]);
        }
      }
    }
    for (int i = 0; i < count; ++i) {
      of_keypoint_[i].push_back(i);
    }
  }

  const std::vector<int>& Of(int keypoint) const { return of_keypoint_[keypoint]; }

 private:
  std::vector<std::vector<int>> of_keypoint_;
};

// Changes the distances.
NearestTwo FindNearestTwo(const Neighborhoods& neighborhoods, int count, int32_t* sq_distances) {
  NearestTwo two;
  two.sq_distance = SmallestOf(sq_distances, count);
  two.nearest = static_cast<int>(std::find(sq_distances, sq_distances + count, two.sq_distance) -
                                 sq_distances);
  for (const int same_place : neighborhoods.Of(two.nearest)) {
    sq_distances[same_place] = kNothingNear;
  }
  two.second_sq_distance = SmallestOf(sq_distances, count);
  return two;
}

// The descriptors of a photo, to be asked and to be searched.
struct Side {
  Side(const ByteDescriptorMatrix& raw, std::span<const Keypoint> keypoints)
      : root(RootSift(raw)),
        rows(MakeRows(root)),
        neighborhoods(keypoints, static_cast<int>(raw.rows())) {}

  ByteDescriptorMatrix root;
  BlockedRows rows;
  Neighborhoods neighborhoods;
};

// Leaves the matches whose descriptor of `b` has no second one in `a` that is as near.
void KeepUniqueInFirst(const Side& a, const Side& b, std::vector<FeatureMatch>* matches) {
  ByteDescriptorMatrix asked(matches->size(), b.root.cols());
  for (size_t i = 0; i < matches->size(); ++i) {
    asked.row(static_cast<Eigen::Index>(i)) = b.root.row((*matches)[i].b_idx);
  }
  const std::vector<int16_t> steps(asked.data(), asked.data() + asked.size());
  const BlockQueries queries(steps, a.rows.centers());
  std::vector<int32_t> sq_distances(a.rows.padded_size());
  size_t i = 0;
  std::erase_if(*matches, [&](const FeatureMatch&) {
    a.rows.Scan(queries[static_cast<int>(i++)], sq_distances.data());
    const NearestTwo two =
        FindNearestTwo(a.neighborhoods, static_cast<int>(a.root.rows()), sq_distances.data());
    return two.sq_distance > kMaxTwinRatio * kMaxTwinRatio * two.second_sq_distance;
  });
}

}  // namespace

std::vector<FeatureMatch> MatchDescriptors(const DescribedPhoto& photo_a,
                                           const DescribedPhoto& photo_b,
                                           const DescriptorMatchOptions& options) {
  const int num_a = static_cast<int>(photo_a.descriptors.rows());
  const int num_b = static_cast<int>(photo_b.descriptors.rows());
  if (num_a == 0 || num_b == 0) {
    return {};
  }
  const Side a(photo_a.descriptors, photo_a.keypoints), b(photo_b.descriptors, photo_b.keypoints);
  const std::vector<int16_t> steps(a.root.data(), a.root.data() + a.root.size());
  const BlockQueries queries(steps, b.rows.centers());

  std::vector<int32_t> sq_distances(kQueriesAtOnce * b.rows.padded_size());
  std::vector<int32_t> smallest_of_b(num_b, kNothingNear);
  std::vector<NearestTwo> nearest(num_a);
  for (int begin = 0; begin < num_a; begin += kQueriesAtOnce) {
    const int end = std::min(num_a, begin + kQueriesAtOnce);
    b.rows.Scan(queries, begin, end, sq_distances.data());
    for (int i = begin; i < end; ++i) {
      int32_t* of_query = sq_distances.data() + (i - begin) * b.rows.padded_size();
      LowerTo(of_query, num_b, smallest_of_b.data());
      nearest[i] = FindNearestTwo(b.neighborhoods, num_b, of_query);
    }
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
  KeepUniqueInFirst(a, b, &matches);
  return matches;
}

}  // namespace cairn
