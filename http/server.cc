#include "http/server.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <thread>

#include "core/error.h"
#include "http/dispatcher.h"
#include "http/localize_service.h"
#include "http/net/listener.h"
#include "http/routes.h"

namespace cairn {
namespace {

constexpr int kAdminThreads = 2;

int NumThreads(const ServerOptions& options) {
  if (options.num_threads > 0) return options.num_threads;
  constexpr int kMinThreads = 64;  // Most of them read, write or wait in line.
  return std::max(kMinThreads, 2 * static_cast<int>(std::thread::hardware_concurrency()));
}

ServerOptions Validated(const ServerOptions& options) {
  options.Validate();
  return options;
}

}  // namespace

void ServerOptions::Validate() const {
  const auto require = [](bool ok, const char* what) {
    if (!ok) throw Error(ErrorCode::kInvalidArgument, fmt::format("ServerOptions: {}", what));
  };
  require(!map_path.empty(), "map_path is empty");
  require(!host.empty(), "host is empty");
  require(port >= 0 && port <= 65535, "port must lie in [0, 65535]");
  require(admin_port >= -1 && admin_port <= 65535, "admin_port must lie in [-1, 65535]");
  require(admin_port < 0 || !admin_host.empty(), "admin_host is empty");
  require(admin_port <= 0 || admin_port != port || admin_host != host,
          "admin_port is the same as port; leave it at -1 to serve both from one");
  require(num_threads >= 0 && num_threads <= 1024, "num_threads must lie in [0, 1024]");
  require(threads_per_query >= 0 && threads_per_query <= 1024,
          "threads_per_query must lie in [0, 1024]");
  require(cache_bytes > 0, "cache_bytes must be positive");
  require(max_body_bytes >= 1024, "max_body_bytes must be at least 1024");
  require(max_image_pixels >= 1, "max_image_pixels must be positive");
  require(max_features >= 1, "max_features must be positive");
  require(default_timeout_ms >= 1, "default_timeout_ms must be positive");
  localizer.Validate();
}

struct Server::Impl {
  LocalizeService service;
  Dispatcher main_dispatcher;
  Dispatcher admin_dispatcher;
  Listener main_listener;
  std::optional<Listener> admin_listener;

  explicit Impl(const ServerOptions& options)
      : service(options),
        main_dispatcher(MainRoutes(&service, /*with_admin=*/options.admin_port < 0),
                        &service.metrics()),
        admin_dispatcher(AdminRoutes(&service), &service.metrics()),
        main_listener(MainListenerOptions(options), &main_dispatcher) {
    if (options.admin_port >= 0) {
      const ListenerOptions admin{.host = options.admin_host,
                                  .port = options.admin_port,
                                  .num_threads = kAdminThreads,
                                  .limits = {}};
      admin_listener.emplace(admin, &admin_dispatcher);
    }
  }

  static ListenerOptions MainListenerOptions(const ServerOptions& options) {
    ListenerOptions listener{.host = options.host,
                             .port = options.port,
                             .num_threads = NumThreads(options),
                             .limits = {}};
    listener.limits.head.max_body_bytes = options.max_body_bytes;
    return listener;
  }
};

Server::Server(const ServerOptions& options) : impl_(std::make_unique<Impl>(Validated(options))) {}

Server::~Server() { Stop(); }

void Server::Start() {
  impl_->main_listener.Start();
  if (impl_->admin_listener) impl_->admin_listener->Start();
}

void Server::Stop() {
  impl_->main_listener.Stop();
  if (impl_->admin_listener) impl_->admin_listener->Stop();
}

int Server::port() const { return impl_->main_listener.port(); }

int Server::admin_port() const {
  return impl_->admin_listener ? impl_->admin_listener->port() : port();
}

}  // namespace cairn
