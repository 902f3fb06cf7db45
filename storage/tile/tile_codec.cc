#include "storage/tile/tile_codec.h"

#include <algorithm>
#include <functional>
#include <string>

#include "core/error.h"
#include "storage/tile/byte_io.h"
#include "storage/tile/morton.h"
#include "storage/tile/pose_bytes.h"
#include "storage/tile/tile_checks.h"
#include "storage/tile/tile_columns.h"
#include "storage/tile/tile_decode.h"
#include "storage/tile/tile_parts.h"

namespace cairn {
namespace {

// Writes the difference of each value to its predecessor, zigzag-coded, in byte planes.
template <typename Range, typename ToUnsigned>
void PutDeltas(const Range& values, const ToUnsigned& to_unsigned, TileColumnWriter* writer) {
  std::vector<uint64_t> deltas(values.size());
  uint64_t previous = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    const auto value = static_cast<uint64_t>(to_unsigned(values[i]));
    deltas[i] = ZigZag(value - previous);
    previous = value;
  }
  writer->PutPlanes(std::span<const uint64_t>(deltas));
}

// Writes the difference of each Morton code to its predecessor, modulo 2^64, in byte planes. Codes
// ascend along the curve, so the differences need no sign.
void PutPositions(const std::vector<Eigen::Vector3f>& x_in_tile, TileColumnWriter* writer) {
  std::vector<uint64_t> gaps(x_in_tile.size());
  uint64_t previous = 0;
  for (size_t i = 0; i < x_in_tile.size(); ++i) {
    const uint64_t code = MortonFromPosition(x_in_tile[i]);
    gaps[i] = code - previous;
    previous = code;
  }
  writer->PutPlanes(std::span<const uint64_t>(gaps));
}

// Writes the sizes of the groups that the offsets delimit.
void PutGroupSizes(std::span<const uint32_t> begin, TileColumnWriter* writer) {
  std::vector<uint32_t> sizes(begin.size() - 1);
  for (size_t i = 0; i < sizes.size(); ++i) {
    sizes[i] = begin[i + 1] - begin[i];
  }
  writer->PutPlanes(std::span<const uint32_t>(sizes));
}

void PutByteDifferences(std::span<const uint8_t> values, TileColumnWriter* writer) {
  std::vector<uint8_t> differences(values.size());
  uint8_t previous = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    differences[i] = static_cast<uint8_t>(values[i] - previous);
    previous = values[i];
  }
  writer->Put(differences);
}

void PutHistories(const Tile& tile, TileColumnWriter* writer) {
  std::vector<uint8_t> counts(tile.num_landmarks());
  for (size_t i = 0; i < counts.size(); ++i) {
    counts[i] = static_cast<uint8_t>(tile.HistoryOf(i).size());
  }
  std::vector<uint8_t> observations(tile.history.size()), chances(tile.history.size());
  for (size_t i = 0; i < tile.history.size(); ++i) {
    observations[i] = tile.history[i].num_observations;
    chances[i] = tile.history[i].num_chances;
  }
  writer->Put(counts);
  PutDeltas(
      tile.history, [](const HistoryEntry& s) { return Value(s.session_id); }, writer);
  writer->Put(observations);
  writer->Put(chances);
}

void PutKeyframes(const std::vector<TileKeyframe>& keyframes, TileColumnWriter* writer) {
  PutDeltas(
      keyframes, [](const TileKeyframe& keyframe) { return Value(keyframe.id); }, writer);
  PutDeltas(
      keyframes, [](const TileKeyframe& keyframe) { return Value(keyframe.session_id); }, writer);
  std::vector<uint8_t> poses;
  ByteWriter poses_writer(&poses);
  for (const TileKeyframe& keyframe : keyframes) {
    PutPose(keyframe.cam_from_tile, &poses_writer);
  }
  writer->Put(poses);
}

// Encodes the landmark indices of each keyframe: the first index, then each gap minus 1, since
// indices ascend.
std::vector<uint8_t> EncodeObservations(const Tile& tile) {
  std::vector<uint8_t> observations;
  ByteWriter writer(&observations);
  for (size_t k = 0; k < tile.num_keyframes(); ++k) {
    uint32_t next = 0;
    for (const uint32_t landmark_idx : tile.LandmarksOfKeyframe(k)) {
      writer.PutVarint(landmark_idx - next);
      next = landmark_idx + 1;
    }
  }
  return observations;
}

