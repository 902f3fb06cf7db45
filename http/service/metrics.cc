#include "http/service/metrics.h"

#include <fmt/format.h>

#include <cmath>

namespace cairn {
namespace {

constexpr double kFirstBoundSeconds = 0.25e-3;
constexpr char kOtherLabels[] = "(other)";  // No label of a key has parentheses.

void Describe(const char* name, const char* type, const char* help, std::string* text) {
  *text += fmt::format("# HELP {} {}\n# TYPE {} {}\n", name, help, name, type);
}

// The time is 0 for a stage that did not run: the query needed no refinement, or its turn came too
// late.
void AddIfRun(double seconds, DurationHistogram* histogram) {
  if (seconds > 0.0) {
    histogram->Add(seconds);
  }
}

void Single(const char* name, const char* type, const char* help, double value, std::string* text) {
  Describe(name, type, help, text);
  *text += fmt::format("{} {}\n", name, value);
}

void RenderCache(const CacheStats& cache, std::string* text) {
  Single("cairn_tile_cache_hits_total", "counter", "Tiles found in the cache.",
         static_cast<double>(cache.num_hits), text);
  Single("cairn_tile_cache_misses_total", "counter", "Tiles loaded from the map.",
         static_cast<double>(cache.num_misses), text);
  Single("cairn_tile_cache_evictions_total", "counter", "Tiles dropped to make room.",
         static_cast<double>(cache.num_evictions), text);
  Single("cairn_tile_cache_entries", "gauge", "Tiles in the cache.",
         static_cast<double>(cache.num_entries), text);
  Single("cairn_tile_cache_bytes", "gauge", "Bytes of the tiles in the cache.",
         static_cast<double>(cache.bytes), text);
  Single("cairn_tile_cache_max_bytes", "gauge", "Maximum size of the cache.",
         static_cast<double>(cache.max_bytes), text);
}

void RenderState(const ServerState& state, std::string* text) {
  Single("cairn_map_readable", "gauge", "1 if the map can be read, else 0.", state.head ? 1.0 : 0.0,
         text);
  if (state.head) {
    Single("cairn_map_version", "gauge", "Version of the map that queries use.",
           static_cast<double>(Value(state.head->version)), text);
    Single("cairn_map_stale", "gauge", "1 if PostgreSQL is silent, else 0.",
           state.head->is_stale ? 1.0 : 0.0, text);
  }
  if (state.head && state.head->created_unix_s) {
    Single("cairn_map_version_created_timestamp_seconds", "gauge",
           "Time at which that version was published, seconds since 1970.",
           *state.head->created_unix_s, text);
  }
  Single("cairn_map_degraded", "gauge", "1 if the served map is not the file at its path, else 0.",
         state.is_degraded ? 1.0 : 0.0, text);
  Single("cairn_draining", "gauge", "1 if the server drains, else 0.",
         state.is_draining ? 1.0 : 0.0, text);
  Single("cairn_queries_waiting", "gauge", "Queries that wait for a core.", state.num_waiting,
         text);
}

}  // namespace

double DurationHistogram::BoundSeconds(int bucket) {
  return std::ldexp(kFirstBoundSeconds, bucket);
}

void DurationHistogram::Add(double seconds) {
  int bucket = 0;
  while (bucket < kNumBounds && seconds > BoundSeconds(bucket)) {
    ++bucket;
  }
  ++counts_[bucket];
  sum_seconds_ += seconds;
}

void DurationHistogram::Render(const std::string& name, const std::string& labels,
                               std::string* text) const {
  const std::string separator = labels.empty() ? "" : ",";
  uint64_t cumulative = 0;
  for (int bucket = 0; bucket <= kNumBounds; ++bucket) {
    cumulative += counts_[bucket];
    const std::string bound =
        bucket == kNumBounds ? "+Inf" : fmt::format("{}", BoundSeconds(bucket));
    *text +=
        fmt::format("{}_bucket{{{}{}le=\"{}\"}} {}\n", name, labels, separator, bound, cumulative);
  }
  const std::string braces = labels.empty() ? "" : fmt::format("{{{}}}", labels);
  *text += fmt::format("{}_sum{} {}\n{}_count{} {}\n", name, braces, sum_seconds_, name, braces,
                       cumulative);
}

void Metrics::CountRequest(const std::string& route, int status, double seconds) {
  const std::lock_guard lock(mutex_);
  ++requests_[{route, status}];
  request_seconds_[route].Add(seconds);
}

void Metrics::CountClient(const std::string& label, int status) {
  const std::lock_guard lock(mutex_);
  const bool is_new = !client_requests_.contains(label);
  const bool is_full = client_requests_.size() >= kMaxLabels;
  ++client_requests_[is_new && is_full ? kOtherLabels : label][status];
}

void Metrics::KeepClients(const std::set<std::string>& labels) {
  const std::lock_guard lock(mutex_);
  std::erase_if(client_requests_, [&](const auto& entry) {
    return entry.first != kOtherLabels && !labels.contains(entry.first);
  });
}

uint64_t Metrics::num_requests() const {
  const std::lock_guard lock(mutex_);
  uint64_t sum = 0;
  for (const auto& [route_and_status, count] : requests_) {
    sum += count;
  }
  return sum;
}

void Metrics::CountLocalize(const LocalizeResult& result, const ServerTimes& times, bool is_stale) {
  const std::lock_guard lock(mutex_);
  ++localize_outcomes_[result.localized ? "LOCALIZED" : NotLocalizedReasonName(result.reason)];
  for (int i = 0; i < kNumStages; ++i) {
    AddIfRun(result.times.seconds[i], &stage_seconds_[i]);
  }
  AddIfRun(times.decode_seconds + times.extract_seconds, &extraction_seconds_);
  if (result.counters.num_tiles_loaded > 0) {
    fetch_seconds_.Add(result.times.seconds[static_cast<size_t>(Stage::kTiles)]);
  }
  num_stale_answers_ += is_stale ? 1 : 0;
}

void Metrics::CountError(ErrorCode code) {
  const std::lock_guard lock(mutex_);
  if (const auto found = store_errors_.find(code); found != store_errors_.end()) {
    ++found->second;
  }
}

void Metrics::RenderStore(std::string* text) const {
  Describe("cairn_fetch_seconds", "histogram",
           "Time to fetch the tiles of a query, of queries that load tiles.", text);
  fetch_seconds_.Render("cairn_fetch_seconds", "", text);
  Describe("cairn_store_errors_total", "counter",
           "Requests that failed because the map could not be read.", text);
  for (const auto& [code, count] : store_errors_) {
    *text +=
        fmt::format("cairn_store_errors_total{{code=\"{}\"}} {}\n", ErrorCodeName(code), count);
  }
  Single("cairn_stale_answers_total", "counter", "Answers from a map that may be out of date.",
         static_cast<double>(num_stale_answers_), text);
}

void Metrics::RenderRequests(std::string* text) const {
  Describe("cairn_http_requests_total", "counter", "Requests by route and status.", text);
  for (const auto& [key, count] : requests_) {
    *text += fmt::format("cairn_http_requests_total{{route=\"{}\",status=\"{}\"}} {}\n", key.first,
                         key.second, count);
  }
  Describe("cairn_client_requests_total", "counter",
           "Requests with a known API key, by the label of the key and status.", text);
  for (const auto& [label, counts] : client_requests_) {
    for (const auto& [status, count] : counts) {
      *text += fmt::format("cairn_client_requests_total{{label=\"{}\",status=\"{}\"}} {}\n", label,
                           status, count);
    }
  }
  Describe("cairn_http_request_seconds", "histogram",
           "Time from the last byte of a request to its response.", text);
  for (const auto& [route, histogram] : request_seconds_) {
    histogram.Render("cairn_http_request_seconds", fmt::format("route=\"{}\"", route), text);
  }
}

std::string Metrics::Render(const ServerState& state) const {
  std::string text;
  const std::lock_guard lock(mutex_);
  RenderRequests(&text);
  Describe("cairn_localize_total", "counter", "Queries by outcome.", &text);
  for (const auto& [outcome, count] : localize_outcomes_) {
    text += fmt::format("cairn_localize_total{{outcome=\"{}\"}} {}\n", outcome, count);
  }
  Describe("cairn_stage_seconds", "histogram", "Time of each stage of a query.", &text);
  for (int i = 0; i < kNumStages; ++i) {
    stage_seconds_[i].Render("cairn_stage_seconds",
                             fmt::format("stage=\"{}\"", StageName(static_cast<Stage>(i))), &text);
  }
  extraction_seconds_.Render("cairn_stage_seconds", "stage=\"extraction\"", &text);
  RenderStore(&text);
  RenderCache(state.cache, &text);
  RenderState(state, &text);
  return text;
}

}  // namespace cairn
