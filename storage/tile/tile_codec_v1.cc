#include "storage/tile/tile_codec_v1.h"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <string>

#include "storage/bytes/byte_io.h"
#include "storage/bytes/checksum.h"
#include "storage/tile/morton.h"
#include "storage/tile/tile_checks.h"
#include "storage/tile/tile_parts.h"

namespace cairn {
namespace {

constexpr uint16_t kVersionWithoutLists = 1;
constexpr uint16_t kVersionWithLists = 2;

struct Header {
  uint16_t version = kVersionWithoutLists;
  uint16_t code_size = 0;
  uint64_t tile_id = 0;
  int64_t codebook_id = 0;
  uint32_t num_landmarks = 0;
  uint32_t num_descriptors = 0;
  uint32_t num_keyframes = 0;
  uint32_t num_observations = 0;
  uint64_t body_size = 0;        // Decompressed.
  uint64_t compressed_size = 0;  // Of the zstd frame.

  uint64_t codes_size() const { return uint64_t{num_descriptors} * code_size; }

  // The lists, after the frame, begin with their number; a member takes a byte at least.
  uint64_t MinListsSize() const {
    return version == kVersionWithLists ? sizeof(uint32_t) + uint64_t{num_descriptors} : 0;
  }
  uint64_t MaxListsSize() const {
    return version == kVersionWithLists ? sizeof(uint32_t) * (uint64_t{num_descriptors} + 1) +
                                              kMaxVarintSize * uint64_t{num_descriptors}
                                        : 0;
  }

  // Bytes of the body without the variable-length landmark indices.
  uint64_t FixedBodySize() const {
    constexpr uint64_t kPerLandmark = 8 + 8 + 8 + 4 + 1;
    constexpr uint64_t kPerDescriptor = 3;
    constexpr uint64_t kPerKeyframe = 8 + 8 + 7 * 8 + 4;
    return kPerLandmark * num_landmarks + kPerDescriptor * num_descriptors +
           kPerKeyframe * num_keyframes;
  }

