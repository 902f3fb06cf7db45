#include "storage/inspection/geopackage.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "storage/tile/byte_io.h"

namespace cairn {
namespace {

constexpr uint8_t kLittleEndian = 1;
constexpr uint8_t kEnvelopeXy = 1 << 1;  // Header flags: envelope is min x, max x, min y, max y.
constexpr uint8_t kEmpty = 1 << 4;
constexpr int32_t kWgs84 = 4326;
constexpr uint32_t kWkbPolygon = 3;
constexpr uint32_t kWkbPointZ = 1001;
constexpr int kMaxNesting = 8;  // Nesting depth of geometry collections.

struct LonLat {
  double lon_deg;
  double lat_deg;
};

void PutHeader(uint8_t flags, ByteWriter* writer) {
  writer->Put('G');
  writer->Put('P');
  writer->Put(uint8_t{0});  // Version 1.
  writer->Put(static_cast<uint8_t>(kLittleEndian | flags));
  writer->Put(kWgs84);
}

// Returns the corners counter-clockwise from the south-west.
std::vector<LonLat> CornersOf(TileId tile_id) {
  constexpr double kHalfTurnDeg = 180.0;
  const GeoBox bounds = tile_id.Bounds();
  const Geodetic anchor = tile_id.Anchor();
  std::vector<LonLat> corners;
  for (const Geodetic& corner : tile_id.Corners()) {
    const double offset_deg =
        std::remainder(corner.lon_deg() - anchor.lon_deg(), 2.0 * kHalfTurnDeg);
    corners.push_back({anchor.lon_deg() + offset_deg, corner.lat_deg()});
  }
  const bool holds_pole = bounds.east_rad - bounds.west_rad > 6.28;
  if (holds_pole) {
    const double south_deg = Geodetic{bounds.south_rad, 0.0, 0.0}.lat_deg();
    const double north_deg = Geodetic{bounds.north_rad, 0.0, 0.0}.lat_deg();
    corners = {{-kHalfTurnDeg, south_deg},
               {kHalfTurnDeg, south_deg},
               {kHalfTurnDeg, north_deg},
               {-kHalfTurnDeg, north_deg}};
  }
  return corners;
}

void Extend(double x, double y, GeometryEnvelope* envelope) {
  if (std::isnan(x) || std::isnan(y)) {
    return;  // WKB writes an empty point like this.
  }
  if (envelope->is_empty) {
    *envelope = {x, x, y, y, false};
    return;
  }
  envelope->min_x = std::min(envelope->min_x, x);
  envelope->max_x = std::max(envelope->max_x, x);
  envelope->min_y = std::min(envelope->min_y, y);
  envelope->max_y = std::max(envelope->max_y, y);
}

// Reads numbers of either byte order. Reads past the end return 0 and make ok() false.
class GeometryReader {
 public:
  explicit GeometryReader(std::span<const uint8_t> bytes) : bytes_(bytes) {}

  bool ok() const { return ok_; }
  size_t remaining() const { return bytes_.size(); }
  void set_little_endian(bool little_endian) { little_endian_ = little_endian; }

  uint8_t Byte() { return static_cast<uint8_t>(Unsigned(1)); }
  uint32_t Word() { return static_cast<uint32_t>(Unsigned(4)); }
  double Number() { return std::bit_cast<double>(Unsigned(8)); }

 private:
  uint64_t Unsigned(size_t size) {
    if (size > bytes_.size()) {
      ok_ = false;
      bytes_ = {};
      return 0;
    }
    uint64_t value = 0;
    for (size_t i = 0; i < size; ++i) {
      value = value << 8 | bytes_[little_endian_ ? size - 1 - i : i];
    }
    bytes_ = bytes_.subspan(size);
    return value;
  }

