#include "ingest/publish_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/printable.h"
#include "ingest/codebook/shipped_codebook.h"
#include "ingest/session_digest.h"
#include "ingest/tile_names.h"
#include "ingest/tiles/write_tile.h"

namespace cairn {
namespace {

[[noreturn]] void Refuse(const SessionPlan& plan, const std::string& reason) {
  throw Error(ErrorCode::kConflict, fmt::format("the plan of session '{}' cannot be published: {}",
                                                Excerpt(plan.session.name), reason));
}

// The plan's ids come from the counters of this very map.
void RequireMap(const SessionPlan& plan, const MapUpdate& update, const std::string& created_at) {
  if (plan.map_created_at != created_at) {
    Refuse(plan, fmt::format("it is for a map that was created at {}, this one was at {}",
                             Excerpt(plan.map_created_at), Excerpt(created_at)));
  }
  const FirstIds next = update.NextIds();
  const FirstIds& first = plan.first_ids;
  const IdCounts& counts = plan.id_counts;
  const bool has_reserved = Value(first.codebook) + counts.num_codebooks <= Value(next.codebook) &&
                            Value(first.session) + counts.num_sessions <= Value(next.session) &&
                            Value(first.keyframe) + counts.num_keyframes <= Value(next.keyframe) &&
                            Value(first.landmark) + counts.num_landmarks <= Value(next.landmark);
  if (!has_reserved) {
    Refuse(plan,
           "the map does not know of the ids that it reserved, so this is another map or a copy "
           "that is older than the plan; plan again");
  }
}

void RequireSessions(const SessionPlan& plan, const MapUpdate& update) {
  RequireNotElsewhere(plan.session, plan.options.joining, update.Sessions());
  const std::optional<SessionRecord> found = update.FindSession(plan.session.name);
  if (found && found->id == plan.session.id) {
    Refuse(plan, "the map has it already; nothing was changed");
  }
  if (found.has_value() && plan.replaced_session == SessionId{}) {
    Refuse(plan, "the map has got a session of this name since; plan again to replace it");
  }
  if (plan.replaced_session != SessionId{} && (!found || found->id != plan.replaced_session)) {
    Refuse(plan, "the session that it replaces was removed or replaced since; plan again");
  }
}

void RequireCodebook(const SessionPlan& plan, const MapUpdate& update) {
  const std::shared_ptr<const Codebook> current = update.CurrentCodebook();
  const CodebookId expected = plan.adds_codebook ? CodebookId{} : plan.codebook->id;
  if ((current ? current->id : CodebookId{}) != expected) {
    Refuse(plan, "the map has another codebook than at that time; plan again");
  }
}

// The tiles whose content is not what the plan starts from.
std::vector<TileId> MovedTiles(const SessionPlan& plan, const MapUpdate& update) {
  std::vector<TileId> moved;
  std::vector<TileId> planned;
  for (const PlannedTile& tile : plan.tiles) {
    planned.push_back(tile.tile_id);
    const std::optional<TileRecord> record = update.FindTile(tile.tile_id);
    if ((record ? record->digest : "") != tile.base_digest) {
      moved.push_back(tile.tile_id);
    }
  }
  if (plan.replaced_session != SessionId{}) {
    for (const TileId tile_id : update.TilesOfSession(plan.replaced_session)) {
      if (!std::binary_search(planned.begin(), planned.end(), tile_id) &&
          update.FindTile(tile_id)) {
        moved.push_back(tile_id);
      }
    }
  }
  return moved;
}

void RequireTiles(const SessionPlan& plan, const MapUpdate& update) {
  const std::vector<TileId> moved = MovedTiles(plan, update);
  if (!moved.empty()) {
    Refuse(plan, fmt::format("{} of its {} tiles have changed since version {}: {}; plan again",
                             moved.size(), plan.tiles.size(), Value(plan.base_version),
                             TileNames(moved)));
  }
}

void AddCodebook(const SessionPlan& plan, MapUpdate* update) {
  if (plan.adds_codebook &&
      update->AddCodebook(*plan.codebook, plan.codebook->id) != plan.codebook->id) {
    Refuse(plan, "the map has its codebook under another id; plan again");
  }
}

void StoreTile(const BuiltTile& built, MapUpdate* update) {
  for (const KeyframeId id : built.tile.replaced_keyframes) {
    update->RemoveKeyframe(id);
  }
  for (const KeyframeRecord& keyframe : built.keyframes) {
    update->AddKeyframe(keyframe, keyframe.id);
  }
  PutTile(built.tile.encoded, update);
}

void CountTile(const RewrittenTile& tile, IngestReport* report) {
  report->changes.Add(tile.changes);
  if (!tile.encoded.payload.empty()) {
    ++report->num_tiles_written;
    report->num_payload_bytes += std::ssize(tile.encoded.payload);
    report->num_landmarks_written += tile.encoded.record.num_landmarks;
    report->num_descriptors_written += tile.encoded.record.num_descriptors;
  }
}

CodebookOrigin OriginOf(const SessionPlan& plan) {
  if (!plan.adds_codebook) {
    return CodebookOrigin::kMap;
  }
  return IsShipped(*plan.codebook) ? CodebookOrigin::kShipped : CodebookOrigin::kTrained;
}

IngestReport ReportOf(const SessionPlan& plan) {
  IngestReport report;
  report.session_id = plan.session.id;
  report.replaced_session = plan.replaced_session != SessionId{};
  report.is_unchanged = plan.is_unchanged;
  report.codebook_origin = OriginOf(plan);
  report.comparison = plan.comparison;
  report.adjustment = plan.adjustment;
  report.num_images = plan.session.num_images;
  report.num_landmarks_read = plan.session.num_landmarks;
  report.num_landmarks_dropped = plan.num_landmarks_dropped;
  report.first_new_landmark = plan.first_ids.landmark;
  return report;
}

std::string SummaryOf(const IngestReport& report) {
  return fmt::format("{} images into {} tiles: {} landmarks merged, {} new, {} faded, {} evicted",
                     report.num_images, report.num_tiles_written, report.changes.num_merged,
                     report.changes.num_new, report.changes.num_faded, report.changes.num_evicted);
}

}  // namespace

IngestReport PublishSession(const SessionPlan& plan,
                            const std::function<BuiltTile(size_t tile_idx)>& load, MapStore* store,
                            std::chrono::milliseconds patience, const IngestProgress& progress) {
  IngestReport report = ReportOf(plan);
  if (plan.is_unchanged) {
    report.map_version = plan.base_version;
    return report;
  }
  MapUpdate update = store->BeginUpdate(patience);
  RequireMap(plan, update, store->Snapshot().Info().created_at);
  RequireSessions(plan, update);
  RequireCodebook(plan, update);
  RequireTiles(plan, update);
  AddCodebook(plan, &update);
  if (plan.replaced_session != SessionId{}) {
    update.RemoveSession(plan.replaced_session);
  }
  update.AddSession(plan.session, plan.session.id);
  const int64_t num_tiles = std::ssize(plan.tiles);
  for (int64_t i = 0; i < num_tiles; ++i) {
    ReportProgress(progress, "publish", i, num_tiles);
    const BuiltTile built = load(static_cast<size_t>(i));
    StoreTile(built, &update);
    CountTile(built.tile, &report);
  }
  // The last report: one that throws must not find the map changed.
  ReportProgress(progress, "publish", num_tiles, num_tiles);
  report.map_version = update.Publish(
      {.kind = report.replaced_session ? VersionKind::kReplace : VersionKind::kIngest,
       .session = plan.session.name,
       .summary = SummaryOf(report)});
  return report;
}

}  // namespace cairn
