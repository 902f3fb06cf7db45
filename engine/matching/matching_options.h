// Options of the matching stage.
#ifndef CAIRN_ENGINE_MATCHING_MATCHING_OPTIONS_H_
#define CAIRN_ENGINE_MATCHING_MATCHING_OPTIONS_H_

#include <cstdint>

namespace cairn {

// Random grids (paper, section "Random Grids"; Aiger, Kokiopoulou, Rivlin, ICCV 2013). The defaults
// recall 95 % of what exhaustive search does (mean of four seeds, 500,000 descriptors of real SIFT)
// at a fiftieth of its time; width 6 recalls 97 % for half as much time again, 12 grids with 4
// probes recall 95 % in less time but more memory. cairn_matching_bench prints such figures.
struct RandomGridsOptions {
  // N, 1 to 64: each descriptor stands in one cell of every grid. Time and memory are linear in it.
  int num_grids = 8;
  // Leading dimensions of the rotated descriptor that make up a cell's key, 1 to 128; a smaller
  // descriptor is hashed whole. Fewer make coarser cells: more recall a grid, more candidates.
  int num_hashed_dims = 12;
  // Side of a cell, [0.001, 1000], in units of sigma = d / sqrt(projected_dim), where d is the
  // codebook's median same-landmark distance: the standard deviation, per dimension, between two
  // descriptors of one landmark. 5.5 in 16 dimensions is 1.4 times d.
  double cell_width_sigmas = 5.5;
  // Cells looked into per grid, 1 to 32: the own one, then those across the nearest borders.
  int num_probes = 8;
  // 1 to 10,000; of a fuller cell a random subset is kept (paper: 100).
  int max_candidates_per_cell = 100;
  uint64_t seed = 1;  // Of rotations, shifts and subsets.

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

struct MatchingOptions {
  RandomGridsOptions grids;

  // k nearest landmarks per keypoint, 1 to 64 (paper: performance peaks at 4).
  int max_neighbors = 4;
  // Absolute threshold on the descriptor distance (without prior terms), as a quantile of the
  // codebook's same-landmark distances, [0.05, 0.95].
  double distance_quantile = 0.9;

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
  // Hard filter: candidates whose gravity-rectified orientation differs by more are rejected, those
  // without one pass; radians in [0.001, pi], pi switches it off.
  double max_orientation_difference_rad = 3.141592653589793;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_MATCHING_OPTIONS_H_
