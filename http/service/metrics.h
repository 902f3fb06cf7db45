// Counters of a running server, in the text format of Prometheus.
#ifndef CAIRN_HTTP_SERVICE_METRICS_H_
#define CAIRN_HTTP_SERVICE_METRICS_H_

#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/loading_cache.h"
#include "engine/query/localize_result.h"
#include "http/json/localize_response.h"

namespace cairn {

// A histogram of durations. The bucket bounds double from 0.25 ms to 4 s; the last bucket is
// unbounded.
class DurationHistogram {
 public:
  static constexpr int kNumBounds = 15;
  static double BoundSeconds(int bucket);  // 0.25 ms * 2^bucket.

  void Add(double seconds);
  // Appends the lines `name_bucket{labels,le="..."} n`, `name_sum` and `name_count`. `labels` may
  // be empty.
  void Render(const std::string& name, const std::string& labels, std::string* text) const;

 private:
  std::array<uint64_t, kNumBounds + 1> counts_{};
  double sum_seconds_ = 0.0;
};

// The state of the server at the time of a scrape.
struct ServerState {
  CacheStats cache;
  // The latest version of the map.
  struct Head {
    MapVersion version{};
    std::optional<double> created_unix_s;  // Time of publication, seconds since 1970, if known.
    bool is_stale = false;                 // PostgreSQL is silent, so there may be a newer version.
  };
  std::optional<Head> head;  // Nothing if the map cannot be read.
  bool is_degraded = false;  // See ServedMaps::Problem.
  bool is_draining = false;
  int num_waiting = 0;  // Queries that wait for a core.
};

// Safe to call from any thread.
class Metrics {
 public:
  // `route` is the pattern of the route, or empty for requests that reached no route. The client's
  // path would make the number of series unbounded.
  void CountRequest(const std::string& route, int status, double seconds);
  // `label` is that of the request's API key. Labels beyond the first kMaxLabels share one series.
  void CountClient(const std::string& label, int status);
  static constexpr size_t kMaxLabels = 256;
  // Forgets the series of all other labels. Otherwise keys that were replaced would keep the room
  // of their successors.
  void KeepClients(const std::set<std::string>& labels);
  uint64_t num_requests() const;  // Counted so far.
  // Stages that did not run add nothing to the histograms. `is_stale` says that the answer is from
  // a map that may be out of date.
  void CountLocalize(const LocalizeResult& result, const ServerTimes& times, bool is_stale);
  // Counts a request that failed with the error, if reading the map caused the error.
  void CountError(ErrorCode code);

  std::string Render(const ServerState& state) const;

 private:
  void RenderRequests(std::string* text) const;
  void RenderStore(std::string* text) const;

  mutable std::mutex mutex_;
  std::map<std::pair<std::string, int>, uint64_t> requests_;
  std::map<std::string, DurationHistogram> request_seconds_;
  std::map<std::string, std::map<int, uint64_t>> client_requests_;  // By label and status.
  std::map<std::string, uint64_t> localize_outcomes_;
  std::array<DurationHistogram, kNumStages> stage_seconds_;
  DurationHistogram extraction_seconds_;
  DurationHistogram fetch_seconds_;
  uint64_t num_stale_answers_ = 0;
  std::map<ErrorCode, uint64_t> store_errors_ = {
      {ErrorCode::kIo, 0}, {ErrorCode::kMapDamaged, 0}, {ErrorCode::kUnavailable, 0}};
};

}  // namespace cairn

#endif  // CAIRN_HTTP_SERVICE_METRICS_H_
