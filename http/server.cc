#include "http/server.h"

#include <fmt/format.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "core/error.h"
#include "core/logging.h"
#include "http/dispatcher.h"
#include "http/exchange/server_url.h"
#include "http/keys/key_file.h"
#include "http/keys/key_ring.h"
#include "http/net/client_network.h"
#include "http/net/listener.h"
#include "http/routes.h"
#include "http/service/access_log.h"
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
  const std::string host, trusted_fronts;
  const std::optional<std::string> api_keys_path;
  LocalizeService service;
  std::optional<KeyRing> keys;
  std::optional<AccessLog> access_log;
  Dispatcher main_dispatcher;
  Dispatcher admin_dispatcher;
  Listener main_listener;
  std::optional<Listener> admin_listener;
  std::optional<MapWatcher> watcher;

  explicit Impl(const ServerOptions& options)
      : host(options.host),
        trusted_fronts(options.trusted_fronts),
        api_keys_path(options.api_keys_path),
        service(options),
        keys(ReadKeys(options.api_keys_path)),
        main_dispatcher(MainRoutes(&service, /*with_admin=*/options.admin_port < 0),
                        &service.metrics(), keys ? &*keys : nullptr,
                        StartAccessLog(options.access_log_path)),
        admin_dispatcher(AdminRoutes(&service), &service.metrics()),
        main_listener(MainListenerOptions(options), &main_dispatcher) {
    if (options.admin_port >= 0) {
      const ListenerOptions admin{
          .host = kAdminHost, .port = options.admin_port, .num_threads = kAdminThreads};
      admin_listener.emplace(admin, &admin_dispatcher);
    }
  }

  // Null without a path.
  AccessLog* StartAccessLog(const std::string& path) {
    return path.empty() ? nullptr : &access_log.emplace(path);
  }

  // A server on loopback is open to others too if a front passes on their requests.
  void WarnIfOpen() const {
    if (!keys && (!IsLoopbackHost(host) || !trusted_fronts.empty())) {
      LogWarning(
          "without --api-keys, everybody who reaches {} may localize, look at the map and copy it",
          trusted_fronts.empty() ? host : fmt::format("{} or its fronts", host));
    }
  }

  static std::optional<KeyRing> ReadKeys(const std::optional<std::string>& path) {
    return path ? std::optional<KeyRing>(std::in_place, ReadKeyFile(*path)) : std::nullopt;
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
  impl_->WarnIfOpen();
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

void Server::ReloadKeys() {
  if (!impl_->keys) {
    return;
  }
  try {
    const std::vector<ApiKey> keys = ReadKeyFile(*impl_->api_keys_path);
    impl_->keys->Replace(keys);
    std::set<std::string> labels;
    for (const ApiKey& key : keys) {
      labels.insert(key.label);
    }
    impl_->service.metrics().KeepClients(labels);
    LogInfo("{} API keys are valid now", keys.size());
  } catch (const std::exception& error) {
    LogError("{}; the API keys of before stay valid", error.what());
  }
}

void Server::ReopenAccessLog() {
  if (impl_->access_log) {
    impl_->access_log->Reopen();
  }
}

int Server::port() const { return impl_->main_listener.port(); }

int Server::admin_port() const {
  return impl_->admin_listener ? impl_->admin_listener->port() : port();
}

}  // namespace cairn
