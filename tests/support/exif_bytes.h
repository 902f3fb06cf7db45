// Writes EXIF blocks and puts them into image files, as cameras do.
#ifndef CAIRN_TESTS_SUPPORT_EXIF_BYTES_H_
#define CAIRN_TESTS_SUPPORT_EXIF_BYTES_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cairn::testing {

// One entry of a TIFF directory.
struct ExifEntry {
  uint16_t type = 0;
  uint32_t count = 0;
  std::vector<uint8_t> values;  // In the byte order of the block.
};

// Writes numbers in one byte order.
class ExifWriter {
 public:
  explicit ExifWriter(bool is_little_endian) : is_little_endian_(is_little_endian) {}

  void Put(uint64_t number, int num_bytes, std::vector<uint8_t>* bytes) const {
    for (int i = 0; i < num_bytes; ++i) {
      const int shift = 8 * (is_little_endian_ ? i : num_bytes - 1 - i);
      bytes->push_back(static_cast<uint8_t>(number >> shift));
    }
  }
  ExifEntry Short(uint16_t value) const { return Numbers(3, 2, {value}); }
  ExifEntry Long(uint32_t value) const { return Numbers(4, 4, {value}); }
  ExifEntry Byte(uint8_t value) const { return Numbers(1, 1, {value}); }
  static ExifEntry Text(const std::string& text) {
    return {2, static_cast<uint32_t>(text.size() + 1),
            std::vector<uint8_t>(text.c_str(), text.c_str() + text.size() + 1)};
  }
  // Each value as a fraction of 10,000,000.
  ExifEntry Rationals(const std::vector<double>& values) const {
    constexpr uint32_t kDenominator = 10'000'000;
    ExifEntry entry{.type = 5, .count = static_cast<uint32_t>(values.size()), .values = {}};
    for (const double value : values) {
      Put(static_cast<uint32_t>(std::llround(value * kDenominator)), 4, &entry.values);
      Put(kDenominator, 4, &entry.values);
    }
    return entry;
  }
  ExifEntry Numbers(uint16_t type, int num_bytes, const std::vector<uint64_t>& values) const {
    ExifEntry entry{.type = type, .count = static_cast<uint32_t>(values.size()), .values = {}};
    for (const uint64_t value : values) {
      Put(value, num_bytes, &entry.values);
    }
    return entry;
  }

 private:
  bool is_little_endian_;
};

using ExifDirectory = std::map<uint16_t, ExifEntry>;

// A photo's EXIF. Angles in degrees; south and west are negative.
struct ExifContent {
  bool is_little_endian = true;
  int orientation = 1;
  std::optional<double> lat_deg = {}, lon_deg = {};
  std::optional<double> altitude_m = {};  // Not negative.
  uint8_t altitude_ref = 0;               // As GPSAltitudeRef.
  std::optional<double> error_m = {};     // GPSHPositioningError.
  std::optional<uint16_t> focal_35mm = {};
  ExifDirectory more_gps = {};           // Entries that replace those above.
  ExifDirectory more_exif = {};          // Entries of the EXIF directory beside those above.
  std::vector<uint8_t> maker_note = {};  // Put into the EXIF directory.
  bool has_thumbnail_directory = false;  // A second directory with an orientation of its own.
};

inline ExifDirectory GpsDirectory(const ExifContent& content, const ExifWriter& writer) {
  ExifDirectory gps = content.more_gps;
  const auto angle = [&](double degrees) {
    const double absolute = std::abs(degrees), whole = std::floor(absolute);
    const double minutes = std::floor(60.0 * (absolute - whole));
    return writer.Rationals({whole, minutes, 3600.0 * (absolute - whole) - 60.0 * minutes});
  };
  if (content.lat_deg) {
    gps.emplace(1, ExifWriter::Text(*content.lat_deg < 0.0 ? "S" : "N"));
    gps.emplace(2, angle(*content.lat_deg));
  }
  if (content.lon_deg) {
    gps.emplace(3, ExifWriter::Text(*content.lon_deg < 0.0 ? "W" : "E"));
    gps.emplace(4, angle(*content.lon_deg));
  }
  if (content.altitude_m) {
    gps.emplace(5, writer.Byte(content.altitude_ref));
    ExifEntry altitude = writer.Numbers(
        5, 4, {static_cast<uint64_t>(std::llround(100.0 * *content.altitude_m)), 100});
    altitude.count = 1;
    gps.emplace(6, altitude);
  }
  if (content.error_m) {
    gps.emplace(0x1f, writer.Rationals({*content.error_m}));
  }
  return gps;
}

