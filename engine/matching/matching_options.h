// Options of the matching stage.
#ifndef CAIRN_ENGINE_MATCHING_MATCHING_OPTIONS_H_
#define CAIRN_ENGINE_MATCHING_MATCHING_OPTIONS_H_

#include <limits>

#include "engine/index/index_options.h"

namespace cairn {

// Which descriptors may match a keypoint (paper, section "Range Search, kNN and Thresholding").
enum class DistanceFilter {
  // Those within the same distance for all: distance_quantile.
  kAbsolute,
  // Those within max_word_ratio times the distance to the nearest word of a vocabulary of the tile,
  // which stands for the density of descriptors thereabouts (the paper's "ratio test").
  kWordRatio,
  // All: plain k nearest neighbours.
  kNone,
};

struct MatchingOptions {
  // How tiles are searched. Localizers that differ in it must not share a tile cache.
  IndexOptions index;

  // Of the time that a query has left until its deadline when matching begins, the share after
  // which the search is broken off, [0, 1]; the stages after it work with what was found. Two
  // thirds is what matching takes of a warm query (`cairn-lab bench`).
  double deadline_share = 0.67;

  // k nearest landmarks per keypoint, 1 to 64 (paper: performance peaks at 4).
  int max_neighbors = 4;

  // The filters act on the descriptor distance without prior terms.
  DistanceFilter distance_filter = DistanceFilter::kAbsolute;
  // For kAbsolute: a quantile of the codebook's same-landmark distances, [0.05, 0.95].
  double distance_quantile = 0.9;
  // For kWordRatio, [0.001, 1000]. Needs index.num_reference_words; words are pairs, one word of a
  // vocabulary for each half of the descriptor, as in the inverted multi-index.
  double max_word_ratio = 1.2;

  // Weighted distance terms: added to the squared descriptor distance when landmarks are ranked, in
  // units of the squared median same-landmark distance. A weight of 0 switches a term off.
  //
  // Orientation: weight * (2 - 2 cos(difference)), the squared chord between the gravity-rectified
  // orientations; 0 where either side has none.
  double orientation_weight = 0.2;
  // Position: weight * (e / prior sigma)^2, where e is how far the landmark's horizontal distance
  // from the prior exceeds viewing_distance_m; 0 without a prior.
  double position_weight = 0.02;
  // Landmarks as near as this to the prior are as likely as any, metres: street scenes are seen
  // from 5 to 50 m.
  double viewing_distance_m = 50.0;

  // Hard filters. Candidates whose gravity-rectified orientation differs by more are rejected,
  // those without one pass; radians in [0.001, pi], pi switches it off.
  double max_orientation_difference_rad = 3.141592653589793;
  // Landmarks with a larger e / prior sigma (see position_weight) are rejected; at least 0,
  // infinity switches it off.
  double max_position_excess_sigmas = std::numeric_limits<double>::infinity();

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_MATCHING_OPTIONS_H_
