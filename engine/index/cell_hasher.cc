#include "engine/index/cell_hasher.h"

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>

#include "core/random.h"
#include "core/simd.h"
#include "engine/index/byte_descriptors.h"
#include "storage/codebook/distance_statistics.h"

namespace cairn {
namespace {

// The lower bits of a 16-bit coordinate, which give the position within the cell.
constexpr int kCellBits = 8;
constexpr int kUnitsPerCell = 1 << kCellBits;

// Vector types. Coordinates: coordinates of one rotated word, unsigned so that sums may wrap
// around; SignedCoordinates: their signed values; Products: their contributions to a hash; Floats
// and Ints: the numbers of one AVX2 register.
constexpr int kCoordinateLanes = 16;
constexpr int kLanes = 8;  // Lanes of AVX2, so that a sum fits one of its registers.
using Coordinates = Lanes<uint16_t, kCoordinateLanes>;
using SignedCoordinates = Lanes<int16_t, kCoordinateLanes>;
using Products = Lanes<uint32_t, kCoordinateLanes>;
using Floats = Lanes<float, kLanes>;
using Ints = Lanes<int32_t, kLanes>;
constexpr int kMaxHashedDims = 128;

// A multiple of the coordinates' 16-bit range. Adding it makes all values positive, so the
// conversion to integers, which rounds toward zero, rounds down.
constexpr float kPositiveShift = 65536.0f;
constexpr float kMaxUnits = 1e9f;

// Returns the side of a cell in projected space. A lower bound keeps the coordinates within their
// precision.
double CellWidth(const Codebook& codebook, double cell_width_sigmas) {
  const double sigma = SameLandmarkDistance(codebook, 0.5) /
                       std::sqrt(static_cast<double>(codebook.projected_dim()));
  return std::max(cell_width_sigmas * sigma, static_cast<double>(ByteScale(codebook).step()));
}

// Returns a uniformly distributed rotation or reflection.
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

// Returns the dimensions by descending variance of the codebook's words.
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

// Rounds to a coordinate and wraps around.
int16_t WrapToCoordinate(double units) {
  constexpr double kRange = 65536.0;
  if (std::abs(units) >= kRange / 2) {
    units = std::fmod(units, kRange);
  }
  return static_cast<int16_t>(std::lround(units));
}

int32_t CellOf(int16_t coordinate) { return coordinate >> kCellBits; }

// The step across the nearer border in one dimension. The distance to the border, in units, is in
// the upper bits; dimension and direction are below it. Hence steps sort as plain integers.
struct PackedStep {
  static constexpr int kLaneBits = 8;

