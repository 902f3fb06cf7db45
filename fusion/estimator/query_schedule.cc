#include "fusion/estimator/query_schedule.h"

#include <algorithm>

#include "core/inertial/imu_time.h"

namespace cairn::fusion {
namespace {

constexpr size_t kMaxExpired = 64;

}  // namespace

bool QuerySchedule::IsDue(int64_t timestamp_ns) const {
  return pending_.size() < static_cast<size_t>(options_.max_pending) &&
         (!last_query_ns_ || ToSeconds(timestamp_ns - *last_query_ns_) >= options_.min_interval_s);
}

int64_t QuerySchedule::Ask(int64_t frame_id, int64_t timestamp_ns) {
  pending_.push_back({next_query_id_, frame_id, timestamp_ns});
  last_query_ns_ = timestamp_ns;
  return next_query_id_++;
}

std::optional<int64_t> QuerySchedule::TakeFrame(int64_t query_id) {
  const auto query = std::find_if(
      pending_.begin(), pending_.end(),
      [query_id](const PendingQuery& pending) { return pending.query_id == query_id; });
  if (query == pending_.end()) {
    return std::nullopt;
  }
  const int64_t frame_id = query->frame_id;
  pending_.erase(query);
  return frame_id;
}

std::vector<int64_t> QuerySchedule::Expire(int64_t now_ns) {
  std::vector<int64_t> frame_ids;
  std::erase_if(pending_, [&](const PendingQuery& query) {
    if (ToSeconds(now_ns - query.timestamp_ns) <= options_.timeout_s) {
      return false;
    }
    frame_ids.push_back(query.frame_id);
    expired_.push_back(query.query_id);
    return true;
  });
  if (expired_.size() > kMaxExpired) {
    expired_.erase(expired_.begin(), expired_.end() - kMaxExpired);
  }
  return frame_ids;
}

bool QuerySchedule::HasExpired(int64_t query_id) const {
  return std::find(expired_.begin(), expired_.end(), query_id) != expired_.end();
}

bool QuerySchedule::HasFrame(int64_t frame_id) const {
  return std::any_of(pending_.begin(), pending_.end(),
                     [frame_id](const PendingQuery& query) { return query.frame_id == frame_id; });
}

void QuerySchedule::Restart() {
  pending_.clear();
  last_query_ns_.reset();
}

}  // namespace cairn::fusion
