#include "fusion/transport/map_transport.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <string_view>
#include <thread>
#include <utility>

#include "core/cell_name.h"
#include "core/random.h"
#include "core/require.h"
#include "core/wire/wire_request.h"
#include "http/exchange/bounded_client.h"
#include "http/exchange/server_url.h"

namespace cairn::fusion {
namespace {

using Clock = std::chrono::steady_clock;

Clock::duration Seconds(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

Answer Failed(const MapQuery& query) {
  Answer answer;
  answer.query_id = query.request.query_id;
  return answer;
}

// Statuses that ask the client to try again later, as opposed to never.
bool IsOverload(int status) { return status == 408 || status == 429 || status >= 500; }

// The key is missing, unknown, or has not the right. The operator may mend that.
bool IsUnauthorized(int status) { return status == 401 || status == 403; }

}  // namespace

void MapTransportOptions::Validate() const {
  ParseServerUrl(url);
  ValidateGeodetic(global_origin, "global_origin");
  RequireOption(timeout_ms > 0, "map_transport.timeout_ms must be positive");
  RequireOption(max_matches > 0, "map_transport.max_matches must be positive");
  RequireOption(max_queued > 0, "map_transport.max_queued must be positive");
  RequireOption(min_interval_s >= 0.0, "map_transport.min_interval_s must not be negative");
  RequireOption(first_backoff_s > 0.0 && max_backoff_s >= first_backoff_s,
                "map_transport.first_backoff_s must be positive and at most max_backoff_s");
  RequireOption(max_response_bytes > 0, "map_transport.max_response_bytes must be positive");
}

struct MapTransport::Impl {
  Impl(const MapTransportOptions& transport_options, Callback callback)
      : options(transport_options),
        on_answer(std::move(callback)),
        http({.url = transport_options.url,
              .ca_file = transport_options.ca_file,
              .api_key = transport_options.api_key,
              .allow_plain_key = transport_options.allow_plain_key,
              .timeout_ms = transport_options.timeout_ms,
              .max_body_bytes = transport_options.max_response_bytes}),
        random(transport_options.seed) {
    if (!options.now) {
      options.now = [] { return Clock::now(); };
    }
    worker = std::thread([this] { Work(); });
  }

  ~Impl() {
    {
      const std::lock_guard lock(mutex);
      stopping = true;
    }
    wake.notify_all();
    http.Stop();
    worker.join();
  }

  SendStatus Send(MapQuery query) {
    {
      const std::lock_guard lock(mutex);
      const Clock::time_point now = options.now();
      if (now < closed_until) {
        return SendStatus::kBackingOff;
      }
      if (last_accepted && now < *last_accepted + Seconds(options.min_interval_s)) {
        return SendStatus::kTooSoon;
      }
      if (static_cast<int>(queue.size()) >= options.max_queued) {
        return SendStatus::kQueueFull;
      }
      queue.push_back(std::move(query));
      last_accepted = now;
    }
    wake.notify_all();
    return SendStatus::kQueued;
  }

  void Work() {
    while (true) {
      MapQuery query;
      bool stop;
      {
        std::unique_lock lock(mutex);
        wake.wait(lock, [&] { return stopping || !queue.empty(); });
        if (queue.empty()) {
          return;
        }
        query = std::move(queue.front());
        queue.pop_front();
        stop = stopping;
      }
      on_answer(stop ? Failed(query) : Ask(query));
    }
  }

  // Never throws: any failure becomes a failed answer.
  Answer Ask(const MapQuery& query) noexcept {
    try {
      return Exchange(query);
    } catch (const std::exception&) {  // The features do not encode, or memory ran out.
      Count(&MapTransportCounters::num_bad_queries);
      return Failed(query);
    }
  }

