#include "storage/tile/tile_decode.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <numeric>
#include <string>
#include <type_traits>

#include "core/simd.h"
#include "storage/tile/morton.h"
#include "storage/tile/pose_bytes.h"
#include "storage/tile/tile_checks.h"
#include "storage/tile/tile_parts.h"

namespace cairn {
namespace {

// Converts gaps to indices in place, list by list. Throws unless every index below `end` occurs
// exactly once.
void SumGaps(const std::vector<uint32_t>& begin, uint32_t end, std::span<uint32_t> members) {
  std::vector<uint64_t> seen(end / 64 + 1);
  for (size_t list = 0; list + 1 < begin.size(); ++list) {
    uint64_t next = 0;
    for (uint32_t& member : members.subspan(begin[list], begin[list + 1] - begin[list])) {
      next += member;
      if (next >= end) {
        ThrowDamagedTile("a list refers to a missing descriptor");
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

// Destination arrays of landmarks and descriptors; see TileLandmarks.
struct LandmarkArrays {
  LandmarkId* landmark_ids;
  Eigen::Vector3f* x_in_tile;
  uint8_t* sigma_codes;
  uint32_t* descriptor_begin;
  uint8_t* orientation_codes;
  uint8_t* size_codes;
  uint8_t* azimuth_codes;
};

// Hands out consecutive parts of a block of memory, each aligned to a cache line. Without a block,
// it only counts the bytes needed.
class Allotter {
 public:
  explicit Allotter(uint8_t* memory) : memory_(memory) {}

  template <typename T>
  T* Take(size_t count) {
    T* values = nullptr;
    if (memory_ != nullptr) {
      values = reinterpret_cast<T*>(memory_ + size_);
      std::uninitialized_default_construct_n(values, count);  // Does not initialize numbers.
    }
    size_ += (count * sizeof(T) + kCacheLineBytes - 1) / kCacheLineBytes * kCacheLineBytes;
    return values;
  }
  size_t size() const { return size_; }

 private:
  static constexpr size_t kCacheLineBytes = 64;

  uint8_t* memory_;
  size_t size_ = 0;
};

template <typename Id>
void GetIds(size_t column, TileColumnReader* reader, Id* ids) {
  reader->GetSums(column, Difference::kSigned,
                  [ids](size_t begin, std::span<const uint64_t> values) {
                    std::transform(values.begin(), values.end(), ids + begin,
                                   [](uint64_t value) { return static_cast<Id>(value); });
                  });
}

// Replaces each byte by the sum of all bytes up to it, modulo 256. Sixteen bytes are summed at a
// time by doubling, and the total of the preceding bytes is added last, so only one addition
// depends on the previous block.
CAIRN_EXACT_VECTOR_CLONES void SumBytes(uint8_t* values, size_t count) {
  using Bytes = Lanes<uint8_t, 16>;
  constexpr Bytes kZeros = {};
  Bytes before = {};
  size_t i = 0;
  for (; i + sizeof(Bytes) <= count; i += sizeof(Bytes)) {
    Bytes sums;
    std::memcpy(&sums, values + i, sizeof(sums));
    sums += __builtin_shufflevector(kZeros, sums, 0, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27,
                                    28, 29, 30);
    sums += __builtin_shufflevector(kZeros, sums, 0, 1, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26,
                                    27, 28, 29);
    sums += __builtin_shufflevector(kZeros, sums, 0, 1, 2, 3, 16, 17, 18, 19, 20, 21, 22, 23, 24,
                                    25, 26, 27);
    sums += __builtin_shufflevector(kZeros, sums, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21,
                                    22, 23);
    const Bytes all = __builtin_shufflevector(sums, sums, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15,
                                              15, 15, 15, 15, 15, 15);
    sums += before;
    before += all;
    std::memcpy(values + i, &sums, sizeof(sums));
  }
  uint8_t sum = before[0];
  for (; i < count; ++i) {
    sum = static_cast<uint8_t>(sum + values[i]);
    values[i] = sum;
  }
}

void GetByteSums(size_t column, size_t count, TileColumnReader* reader, uint8_t* values) {
  reader->Get(column, std::span<uint8_t>(values, count));
  SumBytes(values, count);
}

void GetLandmarks(const TileHeader& header, TileColumnReader* reader, const LandmarkArrays& to) {
  reader->GetSums(kPositionsColumn, Difference::kUnsigned,
                  [&to](size_t begin, std::span<const uint64_t> codes) {
                    PositionsFromMorton(codes, to.x_in_tile + begin);
                  });
  GetIds(kLandmarkIdsColumn, reader, to.landmark_ids);
  reader->GetOffsets(kDescriptorCountsColumn, header.num_descriptors, "descriptors",
                     to.descriptor_begin);
  reader->Get(kSigmasColumn, std::span<uint8_t>(to.sigma_codes, header.num_landmarks));
  GetByteSums(kOrientationsColumn, header.num_descriptors, reader, to.orientation_codes);
  GetByteSums(kSizesColumn, header.num_descriptors, reader, to.size_codes);
  GetByteSums(kAzimuthsColumn, header.num_descriptors, reader, to.azimuth_codes);
}

void GetHistories(const TileHeader& header, TileColumnReader* reader, Tile* tile) {
  tile->history_begin = {0};
  for (const uint8_t count : reader->Get(kHistoryCountsColumn)) {
    tile->history_begin.push_back(tile->history_begin.back() + count);
  }
  if (tile->history_begin.back() != header.num_history_entries) {
    ThrowDamagedTile("counts of histories do not add up");
  }
  std::vector<SessionId> sessions(header.num_history_entries);
  GetIds(kHistorySessionsColumn, reader, sessions.data());
  std::vector<uint8_t> observations(header.num_history_entries),
      chances(header.num_history_entries);
  reader->Get(kHistoryObservationsColumn, observations);
  reader->Get(kChancesColumn, chances);
  for (size_t i = 0; i < sessions.size(); ++i) {
    tile->history.push_back({sessions[i], observations[i], chances[i]});
  }
  if (const std::string problem = FindHistoryProblem(*tile); !problem.empty()) {
    ThrowDamagedTile(problem);
  }
}

std::vector<TileKeyframe> GetKeyframes(size_t count, TileColumnReader* reader) {
  std::vector<KeyframeId> ids(count);
  std::vector<SessionId> sessions(count);
  GetIds(kKeyframeIdsColumn, reader, ids.data());
  GetIds(kKeyframeSessionsColumn, reader, sessions.data());
  ByteReader poses(reader->Get(kPosesColumn), "tile payload");
  std::vector<TileKeyframe> keyframes(count);
  for (size_t k = 0; k < count; ++k) {
    keyframes[k] = {ids[k], sessions[k], GetPose(&poses)};
    if (!IsPose(keyframes[k].cam_from_tile)) {
      ThrowDamagedTile("pose of keyframe " + std::to_string(k) + " is not a rigid transform");
    }
  }
  return keyframes;
}

// Decodes num_keyframes + 1 offsets into `begin`, and begin[num_keyframes] landmark indices into
// `landmarks`.
void GetObservations(const TileHeader& header, TileColumnReader* reader, uint32_t* begin,
                     uint32_t* landmarks) {
  reader->GetOffsets(kObservationCountsColumn, header.num_observations, "observations", begin);
  ByteReader observations(reader->Get(kObservationsColumn), "tile payload");
  for (size_t k = 0; k < header.num_keyframes; ++k) {
    uint32_t* landmark = landmarks + begin[k];
    GetAscending(begin[k + 1] - begin[k], header.num_landmarks,
                 "a keyframe refers to a missing landmark", &observations,
                 [&](uint32_t index) { *landmark++ = index; });
  }
  if (observations.remaining() != 0) {
    ThrowDamagedTile("unexpected bytes follow the last landmark index");
  }
}

// Reorders codes from list order to tile order.
void PutInTileOrder(const TileColumns& columns, std::span<const uint32_t> members, uint8_t* to) {
  const std::span<const uint8_t> codes = columns.codes();
  if (members.empty()) {
    std::copy(codes.begin(), codes.end(), to);
    return;
  }
  const size_t code_size = columns.header().code_size;
  const auto copy = [&](auto size) {
    for (size_t row = 0; row < members.size(); ++row) {
      std::memcpy(to + members[row] * size, codes.data() + row * size, size);
    }
  };
  if (code_size == 8) {  // The default size; a constant lets a copy be a single move.
    copy(std::integral_constant<size_t, 8>());
  } else {
    copy(code_size);
  }
}

LandmarkArrays AllotLandmarks(const TileHeader& header, Allotter* memory) {
  const size_t num_landmarks = header.num_landmarks, num_descriptors = header.num_descriptors;
  return {.landmark_ids = memory->Take<LandmarkId>(num_landmarks),
          .x_in_tile = memory->Take<Eigen::Vector3f>(num_landmarks),
          .sigma_codes = memory->Take<uint8_t>(num_landmarks),
          .descriptor_begin = memory->Take<uint32_t>(num_landmarks + 1),
          .orientation_codes = memory->Take<uint8_t>(num_descriptors),
          .size_codes = memory->Take<uint8_t>(num_descriptors),
          .azimuth_codes = memory->Take<uint8_t>(num_descriptors)};
}

}  // namespace

TileLists DecodeLists(const TileColumns& columns) {
  TileLists lists;
  const TileHeader& header = columns.header();
  if (header.num_lists == 0) {
    return lists;
  }
  TileColumnReader reader(columns);
  lists.begin.resize(size_t{header.num_lists} + 1);
  reader.GetOffsets(kListSizesColumn, header.num_descriptors, "members", lists.begin.data());
  lists.members = reader.GetPlanes32(kListMembersColumn);
  SumGaps(lists.begin, header.num_descriptors, lists.members);
  return lists;
}

LoadedLandmarks DecodeLandmarks(const TileColumns& columns) {
  const TileHeader& header = columns.header();
  Allotter none(nullptr);
  AllotLandmarks(header, &none);
  LoadedLandmarks loaded;
  loaded.memory.resize(none.size());
  Allotter memory(loaded.memory.data());
  const LandmarkArrays arrays = AllotLandmarks(header, &memory);
  TileColumnReader reader(columns);
  GetLandmarks(header, &reader, arrays);
  const size_t num_landmarks = header.num_landmarks, num_descriptors = header.num_descriptors;
  loaded.view.landmark_ids = {arrays.landmark_ids, num_landmarks};
  loaded.view.x_in_tile = {arrays.x_in_tile, num_landmarks};
  loaded.view.sigma_codes = {arrays.sigma_codes, num_landmarks};
  loaded.view.descriptor_begin = {arrays.descriptor_begin, num_landmarks + 1};
  loaded.view.orientation_codes = {arrays.orientation_codes, num_descriptors};
  loaded.view.size_codes = {arrays.size_codes, num_descriptors};
  loaded.view.azimuth_codes = {arrays.azimuth_codes, num_descriptors};
  return loaded;
}

LoadedCovisibility DecodeCovisibility(const TileColumns& columns) {
  const TileHeader& header = columns.header();
  TileColumnReader reader(columns);
  LoadedCovisibility loaded;
  loaded.keyframes = GetKeyframes(header.num_keyframes, &reader);
  loaded.keyframe_begin.resize(size_t{header.num_keyframes} + 1);
  loaded.keyframe_landmarks.resize(header.num_observations);
  GetObservations(header, &reader, loaded.keyframe_begin.data(), loaded.keyframe_landmarks.data());
  return loaded;
}

LargeVector<uint8_t> CodesInTileOrder(const TileColumns& columns,
                                      std::span<const uint32_t> members) {
  LargeVector<uint8_t> codes(columns.codes().size());
  PutInTileOrder(columns, members, codes.data());
  return codes;
}

Tile DecodeTileColumns(const TileColumns& columns, std::span<const uint32_t> members) {
  const TileHeader& header = columns.header();
  const size_t num_landmarks = header.num_landmarks, num_descriptors = header.num_descriptors;
  TileColumnReader reader(columns);
  Tile tile;
  tile.id = TileIdFromPayload(header.tile_id);
  tile.codebook_id = CodebookId(header.codebook_id);
  tile.code_size = header.code_size;
  tile.codes.resize(columns.codes().size());
  PutInTileOrder(columns, members, tile.codes.data());
  tile.landmark_ids.resize(num_landmarks);
  tile.x_in_tile.resize(num_landmarks);
  tile.sigma_codes.resize(num_landmarks);
  tile.descriptor_begin.resize(num_landmarks + 1);
  tile.orientation_codes.resize(num_descriptors);
  tile.size_codes.resize(num_descriptors);
  tile.azimuth_codes.resize(num_descriptors);
  GetLandmarks(header, &reader,
               {tile.landmark_ids.data(), tile.x_in_tile.data(), tile.sigma_codes.data(),
                tile.descriptor_begin.data(), tile.orientation_codes.data(), tile.size_codes.data(),
                tile.azimuth_codes.data()});
  GetHistories(header, &reader, &tile);
  tile.weight_codes.resize(num_descriptors);
  reader.Get(kWeightsColumn, tile.weight_codes);
  tile.keyframes = GetKeyframes(header.num_keyframes, &reader);
  tile.keyframe_begin.resize(size_t{header.num_keyframes} + 1);
  tile.keyframe_landmarks.resize(header.num_observations);
  GetObservations(header, &reader, tile.keyframe_begin.data(), tile.keyframe_landmarks.data());
  return tile;
}

}  // namespace cairn
