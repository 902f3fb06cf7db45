#include "engine/matching/cell_hasher.h"

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>

#include "engine/matching/byte_descriptors.h"
#include "engine/matching/cell_sketch.h"
#include "engine/matching/distance_statistics.h"
#include "engine/matching/probe_sequence.h"
#include "engine/matching/random_bits.h"
#include "engine/vector_clones.h"

namespace cairn {
namespace {

constexpr int kCellBits = 8;  // Of a coordinate's 16 bits, those below the cell.
constexpr int kUnitsPerCell = 1 << kCellBits;

// Coordinates of one rotated word, unsigned so that sums may wrap around; half of them; their
// shares of a hash; numbers of one register.
using Coordinates = uint16_t __attribute__((vector_size(32)));
using HalfCoordinates = int16_t __attribute__((vector_size(16)));
using Products = uint64_t __attribute__((vector_size(64)));
using Floats = float __attribute__((vector_size(64)));
using Ints = int32_t __attribute__((vector_size(64)));
using Packed = uint32_t __attribute__((vector_size(64)));
constexpr int kCoordinateLanes = 16;
constexpr int kFloatLanes = 16;
constexpr int kPackedLanes = 16;
constexpr int kMaxHashedDims = 128;

// Whole turns of the 16-bit coordinates: added to all units to make them positive, so that the
// conversion to integers, which rounds towards zero, rounds down.
constexpr float kPositiveShift = 65536.0f;
constexpr float kMaxUnits = 1e9f;

// Side of a cell in projected space; never so small that the coordinates lose their meaning.
double CellWidth(const Codebook& codebook, double cell_width_sigmas) {
  const double sigma = SameLandmarkDistance(codebook, 0.5) /
                       std::sqrt(static_cast<double>(codebook.projected_dim()));
  return std::max(cell_width_sigmas * sigma, static_cast<double>(ByteScale(codebook).step()));
}

// A uniformly distributed rotation or reflection.
Eigen::MatrixXd RandomRotation(int dim, std::mt19937_64* random) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd gaussian(dim, dim);
  for (int i = 0; i < dim; ++i) {
    for (int j = 0; j < dim; ++j) {
      gaussian(i, j) = normal(*random);
    }
  }
  return Eigen::HouseholderQR<Eigen::MatrixXd>(gaussian).householderQ();
}

// Dimensions by falling variance of the codebook's words.
std::vector<int> DimsByVariance(const Codebook& codebook) {
  const int sub_dim = codebook.subspace_dim();
  std::vector<double> variances;
  for (int dim = 0; dim < codebook.projected_dim(); ++dim) {
    const float* words =
        codebook.words.data() + size_t{1} * (dim / sub_dim) * Codebook::kNumWords * sub_dim;
    double sum = 0.0, sq_sum = 0.0;
    for (int word = 0; word < Codebook::kNumWords; ++word) {
      const double value = words[word * sub_dim + dim % sub_dim];
      sum += value;
      sq_sum += value * value;
    }
    variances.push_back(sq_sum - sum * sum / Codebook::kNumWords);
  }
  std::vector<int> dims(variances.size());
  std::iota(dims.begin(), dims.end(), 0);
  std::stable_sort(dims.begin(), dims.end(),
                   [&](int a, int b) { return variances[a] > variances[b]; });
  return dims;
}

// Rounds to a coordinate, wrapping around.
int16_t WrapToCoordinate(double units) {
  constexpr double kRange = 65536.0;
  if (std::abs(units) >= kRange / 2) {
    units = std::fmod(units, kRange);
  }
  return static_cast<int16_t>(std::lround(units));
}

int32_t CellOf(int16_t coordinate) { return coordinate >> kCellBits; }

// The step across the nearer border in one dimension: the squared distance to it in units, with the
// dimension and the direction packed below it so that steps sort as plain integers.
struct PackedStep {
  static constexpr int kLaneBits = 8;

