// Carries queries of the filter to the server and its answers back, without ever making it wait.
//
//   MapTransport transport(options, [&](Answer answer) { client->Submit(std::move(answer)); });
//   if (auto query = client->PollQuery()) transport.Send({.query = *query, ...});
#ifndef CAIRN_FUSION_TRANSPORT_MAP_TRANSPORT_H_
#define CAIRN_FUSION_TRANSPORT_MAP_TRANSPORT_H_

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/geodesy.h"
#include "fusion/client/fusion_types.h"
#include "fusion/transport/map_messages.h"

namespace cairn::fusion {

struct MapTransportOptions {
  std::string url;  // "http://host:port".
  Geodetic
      global_origin;      // `global` is the east-north-up frame here; the same for a whole session.
  int timeout_ms = 3000;  // To connect, and for any silence of the server; then it is down.
  int max_matches = 300;  // Asked for in an answer.
  int max_queued = 2;     // Queries that wait while one is under way; later ones are refused.
  double min_interval_s = 0.2;  // Between queries that are accepted.
  // After failures in a row the pause doubles from the first to the last of these; a random part of
  // up to half of it is left out, so that clients of a server that comes back do not come at once.
  double first_backoff_s = 0.5;
  double max_backoff_s = 30.0;
  size_t max_response_bytes = size_t{4} << 20;
  uint64_t seed = 1;  // Of the jitter; give each device its own.
  // For tests; the default is std::chrono::steady_clock::now.
  std::function<std::chrono::steady_clock::time_point()> now;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

enum class SendStatus {
  kQueued,      // There will be exactly one callback.
  kQueueFull,   // max_queued wait already.
  kTooSoon,     // Within min_interval_s of the last one.
  kBackingOff,  // The server failed; not before the pause is over.
  kOutOfMemory,
};

// Since the construction.
struct MapTransportCounters {
  int64_t num_sent = 0;
  int64_t num_localized = 0;
  int64_t num_not_localized = 0;  // The server had no pose.
  int64_t num_unreachable = 0;    // No connection, or silence beyond the timeout.
  int64_t num_refused = 0;        // A status other than 200.
  int64_t num_garbled = 0;        // Status 200 with a body that is no answer, or is too long.
  int64_t num_bad_queries = 0;    // Features that cannot be encoded; never sent.
  int64_t num_bytes_sent = 0;     // Of bodies.
};

// One worker thread and one kept connection. Thread-safe. Nothing but the constructor throws.
class MapTransport {
 public:
  // Called from the worker thread, once for each accepted query, with an answer that is not
  // localized if anything failed: the filter then need not keep the frame. It must not throw.
  using Callback = std::function<void(Answer)>;

  // Connects when there is something to send. Throws Error(kInvalidArgument) as Validate.
  MapTransport(const MapTransportOptions& options, Callback on_answer);
  // Breaks off the exchange that is under way; queries that wait are answered as failed.
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
