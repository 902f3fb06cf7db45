#include "storage/database/postgres/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <regex>
#include <sstream>

#include "core/printable.h"

namespace cairn::postgres {
namespace {

constexpr size_t kMaxMessageBytes = 400;

struct Kind {
  const char* sqlstate_prefix;
  ErrorCode code;
  const char* advice;
};

// The first row that matches counts.
constexpr Kind kKinds[] = {
    {"08", ErrorCode::kUnavailable, "try again"},
    {"57P", ErrorCode::kUnavailable, "the server is starting or stopping; try again"},
    {"57014", ErrorCode::kUnavailable, "the server canceled the statement; try again"},
    {"533", ErrorCode::kUnavailable, "raise max_connections or stop other programs"},
    {"40001", ErrorCode::kUnavailable, "try again"},
    {"25006", ErrorCode::kBadInput, "this server is a standby; give the address of the primary"},
    {"40P01", ErrorCode::kConflict, "another program is in the way; try again"},
    {"55P03", ErrorCode::kConflict, "another program is in the way; try again"},
    {"42501", ErrorCode::kIo,
     "connect as a role that may: GRANT cairn_reader lets it read, cairn_builder write"},
    {"53", ErrorCode::kIo, "the server has no space or memory left"},
    {"22021", ErrorCode::kBadInput, "names must be UTF-8"},
    {"3F000", ErrorCode::kMapDamaged, "is this the database of a map?"},
    {"42P01", ErrorCode::kMapDamaged, "its tables are not those of a Cairn map"},
    {"42703", ErrorCode::kMapDamaged, "its tables are not those of a Cairn map"},
    {"42", ErrorCode::kInternal, "please report this"},
    {"22", ErrorCode::kMapDamaged, "the map holds values that Cairn never writes"},
    {"23", ErrorCode::kMapDamaged, "the map holds values that Cairn never writes"},
    {"XX", ErrorCode::kMapDamaged, "look into the server's log"},
    {"", ErrorCode::kInternal, "look into the server's log"},
};

bool HasAny(std::string_view text, std::initializer_list<const char*> parts) {
  return std::any_of(parts.begin(), parts.end(), [text](const char* part) {
    return text.find(part) != std::string_view::npos;
  });
}

std::string OneLine(std::string text) {
  while (!text.empty() && text.back() == '\n') {
    text.pop_back();
  }
  std::replace(text.begin(), text.end(), '\n', ' ');
  return Excerpt(text, kMaxMessageBytes);
}

// Drops the lines that say where in PostgreSQL's source an error arose: "LOCATION:  auth_failed,
// auth.c:326", or the same in the server's language.
std::string WithoutLocations(const std::string& message) {
  static const std::regex location(R"(\.[cl]:[0-9]+\s*$)");
  std::istringstream lines(message);
  std::string kept;
  for (std::string line; std::getline(lines, line);) {
    if (!std::regex_search(line, location)) {
      kept += line + '\n';
    }
  }
  return kept;
}

}  // namespace

bool EndsConnection(std::string_view sqlstate) {
  return sqlstate.empty() || sqlstate.starts_with("08") || sqlstate.starts_with("57P") ||
         sqlstate.starts_with("533");
}

Error StatementError(const std::string& name, const PGresult* result) {
  const char* sqlstate = PQresultErrorField(result, PG_DIAG_SQLSTATE);
  const char* primary = PQresultErrorField(result, PG_DIAG_MESSAGE_PRIMARY);
  // A lost connection has no SQLSTATE.
  const std::string state = sqlstate == nullptr ? "08006" : sqlstate;
  const Kind& kind = *std::find_if(std::begin(kKinds), std::end(kKinds), [&](const Kind& row) {
    return state.starts_with(row.sqlstate_prefix);
  });
  return Error(kind.code,
               fmt::format("{}: PostgreSQL says \"{}\" ({}); {}", name,
                           OneLine(primary == nullptr ? PQresultErrorMessage(result) : primary),
                           state, kind.advice));
}

Error ConnectError(const std::string& name, const std::string& message) {
  const std::string shown = OneLine(WithoutLocations(message));
  const auto error = [&](ErrorCode code, const char* advice) {
    return Error(code, fmt::format("{}: {}; {}", name, shown, advice));
  };
  if (HasAny(message, {"session is read-only", "hot standby"})) {
    return error(ErrorCode::kBadInput, "give the address of the primary");
  }
  if (HasAny(message, {"28P01:", "password", "authentication failed"})) {
    return error(ErrorCode::kIo,
                 "check the user and the password, which comes from PGPASSFILE (default ~/.pgpass, "
                 "readable by its owner only) or PGPASSWORD");
  }
  if (HasAny(message, {"does not support SSL"})) {
    return error(ErrorCode::kIo, "switch on TLS on the server, or take sslmode out of the URL");
  }
  if (HasAny(message, {"pg_hba.conf"})) {
    return error(ErrorCode::kIo,
                 "the server lets this user in from elsewhere only, or with TLS only "
                 "(?sslmode=require)");
  }
  if (HasAny(message, {"certificate", "SSL error", "root.crt"})) {
    return error(ErrorCode::kIo, "check sslmode and sslrootcert");
  }
  if (HasAny(message, {"3D000:", "28000:"})) {  // No such database, no such role.
    return error(ErrorCode::kNotFound, "create it (createdb, createuser) or correct the URL");
  }
  return error(ErrorCode::kUnavailable, "is the server running, and does it listen there?");
}

}  // namespace cairn::postgres
