// The request to a matching index, and the hits that the index returns.
#ifndef CAIRN_ENGINE_INDEX_HIT_COLLECTOR_H_
#define CAIRN_ENGINE_INDEX_HIT_COLLECTOR_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/features.h"
#include "core/stop_function.h"
#include "engine/index/block_kernels.h"
#include "engine/index/byte_scale.h"

namespace cairn {

// A descriptor of the map near a query descriptor.
struct DescriptorHit {
  uint32_t query_idx = 0;
  uint32_t descriptor_idx = 0;
  float sq_distance = 0.0f;  // In projected space.
};

// Hits of one query that were found together.
struct HitRun {
  uint32_t query_idx = 0;
  // `row` of a hit is a place in the index; see MatchingIndex::order.
  std::span<const BlockHit> hits;
  float sq_step = 0.0f;               // Converts squared distances in steps to projected space.
  std::span<const uint32_t> order{};  // MatchingIndex::order of the index.

  DescriptorHit operator[](size_t i) const {
    return {query_idx, order.empty() ? hits[i].row : order[hits[i].row], SqDistance(i)};
  }
  float SqDistance(size_t i) const { return static_cast<float>(hits[i].sq_distance) * sq_step; }
};

// Receives hits as the search finds them, in any order and possibly repeated.
class HitReceiver {
 public:
  virtual ~HitReceiver() = default;
  // Returns the squared distance, in projected space, beyond which further hits of this query are
  // useless.
  virtual float Take(const HitRun& run) = 0;
};

class SharedVisits;

struct SearchRequest {
  const DescriptorMatrix& queries;        // n x dim, projected space.
  std::span<const double> max_distances;  // One per query, projected space; may be infinity.
  // If set, hits go to `receiver` instead of the caller's vector.
  HitReceiver* receiver = nullptr;
  // If set, the index may reuse visits that were computed for another tile of the same query.
  SharedVisits* shared_visits = nullptr;
  // Polled between batches; once it returns true, the search stops and returns the hits so far.
  StopFunction should_stop = {};
};

// Gathers the hits of a search in any order, or passes them to the receiver. Use each collector
// from one thread.
class HitCollector {
 public:
  // Does not keep a reference to `request`. Throws Error(kInternal) if the dimensions of the
  // queries and of the scale differ.
  HitCollector(const ByteScale& scale, const SearchRequest& request);

  // A candidate with a larger squared distance, in steps, is not a hit of the query. The bound may
  // fall while hits arrive.
  int32_t max_sq_steps(uint32_t query_idx) const { return max_sq_steps_[query_idx]; }

  // Adds hits of one query with squared distances in steps. `order` is the index's.
  void Add(uint32_t query_idx, std::span<const BlockHit> hits,
           std::span<const uint32_t> order = {});

  // Polls SearchRequest::should_stop. Reading the clock for every hit would be slow; poll about ten
  // times per millisecond.
  bool ShouldStop() const { return should_stop_ && should_stop_(); }

  // Appends the hits to `hits`, ordered by query, then in the order in which they were added.
  void MoveTo(std::vector<DescriptorHit>* hits) const;

 private:
  void HandOn(const HitRun& run);

  float sq_step_;
  HitReceiver* receiver_;
  StopFunction should_stop_;
  std::vector<int32_t> max_sq_steps_;
  std::vector<DescriptorHit> hits_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_HIT_COLLECTOR_H_
