#include "http/net/listener.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <new>
#include <optional>
#include <random>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "core/log_limiter.h"
#include "core/logging.h"
#include "core/memory_reserve.h"
#include "http/net/response_text.h"
#include "http/net/socket.h"
#include "http/net/url.h"

namespace cairn {
namespace {

constexpr size_t kMaxRequestIdLength = 64;

// Made before any request exists, hence without a request id.
ResponseText OutOfMemoryText() {
  const HttpError error(ProblemCode::kUnavailable, "the server is out of memory");
  return SerializeResponse({.status = InfoOf(error.problem()).status,
                            .content_type = "application/problem+json",
                            .body = ProblemJson(error, ""),
                            .headers = {}},
                           /*is_head=*/false, /*keep_alive=*/std::nullopt);
}

// Ids are unique within a run and, because of the random start, across runs.
class RequestIds {
 public:
  RequestIds() {
    std::random_device device;
    start_ = uint64_t{device()} << 32 | device();
  }
  std::string Next() {
    return fmt::format("{:016x}", start_ + next_.fetch_add(1, std::memory_order_relaxed));
  }

 private:
  uint64_t start_;
  std::atomic<uint64_t> next_{0};
};

bool IsUsableRequestId(std::string_view id) {
  return !id.empty() && id.size() <= kMaxRequestIdLength &&
         std::all_of(id.begin(), id.end(), [](char c) {
           return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' || c == '.';
         });
}

// Returns the client's address and number, from the peer or from what a trusted front says.
Peer ClientOf(const Peer& peer, const RequestHead& head, const TrustedFronts& fronts) {
  if (fronts.empty()) {
    return peer;
  }
  std::string chain;  // Several headers are one list (RFC 9110 section 5.3).
  for (const auto& [name, value] : head.headers) {
    if (name == "x-forwarded-for") {
      chain += "," + value;
    }
  }
  const std::string address = ForwardedClient(peer.address, chain, fronts);
  const std::optional<uint64_t> network = NetworkOfAddress(address);
  return network ? Peer{.address = address, .network = *network} : peer;
}

// `target` is that of the head.
HttpRequest ToRequest(ReceivedRequest received, Target target, const Peer& peer,
                      const TrustedFronts& fronts, std::string request_id) {
  const std::string_view client_id = received.head.Header("x-request-id");
  if (IsUsableRequestId(client_id)) {
    request_id = client_id;
  }
  Peer client = ClientOf(peer, received.head, fronts);
  HttpRequest request{.method = std::move(received.head.method),
                      .path = std::move(target.path),
                      .query = std::move(target.query),
                      .headers = {},
                      .body = std::move(received.body),
                      .remote_address = std::move(client.address),
                      .client = client.network,
                      .request_id = std::move(request_id),
                      .arrival = received.arrival};
  for (auto& [name, value] : received.head.headers) {
    request.headers.emplace(std::move(name), std::move(value));
  }
  return request;
}

// Leaves half of the files to handlers.
LoopLimits WithinOpenFiles(LoopLimits limits) {
  rlimit files{};
  if (getrlimit(RLIMIT_NOFILE, &files) != 0 || files.rlim_cur == RLIM_INFINITY) {
    return limits;
  }
  const auto half = static_cast<int64_t>(std::min<rlim_t>(files.rlim_cur, 1 << 20) / 2);
  if (half < limits.max_connections) {
    LogWarning("the process may open only {} files, so the server accepts at most {} connections",
               files.rlim_cur, half);
    limits.max_connections = static_cast<int>(std::max<int64_t>(half, 1));
  }
  return limits;
}

}  // namespace

struct Listener::Impl {
  const ListenerOptions options;
  RequestHandler* const handler;
  RequestIds request_ids;
  const ResponseText out_of_memory = OutOfMemoryText();
  LogLimiter memory_failures;
  std::atomic<bool> closes_connections{false};  // After the response.
  int port = 0;
  std::optional<EventLoop> loop;  // Created by Start.
  std::vector<std::thread> threads;

  Impl(const ListenerOptions& listener_options, RequestHandler* request_handler)
      : options(listener_options), handler(request_handler) {}

  ResponseText Refusal(const Peer& peer, const RequestHead& head, const HttpError& error) {
    const RefusedRequest refused{
        .request_id = request_ids.Next(),
        .remote_address = ClientOf(peer, head, options.trusted_fronts).address,
        .method = head.method,
        .target = head.target,
        .headers = head.headers};
    return SerializeResponse(handler->Refuse(error, refused), /*is_head=*/false,
                             /*keep_alive=*/std::nullopt);
  }

  void Work() {
    while (std::optional<RequestJob> job = loop->Next()) {
      bool keep_alive = job->request.head.keep_alive;
      ResponseText text = AnswerText(*job->connection, std::move(job->request), &keep_alive);
      job->connection->Respond(std::move(text), keep_alive);
      loop->TakeBack(job->connection);
    }
  }

  ResponseText AnswerText(const Connection& connection, ReceivedRequest received,
                          bool* keep_alive) {
    const bool is_head = received.head.method == "HEAD";
    try {
      std::optional<Target> target = ParseTarget(received.head.target);
      if (!target) {
        *keep_alive = false;
        return Refusal(
            connection.peer(), received.head,
            HttpError(ProblemCode::kBadRequest, "the target has a malformed percent escape"));
      }
      HttpResponse response =
          handler->Handle(ToRequest(std::move(received), std::move(*target), connection.peer(),
                                    options.trusted_fronts, request_ids.Next()));
      *keep_alive = *keep_alive && !closes_connections;
      return SerializeResponse(
          std::move(response), is_head,
          *keep_alive ? std::optional(options.connection.idle_timeout) : std::nullopt);
    } catch (const std::bad_alloc&) {
      // The memory reserve covers this small response.
      *keep_alive = false;
      ResponseText text = out_of_memory;
      RefillMemoryReserve();
      if (memory_failures.Admit()) {
        WriteLog(LogLevel::kError, "a request was refused: out of memory");
      }
      return text;
    } catch (const std::exception& error) {
      LogError("connection closed because of an error: {}", error.what());
      *keep_alive = false;
      return {};
    }
  }
};

Listener::Listener(const ListenerOptions& options, RequestHandler* handler)
    : impl_(std::make_unique<Impl>(options, handler)) {}

Listener::~Listener() { Stop(); }

void Listener::Start() {
  const ListenerOptions& options = impl_->options;
  Socket listening = ListenOn(options.host, options.port);
  impl_->port = LocalPort(listening);
  Impl* const impl = impl_.get();
  ConnectionLimits connection = options.connection;
  connection.check_head = [impl](const RequestHead& head) { impl->handler->CheckHead(head); };
  impl->loop.emplace(std::move(listening), connection, WithinOpenFiles(options.loop),
                     options.num_threads,
                     [impl](const Connection& refused, const HttpError& error) {
                       return impl->Refusal(refused.peer(), refused.head(), error);
                     });
  for (int i = 0; i < options.num_threads + 1; ++i) {  // One more thread waits for the sockets.
    impl->threads.emplace_back([impl] { impl->Work(); });
  }
}

void Listener::Drain() { impl_->closes_connections = true; }

void Listener::Stop() {
  if (impl_->threads.empty()) {
    return;
  }
  Drain();
  impl_->loop->Stop();
  for (std::thread& thread : impl_->threads) {
    thread.join();
  }
  impl_->threads.clear();
}

int Listener::port() const { return impl_->port; }

}  // namespace cairn
