// Sketches: roughly where in its cell a descriptor lies. They stand beside the descriptors' numbers
// in the tables of random grids, where those of a cell are read in a row, and tell of most
// descriptors of a cell that they are out of reach of a query, whose rows, which may lie anywhere
// in memory, are then never read.
//
// A sketch is 32 bits: for each of the leading hashed dimensions, up to 16, the quarter of the cell
// that holds the descriptor, the first dimension in the lowest two bits. Coordinates are those of
// CellHasher, in units of 1/256 cell.
#ifndef CAIRN_ENGINE_MATCHING_CELL_SKETCH_H_
#define CAIRN_ENGINE_MATCHING_CELL_SKETCH_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace cairn {

inline constexpr int kSketchDims = 16;
inline constexpr int kSketchPairs = kSketchDims / 2;
// Four bits of a sketch, two dimensions, have this many values.
inline constexpr int kSketchEntries = 16;

// For pair i of dimensions and each value of its four bits, the squared distance from a query to
// the middle of that part of a cell in these two dimensions, in squared units. A sketch's sum over
// the pairs estimates the squared distance of its descriptor in the hashed dimensions.
struct SketchTable {
  alignas(64) std::array<int32_t, kSketchPairs * kSketchEntries> sq_distances;
};

// The largest sum that speaks for a descriptor within a squared distance, in squared units, when
// `num_hashed_dims` are hashed: that squared distance, but not less than what a descriptor at
// distance 0 can have. On average a sum is larger than the squared distance in the hashed
// dimensions by the variance of a number within a quarter, a dimension; most of this the dimensions
// that are not hashed make good.
int32_t MaxSketchSum(double sq_distance, int num_hashed_dims);

// The tables of a query for its own cell in a grid and for those next to it.
class SketchTables {
 public:
  // coordinates: of the query, any integers; one a hashed dimension.
  void SetQuery(std::span<const int32_t> coordinates);

  // Of the cell across the nearer borders of the dimensions whose bits are set. Valid until the
  // next call.
  const SketchTable& Across(uint32_t crossed_dims);

  int num_pairs() const { return num_pairs_; }

 private:
  int num_pairs_ = 0;
  SketchTable own_;
  // What crossing a dimension's nearer border adds to the table of its pair; 0 for those not there.
  alignas(64) std::array<int32_t, kSketchDims * kSketchEntries> crossing_{};
  SketchTable across_;
};

// Variants of the loop over sketches. All give the same.
struct SketchKernels {
  const char* name;  // "plain", "avx2", "avx512".

  // The first num_pairs pairs of `table` count; bits of a sketch beyond them are not looked at.
  // Copies those of `count` items to `kept` whose sketch has a sum of at most `max_sum`, in order;
  // returns their number. `kept` has room for count + kSketchSlack items.
  size_t (*filter)(const SketchTable& table, int num_pairs, int32_t max_sum,
                   const uint32_t* sketches, const uint32_t* items, size_t count, uint32_t* kept);
};
inline constexpr size_t kSketchSlack = 16;

// The fastest variant this processor runs.
const SketchKernels& BestSketchKernels();

// Every variant this processor runs, the portable one first. For tests and benchmarks.
std::span<const SketchKernels* const> SupportedSketchKernels();

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_CELL_SKETCH_H_
