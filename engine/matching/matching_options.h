// Options of the matching stage.
#ifndef CAIRN_ENGINE_MATCHING_MATCHING_OPTIONS_H_
#define CAIRN_ENGINE_MATCHING_MATCHING_OPTIONS_H_

#include <cstdint>

namespace cairn {

// Random grids (paper, section "Random Grids"; Aiger, Kokiopoulou, Rivlin, ICCV 2013).
struct RandomGridsOptions {
  int num_grids = 8;        // N; each descriptor stands in one cell of every grid.
  int num_hashed_dims = 10; // Of the rotated descriptor. Fewer make coarser cells.
  // Cell width in units of the codebook's median same-landmark distance per... see random_grids.h.
  double cell_width_sigmas = 1.5;
  int num_probes = 4;       // Cells looked into per grid: the own cell and the nearest neighbours.
  int max_candidates_per_cell = 100;  // Paper; a random subset beyond it.
  uint64_t seed = 1;        // Of rotations, shifts and subsets.

  void Validate() const;
};

struct MatchingOptions {
  RandomGridsOptions grids;

  int max_neighbors = 4;    // k nearest landmarks per keypoint (paper: performance peaks at 4).
  // Absolute threshold on the descriptor distance (without prior terms), as a quantile of the
  // codebook's same-landmark distances.
  double distance_quantile = 0.9;
  // Weighted distance terms: they are added to the squared descriptor distance in units of the
  // squared median same-landmark distance. Orientation: w * (2 - 2 cos(difference)).
  double orientation_weight = 0.2;
  // Position: w * (distance of the landmark from the prior / prior sigma)^2 beyond the typical
  // viewing distance.
  double position_weight = 0.02;
  // Hard filter: candidates whose gravity-rectified orientation differs by more are rejected;
  // radians, pi switches it off.
  double max_orientation_difference_rad = 3.141592653589793;

  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_MATCHING_OPTIONS_H_
