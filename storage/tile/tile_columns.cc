#include "storage/tile/tile_columns.h"

#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <string>

#include "core/simd.h"
#include "storage/tile/byte_io.h"
#include "storage/tile/checksum.h"
#include "storage/tile/pose_bytes.h"
#include "storage/tile/tile.h"
#include "storage/tile/tile_checks.h"
#include "storage/tile/tile_parts.h"

namespace cairn {
namespace {

// On the tile of cairn_storage_bench, higher levels save less than 1 % of the payload, and reading
// level 3 takes 50 % longer.
constexpr int kZstdLevel = 1;
// A column is compressed only if compression saves at least 1/8 of it; a smaller saving is not
// worth the decoding time.
constexpr size_t kMinSavingDivisor = 8;
constexpr size_t kDirectorySize = kNumTileColumns * sizeof(uint32_t);

bool IsConstant(std::span<const uint8_t> bytes) {
  return !bytes.empty() &&
         std::all_of(bytes.begin(), bytes.end(), [&](uint8_t byte) { return byte == bytes[0]; });
}

// Adds the bytes of a plane, shifted left by `shift` bits. There are two functions because target
// clones do not work on templates.
CAIRN_EXACT_VECTOR_CLONES void AddPlane(const uint8_t* plane, size_t count, int shift,
                                        uint32_t* values) {
  for (size_t i = 0; i < count; ++i) {
    values[i] |= uint32_t{plane[i]} << shift;
  }
}
CAIRN_EXACT_VECTOR_CLONES void AddPlane(const uint8_t* plane, size_t count, int shift,
                                        uint64_t* values) {
  for (size_t i = 0; i < count; ++i) {
    values[i] |= uint64_t{plane[i]} << shift;
  }
}

// Number of values that are processed together; as 64-bit numbers, they fill half of the level 1
// cache.
constexpr size_t kStretch = 2048;

// Joins numbers from their byte planes, starting with number `begin`. A null plane stands for
// zeros.
template <typename T>
void JoinPlanes(const std::array<const uint8_t*, sizeof(T)>& planes, size_t begin, size_t count,
                T* values) {
  std::fill_n(values, count, T{0});
  for (size_t i = 0; i < planes.size(); ++i) {
    if (planes[i] != nullptr) {
      AddPlane(planes[i] + begin, count, static_cast<int>(8 * i), values);
    }
  }
}

void PutHeader(const TileHeader& header, uint64_t columns_size, ByteWriter* writer) {
  writer->Put(kTileMagic);
  writer->Put(kTileVersion);
  writer->Put(header.code_size);
  writer->Put(header.tile_id);
  writer->Put(header.codebook_id);
  writer->Put(header.num_landmarks);
  writer->Put(header.num_descriptors);
  writer->Put(header.num_keyframes);
  writer->Put(header.num_observations);
  writer->Put(header.num_lists);
  writer->Put(header.observations_size);
  writer->Put(header.num_history_entries);
  writer->Put(uint32_t{0});  // Not used.
  writer->Put(columns_size);
  writer->Put(uint64_t{0});  // Placeholder for the checksum.
}

// Reads the header after magic and version.
TileHeader GetHeader(ByteReader* reader) {
  TileHeader header;
  header.code_size = reader->Get<uint16_t>();
  header.tile_id = reader->Get<uint64_t>();
  header.codebook_id = reader->Get<int64_t>();
  header.num_landmarks = reader->Get<uint32_t>();
  header.num_descriptors = reader->Get<uint32_t>();
  header.num_keyframes = reader->Get<uint32_t>();
  header.num_observations = reader->Get<uint32_t>();
  header.num_lists = reader->Get<uint32_t>();
  header.observations_size = reader->Get<uint32_t>();
  header.num_history_entries = reader->Get<uint32_t>();
  if (reader->Get<uint32_t>() != 0) {
    ThrowDamagedTile("has a number where there should be none");
  }
  return header;
}

void CheckHeader(const TileHeader& header, const TileDecodeLimits& limits) {
  if (header.num_landmarks > limits.max_landmarks ||
      header.num_descriptors > limits.max_descriptors ||
      header.num_keyframes > limits.max_keyframes ||
      header.observations_size > limits.max_decoded_bytes ||
      header.TileSize() > limits.max_decoded_bytes) {
    ThrowDamagedTile("announces more landmarks, descriptors or keyframes than the limits allow");
  }
  if (header.code_size > kMaxCodeSize || (header.code_size == 0 && header.num_descriptors > 0)) {
    ThrowDamagedTile("code size " + std::to_string(header.code_size) + " is out of range");
  }
  if (header.num_history_entries > Tile::kMaxHistory * uint64_t{header.num_landmarks}) {
    ThrowDamagedTile("has longer histories than landmarks can have");
  }
  if (header.num_lists > header.num_descriptors) {
    ThrowDamagedTile("has more lists than descriptors");
  }
  if (header.observations_size < header.num_observations ||
      header.observations_size > kMaxVarintSize * uint64_t{header.num_observations}) {
    ThrowDamagedTile("announced sizes contradict each other");
  }
}

}  // namespace

size_t TileHeader::ColumnSize(size_t column) const {
  struct Range {
    size_t end;
    size_t size;
  };
  const Range ranges[] = {{kListMembersColumn, num_lists},
                          {kPositionsColumn, num_members()},
                          {kHistorySessionsColumn, num_landmarks},
                          {kOrientationsColumn, num_history_entries},
                          {kKeyframeIdsColumn, num_descriptors},
                          {kPosesColumn, num_keyframes},
                          {kObservationCountsColumn, num_keyframes * kPoseBytes},
                          {kObservationsColumn, num_keyframes},
                          {kNumTileColumns, observations_size}};
  return std::find_if(std::begin(ranges), std::end(ranges),
                      [column](const Range& range) { return column < range.end; })
      ->size;
}

uint64_t TileHeader::LandmarksSize() const {
  constexpr uint64_t kPerLandmark =
      sizeof(LandmarkId) + sizeof(Eigen::Vector3f) + sizeof(uint32_t) + 1;
  return kPerLandmark * num_landmarks + 3 * uint64_t{num_descriptors};
}

uint64_t TileHeader::CovisibilitySize() const {
  return (sizeof(TileKeyframe) + sizeof(uint32_t)) * num_keyframes +
         sizeof(uint32_t) * uint64_t{num_observations};
}

uint64_t TileHeader::TileSize() const {
  return LandmarksSize() + CovisibilitySize() + sizeof(uint32_t) * uint64_t{num_landmarks} +
         sizeof(HistoryEntry) * uint64_t{num_history_entries} + num_descriptors + codes_size();
}

void TileColumnWriter::Put(std::span<const uint8_t> column) {
  const size_t begin = bytes_.size();
  if (column.size() > 1 && IsConstant(column)) {
    bytes_.push_back(column[0]);
  } else {
    bytes_.resize(begin + ZSTD_compressBound(column.size()));
    const size_t size = ZSTD_compress(bytes_.data() + begin, bytes_.size() - begin, column.data(),
                                      column.size(), kZstdLevel);
    if (ZSTD_isError(size)) {
      throw Error(ErrorCode::kInternal, std::string("zstd: ") + ZSTD_getErrorName(size));
    }
    bytes_.resize(begin + size);
    if (size + column.size() / kMinSavingDivisor >= column.size()) {
      bytes_.resize(begin);
      bytes_.insert(bytes_.end(), column.begin(), column.end());
    }
  }
  stored_sizes_.push_back(static_cast<uint32_t>(bytes_.size() - begin));
}

std::vector<uint8_t> TileColumnWriter::Finish(const TileHeader& header,
                                              std::span<const uint8_t> codes) const {
  std::vector<uint8_t> payload;
  payload.reserve(kTileHeaderSize + kDirectorySize + codes.size() + bytes_.size());
  ByteWriter writer(&payload);
  PutHeader(header, bytes_.size(), &writer);
  writer.PutArray(std::span<const uint32_t>(stored_sizes_));
  writer.PutArray(codes);
  writer.PutArray(std::span<const uint8_t>(bytes_));
  const uint64_t checksum = ChecksumOf(payload, kTileChecksumOffset);
  std::memcpy(payload.data() + kTileChecksumOffset, &checksum, sizeof(checksum));
  return payload;
}

bool TileColumns::IsPayload(std::span<const uint8_t> payload) {
  if (payload.size() < kTileHeaderSize) {
    return false;
  }
  ByteReader reader(payload, "tile payload");
  return reader.Get<uint32_t>() == kTileMagic && reader.Get<uint16_t>() == kTileVersion;
}

bool TileColumns::HasLists(std::span<const uint8_t> payload) {
  constexpr size_t kNumListsOffset = 40;
  ByteReader reader(payload.subspan(kNumListsOffset), "tile payload");
  return reader.Get<uint32_t>() > 0;
}

TileColumns::TileColumns(std::span<const uint8_t> payload, const TileDecodeLimits& limits) {
  if (!IsPayload(payload)) {
    ThrowDamagedTile("is not of format version 1");
  }
  ByteReader reader(payload.subspan(sizeof(uint32_t) + sizeof(uint16_t)), "tile payload");
  header_ = GetHeader(&reader);
  CheckHeader(header_, limits);
  const auto columns_size = reader.Get<uint64_t>();
  // Nothing can overflow here: codes_size is limited above, and differences are compared.
  if (payload.size() < kTileHeaderSize + kDirectorySize + header_.codes_size() ||
      payload.size() - kTileHeaderSize - kDirectorySize - header_.codes_size() != columns_size) {
    ThrowDamagedTile("is " + std::to_string(payload.size()) +
                     " bytes long, which contradicts its header");
  }
  if (reader.Get<uint64_t>() != ChecksumOf(payload, kTileChecksumOffset)) {
    ThrowDamagedTile("checksum does not match");
  }
  std::array<uint32_t, kNumTileColumns> stored_sizes;
  reader.GetArray(std::span<uint32_t>(stored_sizes));
  begin_[0] = 0;
  for (size_t column = 0; column < kNumTileColumns; ++column) {
    if (stored_sizes[column] > header_.ColumnSize(column)) {
      ThrowDamagedTile("a stored column is longer than its content");
    }
    begin_[column + 1] = begin_[column] + stored_sizes[column];
  }
  if (begin_.back() != columns_size) {
    ThrowDamagedTile("the stored columns do not add up to the payload's size");
  }
  codes_ = reader.Take(header_.codes_size());
  stored_ = reader.Take(columns_size);
  TileIdFromPayload(header_.tile_id);
}

TileColumnReader::TileColumnReader(const TileColumns& columns)
    : columns_(columns), context_(ZSTD_createDCtx(), &ZSTD_freeDCtx) {}

TileColumnReader::~TileColumnReader() = default;

std::span<const uint8_t> TileColumnReader::Get(size_t column) {
  return Get(column, &decoded_.front());
}

std::span<const uint8_t> TileColumnReader::Get(size_t column, LargeVector<uint8_t>* buffer) {
  const std::span<const uint8_t> stored = columns_.Stored(column);
  const size_t size = columns_.header().ColumnSize(column);
  if (stored.size() == size) {
    return stored;
  }
  buffer->resize(std::max(buffer->size(), size));
  const std::span<uint8_t> decoded(buffer->data(), size);
  Get(column, decoded);
  return decoded;
}

void TileColumnReader::Get(size_t column, std::span<uint8_t> to) {
  const std::span<const uint8_t> stored = columns_.Stored(column);
  if (stored.size() == to.size()) {
    std::copy(stored.begin(), stored.end(), to.begin());
  } else if (stored.size() == 1) {
    std::fill(to.begin(), to.end(), stored[0]);
  } else if (ZSTD_getFrameContentSize(stored.data(), stored.size()) != to.size() ||
             ZSTD_findFrameCompressedSize(stored.data(), stored.size()) != stored.size() ||
             ZSTD_decompressDCtx(context_.get(), to.data(), to.size(), stored.data(),
                                 stored.size()) != to.size()) {
    ThrowDamagedTile("column " + std::to_string(column) +
                     " is not a compressed frame of the announced size");
  }
}

template <typename T>
std::array<const uint8_t*, sizeof(T)> TileColumnReader::GetPlanes(size_t column) {
  const bool is_longer = columns_.header().ColumnSize(column) > 1;
  std::array<const uint8_t*, sizeof(T)> planes{};
  for (size_t i = 0; i < sizeof(T); ++i) {
    const std::span<const uint8_t> stored = columns_.Stored(column + i);
    const bool is_zero = is_longer && stored.size() == 1 && stored[0] == 0;
    planes[i] = is_zero ? nullptr : Get(column + i, &decoded_[i]).data();
  }
  return planes;
}

LargeVector<uint32_t> TileColumnReader::GetPlanes32(size_t column) {
  const std::array planes = GetPlanes<uint32_t>(column);
  LargeVector<uint32_t> values(columns_.header().ColumnSize(column));
  for (size_t begin = 0; begin < values.size(); begin += kStretch) {
    JoinPlanes(planes, begin, std::min(kStretch, values.size() - begin), values.data() + begin);
  }
  return values;
}

void TileColumnReader::GetSums(size_t column, Difference difference,
                               const std::function<void(size_t, std::span<const uint64_t>)>& take) {
  const std::array planes = GetPlanes<uint64_t>(column);
  const size_t size = columns_.header().ColumnSize(column);
  std::array<uint64_t, kStretch> values;
  uint64_t sum = 0;
  for (size_t begin = 0; begin < size; begin += kStretch) {
    const size_t count = std::min(kStretch, size - begin);
    JoinPlanes(planes, begin, count, values.data());
    if (difference == Difference::kSigned) {
      std::transform(values.begin(), values.begin() + count, values.begin(), UnZigZag);
    }
    for (size_t i = 0; i < count; ++i) {
      sum += values[i];
      values[i] = sum;
    }
    take(begin, {values.data(), count});
  }
}

void TileColumnReader::GetOffsets(size_t column, uint32_t total, const char* what,
                                  uint32_t* begin) {
  const std::array planes = GetPlanes<uint32_t>(column);
  const size_t num_groups = columns_.header().ColumnSize(column);
  std::array<uint32_t, kStretch> sizes;
  // Offsets are stored as 32 bits, which suffice up to `total`. If the sum exceeds `total`, the
  // function throws and the offsets are not used.
  uint64_t sum = 0;
  for (size_t done = 0; done < num_groups; done += kStretch) {
    const size_t count = std::min(kStretch, num_groups - done);
    JoinPlanes(planes, done, count, sizes.data());
    for (size_t i = 0; i < count; ++i) {
      begin[done + i] = static_cast<uint32_t>(sum);
      sum += sizes[i];
    }
  }
  begin[num_groups] = static_cast<uint32_t>(sum);
  if (sum != total) {
    ThrowDamagedTile(std::string("numbers of ") + what + " do not add up");
  }
}

}  // namespace cairn
