#include "storage/tile/morton.h"

#include <algorithm>
#include <array>

#include "core/simd.h"

namespace cairn {
namespace {

// Number of codes that are processed together, one coordinate at a time.
constexpr size_t kBatch = 256;

// Gathers the steps of one coordinate, whose lowest bit is bit `axis` of a code.
CAIRN_EXACT_VECTOR_CLONES void GatherSteps(const uint64_t* codes, size_t count, int axis,
                                           int32_t* steps) {
  for (size_t i = 0; i < count; ++i) {
    steps[i] = static_cast<int32_t>(GatherBits(codes[i] >> axis));
  }
}

}  // namespace

void PositionsFromMorton(std::span<const uint64_t> codes, Eigen::Vector3f* x_in_tile) {
  constexpr auto kStepM = static_cast<float>(Tile::kPositionStepM);
  std::array<int32_t, kBatch> steps;
  for (size_t begin = 0; begin < codes.size(); begin += kBatch) {
    const size_t count = std::min(kBatch, codes.size() - begin);
    for (int axis = 0; axis < 3; ++axis) {
      GatherSteps(codes.data() + begin, count, axis, steps.data());
      for (size_t i = 0; i < count; ++i) {
        x_in_tile[begin + i][axis] = static_cast<float>(steps[i] - kMaxPositionSteps) * kStepM;
      }
    }
  }
}

}  // namespace cairn
