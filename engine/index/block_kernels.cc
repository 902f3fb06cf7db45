#include "engine/index/block_kernels.h"

#include <algorithm>
#include <limits>

#include "engine/index/block_kernel_variants.h"
#include "engine/index/intrinsics.h"

namespace cairn {
namespace {

// For each row of a block, computes the product of the query's values with the row's bytes.
void PlainProducts(const BlockQuery& query, const uint8_t* block, int stride, int32_t* products) {
  std::fill_n(products, kBlockRows, 0);
  for (int begin = 0; begin < stride; begin += kGroupDims, block += kBlockRows * kGroupDims) {
    for (int row = 0; row < kBlockRows; ++row) {
      for (int j = 0; j < kGroupDims; ++j) {
        products[row] += query.values[begin + j] * block[row * kGroupDims + kDimOfValue[j]];
      }
    }
  }
}

void PlainBlock(const BlockQuery& query, const uint8_t* block, const int32_t* sq_norms, int stride,
                int32_t* sq_distances) {
  int32_t products[kBlockRows];
  PlainProducts(query, block, stride, products);
  for (int row = 0; row < kBlockRows; ++row) {
    sq_distances[row] = query.constant + sq_norms[row] - 2 * products[row];
  }
}

void PlainScan(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms, int stride,
               size_t num_blocks, int32_t* sq_distances) {
  for (size_t i = 0; i < num_blocks; ++i) {
    PlainBlock(query, blocks + i * kBlockRows * stride, sq_norms + i * kBlockRows, stride,
               sq_distances + i * kBlockRows);
  }
}

size_t PlainNearest(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms,
                    int stride, size_t num_rows) {
  BlockHit nearest = {0, std::numeric_limits<int32_t>::max()};
  int32_t sq_distances[kBlockRows];
  for (size_t first = 0; first < num_rows; first += kBlockRows) {
    PlainBlock(query, blocks + first * stride, sq_norms + first, stride, sq_distances);
    for (int row = 0; row < kBlockRows; ++row) {
      if (sq_distances[row] < nearest.sq_distance) {
        nearest = {static_cast<uint32_t>(first) + row, sq_distances[row]};
      }
    }
  }
  return nearest.row;
}

void PlainMinima(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms,
                 int stride, size_t num_blocks, size_t num_parts, int32_t* minima) {
  MinimaOfParts(num_blocks, num_parts, minima, [&](size_t first, size_t last, int32_t* smallest) {
    int32_t sq_distances[kBlockRows];
    std::fill_n(smallest, kBlockRows, std::numeric_limits<int32_t>::max());
    for (size_t i = first; i < last; ++i) {
      PlainBlock(query, blocks + i * kBlockRows * stride, sq_norms + i * kBlockRows, stride,
                 sq_distances);
      for (int row = 0; row < kBlockRows; ++row) {
        smallest[row] = std::min(smallest[row], sq_distances[row]);
      }
    }
  });
}

size_t PlainRange(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms,
                  int stride, size_t begin, size_t end, int32_t max_sq_distance, BlockHit* hits) {
  size_t num_hits = 0;
  int32_t sq_distances[kBlockRows];
  for (size_t first = begin / kBlockRows * kBlockRows; first < end; first += kBlockRows) {
    PlainBlock(query, blocks + first * stride, sq_norms + first, stride, sq_distances);
    const size_t last = std::min(end, first + kBlockRows);
    for (size_t row = std::max(begin, first); row < last; ++row) {
      if (sq_distances[row - first] <= max_sq_distance) {
        hits[num_hits++] = {static_cast<uint32_t>(row), sq_distances[row - first]};
      }
    }
  }
  return num_hits;
}

constexpr BlockKernels kPlain = {"plain", PlainScan, PlainNearest, PlainMinima, PlainRange};

}  // namespace

const BlockKernels& BestBlockKernels() {
  static const BlockKernels& best = *SupportedBlockKernels().back();
  return best;
}

std::vector<const BlockKernels*> SupportedBlockKernels() {
  std::vector<const BlockKernels*> supported = {&kPlain};
#if defined(__x86_64__)
  if (HasAvx2()) {
    supported.push_back(&kAvx2BlockKernels);
  }
  if (HasAvx512Vnni()) {
    supported.push_back(&kAvx512VnniBlockKernels);
  }
#endif
  return supported;
}

}  // namespace cairn
