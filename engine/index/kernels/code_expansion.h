// Product codes to bytes in blocks: how the rows of a tile become searchable when it is loaded.
#ifndef CAIRN_ENGINE_INDEX_KERNELS_CODE_EXPANSION_H_
#define CAIRN_ENGINE_INDEX_KERNELS_CODE_EXPANSION_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/index/kernels/byte_scale.h"
#include "storage/codebook/codebook.h"

namespace cairn {

// What squared norms of rows are about, in every dimension. Queries within the bytes' range then
// need one part (see BlockQuery).
inline constexpr uint8_t kRowCenter = 128;

// What a codebook's words are in bytes. Immutable; safe to use from any thread.
class CodeWords {
 public:
  CodeWords(const Codebook& codebook, const ByteScale& scale);

  int num_subspaces() const { return num_subspaces_; }
  int subspace_dim() const { return subspace_dim_; }
  int stride() const { return stride_; }
  // subspace_dim() bytes of a word.
  const uint8_t* Word(int subspace, uint8_t code) const {
    return bytes_.data() + (size_t{Codebook::kNumWords} * subspace + code) * subspace_dim_;
  }
  // The 256 bytes of all words in one of subspace_dim() dimensions.
  const uint8_t* Plane(int subspace, int dim) const {
    return planes_.data() + size_t{Codebook::kNumWords} * (subspace * subspace_dim_ + dim);
  }
  // |word - kRowCenter|^2.
  int32_t SqNorm(int subspace, uint8_t code) const {
    return sq_norms_[size_t{Codebook::kNumWords} * subspace + code];
  }
  // What each word adds to a row, num_subspaces() x 256, if subspace_dim() divides kGroupDims: its
  // bytes at their place in the group, and above them its squared norm. The sum of a group's words
  // is its four bytes below their squared norm.
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

// Results are integers, so every variant gives the same.
struct ExpansionKernel {
  const char* name;  // "plain", "avx512vbmi".

  // codes: num_rows x num_subspaces -> whole blocks (see block_kernels.h) of stride bytes a row and
  // the squared norms of the rows about kRowCenter. Bytes of padding are 0; squared norms of
  // padding rows are left as they are.
  void (*expand)(const CodeWords& words, const uint8_t* codes, size_t num_rows, uint8_t* blocks,
                 int32_t* sq_norms);
};

// The fastest variant this processor runs.
const ExpansionKernel& BestExpansionKernel();

// Every variant this processor runs, the portable one first. For tests and benchmarks.
std::vector<const ExpansionKernel*> SupportedExpansionKernels();

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_KERNELS_CODE_EXPANSION_H_
