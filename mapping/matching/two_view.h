// What two photos alone say about their cameras.
#ifndef CAIRN_MAPPING_MATCHING_TWO_VIEW_H_
#define CAIRN_MAPPING_MATCHING_TWO_VIEW_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/rigid3.h"
#include "core/scene/tracks.h"
#include "mapping/matching/match_descriptors.h"
#include "mapping/photo_set.h"

namespace cairn {

enum class TwoViewKind : uint8_t {
  kGeneral,
  // The camera turned on the spot, or everything is too far away: there is no translation.
  kRotationOnly,
};

struct TwoView {
  int a = 0, b = 0;  // Photos, a < b.
  TwoViewKind kind = TwoViewKind::kGeneral;
  Rigid3d b_from_a;  // The translation has unit length; of kRotationOnly it means nothing.
  std::vector<FeatureMatch> inliers;  // Ordered by a_idx. `a_idx` is a keypoint of photo a.
  // Median angle between the rays of an inlier.
  double parallax_rad = 0.0;
  // Standard deviations in the least certain direction.
  double rotation_sigma_rad = 0.0;
  double direction_sigma_rad = 0.0;  // Of the direction of the translation.
  // The focal lengths under which the pose was found, relative to the cameras of the set: 1 unless
  // they are guesses.
  double focal_factor_a = 1.0;
  double focal_factor_b = 1.0;
};

struct TwoViewOptions {
  DescriptorMatchOptions descriptors;
  // Matches that must agree with one relative pose. COLMAP asks for as many. Of 500 wrong matches,
  // which lie within 4 sigmas of an epipolar line of a 1,000 px photo with a probability of about
  // 1 %, the best relative pose of many collects up to 12.
  int min_inliers = 15;
  int max_iterations = 1000;  // Of RANSAC: enough for a third of right matches.
  uint64_t seed = 1;
  int num_threads = 1;  // The result does not depend on it.

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// Matches two photos and finds their relative pose by five-point RANSAC. Nothing if too few matches
// agree. If the focal length of a camera is a guess, several are tried, and errors count less.
// Deterministic by seed and the photos' indices.
std::optional<TwoView> FindTwoView(const PhotoSet& set, int a, int b,
                                   const TwoViewOptions& options);

// Receives the steps done and the total. Called from any thread, but by one thread at a time.
using StepProgress = std::function<void(int done, int total)>;

// FindTwoView for each pair, on several threads. The two views are in the order of the pairs.
std::vector<TwoView> FindTwoViews(const PhotoSet& set, std::span<const std::pair<int, int>> pairs,
                                  const TwoViewOptions& options, const StepProgress& progress = {});

}  // namespace cairn

#endif  // CAIRN_MAPPING_MATCHING_TWO_VIEW_H_
