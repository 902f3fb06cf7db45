#include "storage/database/postgres/server.h"

#include <algorithm>
#include <utility>

#include "core/error.h"

namespace cairn::postgres {
namespace {

void SetDefault(const char* keyword, const char* value, Settings* settings) {
  const bool is_set = std::any_of(settings->begin(), settings->end(),
                                  [&](const auto& setting) { return setting.first == keyword; });
  if (!is_set) {
    settings->emplace_back(keyword, value);
  }
}

Settings For(Use use, Settings settings) {
  SetDefault("application_name", "cairn", &settings);
  SetDefault("client_encoding", "UTF8", &settings);
  SetDefault("keepalives_idle", "10", &settings);
  if (use == Use::kWrite) {
    SetDefault("target_session_attrs", "read-write", &settings);
  }
  return settings;
}

}  // namespace

Server::Server(const std::string& url) : name_(url), hosts_(ParseAddress(url)) {}

std::unique_ptr<PostgresConnection> Server::Connect(Use use, const Patience& patience) const {
  std::vector<Settings> hosts;
  for (const Settings& host : hosts_) {
    hosts.push_back(For(use, host));
  }
  auto connection = std::make_unique<PostgresConnection>(Link(hosts, name_, patience));
  // Each statement finds a few rows by an index, so one plan serves all parameters.
  connection->Execute("SET search_path = cairn, public; SET plan_cache_mode = force_generic_plan");
  if (use == Use::kRead) {
    connection->Execute("SET default_transaction_read_only = on");
  }
  return connection;
}

}  // namespace cairn::postgres
