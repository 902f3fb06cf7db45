// Expands product codes to bytes in blocks, which makes the rows of a tile searchable when the tile
// is loaded.
#ifndef CAIRN_ENGINE_INDEX_CODE_EXPANSION_H_
#define CAIRN_ENGINE_INDEX_CODE_EXPANSION_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/index/byte_scale.h"
#include "storage/codebook/codebook.h"

namespace cairn {

// The center, in every dimension, for the squared norms of rows. With this center, queries within
// the range of the bytes need one part (see BlockQuery).
inline constexpr uint8_t kRowCenter = 128;

// A codebook's words as bytes. Immutable; safe to use from any thread.
class CodeWords {
 public:
  CodeWords(const Codebook& codebook, const ByteScale& scale);

  int num_subspaces() const { return num_subspaces_; }
  int subspace_dim() const { return subspace_dim_; }
  int stride() const { return stride_; }
  // Returns the subspace_dim() bytes of a word.
  const uint8_t* Word(int subspace, uint8_t code) const {
    return bytes_.data() + (size_t{Codebook::kNumWords} * subspace + code) * subspace_dim_;
  }
  // Returns the 256 bytes of all words of a subspace in one of its subspace_dim() dimensions.
  const uint8_t* Plane(int subspace, int dim) const {
    return planes_.data() + size_t{Codebook::kNumWords} * (subspace * subspace_dim_ + dim);
  }
  // |word - kRowCenter|^2.
  int32_t SqNorm(int subspace, uint8_t code) const {
    return sq_norms_[size_t{Codebook::kNumWords} * subspace + code];
  }
  // Returns each word's contribution to a row, num_subspaces() x 256, if subspace_dim() divides
  // kGroupDims. The lower bytes of a contribution are the word's bytes at their place in the group;
  // the squared norm is above them. The sum over a group's words has the group's four bytes and,
  // above them, its squared norm.
  const uint64_t* summands() const { return summands_.data(); }

 private:
  int num_subspaces_;
  int subspace_dim_;
  int stride_;
  std::vector<uint8_t> bytes_;   // num_subspaces x 256 x subspace_dim.
  std::vector<uint8_t> planes_;  // num_subspaces x subspace_dim x 256.
  std::vector<int32_t> sq_norms_;
  std::vector<uint64_t> summands_;
};

// Results are integers, so every variant returns the same.
struct ExpansionKernel {
  const char* name;  // "plain", "avx512vbmi".

  // codes: num_rows x num_subspaces -> whole blocks (see block_kernels.h) of `stride` bytes per
  // row, and the squared norms of the rows about kRowCenter. Padding bytes are set to 0. The
  // squared norms of padding rows are not written.
  void (*expand)(const CodeWords& words, const uint8_t* codes, size_t num_rows, uint8_t* blocks,
                 int32_t* sq_norms);
};

// Returns the fastest variant that this processor supports.
const ExpansionKernel& BestExpansionKernel();

// Returns every variant that this processor supports, the portable one first. For tests and
// benchmarks.
std::vector<const ExpansionKernel*> SupportedExpansionKernels();

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_CODE_EXPANSION_H_
