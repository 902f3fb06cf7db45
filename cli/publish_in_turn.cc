#include "cli/publish_in_turn.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "core/error.h"
#include "core/printable.h"
#include "ingest/session_refused.h"

namespace cairn {
namespace {

bool IsWaiting(const MapSessionResult& session) { return session.is_mapped && !session.is_in_map; }

// False, with the problem in `session`, if the map refuses it.
bool TryPublish(const PublishOne& publish, Unanchored unanchored, MapSessionResult* session) {
  if (session->session.options.joining == SessionJoining::kJoin) {
    session->session.options.agreement.unanchored = unanchored;
  }
  try {
    session->report = publish(session);
  } catch (const SessionRefused& error) {
    session->problem = error.what();
    return false;
  }
  session->is_in_map = true;
  session->problem.clear();
  return true;
}

// Publishes the first session that the map takes on these terms.
bool PublishNext(const PublishOne& publish, Unanchored unanchored,
                 std::vector<MapSessionResult>* sessions) {
  return std::any_of(sessions->begin(), sessions->end(), [&](MapSessionResult& session) {
    return IsWaiting(session) && TryPublish(publish, unanchored, &session);
  });
}

[[noreturn]] void ThrowNone(const std::vector<MapSessionResult>& sessions, ErrorCode code) {
  std::string problems;
  for (const MapSessionResult& session : sessions) {
    problems += fmt::format("; {}: {}", Excerpt(session.name), session.problem);
  }
  throw Error(code, fmt::format("the map takes none of the {} sessions, and is as before{}",
                                sessions.size(), problems));
}

}  // namespace

void SortSessions(std::vector<MapSessionResult>* sessions) {
  std::sort(
      sessions->begin(), sessions->end(), [](const MapSessionResult& a, const MapSessionResult& b) {
        return std::tuple(-a.mapped.num_mapped, a.name) < std::tuple(-b.mapped.num_mapped, b.name);
      });
}

void PublishInTurn(const PublishOne& publish, bool map_is_empty,
                   std::vector<MapSessionResult>* sessions) {
  if (sessions->size() == 1) {
    MapSessionResult& alone = sessions->front();
    alone.report = publish(&alone);
    alone.is_in_map = true;
    return;
  }
  bool is_empty = map_is_empty;
  while ((!is_empty && PublishNext(publish, Unanchored::kRefuseAlways, sessions)) ||
         PublishNext(publish, Unanchored::kRefuse, sessions)) {
    is_empty = false;
  }
  if (std::none_of(sessions->begin(), sessions->end(),
                   [](const MapSessionResult& session) { return session.is_in_map; })) {
    const bool has_place =
        std::any_of(sessions->begin(), sessions->end(),
                    [](const MapSessionResult& session) { return session.mapped.num_mapped > 0; });
    ThrowNone(*sessions, has_place ? ErrorCode::kConflict : ErrorCode::kBadInput);
  }
}

}  // namespace cairn