  Answer Exchange(const MapQuery& query) {
    MapRequest message =
        MakeMapRequest(query, options.global_origin, std::min(options.timeout_ms, kMaxTimeoutMs),
                       options.max_matches);
    ClientRequest request{.method = "POST",
                          .path = "/v1/localize",
                          .headers = {{"Content-Type", message.content_type}},
                          .body = std::move(message.body)};
    if (const std::string& cell = message.cell.empty() ? last_cell : message.cell; !cell.empty()) {
      request.headers.emplace_back(kCellHeader, cell);
    }
    Count(&MapTransportCounters::num_sent);
    Count(&MapTransportCounters::num_bytes_sent, static_cast<int64_t>(request.body.size()));
    const ClientResponse response = SendTwiceIfStale(request);
    if (response.status == 0) {
      return Fail(query,
                  response.is_garbled ? &MapTransportCounters::num_garbled
                                      : &MapTransportCounters::num_unreachable,
                  /*back_off=*/true);
    }
    if (response.status != 200) {
      return Refused(query, response);
    }
    if (std::string cell = response.Header(kCellHeader); IsCellName(cell)) {
      last_cell = std::move(cell);
    }
    auto answer = ReadMapAnswer(response.body, query, options.global_origin, options.max_matches);
    if (!answer) {
      return Fail(query, &MapTransportCounters::num_garbled, /*back_off=*/true);
    }
    Count(answer->localized ? &MapTransportCounters::num_localized
                            : &MapTransportCounters::num_not_localized);
    Reopen();
    return std::move(*answer);
  }

  // The server may close an idle connection just as the next request is sent. If a request on a
  // kept connection fails, it is sent once more on a new connection, unless time was over.
  ClientResponse SendTwiceIfStale(const ClientRequest& request) {
    const Clock::time_point start = Clock::now();
    ClientResponse response = http.Send(request);
    const bool had_connection = std::exchange(is_connected, response.status != 0);
    const bool has_time = Clock::now() - start < std::chrono::milliseconds(options.timeout_ms) / 2;
    if (response.status == 0 && !response.is_garbled && had_connection && has_time &&
        !IsStopping()) {
      response = http.Send(request);
      is_connected = response.status != 0;
    }
    return response;
  }

  Answer Refused(const MapQuery& query, const ClientResponse& response) {
    const bool is_unauthorized = IsUnauthorized(response.status);
    if (is_unauthorized) {
      Count(&MapTransportCounters::num_unauthorized);
    }
    Answer answer = Fail(query, &MapTransportCounters::num_refused,
                         is_unauthorized || IsOverload(response.status));
    if (const auto pause = response.RetryAfter()) {
      const std::lock_guard lock(mutex);
      const double pause_s = std::min(static_cast<double>(pause->count()), options.max_backoff_s);
      closed_until = std::max(closed_until, options.now() + Seconds(pause_s));
    }
    return answer;
  }

  Answer Fail(const MapQuery& query, int64_t MapTransportCounters::*counter, bool back_off) {
    Count(counter);
    if (back_off) {
      const std::lock_guard lock(mutex);
      const double pause_s =
          std::min(options.max_backoff_s, options.first_backoff_s * std::exp2(num_failures));
      num_failures = std::min(num_failures + 1, 60);
      const double share = 0.5 + 0.5 * random.Fraction();
      closed_until = options.now() + Seconds(pause_s * share);
    }
    return Failed(query);
  }

  void Reopen() {
    const std::lock_guard lock(mutex);
    num_failures = 0;
  }

  bool IsStopping() {
    const std::lock_guard lock(mutex);
    return stopping;
  }

  void Count(int64_t MapTransportCounters::*counter, int64_t by = 1) {
    const std::lock_guard lock(mutex);
    counters.*counter += by;
  }

  MapTransportOptions options;
  Callback on_answer;
  BoundedClient http;
  // Used by the worker only.
  bool is_connected = false;  // The last exchange succeeded.
  std::string last_cell;      // That the server named last; for queries without a prior.

  std::mutex mutex;  // Guards the members below.
  std::condition_variable wake;
  std::deque<MapQuery> queue;
  bool stopping = false;
  Clock::time_point closed_until = Clock::time_point::min();
  std::optional<Clock::time_point> last_accepted;
  int num_failures = 0;  // Consecutive failures.
  Random random;
  MapTransportCounters counters;

  std::thread worker;  // Last member, because the thread uses all others.
};

MapTransport::MapTransport(const MapTransportOptions& options, Callback on_answer) {
  options.Validate();
  impl_ = std::make_unique<Impl>(options, std::move(on_answer));
}

MapTransport::~MapTransport() = default;

SendStatus MapTransport::Send(MapQuery query) noexcept {
  try {
    return impl_->Send(std::move(query));
  } catch (const std::exception&) {
    return SendStatus::kOutOfMemory;
  }
}

MapTransportCounters MapTransport::counters() const noexcept {
  const std::lock_guard lock(impl_->mutex);
  return impl_->counters;
}

}  // namespace cairn::fusion