void RequireListsOf(const TileLists& lists, const Tile& tile) {
  bool is_sound = lists.num_lists() <= tile.num_descriptors() && lists.begin.front() == 0 &&
                  lists.begin.back() == tile.num_descriptors() &&
                  lists.members.size() == tile.num_descriptors() &&
                  std::is_sorted(lists.begin.begin(), lists.begin.end());
  for (size_t list = 0; is_sound && list < lists.num_lists(); ++list) {
    const std::span<const uint32_t> members = lists.Members(list);
    is_sound = std::is_sorted(members.begin(), members.end(), std::less_equal<>());
  }
  if (!is_sound) {
    throw Error(ErrorCode::kInternal, "the lists do not match the tile's descriptors");
  }
}

void PutLists(const TileLists& lists, TileColumnWriter* writer) {
  if (lists.num_lists() == 0) {
    writer->PutPlanes(std::span<const uint32_t>());
    writer->PutPlanes(std::span<const uint32_t>());
    return;
  }
  PutGroupSizes(lists.begin, writer);
  std::vector<uint32_t> gaps;
  gaps.reserve(lists.members.size());
  for (size_t list = 0; list < lists.num_lists(); ++list) {
    uint32_t next = 0;
    for (const uint32_t member : lists.Members(list)) {
      gaps.push_back(member - next);
      next = member + 1;
    }
  }
  writer->PutPlanes(std::span<const uint32_t>(gaps));
}

}  // namespace

std::vector<uint8_t> EncodeTile(const Tile& tile, const TileLists& lists) {
  tile.Validate();
  if (!lists.empty()) {
    RequireListsOf(lists, tile);
  }
  const std::vector<uint8_t> observations = EncodeObservations(tile);
  TileColumnWriter writer;
  PutLists(lists, &writer);
  PutPositions(tile.x_in_tile, &writer);
  PutDeltas(
      tile.landmark_ids, [](LandmarkId id) { return Value(id); }, &writer);
  PutGroupSizes(tile.descriptor_begin, &writer);
  writer.Put(tile.sigma_codes);
  PutHistories(tile, &writer);
  PutByteDifferences(tile.orientation_codes, &writer);
  PutByteDifferences(tile.size_codes, &writer);
  PutByteDifferences(tile.azimuth_codes, &writer);
  writer.Put(tile.weight_codes);
  PutKeyframes(tile.keyframes, &writer);
  PutGroupSizes(tile.keyframe_begin, &writer);
  writer.Put(observations);

  TileHeader header;
  header.code_size = static_cast<uint16_t>(tile.code_size);
  header.tile_id = tile.id.value();
  header.codebook_id = Value(tile.codebook_id);
  header.num_landmarks = static_cast<uint32_t>(tile.num_landmarks());
  header.num_history_entries = static_cast<uint32_t>(tile.history.size());
  header.num_descriptors = static_cast<uint32_t>(tile.num_descriptors());
  header.num_keyframes = static_cast<uint32_t>(tile.num_keyframes());
  header.num_observations = static_cast<uint32_t>(tile.keyframe_landmarks.size());
  header.num_lists = static_cast<uint32_t>(lists.num_lists());
  header.observations_size = static_cast<uint32_t>(observations.size());
  return writer.Finish(header, OrderCodes(tile.codes, tile.code_size, lists));
}

Tile DecodeTile(std::span<const uint8_t> blob, const TileDecodeLimits& limits) {
  TileLists lists;
  return DecodeTile(blob, limits, &lists);
}

Tile DecodeTile(std::span<const uint8_t> blob, const TileDecodeLimits& limits, TileLists* lists) {
  const TileColumns columns(blob, limits);
  *lists = DecodeLists(columns);
  return DecodeTileColumns(columns, lists->members);
}

std::set<SessionId> SessionsInTile(const Tile& tile) {
  std::set<SessionId> sessions;
  for (const HistoryEntry& entry : tile.history) {
    sessions.insert(entry.session_id);
  }
  for (const TileKeyframe& keyframe : tile.keyframes) {
    sessions.insert(keyframe.session_id);
  }
  sessions.erase(SessionId{});
  return sessions;
}

std::set<SessionId> SessionsInPayload(std::span<const uint8_t> blob) {
  std::set<SessionId> sessions;
  if (!TileColumns::IsPayload(blob)) {
    return sessions;
  }
  const TileColumns columns(blob, TileDecodeLimits());
  TileColumnReader reader(columns);
  for (const size_t column : {kHistorySessionsColumn, kKeyframeSessionsColumn}) {
    reader.GetSums(column, Difference::kSigned, [&](size_t, std::span<const uint64_t> values) {
      for (const uint64_t value : values) {
        sessions.insert(SessionId(static_cast<int64_t>(value)));
      }
    });
  }
  sessions.erase(SessionId{});
  return sessions;
}

}  // namespace cairn
