// Descriptors with one byte per dimension, expanded from product codes when a tile is loaded. The
// bytes take twice the memory of the codes, but an exact distance takes one vector operation
// instead of a table look-up per subspace.
#ifndef CAIRN_ENGINE_INDEX_BYTE_SCALE_H_
#define CAIRN_ENGINE_INDEX_BYTE_SCALE_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/features.h"
#include "storage/codebook/codebook.h"

namespace cairn {

// The affine map between projected space and bytes. Each dimension has an offset, which puts the
// middle of the codebook's words at the middle of a byte's range. All dimensions share one step,
// which is wide enough for every word. Rounding adds a variance of step^2 / 12 per dimension and
// side, about 0.1 % of a squared same-landmark distance. Immutable; safe to use from any thread.
class ByteScale {
 public:
  // Throws Error(kBadInput) if the codebook has more than kMaxDistanceStride dimensions.
  explicit ByteScale(const Codebook& codebook);

  int dim() const { return static_cast<int>(offset_.size()); }
  int stride() const { return stride_; }  // dim() rounded up to a multiple of kDistanceBlock.
  float step() const { return step_; }

  // Returns the codebook's words as bytes in the codebook's order: num_subspaces x 256 x
  // subspace_dim.
  std::vector<uint8_t> WordBytes(const Codebook& codebook) const;

  // n x num_subspaces codes -> n x stride() bytes, row-major; the padding is 0.
  std::vector<uint8_t> ExpandCodes(const Codebook& codebook, std::span<const uint8_t> codes) const;

  // projected: n x dim() -> n x stride() steps in [-1024, 1279], row-major; the padding is 0.
  std::vector<int16_t> QuantizeQueries(const DescriptorMatrix& projected) const;

  // Returns the largest squared distance in steps that does not exceed `max_distance` (projected
  // space).
  int32_t MaxSqSteps(double max_distance) const;

 private:
  std::vector<float> offset_;
  float step_ = 1.0f;
  int stride_ = 0;
};

// Throws Error(kInternal), naming both dimensions, if the queries do not have dimension `dim`.
void RequireQueryDim(const DescriptorMatrix& queries, int dim);

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_BYTE_SCALE_H_
