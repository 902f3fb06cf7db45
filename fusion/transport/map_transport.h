// Sends the filter's queries to the server and delivers the answers. The filter never waits.
//
//   MapTransport transport(options, [&](Answer answer) { client->Submit(std::move(answer)); });
//   if (auto query = client->PollQuery()) transport.Send({.request = *query, ...});
#ifndef CAIRN_FUSION_TRANSPORT_MAP_TRANSPORT_H_
#define CAIRN_FUSION_TRANSPORT_MAP_TRANSPORT_H_

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/geodesy.h"
#include "fusion/estimator/fusion_types.h"
#include "fusion/transport/map_messages.h"

namespace cairn::fusion {

struct MapTransportOptions {
  std::string url;           // As BoundedClientOptions::url.
  std::string ca_file = {};  // PEM file of the certificates to trust; empty: those of the system.
  // API key for the server; empty: none. It goes over plain http to this machine only, unless
  // allow_plain_key is set: everybody on the way could read it.
  std::string api_key = {};
  bool allow_plain_key = false;
  // `global` is the east-north-up frame at this point. The point must not change in a session.
  Geodetic global_origin;
  // Limit on the whole exchange of a query. After it, the server counts as unreachable.
  int timeout_ms = 3000;
  int max_matches = 300;        // Most matches the server is asked for.
  int max_queued = 2;           // Queries that wait while one is under way; more are refused.
  double min_interval_s = 0.2;  // Shortest time between two accepted queries.
  // Pause after a failure, which includes 401 and 403. It doubles with each consecutive failure,
  // from first_backoff_s up to max_backoff_s. A random part of up to half of the pause is left out,
  // so that the clients of a recovered server do not all return at once.
  double first_backoff_s = 0.5;
  double max_backoff_s = 30.0;
  size_t max_response_bytes = size_t{4} << 20;
  uint64_t seed = 1;  // Seed of the jitter; give each device its own.
  // For tests. The default is std::chrono::steady_clock::now.
  std::function<std::chrono::steady_clock::time_point()> now;

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

enum class SendStatus {
  kQueued,      // Exactly one callback will follow.
  kQueueFull,   // max_queued queries are waiting.
  kTooSoon,     // Within min_interval_s of the last accepted query.
  kBackingOff,  // The server failed; the pause is not over.
  kOutOfMemory,
};

// Totals since construction.
struct MapTransportCounters {
  int64_t num_sent = 0;
  int64_t num_localized = 0;
  int64_t num_not_localized = 0;  // The server had no pose.
  int64_t num_unreachable = 0;    // No connection, or no complete response in time.
  int64_t num_refused = 0;        // A status other than 200.
  int64_t num_unauthorized = 0;   // Of these, 401 and 403: the key is missing, unknown or too weak.
  int64_t num_garbled = 0;        // Not HTTP, too long, or status 200 without an answer.
  int64_t num_bad_queries = 0;    // Features that cannot be encoded; never sent.
  int64_t num_bytes_sent = 0;     // Total size of the request bodies.
};

// Runs one worker thread and keeps one connection. Thread-safe. Only the constructor throws.
class MapTransport {
 public:
  // Called from the worker thread exactly once for each accepted query. If anything failed, the
  // answer is not localized, so that the filter can release the frame. The callback must not throw.
  using Callback = std::function<void(Answer)>;

  // The connection opens with the first query. Throws the Error(kInvalidArgument) of Validate, and
  // Error(kIo) if the file of certificates cannot be read.
  MapTransport(const MapTransportOptions& options, Callback on_answer);
  // Aborts the current exchange. Queries that wait are answered as failed.
  ~MapTransport();

  // Returns at once.
  SendStatus Send(MapQuery query) noexcept;

  MapTransportCounters counters() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_TRANSPORT_MAP_TRANSPORT_H_
