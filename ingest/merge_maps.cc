#include "ingest/merge_maps.h"

#include <fmt/format.h>

#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/printable.h"
#include "ingest/tiling/renumber_tile.h"
#include "ingest/tiling/tile_edit.h"
#include "ingest/write_tile.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

constexpr int64_t kAllTiles = std::numeric_limits<int64_t>::max();

// A map that is being merged.
struct Source {
  explicit Source(const MapStore& store) : path(store.path()), snapshot(store.Snapshot()) {}

  // Names the version without the folder of the file.
  std::string Describe() const {
    return fmt::format("{}, version {}", std::filesystem::path(path).filename().string(),
                       Value(snapshot.version()));
  }

  std::string path;
  MapSnapshot snapshot;
  NewIds ids;
};

// Returns the codebook of both maps, null if neither has one. A map without sessions has none.
std::shared_ptr<const Codebook> RequireOneCodebook(const Source& a, const Source& b) {
  const auto of_a = a.snapshot.CurrentCodebook();
  const auto of_b = b.snapshot.CurrentCodebook();
  if (!of_a || !of_b) {
    return of_a ? of_a : of_b;
  }
  if (of_a->descriptor_type != of_b->descriptor_type || of_a->raw_dim() != of_b->raw_dim()) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{} holds {}-D descriptors of type '{}', {} holds {}-D descriptors of "
                            "type '{}'; such maps cannot be merged",
                            a.path, of_a->raw_dim(), Excerpt(of_a->descriptor_type), b.path,
                            of_b->raw_dim(), Excerpt(of_b->descriptor_type)));
  }
  const std::string digest_a = a.snapshot.CodebookDigest(of_a->id);
  const std::string digest_b = b.snapshot.CodebookDigest(of_b->id);
  if (digest_a != digest_b) {
    throw Error(ErrorCode::kConflict,
                fmt::format("{} is coded with codebook {}, {} with codebook {}; only maps of one "
                            "codebook can be merged",
                            a.path, digest_a, b.path, digest_b));
  }
  return of_a;
}

void RequireDistinctSessions(const Source& a, const Source& b) {
  for (const SessionRecord& of_a : a.snapshot.Sessions()) {
    for (const SessionRecord& of_b : b.snapshot.Sessions()) {
      if (of_a.name == of_b.name) {
        throw Error(ErrorCode::kConflict,
                    fmt::format("{} and {} both have a session '{}'; ingest it under another name "
                                "or remove it from one of them",
                                a.path, b.path, Excerpt(of_a.name)));
      }
      if (!of_a.content_digest.empty() && of_a.content_digest == of_b.content_digest) {
        throw Error(ErrorCode::kConflict,
                    fmt::format("session '{}' of {} and session '{}' of {} are the same recording; "
                                "remove it from one of them",
                                Excerpt(of_a.name), a.path, Excerpt(of_b.name), b.path));
      }
    }
  }
}

// Copies sessions and keyframes, and notes the ids that they get.
void CopySessions(CodebookId codebook_id, Source* source, MapUpdate* update) {
  source->ids.codebook_id = codebook_id;
  for (const SessionRecord& session : source->snapshot.Sessions()) {
    const SessionId session_id = update->AddSession(session);
    source->ids.sessions[session.id] = session_id;
    for (KeyframeRecord keyframe : source->snapshot.KeyframesOfSession(session.id)) {
      keyframe.session_id = session_id;
      source->ids.keyframes[keyframe.id] = update->AddKeyframe(keyframe);
    }
  }
  const uint64_t num_landmarks = Value(source->snapshot.NextLandmarkId()) - 1;
  source->ids.landmark_offset = Value(update->ReserveLandmarkIds(num_landmarks)) - 1;
}

// Returns the tile with the ids of the merged map, or nothing if the source has no such tile.
std::optional<Tile> LoadTile(TileId tile_id, const Source& source) {
  const std::optional<TileRecord> record = source.snapshot.FindTile(tile_id);
  if (!record) {
    return std::nullopt;
  }
  Tile tile = DecodeTile(source.snapshot.LoadPayload(record->payload_id));
  const auto codebook = source.snapshot.CurrentCodebook();
  if (codebook == nullptr || tile.codebook_id != codebook->id) {
    throw Error(ErrorCode::kMapDamaged,
                fmt::format("{}: tile {} is not coded with the map's codebook", source.path,
                            tile_id.ToString()));
  }
  RenumberTile(source.ids, &tile);
  return tile;
}

// The tiles of both maps, and in how many of the maps each is.
std::map<TileId, int> CountTiles(const Source& a, const Source& b) {
  std::map<TileId, int> counts;
  for (const Source* source : {&a, &b}) {
    for (const TileRecord& tile : source->snapshot.AllTiles(kAllTiles)) {
      ++counts[tile.tile_id];
    }
  }
  return counts;
}

void MergeInto(const Codebook& codebook, Source* a, Source* b,
               const std::function<void(int64_t, int64_t)>& progress, MapUpdate* update,
               MergeReport* report) {
  Codebook merged_codebook = codebook;
  merged_codebook.id = update->AddCodebook(codebook);
  CopySessions(merged_codebook.id, a, update);
  CopySessions(merged_codebook.id, b, update);
  const std::map<TileId, int> tiles = CountTiles(*a, *b);
  int64_t num_done = 0;
  for (const auto& [tile_id, num_maps] : tiles) {
    std::optional<Tile> tile = LoadTile(tile_id, *a);
    const std::optional<Tile> other = LoadTile(tile_id, *b);
    if (tile && other) {
      AppendTile(*other, &*tile);
      ++report->num_tiles_of_both;
    }
    WriteTile(tile ? *tile : *other, merged_codebook, update);
    if (progress) {
      progress(++num_done, std::ssize(tiles));
    }
  }
}

}  // namespace

MergeReport MergeMaps(const MapStore& a, const MapStore& b, const std::string& to,
                      const std::function<void(int64_t, int64_t)>& progress) {
  Source source_a(a);
  Source source_b(b);
  const std::shared_ptr<const Codebook> codebook = RequireOneCodebook(source_a, source_b);
  RequireDistinctSessions(source_a, source_b);
  MergeReport report;
  MapStore::CreateFilled(to, [&](MapStore* store) {
    MapUpdate update = store->BeginUpdate();
    if (codebook != nullptr) {
      MergeInto(*codebook, &source_a, &source_b, progress, &update, &report);
    }
    update.Publish({.kind = VersionKind::kMerge,
                    .summary = source_a.Describe() + " and " + source_b.Describe()});
    report.totals = store->Snapshot().Info();
  });
  return report;
}

}  // namespace cairn