  std::span<const uint8_t> bytes_;
  bool little_endian_ = true;
  bool ok_ = true;
};

void ReadPoints(uint64_t count, int num_coordinates, GeometryReader* reader,
                GeometryEnvelope* envelope) {
  for (uint64_t i = 0; i < count && reader->ok(); ++i) {
    const double x = reader->Number();
    const double y = reader->Number();
    for (int k = 2; k < num_coordinates; ++k) {
      reader->Number();
    }
    if (reader->ok()) {
      Extend(x, y, envelope);
    }
  }
}

// Reads one well-known-binary geometry. Returns false if the bytes are not one.
bool ReadWkb(int nesting, GeometryReader* reader, GeometryEnvelope* envelope) {
  const uint8_t byte_order = reader->Byte();
  reader->set_little_endian(byte_order == kLittleEndian);
  const uint32_t type = reader->Word();
  if (byte_order > 1 || type >= 4000 || nesting > kMaxNesting) {
    return false;
  }
  const uint32_t dimensions = type / 1000;  // 0: xy, 1: xyz, 2: xym, 3: xyzm.
  const int num_coordinates = dimensions == 0 ? 2 : dimensions == 3 ? 4 : 3;
  const uint32_t shape = type % 1000;
  if (shape == 1) {  // Point.
    ReadPoints(1, num_coordinates, reader, envelope);
  } else if (shape == 2) {  // Line string.
    ReadPoints(reader->Word(), num_coordinates, reader, envelope);
  } else if (shape == 3) {  // Polygon.
    const uint32_t num_rings = reader->Word();
    for (uint32_t i = 0; i < num_rings && reader->ok(); ++i) {
      ReadPoints(reader->Word(), num_coordinates, reader, envelope);
    }
  } else if (shape >= 4 && shape <= 7) {  // Collections.
    const uint32_t num_parts = reader->Word();
    for (uint32_t i = 0; i < num_parts && reader->ok(); ++i) {
      if (!ReadWkb(nesting + 1, reader, envelope)) {
        return false;
      }
    }
  } else {
    return false;
  }
  return reader->ok();
}

}  // namespace

std::vector<uint8_t> PointGeometry(const Geodetic& position) {
  std::vector<uint8_t> blob;
  ByteWriter writer(&blob);
  PutHeader(0, &writer);
  writer.Put(kLittleEndian);
  writer.Put(kWkbPointZ);
  writer.Put(position.lon_deg());
  writer.Put(position.lat_deg());
  writer.Put(position.h_m);
  return blob;
}

std::vector<uint8_t> TileGeometry(TileId tile_id) {
  std::vector<LonLat> ring = CornersOf(tile_id);
  GeometryEnvelope envelope;
  for (const LonLat& corner : ring) {
    Extend(corner.lon_deg, corner.lat_deg, &envelope);
  }
  ring.push_back(ring.front());

  std::vector<uint8_t> blob;
  ByteWriter writer(&blob);
  PutHeader(kEnvelopeXy, &writer);
  for (const double bound : {envelope.min_x, envelope.max_x, envelope.min_y, envelope.max_y}) {
    writer.Put(bound);
  }
  writer.Put(kLittleEndian);
  writer.Put(kWkbPolygon);
  writer.Put(uint32_t{1});  // Number of rings.
  writer.Put(static_cast<uint32_t>(ring.size()));
  for (const LonLat& corner : ring) {
    writer.Put(corner.lon_deg);
    writer.Put(corner.lat_deg);
  }
  return blob;
}

std::optional<GeometryEnvelope> EnvelopeOfGeometry(std::span<const uint8_t> blob) {
  constexpr int kNumEnvelopeNumbers[] = {0, 4, 6, 6, 8};
  GeometryReader reader(blob);
  const bool has_magic = reader.Byte() == 'G' && reader.Byte() == 'P' && reader.Byte() == 0;
  const uint8_t flags = reader.Byte();
  reader.set_little_endian((flags & kLittleEndian) != 0);
  reader.Word();  // Skips the reference system.
  const int envelope_code = flags >> 1 & 7;
  if (!has_magic || envelope_code > 4) {
    return std::nullopt;
  }
  GeometryEnvelope envelope;
  if (envelope_code > 0) {
    const double min_x = reader.Number(), max_x = reader.Number();
    const double min_y = reader.Number(), max_y = reader.Number();
    for (int i = 4; i < kNumEnvelopeNumbers[envelope_code]; ++i) {
      reader.Number();
    }
    Extend(min_x, min_y, &envelope);
    Extend(max_x, max_y, &envelope);
  }
  if ((flags & kEmpty) != 0) {
    envelope.is_empty = true;
  } else if (envelope_code == 0 && !ReadWkb(0, &reader, &envelope)) {
    return std::nullopt;
  }
  return reader.ok() ? std::optional(envelope) : std::nullopt;
}

}  // namespace cairn
