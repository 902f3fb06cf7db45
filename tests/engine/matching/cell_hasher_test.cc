#include "engine/matching/cell_hasher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "engine/matching/cell_sketch.h"
#include "engine/matching/synthetic_descriptors.h"
#include "storage/descriptor_codec.h"

namespace cairn {
namespace {

using testing::MakeSyntheticDescriptors;
using testing::SyntheticDescriptors;

struct Located {
  std::vector<int32_t> coordinates;
  std::vector<Probe> probes;
};

Located Locate(const CellHasher& hasher, const float* descriptor) {
  Located located{std::vector<int32_t>(hasher.num_coordinates()),
                  std::vector<Probe>(size_t{1} * hasher.num_grids() * hasher.num_probes())};
  hasher.FindProbes(descriptor, hasher.num_grids(), located.coordinates, located.probes.data());
  return located;
}

std::vector<uint64_t> ProbesOf(const CellHasher& hasher, const float* descriptor) {
  std::vector<uint64_t> hashes;
  for (const Probe& probe : Locate(hasher, descriptor).probes) {
    hashes.push_back(probe.hash);
  }
  return hashes;
}

// As cell_sketch.h defines it.
uint32_t SketchOf(std::span<const int32_t> coordinates) {
  uint32_t sketch = 0;
  for (size_t dim = 0; dim < std::min<size_t>(coordinates.size(), kSketchDims); ++dim) {
    sketch |= static_cast<uint32_t>((coordinates[dim] & 255) / 64) << (2 * dim);
  }
  return sketch;
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
      const auto places = hasher.PlaceCodes(*data.codebook, data.codes, grid);
      int num_equal_cells = 0, num_equal_sketches = 0;
      for (int i = 0; i < num_codes; ++i) {
        const Located located = Locate(hasher, decoded.row(i).data());
        const uint64_t hash = located.probes[grid * hasher.num_probes()].hash;
        num_equal_cells += hash == places.hashes[i] ? 1 : 0;
        const uint32_t sketch = SketchOf(hasher.Coordinates(located.coordinates, grid));
        num_equal_sketches += sketch == places.sketches[i] ? 1 : 0;
      }
      // Words are rounded to 1/256 cell each; only codes that close to a border, of a cell or of a
      // quarter of it, may differ.
      EXPECT_GT(num_equal_cells, 900) << num_hashed_dims << " dimensions, grid " << grid;
      EXPECT_GT(num_equal_sketches, 600) << num_hashed_dims << " dimensions, grid " << grid;
    }
  }
}

TEST(CellHasher, GridsAndProbesAreDistinct) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 500});
  const CellHasher hasher(*data.codebook, RandomGridsOptions());
  std::vector<uint64_t> hashes = ProbesOf(hasher, data.queries.row(0).data());
  std::sort(hashes.begin(), hashes.end());
  EXPECT_EQ(std::unique(hashes.begin(), hashes.end()), hashes.end());
}

TEST(CellHasher, ASmallStepAcrossABorderReachesTheFirstProbe) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 500});
  const CellHasher hasher(*data.codebook, {.num_grids = 1, .num_probes = 2});
  // Walks along the first axis; where the own cell changes, the probe had announced the new one,
  // unless a border in another dimension was as near.
  Eigen::RowVectorXf descriptor = data.queries.row(0);
  std::vector<uint64_t> before = ProbesOf(hasher, descriptor.data());
  int num_crossings = 0;
  int num_announced = 0;
  for (int i = 0; i < 20'000; ++i) {
    descriptor[0] += 1e-4f;
    const std::vector<uint64_t> after = ProbesOf(hasher, descriptor.data());
    if (after[0] != before[0]) {
      ++num_crossings;
      num_announced += after[0] == before[1] ? 1 : 0;
    }
    before = after;
  }
  EXPECT_GT(num_crossings, 20);
  EXPECT_GT(num_announced, 0.8 * num_crossings);
}

TEST(CellHasher, AProbeSaysWhichBordersItLiesAcross) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 500});
  const CellHasher hasher(*data.codebook, {.num_grids = 1, .num_probes = 32});
  std::vector<float> descriptor(data.queries.row(0).data(), data.queries.row(0).data() + 16);
  const Located located = Locate(hasher, descriptor.data());
  EXPECT_EQ(located.probes[0].crossed_dims, 0u);
  std::vector<uint32_t> crossed;
  for (const Probe& probe : located.probes) {
    EXPECT_LT(probe.crossed_dims, 1u << hasher.num_hashed_dims());
    crossed.push_back(probe.crossed_dims);
  }
  std::sort(crossed.begin(), crossed.end());
  EXPECT_EQ(std::unique(crossed.begin(), crossed.end()), crossed.end());
  // The first probe crosses the border that is nearest.
  const auto distance = [&](uint32_t dim) {
    const int32_t in_cell = located.coordinates[dim] & 255;
    return std::min(in_cell, 256 - in_cell);
  };
  const auto nearest = static_cast<uint32_t>(std::countr_zero(located.probes[1].crossed_dims));
  EXPECT_EQ(located.probes[1].crossed_dims, 1u << nearest);
  for (int dim = 0; dim < hasher.num_hashed_dims(); ++dim) {
    EXPECT_LE(distance(nearest), distance(static_cast<uint32_t>(dim)));
  }
}

TEST(CellHasher, UnitsAreThoseOfTheCoordinates) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 500});
  // All dimensions are rotated, so that lengths stay.
  const CellHasher hasher(*data.codebook, {.num_grids = 1, .num_hashed_dims = 16});
  Eigen::RowVectorXf moved = data.queries.row(0);
  moved[3] += 0.2f;
  moved[9] -= 0.1f;
  const Located from = Locate(hasher, data.queries.row(0).data());
  const Located to = Locate(hasher, moved.data());
  double sq_units = 0.0;
  for (int dim = 0; dim < 16; ++dim) {
    sq_units += std::pow(to.coordinates[dim] - from.coordinates[dim], 2);
  }
  EXPECT_NEAR(std::sqrt(sq_units), std::sqrt(hasher.SqUnitsOf(0.05)), 4.0);
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
    const std::vector<uint64_t> probes = ProbesOf(hasher, descriptor.data());
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
