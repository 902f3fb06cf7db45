#include "http/service/server_options.h"

#include <algorithm>

#include "core/parallel_for.h"
#include "core/require.h"
#include "http/net/client_network.h"

namespace cairn {

void ServerOptions::Validate() const {
  RequireOption(!map_path.empty(), "server.map_path is empty");
  RequireOption(!host.empty(), "server.host is empty");
  RequireWithin("server.port", port, 0, 65535);
  RequireWithin("server.admin_port", admin_port, -1, 65535);
  RequireOption(admin_port <= 0 || admin_port != port || host != kAdminHost,
                "server.admin_port equals server.port; use -1 to share the port");
  RequireWithin("server.num_threads", num_threads, 0, 1024);
  RequireWithin("server.max_waiting", max_waiting, 0, 1024);
  RequireWithin("server.threads_per_query", threads_per_query, 0, 1024);
  RequireWithin("server.drain_s", drain_s, 0, kMaxDrainSeconds);
  RequireWithin("server.keep_alive_s", keep_alive_s, 1, 3600);
  RequireOption(cache_bytes > 0, "server.cache_bytes must be positive");
  RequireOption(max_body_bytes >= 1024, "server.max_body_bytes must be at least 1024");
  RequireOption(max_image_pixels >= 1, "server.max_image_pixels must be positive");
  RequireOption(max_features >= 1, "server.max_features must be positive");
  RequireOption(default_timeout_ms >= 1, "server.default_timeout_ms must be positive");
  RequireWithin("server.max_timeout_ms", max_timeout_ms, 1, kMaxTimeoutMs);
  ParseTrustedFronts(trusted_fronts);
  RequireOption(!api_keys_path || !api_keys_path->empty(), "server.api_keys_path is empty");
  localizer.Validate();
  sift.Validate();
}

int NumThreads(const ServerOptions& options) {
  if (options.num_threads > 0) {
    return options.num_threads;
  }
  constexpr int kMinThreads = 64;  // Most threads wait in line.
  return std::max(kMinThreads, 4 * NumCores());
}

}  // namespace cairn
