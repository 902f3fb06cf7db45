#include "http/exchange/bounded_client.h"

#include <fmt/format.h>
#include <httplib.h>
#include <poll.h>
#include <strings.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <mutex>
#include <optional>
#include <string_view>

#include "core/printable.h"
#include "core/require.h"
#include "http/exchange/channel.h"
#include "http/exchange/http_date.h"
#include "http/exchange/response_guard.h"
#include "http/exchange/server_url.h"
#include "http/exchange/tls.h"

namespace cairn {
namespace {

// What the library reads from and writes to during one exchange.
class GuardedStream final : public httplib::Stream {
 public:
  GuardedStream(int socket, Channel channel, ExchangeClock::time_point deadline,
                ResponseGuard* guard)
      : socket_(socket), channel_(channel), deadline_(deadline), guard_(guard) {}

  bool is_readable() const override {
    return begin_ < end_ || WaitForSocket(socket_, POLLIN, deadline_);
  }
  bool is_writable() const override { return WaitForSocket(socket_, POLLOUT, deadline_); }

  ssize_t read(char* to, size_t size) override {
    if (begin_ == end_) {
      const std::ptrdiff_t received = channel_.Receive(buffer_.data(), buffer_.size());
      if (received <= 0) {
        return received;
      }
      if (!guard_->Take({buffer_.data(), static_cast<size_t>(received)})) {
        return -1;
      }
      begin_ = 0;
      end_ = static_cast<size_t>(received);
    }
    const size_t num_bytes = std::min(size, end_ - begin_);
    std::memcpy(to, buffer_.data() + begin_, num_bytes);
    begin_ += num_bytes;
    return static_cast<ssize_t>(num_bytes);
  }

  ssize_t write(const char* from, size_t size) override { return channel_.Send(from, size); }

  void get_remote_ip_and_port(std::string& ip, int& port) const override { Forget(&ip, &port); }
  void get_local_ip_and_port(std::string& ip, int& port) const override { Forget(&ip, &port); }
  socket_t socket() const override { return socket_; }

 private:
  static void Forget(std::string* ip, int* port) {
    ip->clear();
    *port = 0;
  }

  int socket_;
  Channel channel_;
  ExchangeClock::time_point deadline_;
  ResponseGuard* guard_;
  std::array<char, 16384> buffer_;
  size_t begin_ = 0, end_ = 0;
};

// The library's client on guarded streams. TLS lies below the stream, so the library knows nothing
// of it: its own SSLClient reads from the socket past any guard.
class GuardedClient final : public httplib::ClientImpl {
 public:
  GuardedClient(const ServerUrl& url, std::unique_ptr<const TlsContext> tls)
      : httplib::ClientImpl(url.host, url.port), host_(url.host), tls_(std::move(tls)) {
    set_keep_alive(true);
    set_tcp_nodelay(true);
  }
  ~GuardedClient() override { stop(); }

  void Begin(ExchangeClock::time_point deadline, ResponseGuard* guard) {
    deadline_ = deadline;
    guard_ = guard;
    failure_.clear();
    if (HasUnaskedBytes()) {
      stop();
    }
  }

  // Why no connection came about, if TLS is the reason.
  const std::string& failure() const { return failure_; }

 private:
  bool create_and_connect_socket(Socket& socket, httplib::Error& error) override {
    const auto left = deadline_ - ExchangeClock::now();
    if (left <= ExchangeClock::duration::zero()) {
      error = httplib::Error::Connection;
      return false;
    }
    set_connection_timeout(std::chrono::ceil<std::chrono::microseconds>(left));
    if (!httplib::ClientImpl::create_and_connect_socket(socket, error)) {
      return false;
    }
    if (tls_ != nullptr) {
      session_ = std::make_unique<TlsSession>(*tls_, host_);
      failure_ = Channel(socket.sock, session_.get(), deadline_).Handshake();
    }
    if (!failure_.empty()) {
      error = httplib::Error::SSLConnection;
      shutdown_socket(socket);
      close_socket(socket);
    }
    return failure_.empty();
  }

  // Whether bytes have come on the kept connection since the last response: the end of the
  // connection, or a response that would be taken for that to the next request.
  bool HasUnaskedBytes() {
    const std::lock_guard lock(socket_mutex_);
    if (!socket_.is_open()) {
      return false;
    }
    pollfd kept{.fd = socket_.sock, .events = POLLIN, .revents = 0};
    return (session_ != nullptr && session_->HasInput()) || poll(&kept, 1, /*timeout=*/0) > 0;
  }

  bool process_socket(const Socket& socket,
                      std::function<bool(httplib::Stream& stream)> callback) override {
    GuardedStream stream(socket.sock, Channel(socket.sock, session_.get(), deadline_), deadline_,
                         guard_);
    return callback(stream);
  }

