#include "engine/index/cell_hasher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "engine/synthetic_descriptors.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {
namespace {

using testing::MakeSyntheticDescriptors;
using testing::SyntheticDescriptors;

// Those of all grids.
std::vector<uint32_t> ProbesOf(const CellHasher& hasher, const float* descriptor) {
  std::vector<uint32_t> hashes(size_t{1} * hasher.num_grids() * hasher.num_probes());
  for (int grid = 0; grid < hasher.num_grids(); ++grid) {
    hasher.FindProbes(descriptor, grid, hashes.data() + size_t{1} * grid * hasher.num_probes());
  }
  return hashes;
}

TEST(CellHasher, ACodeStandsInTheCellOfItsDecodedDescriptor) {
  for (const int num_hashed_dims : {1, 7, 8, 12, 16, 100}) {
    const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 500});
    const RandomGridsOptions options{.num_grids = 3, .num_hashed_dims = num_hashed_dims};
    const CellHasher hasher(*data.codebook, options);
    const int num_codes = 1'000;
    const DescriptorMatrix decoded =
        DescriptorCodec(data.codebook).Decode(data.codes.data(), num_codes);
    for (int grid = 0; grid < 3; ++grid) {
      const LargeVector<uint32_t> hashes = hasher.HashCodes(*data.codebook, data.codes, grid);
      int num_equal = 0;
      for (int i = 0; i < num_codes; ++i) {
        const std::vector<uint32_t> probes = ProbesOf(hasher, decoded.row(i).data());
        num_equal += probes[grid * hasher.num_probes()] == hashes[i] ? 1 : 0;
      }
      // Words are rounded to 1/256 cell each; only codes that close to a border may differ.
      EXPECT_GT(num_equal, 900) << num_hashed_dims << " dimensions, grid " << grid;
    }
  }
}

TEST(CellHasher, GridsAndProbesAreDistinct) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 500});
  const CellHasher hasher(*data.codebook, RandomGridsOptions());
  std::vector<uint32_t> hashes = ProbesOf(hasher, data.queries.row(0).data());
  std::sort(hashes.begin(), hashes.end());
  EXPECT_EQ(std::unique(hashes.begin(), hashes.end()), hashes.end());
}

TEST(CellHasher, ASmallStepAcrossABorderReachesTheFirstProbe) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 500});
  const CellHasher hasher(*data.codebook, {.num_grids = 1, .num_probes = 2});
  // Walks along the first axis; where the own cell changes, the probe had announced the new one,
  // unless a border in another dimension was as near. The crossings of one walk share the other
  // dimensions, so that only several walks tell.
  int num_crossings = 0;
  int num_announced = 0;
  for (int query = 0; query < 12; ++query) {
    Eigen::RowVectorXf descriptor = data.queries.row(query);
    std::vector<uint32_t> before = ProbesOf(hasher, descriptor.data());
    for (int i = 0; i < 20'000; ++i) {
      descriptor[0] += 1e-4f;
      const std::vector<uint32_t> after = ProbesOf(hasher, descriptor.data());
      if (after[0] != before[0]) {
        ++num_crossings;
        num_announced += after[0] == before[1] ? 1 : 0;
      }
      before = after;
    }
  }
  EXPECT_GT(num_crossings, 12 * 20);
  EXPECT_GT(num_announced, 0.8 * num_crossings);
}

TEST(CellHasher, FewDimensionsHaveFewProbes) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 500});
  const CellHasher hasher(*data.codebook, {.num_grids = 1, .num_hashed_dims = 2, .num_probes = 32});
  EXPECT_EQ(hasher.num_probes(), 4);
}

TEST(CellHasher, ExtremeNumbersHaveSomeCell) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 500});
  const CellHasher hasher(*data.codebook, RandomGridsOptions());
  for (const float value : {1e38f, -1e38f, std::numeric_limits<float>::infinity(),
                            std::numeric_limits<float>::quiet_NaN()}) {
    const std::vector<float> descriptor(16, value);
    const std::vector<uint32_t> probes = ProbesOf(hasher, descriptor.data());
    EXPECT_EQ(probes.size(), 1u * hasher.num_grids() * hasher.num_probes());
  }
}

TEST(CellHasher, DependsOnTheSeedAlone) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 500});
  const RandomGridsOptions options;
  RandomGridsOptions other_seed;
  other_seed.seed = 2;
  const float* descriptor = data.queries.data();
  EXPECT_EQ(ProbesOf(CellHasher(*data.codebook, options), descriptor),
            ProbesOf(CellHasher(*data.codebook, options), descriptor));
  EXPECT_NE(ProbesOf(CellHasher(*data.codebook, options), descriptor),
            ProbesOf(CellHasher(*data.codebook, other_seed), descriptor));
}

}  // namespace
}  // namespace cairn
