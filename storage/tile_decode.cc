#include "storage/tile_decode.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <numeric>
#include <string>
#include <type_traits>

#include "storage/morton.h"
#include "storage/tile_checks.h"
#include "storage/tile_parts.h"

namespace cairn {
namespace {

// From gaps to indices, list by list, in place. Throws unless every index below `end` comes once.
void SumGaps(const std::vector<uint32_t>& begin, uint32_t end, std::span<uint32_t> members) {
  std::vector<uint64_t> seen(end / 64 + 1);
  for (size_t list = 0; list + 1 < begin.size(); ++list) {
    uint64_t next = 0;
    for (uint32_t& member : members.subspan(begin[list], begin[list + 1] - begin[list])) {
      next += member;
      if (next >= end) {
        ThrowDamagedTile("a list refers to a descriptor that is not there");
      }
      member = static_cast<uint32_t>(next);
      seen[next / 64] |= uint64_t{1} << (next % 64);
      ++next;
    }
  }
  size_t num_seen = 0;
  for (const uint64_t word : seen) {
    num_seen += std::popcount(word);
  }
  if (num_seen != members.size()) {
    ThrowDamagedTile("a descriptor is in two lists");
  }
}

template <typename Id>
void GetIds(size_t column, size_t count, TileColumnReader* reader, std::vector<Id>* ids) {
  ids->resize(count);
  reader->GetDeltas(column, [ids](size_t begin, std::span<const uint64_t> values) {
    std::transform(values.begin(), values.end(), ids->begin() + static_cast<ptrdiff_t>(begin),
                   [](uint64_t value) { return static_cast<Id>(value); });
  });
}

// The sums of all differences so far, modulo 256.
template <typename Vector>
void GetByteSums(size_t column, TileColumnReader* reader, Vector* values) {
  const std::span<const uint8_t> differences = reader->Get(column);
  values->resize(differences.size());
  std::partial_sum(differences.begin(), differences.end(), values->data());
}

void GetLandmarks(const TileHeader& header, TileColumnReader* reader, Tile* tile) {
  tile->x_in_tile.resize(header.num_landmarks);
  reader->GetDeltas(kPositionsColumn, [tile](size_t begin, std::span<const uint64_t> codes) {
    PositionsFromMorton(codes, tile->x_in_tile.data() + begin);
  });
  GetIds(kLandmarkIdsColumn, header.num_landmarks, reader, &tile->landmark_ids);
  GetIds(kLandmarkSessionsColumn, header.num_landmarks, reader, &tile->landmark_sessions);
  reader->GetOffsets(kDescriptorCountsColumn, header.num_descriptors, "descriptors",
                     &tile->descriptor_begin);
  const std::span<const uint8_t> sigmas = reader->Get(kSigmasColumn);
  tile->sigma_codes.assign(sigmas.begin(), sigmas.end());
}

void GetKeyframes(size_t count, TileColumnReader* reader, Tile* tile) {
  std::vector<KeyframeId> ids;
  std::vector<SessionId> sessions;
  GetIds(kKeyframeIdsColumn, count, reader, &ids);
  GetIds(kKeyframeSessionsColumn, count, reader, &sessions);
  ByteReader poses(reader->Get(kPosesColumn), "tile payload");
  tile->keyframes.resize(count);
  for (size_t k = 0; k < count; ++k) {
    std::array<double, kNumPoseNumbers> numbers;
    poses.GetArray(std::span<double>(numbers));
    tile->keyframes[k] = {ids[k], sessions[k], PoseFromNumbers(numbers)};
    if (!IsPose(tile->keyframes[k].cam_from_tile)) {
      ThrowDamagedTile("pose of keyframe " + std::to_string(k) + " is not a rigid transform");
    }
  }
}

void GetObservations(const TileHeader& header, TileColumnReader* reader, Tile* tile) {
  reader->GetOffsets(kObservationCountsColumn, header.num_observations, "observations",
                     &tile->keyframe_begin);
  ByteReader observations(reader->Get(kObservationsColumn), "tile payload");
  tile->keyframe_landmarks.resize(header.num_observations);
  for (size_t k = 0; k < header.num_keyframes; ++k) {
    uint32_t* landmark = tile->keyframe_landmarks.data() + tile->keyframe_begin[k];
    GetAscending(tile->keyframe_begin[k + 1] - tile->keyframe_begin[k], header.num_landmarks,
                 "a keyframe refers to a landmark that is not there", &observations,
                 [&](uint32_t index) { *landmark++ = index; });
  }
  if (observations.remaining() != 0) {
    ThrowDamagedTile("bytes are left over after the last landmark index");
  }
}

// Codes from the order of the lists to that of the tile.
void GetCodes(const TileColumns& columns, std::span<const uint32_t> members, Tile* tile) {
  const std::span<const uint8_t> codes = columns.codes();
  if (members.empty()) {
    tile->codes.assign(codes.begin(), codes.end());
    return;
  }
  tile->codes.resize(codes.size());
  const size_t code_size = tile->code_size;
  const auto copy = [&](auto size) {
    for (size_t row = 0; row < members.size(); ++row) {
      std::memcpy(tile->codes.data() + members[row] * size, codes.data() + row * size, size);
    }
  };
  if (code_size == 8) {  // The default; a constant size lets a copy be a single move.
    copy(std::integral_constant<size_t, 8>());
  } else {
    copy(code_size);
  }
}

}  // namespace

TileLists DecodeLists(const TileColumns& columns) {
  TileLists lists;
  const TileHeader& header = columns.header();
  if (header.num_lists == 0) {
    return lists;
  }
  TileColumnReader reader(columns);
  reader.GetOffsets(kListSizesColumn, header.num_descriptors, "members", &lists.begin);
  lists.members = reader.GetPlanes32(kListMembersColumn);
  SumGaps(lists.begin, header.num_descriptors, lists.members);
  return lists;
}

Tile DecodeTileColumns(const TileColumns& columns, std::span<const uint32_t> members) {
  const TileHeader& header = columns.header();
  TileColumnReader reader(columns);
  Tile tile;
  tile.id = TileIdFromPayload(header.tile_id);
  tile.codebook_id = CodebookId(header.codebook_id);
  tile.code_size = header.code_size;
  GetCodes(columns, members, &tile);
  GetLandmarks(header, &reader, &tile);
  GetByteSums(kOrientationsColumn, &reader, &tile.orientation_codes);
  GetByteSums(kSizesColumn, &reader, &tile.size_codes);
  GetByteSums(kAzimuthsColumn, &reader, &tile.azimuth_codes);
  GetKeyframes(header.num_keyframes, &reader, &tile);
  GetObservations(header, &reader, &tile);
  return tile;
}

}  // namespace cairn
