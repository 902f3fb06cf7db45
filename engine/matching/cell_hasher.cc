#include "engine/matching/cell_hasher.h"

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <random>

#include "engine/matching/byte_descriptors.h"
#include "engine/matching/distance_kernels.h"
#include "engine/matching/distance_statistics.h"
#include "engine/matching/probe_sequence.h"
#include "engine/matching/random_bits.h"

namespace cairn {
namespace {

constexpr int kCellBits = 8;  // Of a coordinate's 16 bits, those below the cell.
constexpr int kUnitsPerCell = 1 << kCellBits;

// Eight coordinates and four floats of one vector register.
using Coordinates = int16_t __attribute__((vector_size(16)));
using Floats = float __attribute__((vector_size(16)));
constexpr int kFloatLanes = 4;

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

// Rounds to a coordinate, wrapping around.
int16_t WrapToCoordinate(double units) {
  constexpr double kRange = 65536.0;
  if (std::abs(units) >= kRange / 2) {
    units = std::fmod(units, kRange);
  }
  return static_cast<int16_t>(std::lround(units));
}

// Rounds down; far coordinates and NaN become some coordinate.
int32_t FloorToUnits(float units) {
  constexpr float kLimit = 1e6f;
  const float above = units > -kLimit ? units : -kLimit;
  const float clamped = above < kLimit ? above : kLimit;
  const auto truncated = static_cast<int32_t>(clamped);
  return truncated - (static_cast<float>(truncated) > clamped ? 1 : 0);
}

int32_t CellOf(int16_t coordinate) { return coordinate >> kCellBits; }

// The cheapest `count` of `steps`, in order, come first.
void SortCheapest(std::span<BorderStep> steps, size_t count) {
  std::partial_sort(steps.begin(), steps.begin() + static_cast<ptrdiff_t>(count), steps.end(),
                    [](const BorderStep& a, const BorderStep& b) { return a.sq_cost < b.sq_cost; });
}

}  // namespace

CellHasher::CellHasher(const Codebook& codebook, const RandomGridsOptions& options)
    : dim_(codebook.projected_dim()),
      num_grids_(options.num_grids),
      num_hashed_dims_(std::min(options.num_hashed_dims, dim_)),
      num_lanes_((num_hashed_dims_ + kLanes - 1) / kLanes * kLanes),
      num_probes_(num_hashed_dims_ < 5 ? std::min(options.num_probes, 1 << num_hashed_dims_)
                                       : options.num_probes),
      rotations_(size_t{1} * dim_ * num_grids_ * num_lanes_),
      shifts_(size_t{1} * num_grids_ * num_lanes_),
      factors_(size_t{1} * num_grids_ * num_lanes_) {
  const double cell_width = CellWidth(codebook, options.cell_width_sigmas);
  for (int grid = 0; grid < num_grids_; ++grid) {
    FillGrid(grid, RandomBits(options.seed, grid), cell_width);
  }
}

void CellHasher::FillGrid(int grid, uint64_t seed, double cell_width) {
  std::mt19937_64 random(seed);
  const Eigen::MatrixXd rotation = RandomRotation(dim_, &random);
  std::uniform_real_distribution<float> uniform(0.0f, kUnitsPerCell);
  for (int j = 0; j < num_hashed_dims_; ++j) {
    const int lane = grid * num_lanes_ + j;
    for (int d = 0; d < dim_; ++d) {
      rotations_[d * num_grids_ * num_lanes_ + lane] =
          static_cast<float>(rotation(j, d) / cell_width * kUnitsPerCell);
    }
    shifts_[lane] = uniform(random);
    factors_[lane] = random() | 1;
  }
}

std::vector<int16_t> CellHasher::RotatedWords(const Codebook& codebook, int first_lane) const {
  const int sub_dim = codebook.subspace_dim();
  const size_t num_words = size_t{Codebook::kNumWords} * codebook.num_subspaces;
  std::vector<int16_t> rotated(num_words * kLanes);
  for (size_t word = 0; word < num_words; ++word) {
    const size_t subspace = word / Codebook::kNumWords;
    for (int j = 0; j < kLanes; ++j) {
      // Half a unit, so that sums of rounded words are rounded down like queries.
      double units = subspace == 0 ? shifts_[first_lane + j] - 0.5 : 0.0;
      for (int d = 0; d < sub_dim; ++d) {
        units += static_cast<double>(codebook.words[word * sub_dim + d]) *
                 rotations_[(subspace * sub_dim + d) * num_grids_ * num_lanes_ + first_lane + j];
      }
      rotated[word * kLanes + j] = WrapToCoordinate(units);
    }
  }
  return rotated;
}

std::vector<uint64_t> CellHasher::HashCodes(const Codebook& codebook,
                                            std::span<const uint8_t> codes, int grid) const {
  const size_t num_subspaces = codebook.num_subspaces;
  std::vector<uint64_t> hashes(codes.size() / num_subspaces);
  for (int begin = 0; begin < num_hashed_dims_; begin += kLanes) {
    const int first_lane = grid * num_lanes_ + begin;
    const int num_used = std::min(kLanes, num_hashed_dims_ - begin);
    const std::vector<int16_t> words = RotatedWords(codebook, first_lane);
    const uint8_t* code = codes.data();
    for (uint64_t& hash : hashes) {
      Coordinates sum = {};
      for (size_t m = 0; m < num_subspaces; ++m, ++code) {
        Coordinates word;
        std::memcpy(&word, words.data() + (m * Codebook::kNumWords + *code) * kLanes, sizeof(word));
        sum += word;
      }
      for (int j = 0; j < num_used; ++j) {
        hash += static_cast<uint64_t>(int64_t{CellOf(sum[j])}) * factors_[first_lane + j];
      }
    }
  }
  return hashes;
}

void CellHasher::ProjectQuery(const float* projected, float* units) const {
  const size_t num_values = shifts_.size();
  for (size_t begin = 0; begin < num_values; begin += kFloatLanes) {
    Floats sum;
    std::memcpy(&sum, shifts_.data() + begin, sizeof(sum));
    for (int d = 0; d < dim_; ++d) {
      Floats rotation;
      std::memcpy(&rotation, rotations_.data() + d * num_values + begin, sizeof(rotation));
      sum += projected[d] * rotation;
    }
    std::memcpy(units + begin, &sum, sizeof(sum));
  }
}

void CellHasher::HashProbes(const float* projected, std::span<float> units,
                            uint64_t* hashes) const {
  ProjectQuery(projected, units.data());
  std::array<BorderStep, kMaxDistanceStride> steps;
  const size_t num_steps = std::min(num_hashed_dims_, num_probes_ - 1);
  for (int grid = 0; grid < num_grids_; ++grid) {
    uint64_t own_hash = 0;
    for (int j = 0; j < num_hashed_dims_; ++j) {
      const int lane = grid * num_lanes_ + j;
      const auto coordinate = static_cast<int16_t>(FloorToUnits(units[lane]));
      const uint64_t factor = factors_[lane];
      own_hash += static_cast<uint64_t>(int64_t{CellOf(coordinate)}) * factor;
      const int32_t above_lower = coordinate & (kUnitsPerCell - 1);
      const int32_t below_upper = kUnitsPerCell - above_lower;
      const bool down = above_lower < below_upper;
      const int32_t cost = down ? above_lower : below_upper;
      steps[j] = {cost * cost, down ? -factor : factor};
    }
    SortCheapest({steps.data(), static_cast<size_t>(num_hashed_dims_)}, num_steps);
    const std::span<uint64_t> row(hashes + grid * num_probes_, num_probes_);
    FillProbeSequence({steps.data(), num_steps}, row);
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
