// The geometry of random grids: computes the cell of a descriptor in each grid, and the cells
// across the nearest borders.
#ifndef CAIRN_ENGINE_INDEX_CELL_HASHER_H_
#define CAIRN_ENGINE_INDEX_CELL_HASHER_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/large_vector.h"
#include "engine/index/index_options.h"
#include "engine/index/probe_sequence.h"
#include "storage/codebook/codebook.h"

namespace cairn {

// In grid n a descriptor x has the cell floor((R_n x)[0..k) / w + s_n). s_n is uniform in [0, 1)^k.
// R_n is a random rotation (QR of a Gaussian matrix) of the dimensions in which the codebook's
// words vary most: three quarters of all dimensions, but at least k. Rotating all dimensions would
// undo the concentration of variance that the projection to principal axes achieves: with half a
// million descriptors of 16 dimensions and k = 12, the same recall would need three times the
// candidates.
//
// A cell's hash is the sum of its coordinates times random 32-bit factors. The upper bits of the
// hash are universal (Dietzfelbinger 1996). A step to a neighboring cell changes the hash by one
// factor.
//
// Coordinates are 16-bit integers in units of 1/256 cell and wrap around after 256 cells. Cells
// that far apart may share a hash, as any two cells may. The coordinates of a code are sums of
// rotated words, one table look-up per subspace.
//
// Immutable; safe to use from any thread. Deterministic by seed.
class CellHasher {
 public:
  CellHasher(const Codebook& codebook, const RandomGridsOptions& options);

  int num_grids() const { return num_grids_; }
  // Number of cells that a query visits in each grid: options.num_probes, or all 2^k if that is
  // less.
  int num_probes() const { return sequence_.size(); }

  // Returns the hashes of the cells of codes (n x num_subspaces bytes) in one grid.
  LargeVector<uint32_t> HashCodes(const Codebook& codebook, std::span<const uint8_t> codes,
                                  int grid) const;

  // Computes the num_probes() hashes of the cells to search in one grid for a descriptor in
  // projected space. The first is the descriptor's own cell; the others lie across the nearest
  // borders, as in multi-probe LSH (Lv et al. 2007).
  void FindProbes(const float* projected, int grid, uint32_t* hashes) const;

  size_t MemoryBytes() const;

 private:
  void FillGrid(int grid, const std::vector<int>& rotated_dims, uint64_t seed);
  // Returns `num_used` of the 16 coordinates, starting at a lane, of every word (num_subspaces x
  // 256) in a grid. The shift is included in the first subspace.
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
  double units_per_length_;  // Per unit of length in projected space.
  int num_lanes_;            // num_hashed_dims_ padded to whole vectors; padding has factor 0.
  // Map from projected space to units of 1/256 cell: rotations (num_grids_ x dim_ x num_lanes_,
  // row-major) and shifts.
  std::vector<float> rotations_;
  std::vector<float> shifts_;
  std::vector<uint32_t> factors_;  // Factors of the hash: num_grids_ x num_lanes_.
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_CELL_HASHER_H_
