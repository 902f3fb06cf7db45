#include "core/images/tiff_directory.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace cairn {
namespace {

constexpr size_t kBytesPerEntry = 12;
constexpr uint16_t kTiffMagic = 42;

enum TiffType : uint16_t {
  kTiffByte = 1,
  kTiffAscii = 2,
  kTiffShort = 3,
  kTiffLong = 4,
  kTiffRational = 5,
  kTiffSByte = 6,
  kTiffUndefined = 7,
  kTiffSShort = 8,
  kTiffSLong = 9,
  kTiffSRational = 10,
  kTiffFloat = 11,
  kTiffDouble = 12,
  kTiffIfd = 13,  // A pointer to a directory.
};

// The size of a number, or 0 for other types.
size_t BytesPerNumber(uint16_t type) {
  switch (type) {
    case kTiffByte:
    case kTiffSByte:
      return 1;
    case kTiffShort:
    case kTiffSShort:
      return 2;
    case kTiffLong:
    case kTiffSLong:
    case kTiffFloat:
      return 4;
    case kTiffRational:
    case kTiffSRational:
    case kTiffDouble:
      return 8;
    default:
      return 0;
  }
}

double AsSigned(uint32_t bits) { return static_cast<double>(static_cast<int32_t>(bits)); }

}  // namespace

TiffDirectory TiffDirectory::First(std::span<const uint8_t> tiff) {
  constexpr size_t kHeaderBytes = 8;
  if (tiff.size() < kHeaderBytes || tiff[0] != tiff[1] || (tiff[0] != 'I' && tiff[0] != 'M')) {
    return {};
  }
  TiffDirectory header;
  header.tiff_ = tiff.first(std::min(tiff.size(), kMaxBytes));
  header.is_little_endian_ = tiff[0] == 'I';
  if (header.Read16(2) != kTiffMagic) {
    return {};
  }
  return At(header.tiff_, header.is_little_endian_, header.Read32(4));
}

TiffDirectory TiffDirectory::At(std::span<const uint8_t> tiff, bool is_little_endian,
                                size_t offset) {
  constexpr size_t kCountBytes = 2;
  if (offset > tiff.size() || tiff.size() - offset < kCountBytes) {
    return {};
  }
  TiffDirectory directory;
  directory.tiff_ = tiff;
  directory.is_little_endian_ = is_little_endian;
  directory.entries_at_ = offset + kCountBytes;
  // Of a block that is cut short, the whole entries count.
  directory.num_entries_ = std::min<size_t>(directory.Read16(offset),
                                            (tiff.size() - directory.entries_at_) / kBytesPerEntry);
  return directory;
}

TiffDirectory TiffDirectory::Pointed(uint16_t tag) const {
  const std::optional<Entry> entry = Find(tag);
  const bool is_pointer = entry && (entry->type == kTiffLong || entry->type == kTiffIfd);
  return is_pointer ? At(tiff_, is_little_endian_, Read32(entry->at)) : TiffDirectory();
}

std::optional<double> TiffDirectory::Number(uint16_t tag, uint32_t n) const {
  const std::optional<Entry> entry = Find(tag);
  const size_t num_bytes = entry ? BytesPerNumber(entry->type) : 0;
  const std::optional<size_t> found = num_bytes > 0 ? OffsetOf(*entry, n, num_bytes) : std::nullopt;
  if (!found) {
    return std::nullopt;
  }
  const size_t at = *found;
  double number = 0.0;
  switch (entry->type) {
    case kTiffByte:
      number = tiff_[at];
      break;
    case kTiffSByte:
      number = static_cast<int8_t>(tiff_[at]);
      break;
    case kTiffShort:
      number = Read16(at);
      break;
    case kTiffSShort:
      number = static_cast<int16_t>(Read16(at));
      break;
    case kTiffLong:
      number = Read32(at);
      break;
    case kTiffSLong:
      number = AsSigned(Read32(at));
      break;
    case kTiffRational:
      number = static_cast<double>(Read32(at)) / Read32(at + 4);
      break;
    case kTiffSRational:
      number = AsSigned(Read32(at)) / AsSigned(Read32(at + 4));
      break;
    case kTiffFloat:
      number = std::bit_cast<float>(Read32(at));
      break;
    default: {
      const uint64_t first = Read32(at), second = Read32(at + 4);
      number =
          std::bit_cast<double>(is_little_endian_ ? second << 32 | first : first << 32 | second);
    }
  }
  return std::isfinite(number) ? std::optional(number) : std::nullopt;
}

char TiffDirectory::Letter(uint16_t tag) const {
  const std::optional<Entry> entry = Find(tag);
  const bool is_text = entry && (entry->type == kTiffAscii || entry->type == kTiffByte ||
                                 entry->type == kTiffUndefined);
  const std::optional<size_t> at = is_text ? OffsetOf(*entry, 0, 1) : std::nullopt;
  const char letter = at ? static_cast<char>(tiff_[*at]) : '\0';
  return letter >= 'a' && letter <= 'z' ? static_cast<char>(letter - 'a' + 'A') : letter;
}

std::string_view TiffDirectory::Text(uint16_t tag) const {
  const std::optional<Entry> entry = Find(tag);
  const std::optional<size_t> at =
      entry && entry->type == kTiffAscii ? OffsetOf(*entry, 0, 1) : std::nullopt;
  if (!at) {
    return {};
  }
  const std::string_view text(reinterpret_cast<const char*>(tiff_.data()) + *at, entry->count);
  return text.substr(0, text.find('\0'));
}

uint16_t TiffDirectory::Read16(size_t at) const {
  const uint8_t* bytes = tiff_.data() + at;
  return static_cast<uint16_t>(is_little_endian_ ? bytes[1] << 8 | bytes[0]
                                                 : bytes[0] << 8 | bytes[1]);
}

uint32_t TiffDirectory::Read32(size_t at) const {
  const uint32_t first = Read16(at), second = Read16(at + 2);
  return is_little_endian_ ? second << 16 | first : first << 16 | second;
}

std::optional<TiffDirectory::Entry> TiffDirectory::Find(uint16_t tag) const {
  for (size_t i = 0; i < num_entries_; ++i) {
    const size_t at = entries_at_ + i * kBytesPerEntry;
    if (Read16(at) == tag) {
      return Entry{.type = Read16(at + 2), .count = Read32(at + 4), .at = at + 8};
    }
  }
  return std::nullopt;
}

std::optional<size_t> TiffDirectory::OffsetOf(const Entry& entry, uint32_t n,
                                              size_t bytes_per_value) const {
  constexpr uint64_t kBytesInEntry = 4;  // Values that fit stand in the entry itself.
  if (n >= entry.count) {
    return std::nullopt;
  }
  const bool is_inline = uint64_t{entry.count} * bytes_per_value <= kBytesInEntry;
  const uint64_t begin = is_inline ? entry.at : Read32(entry.at);
  const uint64_t end = begin + uint64_t{entry.count} * bytes_per_value;
  return end <= tiff_.size() ? std::optional<size_t>(begin + size_t{n} * bytes_per_value)
                             : std::nullopt;
}

}  // namespace cairn
