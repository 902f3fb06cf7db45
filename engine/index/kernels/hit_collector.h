// What is asked of a matching index, and the hits it answers with.
#ifndef CAIRN_ENGINE_INDEX_KERNELS_HIT_COLLECTOR_H_
#define CAIRN_ENGINE_INDEX_KERNELS_HIT_COLLECTOR_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/features.h"
#include "core/stop_function.h"
#include "engine/index/kernels/block_kernels.h"
#include "engine/index/kernels/byte_scale.h"

namespace cairn {

// A landmark descriptor near a query descriptor.
struct DescriptorHit {
  uint32_t query_idx = 0;
  uint32_t descriptor_idx = 0;
  float sq_distance = 0.0f;  // In projected space.
};

// Hits of one query that were found together.
struct HitRun {
  uint32_t query_idx = 0;
  std::span<const BlockHit> hits;     // Rows: places in the index, see MatchingIndex::order.
  float sq_step = 0.0f;               // A squared distance of 1 in projected space.
  std::span<const uint32_t> order{};  // The index's.

  DescriptorHit operator[](size_t i) const {
    return {query_idx, order.empty() ? hits[i].row : order[hits[i].row], SqDistance(i)};
  }
  float SqDistance(size_t i) const { return static_cast<float>(hits[i].sq_distance) * sq_step; }
};

// Takes hits as they are found, in any order, some perhaps more than once.
class HitReceiver {
 public:
  virtual ~HitReceiver() = default;
  // Returns the squared distance, in projected space, beyond which further hits of this query are
  // of no use.
  virtual float Take(const HitRun& run) = 0;
};

class SharedVisits;

struct SearchRequest {
  const DescriptorMatrix& queries;        // n x dim, projected space.
  std::span<const double> max_distances;  // One a query, projected space; infinity is allowed.
  // If set, hits go to it instead of to the caller.
  HitReceiver* receiver = nullptr;
  // If set, the index may take visits from here that another tile of the query has computed.
  SharedVisits* shared_visits = nullptr;
  // Polled between batches; once it returns true, the search stops and returns the hits so far.
  StopFunction should_stop = {};
};

// Gathers the hits of a search in any order, or hands them on. For use within one thread.
class HitCollector {
 public:
  // `request` is only read here. Throws Error(kInternal) if the queries' dimension is not the
  // scale's.
  HitCollector(const ByteScale& scale, const SearchRequest& request);

  // A candidate with a larger squared distance, in steps, is no hit of the query. May fall while
  // hits arrive.
  int32_t max_sq_steps(uint32_t query_idx) const { return max_sq_steps_[query_idx]; }

  // Hits of one query, with squared distances in steps. `order` is the index's.
  void Add(uint32_t query_idx, std::span<const BlockHit> hits,
           std::span<const uint32_t> order = {});

  // See SearchRequest. A clock is not for every hit: ask it about ten times a millisecond.
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

#endif  // CAIRN_ENGINE_INDEX_KERNELS_HIT_COLLECTOR_H_