  static uint32_t Pack(int16_t coordinate, int lane) {
    const int32_t above_lower = coordinate & (kUnitsPerCell - 1);
    const int32_t below_upper = kUnitsPerCell - above_lower;
    const bool down = above_lower < below_upper;
    const auto cost = static_cast<uint32_t>(down ? above_lower : below_upper);
    return (cost * cost << kLaneBits | static_cast<uint32_t>(lane)) << 1 | (down ? 1 : 0);
  }
  static BorderStep Unpack(uint32_t packed, const uint64_t* factors) {
    const uint32_t lane = packed >> 1 & ((1 << kLaneBits) - 1);
    const uint64_t factor = factors[lane];
    return {static_cast<int32_t>(packed >> (kLaneBits + 1)),
            {(packed & 1) != 0 ? -factor : factor, lane < kSketchDims ? uint32_t{1} << lane : 0}};
  }
};

// Adds the cells of eight coordinates, each times its factor.
[[gnu::always_inline]] inline void AddCells(const HalfCoordinates& coordinates,
                                            const uint64_t* factors, Products* sum) {
  Products factors_of_lanes;
  std::memcpy(&factors_of_lanes, factors, sizeof(factors_of_lanes));
  *sum += __builtin_convertvector(coordinates >> kCellBits, Products) * factors_of_lanes;
}

// The quarters of a cell that sixteen coordinates lie in, two bits each.
[[gnu::always_inline]] inline uint32_t SketchOf(const Coordinates& coordinates) {
  static_assert(kCoordinateLanes == kSketchDims);
  constexpr Coordinates kPowersOfFour = {1, 4, 16, 64, 256, 1024, 4096, 16384,
                                         1, 4, 16, 64, 256, 1024, 4096, 16384};
  const Coordinates quarters = (coordinates >> (kCellBits - 2) & 3) * kPowersOfFour;
  std::array<uint64_t, 4> fours;
  std::memcpy(fours.data(), &quarters, sizeof(quarters));
  const uint64_t lower = fours[0] | fours[1];
  const uint64_t upper = fours[2] | fours[3];
  const uint64_t first = (lower | lower >> 32 | lower >> 16 | lower >> 48) & 0xFFFF;
  return static_cast<uint32_t>(first | (upper | upper >> 32 | upper >> 16 | upper >> 48) << 16);
}

// Adds the hashes of the cells that rows of codes lie in, by the rotated words (num_subspaces x
// kNumWords x kCoordinateLanes) that make up their coordinates. Lanes without a factor add nothing.
// Writes sketches unless there are none to write. A constant number of subspaces lets the loop
// unroll.
[[gnu::always_inline]] inline void AddHashesOf(size_t num_subspaces, const int16_t* words,
                                               const uint64_t* factors, const uint8_t* codes,
                                               std::span<uint64_t> hashes, uint32_t* sketches) {
  for (uint64_t& hash : hashes) {
    Coordinates sum = {};
    const int16_t* words_of_subspace = words;
    for (size_t m = 0; m < num_subspaces; ++m) {
      Coordinates word;
      std::memcpy(&word, words_of_subspace + size_t{*codes++} * kCoordinateLanes, sizeof(word));
      sum += word;
      words_of_subspace += Codebook::kNumWords * kCoordinateLanes;
    }
    if (sketches != nullptr) {
      *sketches++ = SketchOf(sum);
    }
    HalfCoordinates halves[2];
    std::memcpy(halves, &sum, sizeof(sum));
    Products products = {};
    AddCells(halves[0], factors, &products);
    AddCells(halves[1], factors + kCoordinateLanes / 2, &products);
    products += __builtin_shufflevector(products, products, 4, 5, 6, 7, 0, 1, 2, 3);
    products += __builtin_shufflevector(products, products, 2, 3, 0, 1, 2, 3, 0, 1);
    hash += products[0] + products[1];
  }
}

CAIRN_VECTOR_CLONES void AddHashes(size_t num_subspaces, const int16_t* words,
                                   const uint64_t* factors, const uint8_t* codes,
                                   std::span<uint64_t> hashes, uint32_t* sketches) {
  constexpr size_t kUsualSubspaces = 8;
  if (num_subspaces == kUsualSubspaces) {
    AddHashesOf(kUsualSubspaces, words, factors, codes, hashes, sketches);
  } else {
    AddHashesOf(num_subspaces, words, factors, codes, hashes, sketches);
  }
}

// Coordinates of a descriptor, rounded down: the sums of rotations (dim x num_lanes, row-major)
// times its values, and of shifts.
CAIRN_VECTOR_CLONES void Project(const float* projected, int dim, const float* rotations,
                                 const float* shifts, int num_lanes, int32_t* coordinates) {
  for (int begin = 0; begin < num_lanes; begin += kFloatLanes) {
    Floats sum;
    std::memcpy(&sum, shifts + begin, sizeof(sum));
    for (int d = 0; d < dim; ++d) {
      Floats rotation;
      std::memcpy(&rotation, rotations + size_t{1} * d * num_lanes + begin, sizeof(rotation));
      sum += projected[d] * rotation;
    }
    // Far coordinates and NaN become some coordinate.
    sum = sum < kMaxUnits ? sum : Floats{} + kMaxUnits;
    sum = sum > -kMaxUnits ? sum : Floats{} - kMaxUnits;
    const Ints rounded = __builtin_convertvector(sum, Ints);
    std::memcpy(coordinates + begin, &rounded, sizeof(rounded));
  }
}

// Writes `count` distinct values, padded with larger ones to whole vectors, in ascending order:
// each to the place that is the number of smaller ones.
CAIRN_VECTOR_CLONES void SortByRank(const uint32_t* values, int count, uint32_t* sorted) {
  for (int begin = 0; begin < count; begin += kPackedLanes) {
    Packed compared;
    std::memcpy(&compared, values + begin, sizeof(compared));
    Packed ranks = {};
    for (int i = 0; i < count; ++i) {
      ranks -= Packed(values[i] < compared);  // A lane of a comparison that holds is -1.
    }
    std::array<uint32_t, kPackedLanes> places;
    std::memcpy(places.data(), &ranks, sizeof(ranks));
    for (int i = begin; i < std::min(count, begin + kPackedLanes); ++i) {
      sorted[places[i - begin]] = values[i];
    }
  }
}

}  // namespace

