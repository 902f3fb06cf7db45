// The columns of a tile payload; see docs/formats/tile_v1.md. Private to storage.
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

// The first column of each field. A field of N-bit numbers takes N / 8 columns, one per byte plane.
enum TileColumn : size_t {
  kListSizesColumn = 0,
  kListMembersColumn = 4,
  kPositionsColumn = 8,
  kLandmarkIdsColumn = 16,
  kDescriptorCountsColumn = 24,
  kSigmasColumn = 28,
  kHistoryCountsColumn = 29,
  kHistorySessionsColumn = 30,
  kHistoryObservationsColumn = 38,
  kChancesColumn = 39,
  kOrientationsColumn = 40,
  kSizesColumn = 41,
  kAzimuthsColumn = 42,
  kWeightsColumn = 43,
  kKeyframeIdsColumn = 44,
  kKeyframeSessionsColumn = 52,
  kPosesColumn = 60,
  kObservationCountsColumn = 61,
  kObservationsColumn = 65,
  kNumTileColumns = 66,
};

inline constexpr uint16_t kTileVersion = 1;

struct TileHeader {
  uint16_t code_size = 0;
  uint64_t tile_id = 0;
  int64_t codebook_id = 0;
  uint32_t num_landmarks = 0;
  uint32_t num_history_entries = 0;
  uint32_t num_descriptors = 0;
  uint32_t num_keyframes = 0;
  uint32_t num_observations = 0;
  uint32_t num_lists = 0;          // 0 if the descriptors have no lists.
  uint32_t observations_size = 0;  // Bytes of the decoded observations column.

  uint64_t codes_size() const { return uint64_t{num_descriptors} * code_size; }
  uint32_t num_members() const { return num_lists > 0 ? num_descriptors : 0; }
  // Returns the bytes of a decoded column.
  size_t ColumnSize(size_t column) const;
  // Return the heap bytes of the decoded landmarks, of the covisibility, and of the whole tile.
  uint64_t LandmarksSize() const;
  uint64_t CovisibilitySize() const;
  uint64_t TileSize() const;
};

// Collects columns and assembles them with the codes into a payload.
class TileColumnWriter {
 public:
  // Call once per column, in the order of TileColumn.
  void Put(std::span<const uint8_t> column);
  // Puts one column per byte plane: all lowest bytes, then all second bytes, and so on.
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

  // `codes` are in list order.
  std::vector<uint8_t> Finish(const TileHeader& header, std::span<const uint8_t> codes) const;

 private:
  std::vector<uint32_t> stored_sizes_;
  std::vector<uint8_t> bytes_;
};

// The parts of a payload. The payload must outlive the object. Immutable; safe to use from any
// thread.
class TileColumns {
 public:
  // Returns true if magic and version are those of a tile payload of version 1.
  static bool IsPayload(std::span<const uint8_t> payload);

  // Returns true if the header of such a payload announces lists.
  static bool HasLists(std::span<const uint8_t> payload);

  // Checks everything except the content of the columns. Throws what DecodeTile throws.
  TileColumns(std::span<const uint8_t> payload, const TileDecodeLimits& limits);

  const TileHeader& header() const { return header_; }
  std::span<const uint8_t> codes() const { return codes_; }
  // Returns the stored bytes of a column, which may be compressed.
  std::span<const uint8_t> Stored(size_t column) const {
    return stored_.subspan(begin_[column], begin_[column + 1] - begin_[column]);
  }

 private:
  TileHeader header_;
  std::span<const uint8_t> codes_;  // Rows of code_size bytes; in list order if the tile has lists.
  std::span<const uint8_t> stored_;  // All columns.
  std::array<uint64_t, kNumTileColumns + 1> begin_;
};

// How differences of 64-bit numbers are stored.
enum class Difference {
  kSigned,    // Zigzag, so that small negative differences are small numbers.
  kUnsigned,  // Modulo 2^64.
};

// Decodes columns. Use each reader from one thread.
class TileColumnReader {
 public:
  explicit TileColumnReader(const TileColumns& columns);
  ~TileColumnReader();
  TileColumnReader(const TileColumnReader&) = delete;
  TileColumnReader& operator=(const TileColumnReader&) = delete;

  // The result is valid until the next call. Throws Error(kMapDamaged).
  std::span<const uint8_t> Get(size_t column);
  // Decodes into `to`, which has the column's size.
  void Get(size_t column, std::span<uint8_t> to);

  // Joins the numbers whose byte planes start at `column`.
  LargeVector<uint32_t> GetPlanes32(size_t column);
  // Decodes the running sums of the differences whose planes start at `column`. Calls take(begin,
  // sums) for consecutive stretches of numbers, each small enough for the cache.
  void GetSums(size_t column, Difference difference,
               const std::function<void(size_t, std::span<const uint64_t>)>& take);
  // Decodes group sizes whose planes start at `column` into offsets: the first is 0, and there is
  // one more offset than groups. Throws Error(kMapDamaged), naming `what`, unless the sizes add up
  // to `total`.
  void GetOffsets(size_t column, uint32_t total, const char* what, uint32_t* begin);

 private:
  // The result is valid until the next call with the same buffer.
  std::span<const uint8_t> Get(size_t column, LargeVector<uint8_t>* buffer);
  // Returns the byte planes that start at `column`, valid until the next call; null for a plane of
  // zeros.
  template <typename T>
  std::array<const uint8_t*, sizeof(T)> GetPlanes(size_t column);

  const TileColumns& columns_;
  std::unique_ptr<ZSTD_DCtx_s, size_t (*)(ZSTD_DCtx_s*)> context_;
  // One buffer for each byte plane of a number.
  std::array<LargeVector<uint8_t>, sizeof(uint64_t)> decoded_;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_TILE_COLUMNS_H_
