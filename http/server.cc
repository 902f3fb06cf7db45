#include "http/server.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include "http/dispatcher.h"
#include "http/net/client_network.h"
#include "http/net/listener.h"
#include "http/routes.h"
#include "http/service/localize_service.h"

namespace cairn {
namespace {

constexpr int kAdminThreads = 2;
constexpr std::chrono::seconds kMapRefreshInterval{1};

// Refreshes the maps about once a second until it is destroyed.
class MapWatcher {
 public:
  explicit MapWatcher(ServedMaps* maps)
      : thread_([this, maps](const std::stop_token& stop) {
          std::unique_lock lock(mutex_);
          while (!wake_.wait_for(lock, stop, kMapRefreshInterval, [&] { return false; }) &&
                 !stop.stop_requested()) {
            maps->Refresh();
          }
        }) {}

 private:
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread thread_;  // The last member, so that the thread ends before the other members.
};

ServerOptions Validated(const ServerOptions& options) {
  options.Validate();
  return options;
}

}  // namespace

struct Server::Impl {
  LocalizeService service;
  Dispatcher main_dispatcher;
  Dispatcher admin_dispatcher;
  Listener main_listener;
  std::optional<Listener> admin_listener;
  std::optional<MapWatcher> watcher;

  explicit Impl(const ServerOptions& options)
      : service(options),
        main_dispatcher(MainRoutes(&service, /*with_admin=*/options.admin_port < 0),
                        &service.metrics()),
        admin_dispatcher(AdminRoutes(&service), &service.metrics()),
        main_listener(MainListenerOptions(options), &main_dispatcher) {
    if (options.admin_port >= 0) {
      const ListenerOptions admin{
          .host = kAdminHost, .port = options.admin_port, .num_threads = kAdminThreads};
      admin_listener.emplace(admin, &admin_dispatcher);
    }
  }

  static ListenerOptions MainListenerOptions(const ServerOptions& options) {
    ListenerOptions listener{
        .host = options.host, .port = options.port, .num_threads = NumThreads(options)};
    listener.connection.max_body_bytes = options.max_body_bytes;
    listener.trusted_fronts = ParseTrustedFronts(options.trusted_fronts);
    listener.connection.idle_timeout = std::chrono::seconds(options.keep_alive_s);
    return listener;
  }
};

Server::Server(const ServerOptions& options) : impl_(std::make_unique<Impl>(Validated(options))) {}

Server::~Server() { Stop(); }

void Server::Start() {
  impl_->main_listener.Start();
  if (impl_->admin_listener) {
    impl_->admin_listener->Start();
  }
  impl_->watcher.emplace(&impl_->service.maps());
}

void Server::Drain() {
  impl_->service.BeginDrain();
  impl_->main_listener.Drain();
}

void Server::Stop() {
  impl_->service.BeginStop();
  impl_->watcher.reset();
  impl_->main_listener.Stop();
  if (impl_->admin_listener) {
    impl_->admin_listener->Stop();
  }
}

uint64_t Server::num_requests() const { return impl_->service.metrics().num_requests(); }

void Server::ReloadMap() { impl_->service.maps().Reload(); }

int Server::port() const { return impl_->main_listener.port(); }

int Server::admin_port() const {
  return impl_->admin_listener ? impl_->admin_listener->port() : port();
}

}  // namespace cairn