CellHasher::CellHasher(const Codebook& codebook, const RandomGridsOptions& options)
    : dim_(codebook.projected_dim()),
      num_grids_(options.num_grids),
      num_hashed_dims_(std::min(options.num_hashed_dims, dim_)),
      num_probes_(num_hashed_dims_ < 5 ? std::min(options.num_probes, 1 << num_hashed_dims_)
                                       : options.num_probes),
      units_per_length_(kUnitsPerCell / CellWidth(codebook, options.cell_width_sigmas)),
      num_lanes_((num_grids_ * num_hashed_dims_ + kFloatLanes - 1) / kFloatLanes * kFloatLanes),
      rotations_(size_t{1} * dim_ * num_lanes_),
      shifts_(num_lanes_),
      factors_(num_lanes_) {
  std::vector<int> rotated_dims = DimsByVariance(codebook);
  rotated_dims.resize(std::max(num_hashed_dims_, 3 * dim_ / 4));
  for (int grid = 0; grid < num_grids_; ++grid) {
    FillGrid(grid, rotated_dims, RandomBits(options.seed, grid));
  }
}

void CellHasher::FillGrid(int grid, const std::vector<int>& rotated_dims, uint64_t seed) {
  std::mt19937_64 random(seed);
  const Eigen::MatrixXd rotation = RandomRotation(static_cast<int>(rotated_dims.size()), &random);
  std::uniform_real_distribution<float> uniform(0.0f, kUnitsPerCell);
  for (int j = 0; j < num_hashed_dims_; ++j) {
    const int lane = grid * num_hashed_dims_ + j;
    for (size_t d = 0; d < rotated_dims.size(); ++d) {
      rotations_[size_t{1} * rotated_dims[d] * num_lanes_ + lane] =
          static_cast<float>(rotation(j, static_cast<Eigen::Index>(d)) * units_per_length_);
    }
    shifts_[lane] = kPositiveShift + uniform(random);
    factors_[lane] = random() | 1;
  }
}