  std::string host_;
  std::unique_ptr<const TlsContext> tls_;  // Null without TLS.
  std::unique_ptr<TlsSession> session_;    // Of the current connection.
  ExchangeClock::time_point deadline_;
  ResponseGuard* guard_ = nullptr;
  std::string failure_;
};

std::optional<std::chrono::seconds> ParseSeconds(std::string_view text) {
  int seconds = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  const bool is_number = error == std::errc() && end == text.data() + text.size() && seconds >= 0;
  return is_number ? std::optional(std::chrono::seconds(seconds)) : std::nullopt;
}

}  // namespace

void BoundedClientOptions::Validate() const {
  RequireOption(timeout_ms > 0, "client.timeout_ms must be positive");
  RequireOption(max_body_bytes > 0, "client.max_body_bytes must be positive");
  const ServerUrl server = ParseServerUrl(url);
  RequireOption(server.is_secure || ca_file.empty(),
                "client.ca_file needs a URL that begins with https://");
  if (api_key.empty()) {
    return;
  }
  RequireOption(
      std::all_of(api_key.begin(), api_key.end(), [](char c) { return c > ' ' && c <= '~'; }),
      "client.api_key has a blank or another character that no key has");
  RequireOption(server.is_secure || allow_plain_key || IsLoopbackHost(server.host),
                fmt::format("everybody on the way to {} could read the API key; use https://, or "
                            "allow it for a network that you trust (client.allow_plain_key, "
                            "--insecure-key)",
                            Excerpt(url)));
}

std::string ClientResponse::Header(const std::string& name) const {
  const auto found = std::find_if(headers.begin(), headers.end(), [&](const auto& header) {
    return strcasecmp(header.first.c_str(), name.c_str()) == 0;
  });
  return found == headers.end() ? "" : found->second;
}

std::optional<std::chrono::seconds> ClientResponse::RetryAfter() const {
  constexpr int kTooManyRequests = 429;
  const std::string text = Header("Retry-After");
  std::optional<std::chrono::seconds> pause = ParseSeconds(text);
  if (const auto date = ParseHttpDate(text)) {
    const auto now = ParseHttpDate(Header("Date"));
    pause = *date - now.value_or(
                        std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now()));
  }
  if (status != kTooManyRequests || !pause) {
    return std::nullopt;
  }
  return std::max(*pause, std::chrono::seconds(1));  // A server may say 0 for ever.
}

struct BoundedClient::Impl {
  explicit Impl(const BoundedClientOptions& client_options)
      : options(Validated(client_options)),
        url(ParseServerUrl(options.url)),
        http(MakeClient(options, url)) {}

  static const BoundedClientOptions& Validated(const BoundedClientOptions& options) {
    options.Validate();
    return options;
  }

  static std::unique_ptr<GuardedClient> MakeClient(const BoundedClientOptions& options,
                                                   const ServerUrl& url) {
    return std::make_unique<GuardedClient>(
        url, url.is_secure ? std::make_unique<const TlsContext>(options.ca_file) : nullptr);
  }

  // Appends to `body` until it is too long.
  httplib::ContentReceiverWithProgress Receiver(std::string* body, bool* is_too_long) const {
    return [this, body, is_too_long](const char* data, size_t size, uint64_t, uint64_t) {
      *is_too_long = body->size() + size > options.max_body_bytes;
      if (!*is_too_long) {
        body->append(data, size);
      }
      return !*is_too_long;
    };
  }

  std::string Explain(const ResponseGuard& guard, ExchangeClock::time_point deadline,
                      bool is_too_long, httplib::Error error) const {
    if (!guard.violation().empty()) {
      return guard.violation();
    }
    if (is_too_long) {
      return fmt::format("the body of the response is longer than {} bytes",
                         options.max_body_bytes);
    }
    if (ExchangeClock::now() >= deadline) {
      return fmt::format("no complete response within {} ms", options.timeout_ms);
    }
    return http->failure().empty() ? httplib::to_string(error) : http->failure();
  }

  BoundedClientOptions options;
  ServerUrl url;
  std::unique_ptr<GuardedClient> http;
};

BoundedClient::BoundedClient(const BoundedClientOptions& options)
    : impl_(std::make_unique<Impl>(options)) {}

BoundedClient::~BoundedClient() = default;

ClientResponse BoundedClient::Send(ClientRequest request) {
  const auto deadline = ExchangeClock::now() + std::chrono::milliseconds(impl_->options.timeout_ms);
  ResponseGuard guard(impl_->options.max_body_bytes);
  impl_->http->Begin(deadline, &guard);

  ClientResponse response;
  bool is_too_long = false;
  httplib::Request message;
  message.method = std::move(request.method);
  message.path = impl_->url.prefix + request.path;
  message.headers.insert(request.headers.begin(), request.headers.end());
  if (!impl_->options.api_key.empty()) {
    message.headers.emplace("Authorization", "Bearer " + impl_->options.api_key);
  }
  message.body = std::move(request.body);
  message.content_receiver = impl_->Receiver(&response.body, &is_too_long);
  const httplib::Result result = impl_->http->send(message);
  if (!result) {
    response.body.clear();
    response.is_garbled = is_too_long || !guard.violation().empty();
    response.failure = impl_->Explain(guard, deadline, is_too_long, result.error());
    return response;
  }
  response.status = result->status;
  response.headers.assign(result->headers.begin(), result->headers.end());
  return response;
}

void BoundedClient::Stop() { impl_->http->stop(); }

}  // namespace cairn
