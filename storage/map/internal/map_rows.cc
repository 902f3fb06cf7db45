#include "storage/map/internal/map_rows.h"

#include <fmt/format.h>

#include <charconv>
#include <string_view>
#include <system_error>

#include "core/angles.h"
#include "core/printable.h"
#include "storage/tile/tile_checks.h"

namespace cairn::rows {
namespace {

// Queries search for cameras between these heights.
void RequireHeights(const db::Connection& connection, const TileRecord& tile) {
  constexpr double kMaxHeightM = 1e5;
  if (!(-kMaxHeightM <= tile.min_h_m && tile.min_h_m <= tile.max_h_m &&
        tile.max_h_m <= kMaxHeightM)) {
    throw Error(
        ErrorCode::kMapDamaged,
        fmt::format("{}: tile {}: its cameras have heights of {} to {} m", connection.name(),
                    tile.tile_id.ToString(), tile.min_h_m, tile.max_h_m));
  }
}

// Parses "[1.5,2,3]". Throws Error if the text is anything else.
std::vector<double> ParseNumbers(std::string_view text) {
  std::vector<double> numbers;
  const auto refuse = [text] {
    return Error(ErrorCode::kMapDamaged,
                 "camera parameters '" + Excerpt(text) + "' are not a list of numbers");
  };
  if (text.size() < 2 || text.front() != '[' || text.back() != ']') {
    throw refuse();
  }
  const char* next = text.data() + 1;
  const char* const end = text.data() + text.size() - 1;
  while (true) {
    double number = 0.0;
    const auto [after, error] = std::from_chars(next, end, number);
    if (error != std::errc()) {
      throw refuse();
    }
    numbers.push_back(number);
    if (after == end) {
      return numbers;
    }
    if (*after != ',') {
      throw refuse();
    }
    next = after + 1;
  }
}

}  // namespace

TileId ReadTileId(const db::Connection& connection, int64_t value) {
  return MakeFromRow(connection,
                     [value] { return TileId::FromValue(static_cast<uint64_t>(value)); });
}

TileRecord ReadTile(const db::Connection& connection, const db::Statement& row) {
  TileRecord tile;
  tile.tile_id = ReadTileId(connection, row.Int64(0));
  tile.payload_id = PayloadId(row.Int64(1));
  tile.codebook_id = CodebookId(row.Int64(2));
  tile.num_landmarks = row.Int64(3);
  tile.num_descriptors = row.Int64(4);
  tile.num_keyframes = row.Int64(5);
  tile.num_bytes = row.Int64(6);
  tile.min_h_m = row.Double(7);
  tile.max_h_m = row.Double(8);
  RequireHeights(connection, tile);
  tile.landmark_bounds = {row.Double(9) / kDegPerRad, row.Double(10) / kDegPerRad,
                          row.Double(11) / kDegPerRad, row.Double(12) / kDegPerRad};
  tile.digest = row.Text(13);
  return tile;
}

std::vector<TileRecord> ReadTiles(const db::Connection& connection, db::Statement* rows) {
  std::vector<TileRecord> tiles;
  while (rows->Step()) {
    tiles.push_back(ReadTile(connection, *rows));
  }
  return tiles;
}

SessionRecord ReadSession(const db::Statement& row) {
  SessionRecord session;
  session.id = SessionId(row.Int64(0));
  session.name = row.Text(1);
  session.source = row.Text(2);
  session.created_at = row.Text(3);
  session.recorded_at = row.Text(4);
  session.content_digest = row.Text(5);
  session.num_images = row.Int64(6);
  session.num_landmarks = row.Int64(7);
  session.georef_median_residual_m = row.Double(8);
  return session;
}

KeyframeRecord ReadKeyframe(const db::Connection& connection, const db::Statement& row) {
  KeyframeRecord keyframe;
  keyframe.id = KeyframeId(row.Int64(0));
  keyframe.session_id = SessionId(row.Int64(1));
  keyframe.tile_id = ReadTileId(connection, row.Int64(2));
  keyframe.image_name = row.Text(3);
  keyframe.camera = MakeFromRow(connection, [&row] {
    return Camera(CameraModelFromName(row.Text(4)), static_cast<int>(row.Int64(5)),
                  static_cast<int>(row.Int64(6)), ParseNumbers(row.Text(7)));
  });
  // Keeps the stored quaternion; the constructor would normalize it again.
  keyframe.cam_from_ecef.rotation =
      Eigen::Quaterniond(row.Double(8), row.Double(9), row.Double(10), row.Double(11));
  keyframe.cam_from_ecef.translation = {row.Double(12), row.Double(13), row.Double(14)};
  if (!IsPose(keyframe.cam_from_ecef)) {
    throw Error(ErrorCode::kMapDamaged,
                fmt::format("{}: keyframe {}: its pose is not a rigid transform", connection.name(),
                            Value(keyframe.id)));
  }
  return keyframe;
}

std::vector<KeyframeRecord> ReadKeyframes(const db::Connection& connection, db::Statement* rows) {
  std::vector<KeyframeRecord> keyframes;
  while (rows->Step()) {
    keyframes.push_back(ReadKeyframe(connection, *rows));
  }
  return keyframes;
}

}  // namespace cairn::rows