std::vector<int16_t> CellHasher::RotatedWords(const Codebook& codebook, int first_lane,
                                              int num_used) const {
  const int sub_dim = codebook.subspace_dim();
  const size_t num_words = size_t{Codebook::kNumWords} * codebook.num_subspaces;
  std::vector<int16_t> rotated(num_words * kCoordinateLanes);
  for (size_t word = 0; word < num_words; ++word) {
    const size_t subspace = word / Codebook::kNumWords;
    for (int j = 0; j < num_used; ++j) {
      // Half a unit, so that sums of rounded words are rounded down like queries.
      double units = subspace == 0 ? shifts_[first_lane + j] - 0.5 : 0.0;
      for (int d = 0; d < sub_dim; ++d) {
        units += static_cast<double>(codebook.words[word * sub_dim + d]) *
                 rotations_[(subspace * sub_dim + d) * num_lanes_ + first_lane + j];
      }
      rotated[word * kCoordinateLanes + j] = WrapToCoordinate(units);
    }
  }
  return rotated;
}

CellHasher::CellPlaces CellHasher::PlaceCodes(const Codebook& codebook,
                                              std::span<const uint8_t> codes, int grid) const {
  const size_t num_subspaces = codebook.num_subspaces;
  const size_t num_codes = codes.size() / num_subspaces;
  CellPlaces places{std::vector<uint64_t>(num_codes), std::vector<uint32_t>(num_codes)};
  for (int begin = 0; begin < num_hashed_dims_; begin += kCoordinateLanes) {
    const int first_lane = grid * num_hashed_dims_ + begin;
    const int num_used = std::min(kCoordinateLanes, num_hashed_dims_ - begin);
    const std::vector<int16_t> words = RotatedWords(codebook, first_lane, num_used);
    std::array<uint64_t, kCoordinateLanes> factors{};
    std::copy_n(factors_.begin() + first_lane, num_used, factors.begin());
    AddHashes(num_subspaces, words.data(), factors.data(), codes.data(), places.hashes,
              begin == 0 ? places.sketches.data() : nullptr);
  }
  return places;
}

void CellHasher::FindProbes(const float* projected, int num_grids, std::span<int32_t> coordinates,
                            Probe* probes) const {
  Project(projected, dim_, rotations_.data(), shifts_.data(), num_lanes_, coordinates.data());
  const int num_steps = std::min(num_hashed_dims_, num_probes_ - 1);
  std::array<uint32_t, kMaxHashedDims> packed, sorted;
  packed.fill(std::numeric_limits<uint32_t>::max());
  std::array<BorderStep, kMaxProbes> steps;
  for (int grid = 0; grid < num_grids; ++grid) {
    const uint64_t* factors = factors_.data() + grid * num_hashed_dims_;
    Probe own;
    for (int j = 0; j < num_hashed_dims_; ++j) {
      const auto coordinate = static_cast<int16_t>(coordinates[grid * num_hashed_dims_ + j]);
      own.hash += static_cast<uint64_t>(int64_t{CellOf(coordinate)}) * factors[j];
      packed[j] = PackedStep::Pack(coordinate, j);
    }
    SortByRank(packed.data(), num_hashed_dims_, sorted.data());
    for (int i = 0; i < num_steps; ++i) {
      steps[i] = PackedStep::Unpack(sorted[i], factors);
    }
    FillProbeSequence(own, {steps.data(), size_t(num_steps)},
                      {probes + grid * num_probes_, size_t(num_probes_)});
  }
}

size_t CellHasher::MemoryBytes() const {
  return (rotations_.capacity() + shifts_.capacity()) * sizeof(float) +
         factors_.capacity() * sizeof(uint64_t);
}

}  // namespace cairn
