#include "storage/database/postgres/address.h"

#include <libpq-fe.h>

#include <algorithm>
#include <memory>

#include "core/error.h"

namespace cairn::postgres {
namespace {

using Options = std::unique_ptr<PQconninfoOption, decltype(&PQconninfoFree)>;

// Splits at commas: "a,b" has the parts a and b, "" has one empty part.
std::vector<std::string> Split(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ',') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

Options Parse(const std::string& url) {
  char* ignored = nullptr;  // libpq's message, which may quote the password.
  Options options(PQconninfoParse(url.c_str(), &ignored), &PQconninfoFree);
  PQfreemem(ignored);
  if (options == nullptr) {
    throw Error(ErrorCode::kInvalidArgument,
                "this is not a PostgreSQL URL; write postgresql://USER@HOST:PORT/DATABASE, or "
                "postgresql:///DATABASE?host=/run/postgresql for a socket");
  }
  return options;
}

void RefusePassword(const std::string& keyword) {
  if (keyword == "password" || keyword == "sslpassword") {
    throw Error(ErrorCode::kInvalidArgument,
                "the PostgreSQL URL holds a password, which everybody on this machine can read in "
                "the list of processes; put it into the file that PGPASSFILE names (default "
                "~/.pgpass) and take it out of the URL");
  }
}

// A port that is not a number may be a password: "postgresql://user:password" lacks its host.
void RequirePort(const std::string& port) {
  if (port.find_first_not_of("0123456789") != std::string::npos) {
    throw Error(ErrorCode::kInvalidArgument,
                "the PostgreSQL URL has a port that is not a number; write "
                "postgresql://USER@HOST:PORT/DATABASE");
  }
}

// Returns the part for host `i`. A list of one part is for all hosts.
const std::string& PartOf(const std::vector<std::string>& parts, size_t i) {
  return parts.size() == 1 ? parts[0] : parts.at(i);
}

}  // namespace

std::vector<Settings> ParseAddress(const std::string& url) {
  const Options options = Parse(url);
  Settings common;
  std::vector<std::pair<std::string, std::vector<std::string>>> of_hosts;
  size_t num_hosts = 1;
  for (const PQconninfoOption* option = options.get(); option->keyword != nullptr; ++option) {
    if (option->val == nullptr) {
      continue;
    }
    const std::string keyword = option->keyword;
    RefusePassword(keyword);
    if (keyword == "host" || keyword == "hostaddr" || keyword == "port") {
      of_hosts.emplace_back(keyword, Split(option->val));
      num_hosts = std::max(num_hosts, of_hosts.back().second.size());
      if (keyword == "port") {
        std::for_each(of_hosts.back().second.begin(), of_hosts.back().second.end(), RequirePort);
      }
    } else {
      common.emplace_back(keyword, option->val);
    }
  }
  std::vector<Settings> hosts(num_hosts, common);
  for (const auto& [keyword, parts] : of_hosts) {
    if (parts.size() != 1 && parts.size() != num_hosts) {
      throw Error(ErrorCode::kInvalidArgument,
                  "the PostgreSQL URL needs as many ports as hosts, or one");
    }
    for (size_t i = 0; i < num_hosts; ++i) {
      hosts[i].emplace_back(keyword, PartOf(parts, i));
    }
  }
  return hosts;
}

}  // namespace cairn::postgres
