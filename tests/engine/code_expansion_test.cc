#include "engine/index/code_expansion.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "engine/index/block_kernels.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

struct Expanded {
  std::vector<uint8_t> blocks;
  std::vector<int32_t> sq_norms;

  bool operator==(const Expanded&) const = default;
};

std::vector<uint8_t> RandomCodes(size_t size, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<uint8_t> codes(size);
  for (uint8_t& code : codes) {
    code = static_cast<uint8_t>(random());
  }
  return codes;
}

size_t PaddedSize(size_t num_rows) { return (num_rows + kBlockRows - 1) / kBlockRows * kBlockRows; }

Expanded Expand(const ExpansionKernel& kernel, const CodeWords& words,
                const std::vector<uint8_t>& codes) {
  const size_t num_rows = codes.size() / words.num_subspaces();
  Expanded expanded;
  expanded.blocks.resize(PaddedSize(num_rows) * words.stride(), 0xaa);
  expanded.sq_norms.resize(PaddedSize(num_rows), -1);
  kernel.expand(words, codes.data(), num_rows, expanded.blocks.data(), expanded.sq_norms.data());
  return expanded;
}

// Against rows that lie one by one: dimensions 16 (the usual), 6 (padded), 20 (two strides), and
// words of 1, 2, 3, 4 and 5 dimensions.
TEST(CodeExpansion, GivesTheRowsOfTheCodesInBlocks) {
  for (const testing::RandomCodebookOptions& options :
       {testing::RandomCodebookOptions{},
        testing::RandomCodebookOptions{.projected_dim = 6, .num_subspaces = 3},
        testing::RandomCodebookOptions{.projected_dim = 6, .num_subspaces = 2},
        testing::RandomCodebookOptions{.projected_dim = 16, .num_subspaces = 16},
        testing::RandomCodebookOptions{.projected_dim = 16, .num_subspaces = 4},
        testing::RandomCodebookOptions{.projected_dim = 20, .num_subspaces = 4}}) {
    const Codebook codebook = testing::RandomCodebook(options);
    const ByteScale scale(codebook);
    const CodeWords words(codebook, scale);
    const std::vector<uint8_t> codes = RandomCodes(100 * codebook.num_subspaces, 1);
    const std::vector<uint8_t> rows = scale.ExpandCodes(codebook, codes);
    const Expanded expanded = Expand(*SupportedExpansionKernels().front(), words, codes);
    const int stride = scale.stride();
    for (size_t row = 0; row < 100; ++row) {
      int32_t sq_norm = 0;
      for (int dim = 0; dim < stride; ++dim) {
        const uint8_t byte = rows[row * stride + dim];
        const size_t place = row / kBlockRows * kBlockRows * stride +
                             (dim / kGroupDims * kBlockRows + row % kBlockRows) * kGroupDims +
                             dim % kGroupDims;
        ASSERT_EQ(expanded.blocks[place], byte) << "row " << row << ", dimension " << dim;
        sq_norm += (byte - kRowCenter) * (byte - kRowCenter);
      }
      ASSERT_EQ(expanded.sq_norms[row], sq_norm) << "row " << row;
    }
  }
}

TEST(CodeExpansion, IsTheSameInEveryVariant) {
  const Codebook codebook = testing::RandomCodebook();
  const CodeWords words(codebook, ByteScale(codebook));
  for (const size_t num_rows : {0, 1, 16, 63, 64, 65, 130, 1000}) {
    const std::vector<uint8_t> codes = RandomCodes(num_rows * codebook.num_subspaces, num_rows);
    const Expanded expected = Expand(*SupportedExpansionKernels().front(), words, codes);
    for (const ExpansionKernel* kernel : SupportedExpansionKernels()) {
      EXPECT_EQ(Expand(*kernel, words, codes), expected) << kernel->name << ", " << num_rows;
    }
  }
}

// Every word of every subspace.
TEST(CodeExpansion, KnowsAllWords) {
  const Codebook codebook = testing::RandomCodebook();
  const CodeWords words(codebook, ByteScale(codebook));
  std::vector<uint8_t> codes;
  for (int code = 0; code < Codebook::kNumWords; ++code) {
    codes.insert(codes.end(), codebook.num_subspaces, static_cast<uint8_t>(code));
  }
  const Expanded expected = Expand(*SupportedExpansionKernels().front(), words, codes);
  for (const ExpansionKernel* kernel : SupportedExpansionKernels()) {
    EXPECT_EQ(Expand(*kernel, words, codes), expected) << kernel->name;
  }
}

}  // namespace
}  // namespace cairn
