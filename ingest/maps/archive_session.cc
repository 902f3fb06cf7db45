#include "ingest/maps/archive_session.h"

#include <algorithm>
#include <iterator>
#include <optional>

#include "core/error.h"
#include "ingest/ingest_session.h"
#include "ingest/session_digest.h"

namespace cairn {
namespace {

SessionKey KeyOf(const SessionRecord& session) { return {session.name, IngestDigestOf(session)}; }

// The time of the photos that is a part of the session's digest: none if the time is that of the
// ingest, and else what was given now or at an earlier ingest.
std::string GivenRecordedAt(const SessionRecord& session, const Sim3d& ecef_from_world,
                            const IngestOptions& options, const Reconstruction& reconstruction) {
  const std::string with_options = DigestOf(reconstruction) + DigestOf(ecef_from_world, options);
  return AreOneIngest(with_options, session.content_digest) ? options.recorded_at
                                                            : session.recorded_at;
}

// Reserves the ids from the map's next ones up to `first`, so that a session gets these.
void LeaveOutIdsBefore(const FirstIds& first, MapStore* store) {
  const FirstIds next = store->ReserveIds({});
  const auto missing = [](auto from, auto to) {
    return Value(to) > Value(from) ? Value(to) - Value(from) : 0;
  };
  store->ReserveIds({.num_codebooks = missing(next.codebook, first.codebook),
                     .num_sessions = missing(next.session, first.session),
                     .num_keyframes = missing(next.keyframe, first.keyframe),
                     .num_landmarks = missing(next.landmark, first.landmark)});
}

}  // namespace

std::vector<MapSession> MapSessionsOf(const MapSnapshot& map) {
  std::vector<MapSession> sessions;
  std::ranges::transform(map.Sessions(), std::back_inserter(sessions),
                         [](const SessionRecord& session) {
                           return MapSession{KeyOf(session), session.id};
                         });
  return sessions;
}

ArchivedMap ArchivedMapOf(const MapSnapshot& map) {
  return {map.Info().created_at, map.version(), MapSessionsOf(map)};
}

ArchiveManifest MakeManifest(const PlannedSession& planned, const Sim3d& ecef_from_world,
                             const IngestOptions& options, const std::string& options_json) {
  const SessionPlan& plan = planned.plan;
  ArchiveManifest manifest;
  manifest.session = KeyOf(plan.session);
  manifest.source = plan.session.source;
  manifest.given_recorded_at =
      GivenRecordedAt(plan.session, ecef_from_world, options, *planned.reconstruction);
  manifest.recorded_at = plan.session.recorded_at;
  manifest.options_json = options_json;
  manifest.map_created_at = plan.map_created_at;
  manifest.first_ids = plan.first_ids;
  manifest.first_ids.session = plan.session.id;
  manifest.is_apart = options.joining == SessionJoining::kApart;
  manifest.georef_median_residual_m = plan.session.georef_median_residual_m;
  manifest.ecef_from_world = ecef_from_world;
  for (const SessionRecord& other : planned.base->Sessions()) {
    if (Value(other.id) < Value(plan.session.id) && other.id != plan.replaced_session) {
      manifest.earlier_sessions.push_back(KeyOf(other));
    }
  }
  return manifest;
}

IngestReport IngestAgain(const ArchivedSession& session, IngestOptions options, Numbering numbering,
                         MapStore* store, const IngestProgress& progress) {
  const ArchiveManifest& manifest = session.manifest;
  options.session_name = manifest.session.name;
  options.source = manifest.source;
  options.recorded_at = manifest.given_recorded_at;
  options.now = manifest.recorded_at;
  options.joining = manifest.is_apart ? SessionJoining::kApart : SessionJoining::kJoin;
  options.georef_median_residual_m = manifest.georef_median_residual_m;
  options.gate.max_lost_share = 1.0;  // The session was published once.
  if (numbering == Numbering::kAsBefore) {
    LeaveOutIdsBefore(manifest.first_ids, store);
  }
  return IngestSession(
      session.reconstruction, manifest.ecef_from_world, options, store, progress,
      [&](const PlannedSession& planned) {
        if (!AreOneIngest(planned.plan.session.content_digest, manifest.session.content_digest)) {
          throw Error(ErrorCode::kMapDamaged, "the content does not match its digest");
        }
      });
}

}  // namespace cairn
