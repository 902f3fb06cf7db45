#include "engine/index/product_words.h"

#include <algorithm>
#include <cmath>

namespace cairn {
namespace {

int FirstHalf(const ByteDescriptors& descriptors) { return (descriptors.scale().dim() + 1) / 2; }

}  // namespace

ProductWords::ProductWords(const ByteDescriptors& descriptors, int num_words, int num_iterations,
                           uint64_t seed)
    : first_(descriptors, {.first_dim = 0,
                           .num_dims = FirstHalf(descriptors),
                           .num_words = num_words,
                           .num_iterations = num_iterations,
                           .seed = seed}),
      second_(descriptors, {.first_dim = FirstHalf(descriptors),
                            .num_dims = descriptors.scale().dim() - FirstHalf(descriptors),
                            .num_words = num_words,
                            .num_iterations = num_iterations,
                            .seed = seed}) {}

std::vector<uint32_t> ProductWords::NearestCells(const ByteDescriptors& descriptors) const {
  std::vector<uint32_t> cells = first_.NearestWords(descriptors);
  const std::vector<uint32_t> seconds = second_.NearestWords(descriptors);
  for (size_t i = 0; i < cells.size(); ++i) {
    cells[i] = cells[i] * static_cast<uint32_t>(second_.size()) + seconds[i];
  }
  return cells;
}

std::vector<double> ProductWords::NearestDistances(const ByteScale& scale,
                                                   const DescriptorMatrix& queries) const {
  RequireQueryDim(queries, scale.dim());
  std::vector<double> distances(queries.rows(), 0.0);
  if (first_.size() == 0) {
    return distances;
  }
  const std::vector<int16_t> steps = scale.QuantizeQueries(queries);
  const BlockQueries first_queries = first_.Prepare(steps, scale.stride());
  const BlockQueries second_queries = second_.Prepare(steps, scale.stride());
  for (size_t query = 0; query < distances.size(); ++query) {
    const double sq_steps = static_cast<double>(first_.NearestSqDistance(first_queries[query])) +
                            second_.NearestSqDistance(second_queries[query]);
    distances[query] = scale.step() * std::sqrt(sq_steps);
  }
  return distances;
}

}  // namespace cairn
