#include "ingest/maps/recode_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <vector>

#include "core/error.h"
#include "ingest/codebook/transcoder.h"
#include "ingest/tiles/write_tile.h"
#include "storage/codebook/codebook_digest.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

// Transcodes tiles, each from the codebook that it names.
class TileTranscoder {
 public:
  TileTranscoder(const MapSnapshot& snapshot, const Codebook& target)
      : snapshot_(snapshot), target_(std::make_shared<const Codebook>(target)) {}

  void Transcode(Tile* tile) {
    if (tile->codebook_id != target_->id) {
      For(tile->codebook_id).Transcode(tile);
    }
  }

 private:
  const Transcoder& For(CodebookId codebook_id) {
    const auto found = transcoders_.find(codebook_id);
    if (found != transcoders_.end()) {
      return found->second;
    }
    return transcoders_
        .emplace(codebook_id, Transcoder(snapshot_.LoadCodebook(codebook_id), target_))
        .first->second;
  }

  const MapSnapshot& snapshot_;
  std::shared_ptr<const Codebook> target_;
  std::map<CodebookId, Transcoder> transcoders_;
};

void RequireOther(const std::vector<TileRecord>& tiles, const MapSnapshot& snapshot,
                  const Codebook& codebook, const std::string& path) {
  const std::shared_ptr<const Codebook> current = snapshot.CurrentCodebook();
  if (current == nullptr) {
    return;
  }
  const std::string reason = WhyNotTranscodable(*current, codebook);
  if (!reason.empty()) {
    throw Error(ErrorCode::kBadInput, fmt::format("{}: cannot be recoded: {}", path, reason));
  }
  const std::string digest = DigestOf(codebook);
  const bool is_coded = snapshot.CodebookDigest(current->id) == digest &&
                        std::all_of(tiles.begin(), tiles.end(), [&](const TileRecord& tile) {
                          return tile.codebook_id == current->id;
                        });
  if (is_coded) {
    throw Error(ErrorCode::kConflict,
                fmt::format("{}: is coded with codebook {} already", path, digest));
  }
}

std::string SummaryOf(const RecodeReport& report, const Codebook& codebook) {
  return fmt::format("{} descriptors in {} tiles coded with codebook {}", report.num_descriptors,
                     report.num_tiles, DigestOf(codebook));
}

}  // namespace

RecodeReport RecodeMap(const Codebook& codebook, MapStore* store,
                       const std::function<void(int64_t, int64_t)>& progress) {
  MapUpdate update = store->BeginUpdate();  // Nobody else publishes from here on.
  const MapSnapshot snapshot = store->Snapshot();
  const std::vector<TileRecord> tiles = snapshot.AllTiles(std::numeric_limits<int64_t>::max());
  RequireOther(tiles, snapshot, codebook, store->path());
  Codebook target = codebook;
  target.id = update.AddCodebook(codebook);
  TileTranscoder transcoder(snapshot, target);
  RecodeReport report;
  for (const TileRecord& record : tiles) {
    Tile tile = DecodeTile(snapshot.LoadPayload(record.payload_id));
    transcoder.Transcode(&tile);
    report.num_bytes_before += record.num_bytes;
    report.num_bytes_after += WriteTile(tile, target, &update);
    report.num_descriptors += static_cast<int64_t>(tile.num_descriptors());
    ++report.num_tiles;
    if (progress) {
      progress(report.num_tiles, std::ssize(tiles));
    }
  }
  report.map_version =
      update.Publish({.kind = VersionKind::kRecode, .summary = SummaryOf(report, codebook)});
  return report;
}

}  // namespace cairn