  static int32_t Pack(int16_t coordinate, int lane) {
    const int32_t above_lower = coordinate & (kUnitsPerCell - 1);
    const int32_t below_upper = kUnitsPerCell - above_lower;
    const bool down = above_lower < below_upper;
    const int32_t length = down ? above_lower : below_upper;
    return (length << kLaneBits | lane) << 1 | (down ? 1 : 0);
  }
  // Returns the step's contribution to a hash.
  static uint32_t Unpack(int32_t packed, const uint32_t* factors) {
    const uint32_t factor = factors[packed >> 1 & ((1 << kLaneBits) - 1)];
    return (packed & 1) != 0 ? -factor : factor;
  }
};

// Adds the hashes of the cells of `codes`. The coordinates of a code are sums of rotated words
// (num_subspaces x kNumWords x kCoordinateLanes). Lanes with factor 0 add nothing. A constant
// number of subspaces lets the loop unroll.
[[gnu::always_inline]] inline void AddHashesOf(size_t num_subspaces, const int16_t* words,
                                               const uint32_t* factors_of_lanes,
                                               const uint8_t* codes, std::span<uint32_t> hashes) {
  Products factors;
  std::memcpy(&factors, factors_of_lanes, sizeof(factors));
  for (uint32_t& hash : hashes) {
    Coordinates sum = {};
    const int16_t* words_of_subspace = words;
    for (size_t m = 0; m < num_subspaces; ++m) {
      Coordinates word;
      std::memcpy(&word, words_of_subspace + size_t{*codes++} * kCoordinateLanes, sizeof(word));
      sum += word;
      words_of_subspace += Codebook::kNumWords * kCoordinateLanes;
    }
    SignedCoordinates coordinates;
    std::memcpy(&coordinates, &sum, sizeof(sum));
    Products products = __builtin_convertvector(coordinates >> kCellBits, Products) * factors;
    products += __builtin_shufflevector(products, products, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2,
                                        3, 4, 5, 6, 7);
    products += __builtin_shufflevector(products, products, 4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15,
                                        8, 9, 10, 11);
    hash += products[0] + products[1] + products[2] + products[3];
  }
}

CAIRN_VECTOR_CLONES void AddHashes(size_t num_subspaces, const int16_t* words,
                                   const uint32_t* factors, const uint8_t* codes,
                                   std::span<uint32_t> hashes) {
  constexpr size_t kUsualSubspaces = 8;
  if (num_subspaces == kUsualSubspaces) {
    AddHashesOf(kUsualSubspaces, words, factors, codes, hashes);
  } else {
    AddHashesOf(num_subspaces, words, factors, codes, hashes);
  }
}

// Computes a descriptor's coordinates, rounded down: rotations (dim x num_lanes, row-major) times
// the descriptor, plus shifts.
CAIRN_VECTOR_CLONES void Project(const float* projected, int dim, const float* rotations,
                                 const float* shifts, int num_lanes, int32_t* coordinates) {
  for (int begin = 0; begin < num_lanes; begin += kLanes) {
    Floats sum;
    std::memcpy(&sum, shifts + begin, sizeof(sum));
    for (int d = 0; d < dim; ++d) {
      Floats rotation;
      std::memcpy(&rotation, rotations + size_t{1} * d * num_lanes + begin, sizeof(rotation));
      sum += projected[d] * rotation;
    }
    // Clamps values that are too large; a NaN becomes an arbitrary coordinate.
    sum = sum < kMaxUnits ? sum : Floats{} + kMaxUnits;
    sum = sum > -kMaxUnits ? sum : Floats{} - kMaxUnits;
    const Ints rounded = __builtin_convertvector(sum, Ints);
    std::memcpy(coordinates + begin, &rounded, sizeof(rounded));
  }
}

// Sorts `count` distinct values, which are padded to whole vectors with larger ones. The position
// of a value is the number of smaller values.
CAIRN_VECTOR_CLONES void SortByRank(const int32_t* values, int count, int32_t* sorted) {
  for (int begin = 0; begin < count; begin += kLanes) {
    Ints compared;
    std::memcpy(&compared, values + begin, sizeof(compared));
    Ints ranks = {};
    for (int i = 0; i < count; ++i) {
      ranks -= values[i] < compared;  // In a comparison that holds, a lane is -1.
    }
    std::array<int32_t, kLanes> places;
    std::memcpy(places.data(), &ranks, sizeof(ranks));
    for (int i = begin; i < std::min(count, begin + kLanes); ++i) {
      sorted[places[i - begin]] = values[i];
    }
  }
}

}  // namespace

CellHasher::CellHasher(const Codebook& codebook, const RandomGridsOptions& options)
    : dim_(codebook.projected_dim()),
      num_grids_(options.num_grids),
      num_hashed_dims_(std::min(options.num_hashed_dims, dim_)),
      sequence_(num_hashed_dims_, options.num_probes),
      units_per_length_(kUnitsPerCell / CellWidth(codebook, options.cell_width_sigmas)),
      num_lanes_((num_hashed_dims_ + kLanes - 1) / kLanes * kLanes),
      rotations_(size_t{1} * num_grids_ * dim_ * num_lanes_),
      shifts_(size_t{1} * num_grids_ * num_lanes_),
      factors_(size_t{1} * num_grids_ * num_lanes_) {
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
  float* of_grid = rotations_.data() + size_t{1} * grid * dim_ * num_lanes_;
  for (int j = 0; j < num_hashed_dims_; ++j) {
    for (size_t d = 0; d < rotated_dims.size(); ++d) {
      of_grid[size_t{1} * rotated_dims[d] * num_lanes_ + j] =
          static_cast<float>(rotation(j, static_cast<Eigen::Index>(d)) * units_per_length_);
    }
    shifts_[size_t{1} * grid * num_lanes_ + j] = kPositiveShift + uniform(random);
    factors_[size_t{1} * grid * num_lanes_ + j] = static_cast<uint32_t>(random()) | 1;
  }
}

std::vector<int16_t> CellHasher::RotatedWords(const Codebook& codebook, int grid, int first_lane,
                                              int num_used) const {
  const float* rotation = Rotation(grid) + first_lane;
  const float* shifts = Shifts(grid) + first_lane;
  const int sub_dim = codebook.subspace_dim();
  const size_t num_words = size_t{Codebook::kNumWords} * codebook.num_subspaces;
  std::vector<int16_t> rotated(num_words * kCoordinateLanes);
  for (size_t word = 0; word < num_words; ++word) {
    const size_t subspace = word / Codebook::kNumWords;
    for (int j = 0; j < num_used; ++j) {
      // Adds half a unit, so that the rounded sum rounds down as the coordinates of queries do.
      double units = subspace == 0 ? shifts[j] - 0.5 : 0.0;
      for (int d = 0; d < sub_dim; ++d) {
        units += static_cast<double>(codebook.words[word * sub_dim + d]) *
                 rotation[(subspace * sub_dim + d) * num_lanes_ + j];
      }
      rotated[word * kCoordinateLanes + j] = WrapToCoordinate(units);
    }
  }
  return rotated;
}

LargeVector<uint32_t> CellHasher::HashCodes(const Codebook& codebook,
                                            std::span<const uint8_t> codes, int grid) const {
  const size_t num_subspaces = codebook.num_subspaces;
  LargeVector<uint32_t> hashes(codes.size() / num_subspaces, 0);
  for (int begin = 0; begin < num_hashed_dims_; begin += kCoordinateLanes) {
    const int num_used = std::min(kCoordinateLanes, num_hashed_dims_ - begin);
    const std::vector<int16_t> words = RotatedWords(codebook, grid, begin, num_used);
    std::array<uint32_t, kCoordinateLanes> factors{};
    std::copy_n(Factors(grid) + begin, num_used, factors.begin());
    AddHashes(num_subspaces, words.data(), factors.data(), codes.data(), hashes);
  }
  return hashes;
}

void CellHasher::FindProbes(const float* projected, int grid, uint32_t* hashes) const {
  std::array<int32_t, kMaxHashedDims> coordinates;
  Project(projected, dim_, Rotation(grid), Shifts(grid), num_lanes_, coordinates.data());
  const uint32_t* factors = Factors(grid);
  std::array<int32_t, kMaxHashedDims> packed, sorted;
  packed.fill(std::numeric_limits<int32_t>::max());
  uint32_t own = 0;
  for (int j = 0; j < num_hashed_dims_; ++j) {
    const auto coordinate = static_cast<int16_t>(coordinates[j]);
    own += static_cast<uint32_t>(CellOf(coordinate)) * factors[j];
    packed[j] = PackedStep::Pack(coordinate, j);
  }
  SortByRank(packed.data(), num_hashed_dims_, sorted.data());
  std::array<uint32_t, kMaxHashedDims> steps;
  for (int i = 0; i < sequence_.num_steps(); ++i) {
    steps[i] = PackedStep::Unpack(sorted[i], factors);
  }
  sequence_.Fill(own, steps, hashes);
}

size_t CellHasher::MemoryBytes() const {
  return (rotations_.capacity() + shifts_.capacity()) * sizeof(float) +
         factors_.capacity() * sizeof(uint32_t);
}

}  // namespace cairn
