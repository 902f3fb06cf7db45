// Decides when the map is asked, and tracks the pending queries.
#ifndef CAIRN_FUSION_ESTIMATOR_QUERY_SCHEDULE_H_
#define CAIRN_FUSION_ESTIMATOR_QUERY_SCHEDULE_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "fusion/estimator/fusion_options.h"

namespace cairn::fusion {

// A query is pending from Ask until TakeFrame, Expire or Restart ends it. Ids are never reused. Not
// thread-safe.
class QuerySchedule {
 public:
  explicit QuerySchedule(const QueryOptions& options) : options_(options) {}

  // Returns whether a frame of this time may be queried: fewer than options.max_pending queries are
  // pending, and the last queried frame is at least options.min_interval_s older.
  bool IsDue(int64_t timestamp_ns) const;

  // Adds a query of a frame and returns the query's id.
  int64_t Ask(int64_t frame_id, int64_t timestamp_ns);

  // Ends a pending query whose answer has arrived and returns the query's frame. Returns nothing if
  // the query is not pending.
  std::optional<int64_t> TakeFrame(int64_t query_id);

  // Ends the queries whose frames are more than options.timeout_s old, and returns the frames.
  std::vector<int64_t> Expire(int64_t now_ns);

  // Returns whether the query is among the last 64 expired ones. Restart does not change these.
  bool HasExpired(int64_t query_id) const;

  // Returns whether a pending query belongs to this frame.
  bool HasFrame(int64_t frame_id) const;

  // Drops the pending queries. To be called when their frames no longer exist.
  void Restart();

 private:
  struct PendingQuery {
    int64_t query_id;
    int64_t frame_id;
    int64_t timestamp_ns;
  };

  QueryOptions options_;
  std::vector<PendingQuery> pending_;
  std::vector<int64_t> expired_;  // Oldest first.
  int64_t next_query_id_ = 1;
  std::optional<int64_t> last_query_ns_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_ESTIMATOR_QUERY_SCHEDULE_H_
