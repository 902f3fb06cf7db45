#include "engine/matching/hit_collector.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "core/check.h"

namespace cairn {

HitCollector::HitCollector(const ByteScale& scale, const SearchRequest& request)
    : sq_step_(scale.step() * scale.step()),
      receiver_(request.receiver),
      max_hits_(request.max_hits) {
  RequireQueryDim(request.queries, scale.dim());
  CAIRN_CHECK(request.max_distances.size() == static_cast<size_t>(request.queries.rows()),
              "every query has a distance");
  for (const double max_distance : request.max_distances) {
    max_sq_steps_.push_back(scale.MaxSqSteps(max_distance));
  }
  constexpr size_t kNever = std::numeric_limits<size_t>::max();
  // Room for as many hits again as are kept, and so many that compactions are rare.
  constexpr size_t kMinSpare = size_t{1} << 16;
  const size_t num_queries = std::max<size_t>(1, max_sq_steps_.size());
  compaction_size_ = max_hits_ > kNever / 4 / num_queries
                         ? kNever
                         : max_hits_ * num_queries + std::max(max_hits_ * num_queries, kMinSpare);
}

void HitCollector::HandOn(const Hit& hit) {
  const float max_sq_distance = receiver_->Take(
      {hit.query_idx, hit.descriptor_idx, static_cast<float>(hit.sq_steps) * sq_step_});
  // Rounded up: what is just useful passes.
  constexpr float kRounding = 1.0f + 1e-6f;
  const float max_sq_steps = max_sq_distance / sq_step_ * kRounding + 1.0f;
  int32_t& bound = max_sq_steps_[hit.query_idx];
  if (max_sq_steps < static_cast<float>(bound)) {
    bound = static_cast<int32_t>(max_sq_steps);
  }
}

void HitCollector::Compact() {
  // A counting sort by query.
  std::vector<size_t> begin(max_sq_steps_.size() + 1, 0);
  for (const Hit& hit : hits_) {
    ++begin[hit.query_idx + 1];
  }
  for (size_t query = 0; query < max_sq_steps_.size(); ++query) {
    begin[query + 1] += begin[query];
  }
  ordered_hits_.resize(hits_.size());
  std::vector<size_t> next(begin.begin(), begin.end() - 1);
  for (const Hit& hit : hits_) {
    ordered_hits_[next[hit.query_idx]++] = hit;
  }
  hits_.clear();
  for (size_t query = 0; query < max_sq_steps_.size(); ++query) {
    const auto first = ordered_hits_.begin() + static_cast<ptrdiff_t>(begin[query]);
    auto last = ordered_hits_.begin() + static_cast<ptrdiff_t>(begin[query + 1]);
    if (static_cast<size_t>(last - first) > max_hits_) {
      last = first + static_cast<ptrdiff_t>(max_hits_);
      std::partial_sort(
          first, last, ordered_hits_.begin() + static_cast<ptrdiff_t>(begin[query + 1]),
          [](const Hit& a, const Hit& b) {
            return std::tie(a.sq_steps, a.descriptor_idx) < std::tie(b.sq_steps, b.descriptor_idx);
          });
      max_sq_steps_[query] = max_hits_ == 0 ? -1 : (last - 1)->sq_steps;
    }
    hits_.insert(hits_.end(), first, last);
  }
}

void HitCollector::MoveTo(std::vector<DescriptorHit>* hits) {
  if (receiver_ != nullptr) {
    return;
  }
  Compact();
  hits->reserve(hits->size() + hits_.size());
  for (const Hit& hit : hits_) {
    hits->push_back(
        {hit.query_idx, hit.descriptor_idx, static_cast<float>(hit.sq_steps) * sq_step_});
  }
  hits_.clear();
}

}  // namespace cairn