  // Heap bytes of the tile the header announces.
  uint64_t TileSize() const {
    constexpr uint64_t kPerLandmark =
        sizeof(LandmarkId) + sizeof(SessionId) + sizeof(Eigen::Vector3f) + sizeof(uint32_t) + 1;
    return kPerLandmark * num_landmarks + 3 * uint64_t{num_descriptors} + codes_size() +
           (sizeof(TileKeyframe) + sizeof(uint32_t)) * num_keyframes +
           sizeof(uint32_t) * uint64_t{num_observations};
  }
};

// ---- Columns of the body -----------------------------------------------------------------------

// Differences to the predecessor, zigzag, in byte planes. Calls set(i, value) for each of `count`
// values.
template <typename Set>
void GetDeltas(size_t count, ByteReader* reader, const Set& set) {
  const std::vector<uint64_t> deltas = reader->GetPlanes<uint64_t>(count);
  uint64_t value = 0;
  for (size_t i = 0; i < count; ++i) {
    value += UnZigZag(deltas[i]);
    set(i, value);
  }
}

// Offsets from lengths of groups, which must add up to `total`.
std::vector<uint32_t> GetGroupSizes(size_t count, uint32_t total, const char* what,
                                    ByteReader* reader) {
  const std::vector<uint32_t> sizes = reader->GetPlanes<uint32_t>(count);
  std::vector<uint32_t> begin(count + 1, 0);
  uint64_t sum = 0;
  for (size_t i = 0; i < count; ++i) {
    sum += sizes[i];
    if (sum > total) {
      break;
    }
    begin[i + 1] = static_cast<uint32_t>(sum);
  }
  if (sum != total) {
    ThrowDamagedTile(std::string("numbers of ") + what + " do not add up");
  }
  return begin;
}

// Attributes of descriptors: first those of each landmark's first descriptor, then the differences
// of all others to their predecessor. For several columns that follow one another: how many
// descriptors a landmark has is hard to predict for the processor, and is met once for all.
template <size_t kNumColumns>
void GetAttributes(const std::vector<uint32_t>& begin, ByteReader* reader,
                   const std::array<std::vector<uint8_t>*, kNumColumns>& columns) {
  size_t num_firsts = 0;
  for (size_t landmark = 0; landmark + 1 < begin.size(); ++landmark) {
    num_firsts += begin[landmark] < begin[landmark + 1] ? 1 : 0;
  }
  std::array<const uint8_t*, kNumColumns> firsts, differences;
  std::array<uint8_t*, kNumColumns> values;
  for (size_t column = 0; column < kNumColumns; ++column) {
    firsts[column] = reader->Take(begin.back()).data();
    differences[column] = firsts[column] + num_firsts;
    columns[column]->resize(begin.back());
    values[column] = columns[column]->data();
  }
  size_t next_first = 0, next_difference = 0;
  for (size_t landmark = 0; landmark + 1 < begin.size(); ++landmark) {
    if (begin[landmark] == begin[landmark + 1]) {
      continue;
    }
    for (size_t column = 0; column < kNumColumns; ++column) {
      values[column][begin[landmark]] = firsts[column][next_first];
    }
    ++next_first;
    for (uint32_t i = begin[landmark] + 1; i < begin[landmark + 1]; ++i, ++next_difference) {
      for (size_t column = 0; column < kNumColumns; ++column) {
        values[column][i] =
            static_cast<uint8_t>(values[column][i - 1] + differences[column][next_difference]);
      }
    }
  }
}

std::vector<TileKeyframe> GetKeyframes(size_t count, ByteReader* reader) {
  std::vector<TileKeyframe> keyframes(count);
  GetDeltas(count, reader, [&](size_t i, uint64_t value) { keyframes[i].id = KeyframeId(value); });
  GetDeltas(count, reader,
            [&](size_t i, uint64_t value) { keyframes[i].session_id = SessionId(value); });
  for (TileKeyframe& keyframe : keyframes) {
    std::array<double, kNumPoseNumbers> numbers;
    reader->GetArray(std::span<double>(numbers));
    keyframe.cam_from_tile = PoseFromNumbers(numbers);
  }
  return keyframes;
}

void GetCovisibility(const Header& header, ByteReader* reader, Tile* tile) {
  tile->keyframe_begin =
      GetGroupSizes(header.num_keyframes, header.num_observations, "observations", reader);
  tile->keyframe_landmarks.resize(header.num_observations);
  for (size_t k = 0; k < header.num_keyframes; ++k) {
    uint32_t* landmark = tile->keyframe_landmarks.data() + tile->keyframe_begin[k];
    GetAscending(tile->keyframe_begin[k + 1] - tile->keyframe_begin[k], header.num_landmarks,
                 "a keyframe refers to a landmark that is not there", reader,
                 [&](uint32_t index) { *landmark++ = index; });
  }
}

// ---- Lists, after the frame --------------------------------------------------------------------

TileLists GetLists(const Header& header, ByteReader* reader) {
  const auto num_lists = reader->Get<uint32_t>();
  if (num_lists > header.num_descriptors) {
    ThrowDamagedTile("has more lists than descriptors");
  }
  TileLists lists;
  lists.begin = GetGroupSizes(num_lists, header.num_descriptors, "members", reader);
  lists.members.resize(header.num_descriptors);
  std::vector<uint64_t> seen(header.num_descriptors / 64 + 1);
  uint64_t num_again = 0;
  for (size_t list = 0; list < num_lists; ++list) {
    uint32_t* member = lists.members.data() + lists.begin[list];
    GetAscending(lists.begin[list + 1] - lists.begin[list], header.num_descriptors,
                 "a list refers to a descriptor that is not there", reader, [&](uint32_t index) {
                   num_again += seen[index / 64] >> (index % 64) & 1;
                   seen[index / 64] |= uint64_t{1} << (index % 64);
                   *member++ = index;
                 });
  }
  if (num_again > 0) {
    ThrowDamagedTile("a descriptor is in two lists");
  }
  if (reader->remaining() != 0) {
    ThrowDamagedTile("bytes are left over after the lists");
  }
  return lists;
}

// ---- The body ----------------------------------------------------------------------------------

void DecodeBody(const Header& header, std::span<const uint8_t> body, Tile* tile) {
  ByteReader reader(body, "tile payload");
  const size_t num_landmarks = header.num_landmarks;
  tile->x_in_tile.resize(num_landmarks);
  tile->landmark_ids.resize(num_landmarks);
  tile->landmark_sessions.resize(num_landmarks);
  GetDeltas(num_landmarks, &reader,
            [&](size_t i, uint64_t value) { tile->x_in_tile[i] = PositionFromMorton(value); });
  GetDeltas(num_landmarks, &reader,
            [&](size_t i, uint64_t value) { tile->landmark_ids[i] = LandmarkId(value); });
  GetDeltas(num_landmarks, &reader,
            [&](size_t i, uint64_t value) { tile->landmark_sessions[i] = SessionId(value); });
  tile->descriptor_begin =
      GetGroupSizes(num_landmarks, header.num_descriptors, "descriptors", &reader);
  tile->sigma_codes = reader.GetVector<uint8_t>(num_landmarks);
  GetAttributes<3>(tile->descriptor_begin, &reader,
                   {&tile->orientation_codes, &tile->size_codes, &tile->azimuth_codes});
  tile->keyframes = GetKeyframes(header.num_keyframes, &reader);
  GetCovisibility(header, &reader, tile);
  if (reader.remaining() != 0) {
    ThrowDamagedTile("bytes are left over after the last landmark index");
  }
}

std::vector<uint8_t> Decompress(std::span<const uint8_t> frame, uint64_t body_size) {
  if (ZSTD_getFrameContentSize(frame.data(), frame.size()) != body_size ||
      ZSTD_findFrameCompressedSize(frame.data(), frame.size()) != frame.size()) {
    ThrowDamagedTile("the compressed part is not one frame of the announced size");
  }
  std::vector<uint8_t> body(body_size);
  const size_t size = ZSTD_decompress(body.data(), body.size(), frame.data(), frame.size());
  if (ZSTD_isError(size)) {
    ThrowDamagedTile(std::string("zstd: ") + ZSTD_getErrorName(size));
  }
  if (size != body_size) {
    ThrowDamagedTile("the compressed part is shorter than announced");
  }
  return body;
}

// ---- The header --------------------------------------------------------------------------------

void CheckHeader(const Header& header, size_t blob_size, const TileDecodeLimits& limits) {
  if (header.num_landmarks > limits.max_landmarks ||
      header.num_descriptors > limits.max_descriptors ||
      header.num_keyframes > limits.max_keyframes || header.body_size > limits.max_decoded_bytes ||
      header.TileSize() > limits.max_decoded_bytes) {
    ThrowDamagedTile("announces more landmarks, descriptors or keyframes than the limits allow");
  }
  if (header.code_size > kMaxCodeSize || (header.code_size == 0 && header.num_descriptors > 0)) {
    ThrowDamagedTile("code size " + std::to_string(header.code_size) + " is out of range");
  }
  const uint64_t min_body_size = header.FixedBodySize() + header.num_observations;
  const uint64_t max_body_size =
      header.FixedBodySize() + kMaxVarintSize * uint64_t{header.num_observations};
  if (header.body_size < min_body_size || header.body_size > max_body_size) {
    ThrowDamagedTile("announced sizes contradict each other");
  }
  // Nothing can wrap around: the code bytes are limited above, and differences are compared.
  const uint64_t after_header = blob_size - kTileHeaderSize;
  if (after_header < header.codes_size() ||
      after_header - header.codes_size() < header.compressed_size ||
      after_header - header.codes_size() - header.compressed_size < header.MinListsSize() ||
      after_header - header.codes_size() - header.compressed_size > header.MaxListsSize()) {
    ThrowDamagedTile("is " + std::to_string(blob_size) + " bytes long, its header says otherwise");
  }
}

Header GetHeader(std::span<const uint8_t> blob, const TileDecodeLimits& limits) {
  if (blob.size() < kTileHeaderSize) {
    ThrowDamagedTile("is shorter than a header");
  }
  ByteReader reader(blob.first(kTileHeaderSize), "tile payload");
  if (reader.Get<uint32_t>() != kTileMagic) {
    ThrowDamagedTile("does not start with CTIL");
  }
  Header header;
  header.version = reader.Get<uint16_t>();
  if (header.version != kVersionWithoutLists && header.version != kVersionWithLists) {
    ThrowDamagedTile("format version " + std::to_string(header.version) +
                     " is unknown, expected 1 to 3");
  }
  header.code_size = reader.Get<uint16_t>();
  header.tile_id = reader.Get<uint64_t>();
  header.codebook_id = reader.Get<int64_t>();
  header.num_landmarks = reader.Get<uint32_t>();
  header.num_descriptors = reader.Get<uint32_t>();
  header.num_keyframes = reader.Get<uint32_t>();
  header.num_observations = reader.Get<uint32_t>();
  header.body_size = reader.Get<uint64_t>();
  header.compressed_size = reader.Get<uint64_t>();
  CheckHeader(header, blob.size(), limits);
  if (reader.Get<uint64_t>() != ChecksumOf(blob, kTileChecksumOffset)) {
    ThrowDamagedTile("checksum does not match");
  }
  return header;
}

}  // namespace

Tile DecodeTileV1(std::span<const uint8_t> blob, const TileDecodeLimits& limits, TileLists* lists) {
  const Header header = GetHeader(blob, limits);
  ByteReader reader(blob.subspan(kTileHeaderSize), "tile payload");
  Tile tile;
  tile.id = TileIdFromPayload(header.tile_id);
  tile.codebook_id = CodebookId(header.codebook_id);
  tile.code_size = header.code_size;
  tile.codes = reader.GetVector<uint8_t>(header.codes_size());
  DecodeBody(header, Decompress(reader.Take(header.compressed_size), header.body_size), &tile);
  if (const std::string problem = FindTileProblem(tile); !problem.empty()) {
    ThrowDamagedTile(problem);
  }
  *lists = header.version == kVersionWithLists ? GetLists(header, &reader) : TileLists();
  return tile;
}

}  // namespace cairn
