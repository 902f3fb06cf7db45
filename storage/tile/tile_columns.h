// The columns of a tile payload, docs/formats/tile_v1.md; private to storage.
#ifndef CAIRN_STORAGE_TILE_TILE_COLUMNS_H_
#define CAIRN_STORAGE_TILE_TILE_COLUMNS_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

#include "core/large_vector.h"
#include "storage/tile/tile_codec.h"

struct ZSTD_DCtx_s;

namespace cairn {

// Where the columns of each field begin. Planes of uN take N / 8 columns.
enum TileColumn : size_t {
  kListSizesColumn = 0,
  kListMembersColumn = 4,
  kPositionsColumn = 8,
  kLandmarkIdsColumn = 16,
  kLandmarkSessionsColumn = 24,
  kDescriptorCountsColumn = 32,
  kSigmasColumn = 36,
  kOrientationsColumn = 37,
  kSizesColumn = 38,
  kAzimuthsColumn = 39,
  kKeyframeIdsColumn = 40,
  kKeyframeSessionsColumn = 48,
  kPosesColumn = 56,
  kObservationCountsColumn = 57,
  kObservationsColumn = 61,
  kNumTileColumns = 62,
};

inline constexpr uint16_t kTileVersion = 1;

struct TileHeader {
  uint16_t code_size = 0;
  uint64_t tile_id = 0;
  int64_t codebook_id = 0;
  uint32_t num_landmarks = 0;
  uint32_t num_descriptors = 0;
  uint32_t num_keyframes = 0;
  uint32_t num_observations = 0;
  uint32_t num_lists = 0;          // 0: the descriptors have no lists.
  uint32_t observations_size = 0;  // Bytes of the decoded observations column.

  uint64_t codes_size() const { return uint64_t{num_descriptors} * code_size; }
  uint32_t num_members() const { return num_lists > 0 ? num_descriptors : 0; }
  // Bytes of a column when it is decoded.
  size_t ColumnSize(size_t column) const;
  // Heap bytes of the tile's landmarks, of its covisibility and of all of it.
  uint64_t LandmarksSize() const;
  uint64_t CovisibilitySize() const;
  uint64_t TileSize() const;
};

// Gathers codes and columns, and puts them together to a payload.
class TileColumnWriter {
 public:
  // Columns are put in the order of their numbers.
  void Put(std::span<const uint8_t> column);
  // A column of all lowest bytes, one of all second bytes, and so on.
  template <typename T>
  void PutPlanes(std::span<const T> values) {
    static_assert(std::is_unsigned_v<T>);
    std::vector<uint8_t> plane(values.size());
    for (size_t shift = 0; shift < 8 * sizeof(T); shift += 8) {
      for (size_t i = 0; i < values.size(); ++i) {
        plane[i] = static_cast<uint8_t>(values[i] >> shift);
      }
      Put(plane);
    }
  }

  // `codes` are in the order of the lists.
  std::vector<uint8_t> Finish(const TileHeader& header, std::span<const uint8_t> codes) const;

 private:
  std::vector<uint32_t> stored_sizes_;
  std::vector<uint8_t> bytes_;
};

// The parts of a payload, which must outlive it. Immutable; safe to use from any thread.
class TileColumns {
 public:
  // True if the bytes say that they are a tile payload of version 1.
  static bool IsPayload(std::span<const uint8_t> payload);

  // Of such a payload: true if its header announces lists.
  static bool HasLists(std::span<const uint8_t> payload);

  // Checks everything but what is in the columns; throws as DecodeTile.
  TileColumns(std::span<const uint8_t> payload, const TileDecodeLimits& limits);

  const TileHeader& header() const { return header_; }
  std::span<const uint8_t> codes() const { return codes_; }
  // A column as it is stored.
  std::span<const uint8_t> Stored(size_t column) const {
    return stored_.subspan(begin_[column], begin_[column + 1] - begin_[column]);
  }

 private:
  TileHeader header_;
  std::span<const uint8_t> codes_;   // Rows of code_size bytes, in order of the lists if any.
  std::span<const uint8_t> stored_;  // All columns.
  std::array<uint64_t, kNumTileColumns + 1> begin_;
};

// Decodes columns. For use within one thread.
class TileColumnReader {
 public:
  explicit TileColumnReader(const TileColumns& columns);
  ~TileColumnReader();
  TileColumnReader(const TileColumnReader&) = delete;
  TileColumnReader& operator=(const TileColumnReader&) = delete;

  // Valid until the next call. Throws Error(kMapDamaged).
  std::span<const uint8_t> Get(size_t column);
  // The same, to memory of the column's size.
  void Get(size_t column, std::span<uint8_t> to);

  // The numbers whose planes begin with `column`.
  LargeVector<uint32_t> GetPlanes32(size_t column);
  // What the differences that begin with `column` add up to, each the sum of all before: calls
  // take(begin, sums) for one stretch after the other, which is a cache's worth of numbers.
  void GetDeltas(size_t column, const std::function<void(size_t, std::span<const uint64_t>)>& take);
  // Offsets that begin with 0, one more than there are lengths of groups, which begin with
  // `column`. Throws Error(kMapDamaged), saying `what` they are of, unless they add up to `total`.
  void GetOffsets(size_t column, uint32_t total, const char* what, uint32_t* begin);

 private:
  // Valid until the next call with the same buffer.
  std::span<const uint8_t> Get(size_t column, LargeVector<uint8_t>* buffer);
  // The planes of uN that begin with `column`, valid until the next call; null for all zeros.
  template <typename T>
  std::array<const uint8_t*, sizeof(T)> GetPlanes(size_t column);

  const TileColumns& columns_;
  std::unique_ptr<ZSTD_DCtx_s, size_t (*)(ZSTD_DCtx_s*)> context_;
  std::array<LargeVector<uint8_t>, sizeof(uint64_t)> decoded_;  // One for each plane of a number.
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_TILE_COLUMNS_H_
