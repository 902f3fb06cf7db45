#include "http/net/listener.h"

#include <fmt/format.h>
#include <httplib.h>
#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <new>
#include <random>
#include <string_view>
#include <thread>

#include "core/logging.h"
#include "core/memory_reserve.h"
#include "http/net/url.h"

namespace cairn {
namespace {

constexpr int kBacklog = 256;  // httplib's own is 5: bursts would wait for TCP retransmissions.
constexpr size_t kMaxRequestIdLength = 64;

const char* ReasonPhrase(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 204:
      return "No Content";
    case 304:
      return "Not Modified";
    default:
      break;
  }
  for (const ProblemInfo& problem : AllProblems()) {
    if (problem.status == status) return problem.title;
  }
  return "";
}

std::string Serialize(const HttpResponse& response, bool is_head, bool keep_alive) {
  std::string text =
      fmt::format("HTTP/1.1 {} {}\r\n", response.status, ReasonPhrase(response.status));
  for (const auto& [name, value] : response.headers) {
    text += fmt::format("{}: {}\r\n", name, value);
  }
  if (!response.content_type.empty()) {
    text += fmt::format("Content-Type: {}\r\n", response.content_type);
  }
  if (response.status != 204 && response.status != 304) {
    text += fmt::format("Content-Length: {}\r\n", response.body.size());
  }
  text += keep_alive ? "Connection: keep-alive\r\n\r\n" : "Connection: close\r\n\r\n";
  if (!is_head) text += response.body;
  return text;
}

// Without the request's id, as it is made before there are requests.
HttpResponse OutOfMemoryResponse() {
  const HttpError error(ProblemCode::kUnavailable, "the server is out of memory");
  return {.status = InfoOf(error.problem()).status,
          .content_type = "application/problem+json",
          .body = ProblemJson(error, ""),
          .headers = {}};
}

// Unique within and, by a random start, across runs.
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

std::string RemoteAddress(int socket) {
  sockaddr_storage address;
  socklen_t size = sizeof(address);
  char host[NI_MAXHOST];
  if (getpeername(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0 ||
      getnameinfo(reinterpret_cast<sockaddr*>(&address), size, host, sizeof(host), nullptr, 0,
                  NI_NUMERICHOST) != 0) {
    return "unknown";
  }
  return host;
}

// httplib's pool, and a count of the connections that wait for a worker.
class CountingPool : public httplib::TaskQueue {
 public:
  CountingPool(int num_threads, std::atomic<int>* num_waiting)
      : pool_(static_cast<size_t>(num_threads)), num_waiting_(num_waiting) {}

  // Called by the thread that accepts, which must not end. A connection for which there is no
  // memory waits; if there is none for long, the thread serves it itself.
  void enqueue(std::function<void()> task) override {
    constexpr int kMaxTries = 100;
    for (int i = 0; i < kMaxTries; ++i) {
      if (TryEnqueue(task)) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    task();
  }
  void shutdown() override { pool_.shutdown(); }

 private:
  bool TryEnqueue(const std::function<void()>& task) {
    num_waiting_->fetch_add(1);
    try {
      pool_.enqueue([this, task] {
        num_waiting_->fetch_sub(1);
        task();
      });
      return true;
    } catch (const std::bad_alloc&) {
      num_waiting_->fetch_sub(1);
      return false;
    }
  }

  httplib::ThreadPool pool_;
  std::atomic<int>* num_waiting_;
};

// httplib's accept loop with our own conversation on each connection.
class AcceptLoop : public httplib::Server {
 public:
  AcceptLoop(const ListenerOptions& options, RequestHandler* handler)
      : limits_(options.limits),
        handler_(handler),
        out_of_memory_(Serialize(OutOfMemoryResponse(), /*is_head=*/false, /*keep_alive=*/false)) {
    set_tcp_nodelay(true);
    // Not SO_REUSEPORT, httplib's default: a second server would silently share the port.
    set_socket_options([](socket_t socket) {
      const int yes = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
    });
    const int num_threads = options.num_threads;
    new_task_queue = [this, num_threads] { return new CountingPool(num_threads, &num_waiting_); };
  }

  void WidenBacklog() { ::listen(svr_sock_, kBacklog); }
  void BeginStop() { stopping_ = true; }

 private:
  // Overrides httplib's whole treatment of a connection.
  bool process_and_close_socket(socket_t socket) override {
    try {
      Converse(socket);
    } catch (const std::bad_alloc&) {
      WriteLog(LogLevel::kError, "connection given up: out of memory");
    } catch (const std::exception& e) {
      LogError("connection given up: {}", e.what());
    }
    ::shutdown(socket, SHUT_RDWR);
    ::close(socket);
    return true;
  }

  void Converse(socket_t socket) {
    Connection connection(socket, limits_, [this] { return stopping_ || num_waiting_.load() > 0; });
    const std::string remote_address = RemoteAddress(socket);
    while (AnswerOne(remote_address, &connection)) {
    }
  }

  // True if the connection may carry another request.
  bool AnswerOne(const std::string& remote_address, Connection* connection) {
    const std::string request_id = request_ids_.Next();
    try {
      std::optional<ReceivedRequest> received = connection->ReadRequest();
      if (!received) return false;
      const bool is_head = received->head.method == "HEAD";
      const bool keep_alive = received->head.keep_alive && !stopping_;
      const HttpRequest request = ToRequest(std::move(*received), remote_address, request_id);
      const HttpResponse response = handler_->Handle(request);
      return connection->Send(Serialize(response, is_head, keep_alive)) && keep_alive;
    } catch (const HttpError& error) {
      connection->Send(Serialize(handler_->Refuse(error, request_id), /*is_head=*/false,
                                 /*keep_alive=*/false));
      connection->FinishSending();
      return false;
    } catch (const std::bad_alloc&) {
      // Nothing here allocates until the answer is on its way.
      connection->Send(out_of_memory_);
      RefillMemoryReserve();
      WriteLog(LogLevel::kError, "a request was refused: out of memory");
      connection->FinishSending();
      return false;
    }
  }

  static HttpRequest ToRequest(ReceivedRequest received, const std::string& remote_address,
                               std::string request_id) {
    std::optional<Target> target = ParseTarget(received.head.target);
    if (!target) {
      throw HttpError(ProblemCode::kBadRequest, "the target has a malformed percent escape");
    }
    const std::string_view client_id = received.head.Header("x-request-id");
    if (IsUsableRequestId(client_id)) request_id = client_id;
    HttpRequest request{.method = std::move(received.head.method),
                        .path = std::move(target->path),
                        .query = std::move(target->query),
                        .headers = {},
                        .body = std::move(received.body),
                        .remote_address = remote_address,
                        .request_id = std::move(request_id),
                        .arrival = received.arrival};
    for (auto& [name, value] : received.head.headers) {
      request.headers.emplace(std::move(name), std::move(value));
    }
    return request;
  }

  const ConnectionLimits limits_;
  RequestHandler* const handler_;
  const std::string out_of_memory_;  // The whole response.
  std::atomic<int> num_waiting_{0};
  std::atomic<bool> stopping_{false};
  RequestIds request_ids_;
};

}  // namespace

struct Listener::Impl {
  ListenerOptions options;
  AcceptLoop loop;
  std::thread thread;
  std::atomic<bool> has_ended{false};
  int port = 0;

  Impl(const ListenerOptions& listener_options, RequestHandler* handler)
      : options(listener_options), loop(listener_options, handler) {}
};

Listener::Listener(const ListenerOptions& options, RequestHandler* handler)
    : impl_(std::make_unique<Impl>(options, handler)) {}

Listener::~Listener() { Stop(); }

void Listener::Start() {
  const ListenerOptions& options = impl_->options;
  errno = 0;
  impl_->port = options.port;
  bool bound;
  if (options.port == 0) {
    impl_->port = impl_->loop.bind_to_any_port(options.host);
    bound = impl_->port > 0;
  } else {
    bound = impl_->loop.bind_to_port(options.host, options.port);
  }
  if (!bound && errno == EADDRINUSE) {
    throw Error(ErrorCode::kConflict,
                fmt::format("port {} on {} is taken by another program; choose another port",
                            options.port, options.host));
  }
  if (!bound) {
    throw Error(ErrorCode::kIo,
                fmt::format("cannot listen on {}:{}: {}", options.host, options.port,
                            errno != 0 ? std::strerror(errno) : "unknown host"));
  }
  impl_->loop.WidenBacklog();
  impl_->thread = std::thread([impl = impl_.get()] {
    impl->loop.listen_after_bind();
    impl->has_ended = true;
  });
  // httplib's stop() has no effect on a loop that does not run yet.
  while (!impl_->loop.is_running() && !impl_->has_ended) std::this_thread::yield();
}

void Listener::Stop() {
  if (!impl_->thread.joinable()) return;
  impl_->loop.BeginStop();
  impl_->loop.stop();
  impl_->thread.join();
}

int Listener::port() const { return impl_->port; }

}  // namespace cairn
