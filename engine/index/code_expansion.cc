#include "engine/index/code_expansion.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>

#include "engine/index/block_kernels.h"
#include "engine/index/intrinsics.h"

namespace cairn {
namespace {

std::vector<int32_t> WordSqNorms(const CodeWords& words) {
  std::vector<int32_t> sq_norms(size_t{Codebook::kNumWords} * words.num_subspaces(), 0);
  for (size_t i = 0; i < sq_norms.size(); ++i) {
    const uint8_t* word = words.Word(static_cast<int>(i / Codebook::kNumWords),
                                     static_cast<uint8_t>(i % Codebook::kNumWords));
    for (int d = 0; d < words.subspace_dim(); ++d) {
      sq_norms[i] += (word[d] - kRowCenter) * (word[d] - kRowCenter);
    }
  }
  return sq_norms;
}

// See CodeWords::summands.
std::vector<uint64_t> WordSummands(const CodeWords& words, std::span<const int32_t> sq_norms) {
  const int dim = words.subspace_dim();
  if (kGroupDims % dim != 0) {
    return {};
  }
  std::vector<uint64_t> summands;
  summands.reserve(sq_norms.size());
  for (size_t i = 0; i < sq_norms.size(); ++i) {
    const auto subspace = static_cast<int>(i / Codebook::kNumWords);
    const uint8_t* word = words.Word(subspace, static_cast<uint8_t>(i % Codebook::kNumWords));
    std::array<uint8_t, kGroupDims> group{};
    std::copy_n(word, dim, group.begin() + subspace * dim % kGroupDims);
    uint32_t bytes = 0;
    std::memcpy(&bytes, group.data(), sizeof(bytes));
    summands.push_back(static_cast<uint64_t>(sq_norms[i]) << 32 | bytes);
  }
  return summands;
}

// Returns the contribution of a row's zero padding to its squared norm.
int32_t PaddingSqNorm(const CodeWords& words) {
  return (words.stride() - words.num_subspaces() * words.subspace_dim()) * kRowCenter * kRowCenter;
}

// Expands one row of codes to its place in a block; returns the row's squared norm. Constant
// numbers let the loops unroll.
[[gnu::always_inline]] inline int32_t ExpandRow(const uint64_t* summands, const uint8_t* codes,
                                                int num_subspaces, int subspaces_per_group,
                                                uint8_t* to) {
  uint64_t sq_norm = 0;
  for (int first = 0; first < num_subspaces; first += subspaces_per_group) {
    uint64_t group = 0;
    for (int m = first; m < std::min(num_subspaces, first + subspaces_per_group); ++m) {
      group += summands[size_t{Codebook::kNumWords} * m + codes[m]];
    }
    const auto bytes = static_cast<uint32_t>(group);
    std::memcpy(to, &bytes, sizeof(bytes));
    to += kBlockRows * kGroupDims;
    sq_norm += group >> 32;
  }
  return static_cast<int32_t>(sq_norm);
}

// For words whose dimension divides kGroupDims. kNumSubspaces 0 stands for any number.
template <int kDim, int kNumSubspaces>
void ExpandGroups(const CodeWords& words, const uint8_t* codes, size_t num_rows, uint8_t* blocks,
                  int32_t* sq_norms) {
  const int num_subspaces = kNumSubspaces > 0 ? kNumSubspaces : words.num_subspaces();
  const int32_t padding_sq_norm = PaddingSqNorm(words);
  const size_t block_size = size_t{kBlockRows} * words.stride();
  for (size_t row = 0; row < num_rows; ++row) {
    uint8_t* block = blocks + row / kBlockRows * block_size;
    if (row % kBlockRows == 0 && (padding_sq_norm > 0 || num_rows - row < kBlockRows)) {
      std::memset(block, 0, block_size);
    }
    sq_norms[row] =
        padding_sq_norm + ExpandRow(words.summands(), codes, num_subspaces, kGroupDims / kDim,
                                    block + row % kBlockRows * kGroupDims);
    codes += num_subspaces;
  }
}

// For words of any dimension.
void ExpandWords(const CodeWords& words, const uint8_t* codes, size_t num_rows, uint8_t* blocks,
                 int32_t* sq_norms) {
  const int dim = words.subspace_dim();
  const int32_t padding_sq_norm = PaddingSqNorm(words);
  const size_t num_blocks = (num_rows + kBlockRows - 1) / kBlockRows;
  std::memset(blocks, 0, num_blocks * kBlockRows * words.stride());
  for (size_t row = 0; row < num_rows; ++row) {
    uint8_t* block = blocks + row / kBlockRows * kBlockRows * words.stride();
    sq_norms[row] = padding_sq_norm;
    for (int m = 0; m < words.num_subspaces(); ++m) {
      const uint8_t code = *codes++;
      for (int d = m * dim; d < (m + 1) * dim; ++d) {
        block[(d / kGroupDims * kBlockRows + row % kBlockRows) * kGroupDims + d % kGroupDims] =
            words.Word(m, code)[d - m * dim];
      }
      sq_norms[row] += words.SqNorm(m, code);
    }
  }
}

void PlainExpand(const CodeWords& words, const uint8_t* codes, size_t num_rows, uint8_t* blocks,
                 int32_t* sq_norms) {
  const bool is_usual = words.num_subspaces() == 8 && words.subspace_dim() == 2;
  const auto expand = is_usual                    ? ExpandGroups<2, 8>
                      : words.subspace_dim() == 1 ? ExpandGroups<1, 0>
                      : words.subspace_dim() == 2 ? ExpandGroups<2, 0>
                      : words.subspace_dim() == 4 ? ExpandGroups<4, 0>
                                                  : ExpandWords;
  expand(words, codes, num_rows, blocks, sq_norms);
}

constexpr ExpansionKernel kPlain = {"plain", PlainExpand};

#if defined(__x86_64__)

// The vector code handles this shape only: eight subspaces of two dimensions.
constexpr int kNumSubspaces = 8;
constexpr int kStride = 16;
constexpr int kNumBlocks = 4;  // Expanded together: a vector has one byte for each of their rows.
constexpr size_t kNumRows = size_t{kNumBlocks} * kBlockRows;
constexpr int kVectorBytes = 64;

// Loads the codes of four blocks, one vector per subspace. In each 16 bytes, the first four are
// rows of the first block, the next four rows of the second, and so on.
CAIRN_AVX512VBMI inline void LoadCodes(const uint8_t* codes, __m512i* by_subspace) {
  constexpr int kRowsPerLoad = 4;
  const auto load = [&](int place) CAIRN_AVX512VBMI {
    const int first_row = place % kNumBlocks * kBlockRows + place / kNumBlocks * kRowsPerLoad;
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(codes + first_row * kNumSubspaces));
  };
  // Transposes the 8 x 8 bytes of a vector.
  alignas(kVectorBytes) std::array<uint8_t, kVectorBytes> transposed;
  for (int i = 0; i < kVectorBytes; ++i) {
    transposed[i] = static_cast<uint8_t>(i % kNumSubspaces * kNumSubspaces + i / kNumSubspaces);
  }
  const __m512i order = _mm512_load_si512(transposed.data());
  __m512i rows[kNumSubspaces];  // Eight rows each; one subspace after the other.
  for (int i = 0; i < kNumSubspaces; ++i) {
    rows[i] = _mm512_permutexvar_epi8(
        order, _mm512_inserti64x4(_mm512_castsi256_si512(load(2 * i)), load(2 * i + 1), 1));
  }
  // Transposes 8 x 8 numbers of 64 bits.
  __m512i pairs[kNumSubspaces], quads[kNumSubspaces];
  for (int i = 0; i < kNumSubspaces; i += 2) {
    pairs[i] = _mm512_unpacklo_epi64(rows[i], rows[i + 1]);      // Subspaces 0, 2, 4, 6.
    pairs[i + 1] = _mm512_unpackhi_epi64(rows[i], rows[i + 1]);  // 1, 3, 5, 7.
  }
  for (int i = 0; i < 2; ++i) {
    for (int half = 0; half < 2; ++half) {
      const __m512i a = pairs[4 * half + i], b = pairs[4 * half + 2 + i];
      quads[4 * half + i] = _mm512_shuffle_i64x2(a, b, 0x88);      // Subspaces i, 4 + i.
      quads[4 * half + 2 + i] = _mm512_shuffle_i64x2(a, b, 0xdd);  // 2 + i, 6 + i.
    }
    for (int j = 0; j < 2; ++j) {
      const __m512i a = quads[2 * j + i], b = quads[4 + 2 * j + i];
      by_subspace[2 * j + i] = _mm512_shuffle_i64x2(a, b, 0x88);
      by_subspace[4 + 2 * j + i] = _mm512_shuffle_i64x2(a, b, 0xdd);
    }
  }
}

// Replaces each byte by the byte of that index in a plane of 256.
CAIRN_AVX512VBMI inline __m512i LookUp(const uint8_t* plane, __m512i bytes) {
  const __m512i low = _mm512_permutex2var_epi8(_mm512_loadu_si512(plane), bytes,
                                               _mm512_loadu_si512(plane + kVectorBytes));
  const __m512i high = _mm512_permutex2var_epi8(_mm512_loadu_si512(plane + 2 * kVectorBytes), bytes,
                                                _mm512_loadu_si512(plane + 3 * kVectorBytes));
  return _mm512_mask_mov_epi8(low, _mm512_movepi8_mask(bytes), high);
}

CAIRN_AVX512VBMI void VbmiExpand(const CodeWords& words, const uint8_t* codes, size_t num_rows,
                                 uint8_t* blocks, int32_t* sq_norms) {
  const bool is_usual = words.num_subspaces() == kNumSubspaces && words.subspace_dim() == 2 &&
                        words.stride() == kStride;
  size_t begin = 0;
  const __m512i ones = _mm512_set1_epi8(1);
  const __m512i sign = _mm512_set1_epi8(static_cast<char>(0x80));
  for (; is_usual && begin + kNumRows <= num_rows; begin += kNumRows) {
    __m512i by_subspace[kNumSubspaces];
    LoadCodes(codes + begin * kNumSubspaces, by_subspace);
    // With s = r - 128: |s|^2 = r.s - 128 (1.s).
    __m512i products[kNumBlocks] = {}, sums[kNumBlocks] = {};
    for (int group = 0; group < kStride / kGroupDims; ++group) {
      const __m512i a = LookUp(words.Plane(2 * group, 0), by_subspace[2 * group]);
      const __m512i b = LookUp(words.Plane(2 * group, 1), by_subspace[2 * group]);
      const __m512i c = LookUp(words.Plane(2 * group + 1, 0), by_subspace[2 * group + 1]);
      const __m512i d = LookUp(words.Plane(2 * group + 1, 1), by_subspace[2 * group + 1]);
      const __m512i ab_low = _mm512_unpacklo_epi8(a, b), ab_high = _mm512_unpackhi_epi8(a, b);
      const __m512i cd_low = _mm512_unpacklo_epi8(c, d), cd_high = _mm512_unpackhi_epi8(c, d);
      const __m512i rows[kNumBlocks] = {
          _mm512_unpacklo_epi16(ab_low, cd_low), _mm512_unpackhi_epi16(ab_low, cd_low),
          _mm512_unpacklo_epi16(ab_high, cd_high), _mm512_unpackhi_epi16(ab_high, cd_high)};
      for (int i = 0; i < kNumBlocks; ++i) {
        _mm512_storeu_si512(
            blocks + begin * kStride + i * kBlockRows * kStride + group * kVectorBytes, rows[i]);
        const __m512i centered = _mm512_xor_si512(rows[i], sign);
        products[i] = _mm512_dpbusd_epi32(products[i], rows[i], centered);
        sums[i] = _mm512_dpbusd_epi32(sums[i], ones, centered);
      }
    }
    for (int i = 0; i < kNumBlocks; ++i) {
      _mm512_storeu_si512(sq_norms + begin + i * kBlockRows,
                          _mm512_sub_epi32(products[i], _mm512_slli_epi32(sums[i], 7)));
    }
  }
  PlainExpand(words, codes + begin * words.num_subspaces(), num_rows - begin,
              blocks + begin * words.stride(), sq_norms + begin);
}

constexpr ExpansionKernel kVbmi = {"avx512vbmi", VbmiExpand};

#endif

}  // namespace

CodeWords::CodeWords(const Codebook& codebook, const ByteScale& scale)
    : num_subspaces_(codebook.num_subspaces),
      subspace_dim_(codebook.subspace_dim()),
      stride_(scale.stride()),
      bytes_(scale.WordBytes(codebook)),
      planes_(bytes_.size()),
      sq_norms_(WordSqNorms(*this)),
      summands_(WordSummands(*this, sq_norms_)) {
  uint8_t* plane = planes_.data();
  for (int m = 0; m < num_subspaces_; ++m) {
    for (int d = 0; d < subspace_dim_; ++d) {
      for (int code = 0; code < Codebook::kNumWords; ++code) {
        *plane++ = Word(m, static_cast<uint8_t>(code))[d];
      }
    }
  }
}

const ExpansionKernel& BestExpansionKernel() {
  static const ExpansionKernel& best = *SupportedExpansionKernels().back();
  return best;
}

std::vector<const ExpansionKernel*> SupportedExpansionKernels() {
  std::vector<const ExpansionKernel*> supported = {&kPlain};
#if defined(__x86_64__)
  if (HasAvx512Vbmi()) {
    supported.push_back(&kVbmi);
  }
#endif
  return supported;
}

}  // namespace cairn
