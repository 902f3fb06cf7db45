#include "ingest/maps/built_tile_codec.h"

#include <cmath>
#include <cstring>

#include "core/check.h"
#include "ingest/maps/image_row.h"
#include "ingest/maps/require_input.h"
#include "storage/tile/byte_io.h"
#include "storage/tile/checksum.h"

namespace cairn {
namespace {

constexpr uint32_t kMagic = 0x53455243;  // "CRES".
constexpr uint32_t kVersion = 1;
constexpr size_t kChecksumOffset = 8;
constexpr size_t kDigestSize = 32;

// Calls visit(member) for each number, in the order of the format.
template <typename Changes, typename Visit>
void VisitChanges(Changes& changes, const Visit& visit) {
  auto& [merged, fresh, not_needed, faded, evicted, replaced, bytes_before, bytes_after] = changes;
  for (auto* number :
       {&merged, &fresh, &not_needed, &faded, &evicted, &replaced, &bytes_before, &bytes_after}) {
    visit(*number);
  }
}

void PutRecord(const TileRecord& record, ByteWriter* writer) {
  for (const int64_t number : {int64_t{Value(record.codebook_id)}, record.num_landmarks,
                               record.num_descriptors, record.num_keyframes}) {
    writer->Put(number);
  }
  const GeoBox& bounds = record.landmark_bounds;
  for (const double number : {record.min_h_m, record.max_h_m, bounds.south_rad, bounds.west_rad,
                              bounds.north_rad, bounds.east_rad}) {
    writer->Put(number);
  }
}

TileRecord GetRecord(TileId tile_id, ByteReader* reader) {
  TileRecord record;
  record.tile_id = tile_id;
  record.codebook_id = CodebookId(reader->Get<int64_t>());
  record.num_landmarks = reader->Get<int64_t>();
  record.num_descriptors = reader->Get<int64_t>();
  record.num_keyframes = reader->Get<int64_t>();
  record.min_h_m = reader->Get<double>();
  record.max_h_m = reader->Get<double>();
  GeoBox& bounds = record.landmark_bounds;
  for (double* number :
       {&bounds.south_rad, &bounds.west_rad, &bounds.north_rad, &bounds.east_rad}) {
    *number = reader->Get<double>();
  }
  RequireInput(
      record.num_landmarks >= 0 && record.num_descriptors >= 0 && record.num_keyframes >= 0,
      "a count is negative");
  RequireInput(std::isfinite(record.min_h_m) && std::isfinite(record.max_h_m) &&
                   std::isfinite(bounds.south_rad) && std::isfinite(bounds.west_rad) &&
                   std::isfinite(bounds.north_rad) && std::isfinite(bounds.east_rad),
               "a height or a bound is not finite");
  return record;
}

}  // namespace

std::vector<uint8_t> EncodeBuiltTile(const BuiltTile& built, const std::string& plan_digest) {
  CAIRN_CHECK(plan_digest.size() == kDigestSize, "a digest must have 32 digits");
  const EncodedTile& encoded = built.tile.encoded;
  std::vector<uint8_t> bytes;
  ByteWriter writer(&bytes);
  writer.Put(kMagic);
  writer.Put(kVersion);
  writer.Put(uint64_t{0});  // Placeholder for the checksum.
  writer.PutArray(std::span<const char>(plan_digest));
  writer.Put(encoded.record.tile_id.value());
  VisitChanges(built.tile.changes, [&](int64_t number) { writer.Put(number); });
  PutRecord(encoded.record, &writer);
  writer.Put(static_cast<uint32_t>(built.tile.replaced_keyframes.size()));
  writer.Put(static_cast<uint32_t>(built.keyframes.size()));
  for (const KeyframeId id : built.tile.replaced_keyframes) {
    writer.Put(Value(id));
  }
  for (const KeyframeRecord& keyframe : built.keyframes) {
    PutImageRow(keyframe, &writer);
  }
  writer.Put(static_cast<uint64_t>(encoded.payload.size()));
  writer.PutArray(std::span<const uint8_t>(encoded.payload));
  const uint64_t checksum = ChecksumOf(bytes, kChecksumOffset);
  std::memcpy(bytes.data() + kChecksumOffset, &checksum, sizeof(checksum));
  return bytes;
}

BuiltTile DecodeBuiltTile(std::span<const uint8_t> bytes, const std::string& plan_digest,
                          TileId tile_id, SessionId session_id) {
  ByteReader reader(bytes, "result");
  RequireInput(reader.Get<uint32_t>() == kMagic && reader.Get<uint32_t>() == kVersion,
               "does not start as a result of version 1");
  const auto checksum = reader.Get<uint64_t>();
  RequireInput(checksum == ChecksumOf(bytes, kChecksumOffset), "checksum does not match");
  const std::span<const uint8_t> digest = reader.Take(kDigestSize);
  RequireInput(std::string(digest.begin(), digest.end()) == plan_digest, "belongs to another plan");
  RequireInput(reader.Get<uint64_t>() == tile_id.value(), "belongs to another tile");
  BuiltTile built;
  VisitChanges(built.tile.changes, [&](int64_t& number) {
    number = reader.Get<int64_t>();
    RequireInput(number >= 0, "a count is negative");
  });
  built.tile.encoded.record = GetRecord(tile_id, &reader);
  const auto num_replaced = reader.Get<uint32_t>();
  const auto num_keyframes = reader.Get<uint32_t>();
  for (const int64_t id : reader.GetVector<int64_t>(num_replaced)) {
    built.tile.replaced_keyframes.push_back(KeyframeId(id));
  }
  built.keyframes = GetImageRows(num_keyframes, &reader);
  for (KeyframeRecord& keyframe : built.keyframes) {
    keyframe.tile_id = tile_id;
    keyframe.session_id = session_id;
  }
  RequireInput(reader.Get<uint64_t>() == reader.remaining(),
               "has another length than its header says");
  const std::span<const uint8_t> payload = reader.Take(reader.remaining());
  built.tile.encoded.payload.assign(payload.begin(), payload.end());
  return built;
}

}  // namespace cairn
