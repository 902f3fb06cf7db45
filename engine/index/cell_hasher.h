// The geometry of random grids: which cell of each grid a descriptor stands in, and which cells lie
// across the nearest borders.
#ifndef CAIRN_ENGINE_INDEX_CELL_HASHER_H_
#define CAIRN_ENGINE_INDEX_CELL_HASHER_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/index/index_options.h"
#include "engine/index/probe_sequence.h"
#include "storage/codebook/codebook.h"

namespace cairn {

// In grid n a descriptor x has the cell floor((R_n x)[0..k) / w + s_n), with R_n a random rotation
// (QR of a Gaussian matrix) of the dimensions in which the codebook's words vary most, three
// quarters of all but at least k, and s_n uniform in [0, 1)^k. Rotating all dimensions gives away
// what the projection to principal axes has gathered: half a million descriptors of 16 dimensions
// then need three times the candidates for the same recall (k = 12). The cell's hash is the sum of
// its coordinates times random 32-bit factors, of which the upper bits are universal
// (Dietzfelbinger 1996) and which changes by one factor per step to a neighbour.
//
// Coordinates are 16-bit integers of 1/256 cell that wrap around after 256 cells; cells that far
// apart may share a hash, as any two may. A code's coordinates are the sum of rotated words, one
// table look-up per subspace.
//
// Immutable; safe to use from any thread. Deterministic by seed.
class CellHasher {
 public:
  CellHasher(const Codebook& codebook, const RandomGridsOptions& options);

  int num_grids() const { return num_grids_; }
  // Cells a query is sent to in each grid: options.num_probes, or all 2^k if that is less.
  int num_probes() const { return sequence_.size(); }

  // Hashes of the cells of codes (n x num_subspaces bytes) in one grid.
  std::vector<uint32_t> HashCodes(const Codebook& codebook, std::span<const uint8_t> codes,
                                  int grid) const;

  // num_probes() hashes of the cells to look into, in one grid, for a descriptor in projected
  // space: first the own cell; then, as in multi-probe LSH (Lv et al. 2007), cells across the
  // nearest borders.
  void FindProbes(const float* projected, int grid, uint32_t* hashes) const;

  size_t MemoryBytes() const;

 private:
  void FillGrid(int grid, const std::vector<int>& rotated_dims, uint64_t seed);
  // Of every word (num_subspaces x 256), `num_used` of 16 coordinates in a grid from a lane on; the
  // shift is included in the first subspace.
  std::vector<int16_t> RotatedWords(const Codebook& codebook, int grid, int first_lane,
                                    int num_used) const;
  const float* Rotation(int grid) const {
    return rotations_.data() + size_t{1} * grid * dim_ * num_lanes_;
  }
  const float* Shifts(int grid) const { return shifts_.data() + size_t{1} * grid * num_lanes_; }
  const uint32_t* Factors(int grid) const {
    return factors_.data() + size_t{1} * grid * num_lanes_;
  }

  int dim_;
  int num_grids_;
  int num_hashed_dims_;
  ProbeSequence sequence_;
  double units_per_length_;  // In projected space.
  int num_lanes_;            // num_hashed_dims_ coordinates, padded with 0 for the vector unit.
  // From projected space to units of 1/256 cell: num_grids_ x dim_ x num_lanes_, row-major, and
  // shifts.
  std::vector<float> rotations_;
  std::vector<float> shifts_;
  std::vector<uint32_t> factors_;  // Of the hash: num_grids_ x num_lanes_.
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_CELL_HASHER_H_
