#include "engine/index/byte_descriptors.h"

#include <algorithm>

#include "core/check.h"
#include "engine/index/distance_kernels.h"

namespace cairn {
namespace {

// Number of rows that fit the level 1 cache while all queries are compared with them.
constexpr size_t kScanRows = 1024;

}  // namespace

ByteDescriptors::ByteDescriptors(const Codebook& codebook, std::span<const uint8_t> codes)
    : scale_(codebook),
      num_rows_(codes.size() / codebook.num_subspaces),
      rows_(scale_.ExpandCodes(codebook, codes)) {
  CAIRN_CHECK(codes.size() % codebook.num_subspaces == 0, "codes must be whole rows");
}

int64_t ByteDescriptors::Search(const SearchRequest& request,
                                std::vector<DescriptorHit>* hits) const {
  HitCollector collector(scale_, request);
  const DistanceKernels& kernels = BestDistanceKernels();
  const size_t stride = scale_.stride();
  const std::vector<int16_t> steps = scale_.QuantizeQueries(request.queries);
  std::vector<int32_t> sq_distances(std::min(kScanRows, num_rows_));
  std::vector<BlockHit> hits_of_query;
  size_t begin = 0;
  for (; begin < num_rows_ && !collector.ShouldStop(); begin += kScanRows) {
    const size_t count = std::min(kScanRows, num_rows_ - begin);
    for (uint32_t query = 0; query < request.queries.rows(); ++query) {
      kernels.scan(steps.data() + query * stride, rows_.data() + begin * stride, scale_.stride(),
                   count, sq_distances.data());
      const int32_t max_sq_steps = collector.max_sq_steps(query);
      hits_of_query.clear();
      for (size_t i = 0; i < count; ++i) {
        if (sq_distances[i] <= max_sq_steps) {
          hits_of_query.push_back({static_cast<uint32_t>(begin + i), sq_distances[i]});
        }
      }
      collector.Add(query, hits_of_query);
    }
  }
  collector.MoveTo(hits);
  return static_cast<int64_t>(std::min(begin, num_rows_)) * request.queries.rows();
}

void ByteDescriptors::RangeSearch(const DescriptorMatrix& queries, double max_distance,
                                  std::vector<DescriptorHit>* hits) const {
  const std::vector<double> max_distances(queries.rows(), max_distance);
  Search({queries, max_distances}, hits);
}

}  // namespace cairn
