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
using Floats = float __attribute__((vector_size(16)));
using Ints = int32_t __attribute__((vector_size(16)));
constexpr int kCoordinateLanes = 16;
constexpr int kFloatLanes = 4;

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
    const uint64_t factor = factors[packed >> 1 & ((1 << kLaneBits) - 1)];
    return {static_cast<int32_t>(packed >> (kLaneBits + 1)), (packed & 1) != 0 ? -factor : factor};
  }
};

// Adds the cells of eight coordinates, each times its factor.
[[gnu::always_inline]] inline void AddCells(const HalfCoordinates& coordinates,
                                            const uint64_t* factors, Products* sum) {
  Products factors_of_lanes;
  std::memcpy(&factors_of_lanes, factors, sizeof(factors_of_lanes));
  *sum += __builtin_convertvector(coordinates >> kCellBits, Products) * factors_of_lanes;
}

// Adds the hashes of the cells that rows of codes lie in, by the rotated words (num_subspaces x
// kNumWords x kCoordinateLanes) that make up their coordinates. Lanes without a factor add nothing.
// A constant number of subspaces lets the loop unroll.
[[gnu::always_inline]] inline void AddHashesOf(size_t num_subspaces, const int16_t* words,
                                               const uint64_t* factors, const uint8_t* codes,
                                               std::span<uint64_t> hashes) {
  for (uint64_t& hash : hashes) {
    Coordinates sum = {};
    const int16_t* words_of_subspace = words;
    for (size_t m = 0; m < num_subspaces; ++m) {
      Coordinates word;
      std::memcpy(&word, words_of_subspace + size_t{*codes++} * kCoordinateLanes, sizeof(word));
      sum += word;
      words_of_subspace += Codebook::kNumWords * kCoordinateLanes;
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
                                   std::span<uint64_t> hashes) {
  constexpr size_t kUsualSubspaces = 8;
  if (num_subspaces == kUsualSubspaces) {
    AddHashesOf(kUsualSubspaces, words, factors, codes, hashes);
  } else {
    AddHashesOf(num_subspaces, words, factors, codes, hashes);
  }
}

// Keeps the smallest values seen, ascending. Without branches, which would be mispredicted.
void InsertSorted(uint32_t value, std::span<uint32_t> smallest) {
  for (uint32_t& kept : smallest) {
    const uint32_t smaller = std::min(kept, value);
    value = std::max(kept, value);
    kept = smaller;
  }
}

}  // namespace

CellHasher::CellHasher(const Codebook& codebook, const RandomGridsOptions& options)
    : dim_(codebook.projected_dim()),
      num_grids_(options.num_grids),
      num_hashed_dims_(std::min(options.num_hashed_dims, dim_)),
      num_probes_(num_hashed_dims_ < 5 ? std::min(options.num_probes, 1 << num_hashed_dims_)
                                       : options.num_probes),
      num_lanes_((num_grids_ * num_hashed_dims_ + kFloatLanes - 1) / kFloatLanes * kFloatLanes),
      rotations_(size_t{1} * dim_ * num_lanes_),
      shifts_(num_lanes_),
      factors_(num_lanes_) {
  const double cell_width = CellWidth(codebook, options.cell_width_sigmas);
  std::vector<int> rotated_dims = DimsByVariance(codebook);
  rotated_dims.resize(std::max(num_hashed_dims_, 3 * dim_ / 4));
  for (int grid = 0; grid < num_grids_; ++grid) {
    FillGrid(grid, rotated_dims, RandomBits(options.seed, grid), cell_width);
  }
}

void CellHasher::FillGrid(int grid, const std::vector<int>& rotated_dims, uint64_t seed,
                          double cell_width) {
  std::mt19937_64 random(seed);
  const Eigen::MatrixXd rotation = RandomRotation(static_cast<int>(rotated_dims.size()), &random);
  std::uniform_real_distribution<float> uniform(0.0f, kUnitsPerCell);
  for (int j = 0; j < num_hashed_dims_; ++j) {
    const int lane = grid * num_hashed_dims_ + j;
    for (size_t d = 0; d < rotated_dims.size(); ++d) {
      rotations_[size_t{1} * rotated_dims[d] * num_lanes_ + lane] = static_cast<float>(
          rotation(j, static_cast<Eigen::Index>(d)) / cell_width * kUnitsPerCell);
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

std::vector<uint64_t> CellHasher::HashCodes(const Codebook& codebook,
                                            std::span<const uint8_t> codes, int grid) const {
  const size_t num_subspaces = codebook.num_subspaces;
  std::vector<uint64_t> hashes(codes.size() / num_subspaces);
  for (int begin = 0; begin < num_hashed_dims_; begin += kCoordinateLanes) {
    const int first_lane = grid * num_hashed_dims_ + begin;
    const int num_used = std::min(kCoordinateLanes, num_hashed_dims_ - begin);
    const std::vector<int16_t> words = RotatedWords(codebook, first_lane, num_used);
    std::array<uint64_t, kCoordinateLanes> factors{};
    std::copy_n(factors_.begin() + first_lane, num_used, factors.begin());
    AddHashes(num_subspaces, words.data(), factors.data(), codes.data(), hashes);
  }
  return hashes;
}

void CellHasher::ProjectQuery(const float* projected, int32_t* units) const {
  for (int begin = 0; begin < num_lanes_; begin += kFloatLanes) {
    Floats sum;
    std::memcpy(&sum, shifts_.data() + begin, sizeof(sum));
    for (int d = 0; d < dim_; ++d) {
      Floats rotation;
      std::memcpy(&rotation, rotations_.data() + size_t{1} * d * num_lanes_ + begin,
                  sizeof(rotation));
      sum += projected[d] * rotation;
    }
    // Far coordinates and NaN become some coordinate.
    sum = sum < kMaxUnits ? sum : Floats{} + kMaxUnits;
    sum = sum > -kMaxUnits ? sum : Floats{} - kMaxUnits;
    const Ints rounded = __builtin_convertvector(sum, Ints);
    std::memcpy(units + begin, &rounded, sizeof(rounded));
  }
}

void CellHasher::HashProbes(const float* projected, int num_grids, std::span<int32_t> units,
                            uint64_t* hashes) const {
  ProjectQuery(projected, units.data());
  const int num_steps = std::min(num_hashed_dims_, num_probes_ - 1);
  std::array<uint32_t, kMaxProbes> packed_steps;
  std::array<BorderStep, kMaxProbes> steps;
  for (int grid = 0; grid < num_grids; ++grid) {
    const uint64_t* factors = factors_.data() + grid * num_hashed_dims_;
    std::fill_n(packed_steps.begin(), num_steps, std::numeric_limits<uint32_t>::max());
    uint64_t own_hash = 0;
    for (int j = 0; j < num_hashed_dims_; ++j) {
      const auto coordinate = static_cast<int16_t>(units[grid * num_hashed_dims_ + j]);
      own_hash += static_cast<uint64_t>(int64_t{CellOf(coordinate)}) * factors[j];
      InsertSorted(PackedStep::Pack(coordinate, j), {packed_steps.data(), size_t(num_steps)});
    }
    for (int i = 0; i < num_steps; ++i) {
      steps[i] = PackedStep::Unpack(packed_steps[i], factors);
    }
    const std::span<uint64_t> row(hashes + grid * num_probes_, num_probes_);
    FillProbeSequence({steps.data(), size_t(num_steps)}, row);
    for (uint64_t& hash : row) {
      hash += own_hash;
    }
  }
}

size_t CellHasher::MemoryBytes() const {
  return (rotations_.capacity() + shifts_.capacity()) * sizeof(float) +
         factors_.capacity() * sizeof(uint64_t);
}

}  // namespace cairn
