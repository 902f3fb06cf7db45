// Reads single values from a TIFF structure, the form of EXIF (TIFF 6.0; EXIF 2.32, CIPA DC-008).
// Private to core/images.
#ifndef CAIRN_CORE_IMAGES_TIFF_DIRECTORY_H_
#define CAIRN_CORE_IMAGES_TIFF_DIRECTORY_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace cairn {

// A directory (IFD) of a TIFF structure: a list of entries with a tag, a type, a number of values
// and the values. Each call reads one value where it stands: nothing is copied, no entry is
// followed unless the caller names its tag, and a call takes time linear in the number of entries.
// Entries may therefore overlap or point in circles without effect. An entry whose values do not
// all lie in the structure has none. Of two entries with the same tag, the first counts.
class TiffDirectory {
 public:
  // EXIF in a JPEG cannot be longer, because a segment has at most this length.
  static constexpr size_t kMaxBytes = size_t{64} << 10;

  // The first directory of `tiff`, in either byte order; empty if the bytes are no TIFF structure.
  // Only the first kMaxBytes are read. `tiff` must outlive the directory.
  static TiffDirectory First(std::span<const uint8_t> tiff);

  // The directory to which `tag` points; empty if there is none.
  TiffDirectory Pointed(uint16_t tag) const;

  // The value number `n` of a tag of any numeric type. Returns nothing if the directory has no
  // such tag, if its values are no numbers or fewer, or if the value is not finite.
  std::optional<double> Number(uint16_t tag, uint32_t n = 0) const;

  bool IsEmpty() const { return num_entries_ == 0; }

  // The first character of a text, in upper case; 0 if there is none. Some writers give texts the
  // types of bytes (BYTE, UNDEFINED).
  char Letter(uint16_t tag) const;

  // A text up to its first zero byte, as a view of the structure; empty if there is none.
  std::string_view Text(uint16_t tag) const;

 private:
  struct Entry {
    uint16_t type = 0;
    uint32_t count = 0;  // Number of values.
    size_t at = 0;       // Offset of the entry's last four bytes: its values or their offset.
  };

  static TiffDirectory At(std::span<const uint8_t> tiff, bool is_little_endian, size_t offset);
  uint16_t Read16(size_t at) const;
  uint32_t Read32(size_t at) const;
  std::optional<Entry> Find(uint16_t tag) const;
  // The offset of value number `n`. All values of the entry then lie in the structure.
  std::optional<size_t> OffsetOf(const Entry& entry, uint32_t n, size_t bytes_per_value) const;

  std::span<const uint8_t> tiff_;
  bool is_little_endian_ = false;
  size_t entries_at_ = 0;  // Offset of the first entry.
  size_t num_entries_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_CORE_IMAGES_TIFF_DIRECTORY_H_