// Appends a directory and its values; `next` is the offset of the following directory.
inline void PutDirectory(const ExifDirectory& directory, uint32_t next, const ExifWriter& writer,
                         std::vector<uint8_t>* tiff) {
  const size_t begin = tiff->size();
  size_t values_at = begin + 2 + 12 * directory.size() + 4;
  std::vector<uint8_t> values;
  writer.Put(directory.size(), 2, tiff);
  for (const auto& [tag, entry] : directory) {
    writer.Put(tag, 2, tiff);
    writer.Put(entry.type, 2, tiff);
    writer.Put(entry.count, 4, tiff);
    if (entry.values.size() <= 4) {
      tiff->insert(tiff->end(), entry.values.begin(), entry.values.end());
      tiff->resize(tiff->size() + 4 - entry.values.size());
    } else {
      writer.Put(values_at + values.size(), 4, tiff);
      values.insert(values.end(), entry.values.begin(), entry.values.end());
    }
  }
  writer.Put(next, 4, tiff);
  tiff->insert(tiff->end(), values.begin(), values.end());
}

// The number of bytes that PutDirectory appends.
inline uint32_t DirectoryBytes(const ExifDirectory& directory) {
  size_t num_bytes = 2 + 12 * directory.size() + 4;
  for (const auto& [tag, entry] : directory) {
    num_bytes += entry.values.size() <= 4 ? 0 : entry.values.size();
  }
  return static_cast<uint32_t>(num_bytes);
}

// The TIFF structure of the content: directories 0, EXIF, GPS, and 1 if there is a thumbnail.
inline std::vector<uint8_t> ExifBlock(const ExifContent& content) {
  const ExifWriter writer(content.is_little_endian);
  ExifDirectory exif = content.more_exif, thumbnail;
  if (content.focal_35mm) {
    exif.emplace(0xa405, writer.Short(*content.focal_35mm));
  }
  if (!content.maker_note.empty()) {
    exif.emplace(
        0x927c, ExifEntry{7, static_cast<uint32_t>(content.maker_note.size()), content.maker_note});
  }
  if (content.has_thumbnail_directory) {
    thumbnail.emplace(0x0112, writer.Short(5));
  }
  const ExifDirectory gps = GpsDirectory(content, writer);
  ExifDirectory first = {{0x010f, ExifWriter::Text("Maker of Cameras")},
                         {0x0112, writer.Short(static_cast<uint16_t>(content.orientation))},
                         {0x8769, writer.Long(0)},
                         {0x8825, writer.Long(0)}};
  const uint32_t exif_at = 8 + DirectoryBytes(first);
  const uint32_t gps_at = exif_at + DirectoryBytes(exif);
  first[0x8769] = writer.Long(exif_at);
  first[0x8825] = writer.Long(gps_at);
  std::vector<uint8_t> tiff(2, content.is_little_endian ? 'I' : 'M');
  writer.Put(42, 2, &tiff);
  writer.Put(8, 4, &tiff);
  PutDirectory(first, thumbnail.empty() ? 0 : gps_at + DirectoryBytes(gps), writer, &tiff);
  PutDirectory(exif, 0, writer, &tiff);
  PutDirectory(gps, 0, writer, &tiff);
  if (!thumbnail.empty()) {
    PutDirectory(thumbnail, 0, writer, &tiff);
  }
  return tiff;
}

// The JPEG with an EXIF segment behind its first marker. The block has at most 65,527 bytes.
inline std::vector<uint8_t> JpegWithExifBlock(std::vector<uint8_t> jpeg,
                                              const std::vector<uint8_t>& block) {
  const size_t length = 2 + 6 + block.size();
  std::vector<uint8_t> segment = {0xff, 0xe1, static_cast<uint8_t>(length >> 8),
                                  static_cast<uint8_t>(length)};
  for (const char c : {'E', 'x', 'i', 'f', '\0', '\0'}) {
    segment.push_back(static_cast<uint8_t>(c));
  }
  segment.insert(segment.end(), block.begin(), block.end());
  jpeg.insert(jpeg.begin() + 2, segment.begin(), segment.end());
  return jpeg;
}

// The checksum of PNG chunks.
inline uint32_t Crc32(const std::vector<uint8_t>& bytes) {
  uint32_t crc = ~0u;
  for (const uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) {
      crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0u);
    }
  }
  return ~crc;
}

// The PNG with a chunk of a type of four letters behind its header.
inline std::vector<uint8_t> PngWithChunk(std::vector<uint8_t> png, const std::string& type,
                                         const std::vector<uint8_t>& content) {
  constexpr size_t kEndOfHeader = 8 + 12 + 13;
  const ExifWriter big_endian(false);
  std::vector<uint8_t> typed(type.begin(), type.end());
  typed.insert(typed.end(), content.begin(), content.end());
  std::vector<uint8_t> chunk;
  big_endian.Put(content.size(), 4, &chunk);
  chunk.insert(chunk.end(), typed.begin(), typed.end());
  big_endian.Put(Crc32(typed), 4, &chunk);
  png.insert(png.begin() + kEndOfHeader, chunk.begin(), chunk.end());
  return png;
}

// The PNG with an eXIf chunk behind its header.
inline std::vector<uint8_t> PngWithExifBlock(std::vector<uint8_t> png,
                                             const std::vector<uint8_t>& block) {
  return PngWithChunk(std::move(png), "eXIf", block);
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_EXIF_BYTES_H_
