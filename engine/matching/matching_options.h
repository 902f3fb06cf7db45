// Options of the matching stage.
#ifndef CAIRN_ENGINE_MATCHING_MATCHING_OPTIONS_H_
#define CAIRN_ENGINE_MATCHING_MATCHING_OPTIONS_H_

#include <limits>

#include "core/angles.h"
#include "engine/index/index_options.h"

namespace cairn {

// The rule by which a descriptor may match a keypoint (paper, section "Range Search, kNN and
// Thresholding").
enum class DistanceFilter {
  // Descriptors within one distance for all keypoints: distance_quantile.
  kAbsolute,
  // Descriptors within max_word_ratio times the keypoint's distance to the nearest word of a
  // vocabulary of the tile, which is a measure of the local density of descriptors (the paper's
  // "ratio test").
  kWordRatio,
  // All descriptors: plain k nearest neighbors.
  kNone,
};

struct MatchingOptions {
  // How tiles are searched. Localizers with different index options must not share a tile cache.
  IndexOptions index;

  // The share of the time until the query's deadline that matching may use, [0, 1]. The search then
  // stops, and later stages work with what was found. Matching takes two thirds of a warm query
  // (`cairn-lab bench`).
  double deadline_share = 0.67;

  // k nearest landmarks per keypoint, 1 to 64 (paper: performance peaks at 4).
  int max_neighbors = 4;
  // Most keypoints that match a landmark, the nearest ones; at least 1. A camera sees a landmark
  // once or a few times, so where many keypoints match it, most are wrong (docs/decisions/0079).
  int max_keypoints_of_landmark = 8;

  // The filters use the descriptor distance without prior terms.
  DistanceFilter distance_filter = DistanceFilter::kAbsolute;
  // For kAbsolute: a quantile of the codebook's same-landmark distances, [0.05, 0.95].
  double distance_quantile = 0.9;
  // For kWordRatio, [0.001, 1000]. Needs index.num_reference_words. A word here is a pair of words,
  // one of each half of the descriptor, as in the inverted multi-index.
  double max_word_ratio = 1.2;

  // Weighted prior terms are added to the squared descriptor distance when landmarks are ranked.
  // Their unit is the squared median same-landmark distance. A weight of 0 switches a term off.
  //
  // Orientation term: weight * (2 - 2 cos(difference)), the squared chord between the
  // gravity-rectified orientations; 0 if either side has none.
  double orientation_weight = 0.2;
  // Position term: weight * (e / prior sigma)^2, where e is how far the landmark's horizontal
  // distance from the prior exceeds viewing_distance_m; 0 without a prior.
  double position_weight = 0.02;
  // Landmarks within this distance of the prior are all equally likely, meters. Street scenes are
  // seen from 5 to 50 m.
  double viewing_distance_m = 50.0;

  // Hard filters. A candidate whose gravity-rectified orientation differs by more than this is
  // rejected; a candidate without an orientation passes. Radians in [0.001, pi]; pi switches the
  // filter off.
  double max_orientation_difference_rad = kPi;
  // A landmark with a larger e / prior sigma (see position_weight) is rejected. At least 0;
  // infinity switches the filter off.
  double max_position_excess_sigmas = std::numeric_limits<double>::infinity();

  // Throws Error(kInvalidArgument), naming the field.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_MATCHING_OPTIONS_H_
