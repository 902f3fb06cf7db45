#include "engine/index/hit_collector.h"

#include <numeric>

#include "core/check.h"

namespace cairn {

HitCollector::HitCollector(const ByteScale& scale, const SearchRequest& request)
    : sq_step_(scale.step() * scale.step()),
      receiver_(request.receiver),
      should_stop_(request.should_stop) {
  RequireQueryDim(request.queries, scale.dim());
  CAIRN_CHECK(request.max_distances.size() == static_cast<size_t>(request.queries.rows()),
              "every query has a distance");
  for (const double max_distance : request.max_distances) {
    max_sq_steps_.push_back(scale.MaxSqSteps(max_distance));
  }
}

void HitCollector::Add(uint32_t query_idx, std::span<const BlockHit> hits,
                       std::span<const uint32_t> order) {
  if (hits.empty()) {
    return;
  }
  const HitRun run = {query_idx, hits, sq_step_, order};
  if (receiver_ != nullptr) {
    HandOn(run);
    return;
  }
  for (size_t i = 0; i < hits.size(); ++i) {
    hits_.push_back(run[i]);
  }
}

void HitCollector::HandOn(const HitRun& run) {
  const float max_sq_distance = receiver_->Take(run);
  // Rounded up, so that a hit exactly at the bound passes.
  constexpr float kRounding = 1.0f + 1e-6f;
  const float max_sq_steps = max_sq_distance / sq_step_ * kRounding + 1.0f;
  int32_t& bound = max_sq_steps_[run.query_idx];
  if (max_sq_steps < static_cast<float>(bound)) {
    bound = static_cast<int32_t>(max_sq_steps);
  }
}

void HitCollector::MoveTo(std::vector<DescriptorHit>* hits) const {
  if (receiver_ != nullptr) {
    return;
  }
  // A counting sort by query.
  std::vector<size_t> next(max_sq_steps_.size() + 1, 0);
  next[0] = hits->size();
  for (const DescriptorHit& hit : hits_) {
    ++next[hit.query_idx + 1];
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  hits->resize(hits->size() + hits_.size());
  for (const DescriptorHit& hit : hits_) {
    (*hits)[next[hit.query_idx]++] = hit;
  }
}

}  // namespace cairn
