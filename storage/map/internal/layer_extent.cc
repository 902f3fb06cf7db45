#include "storage/map/internal/layer_extent.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "storage/map/internal/index_extent.h"

namespace cairn {
namespace {

bool Same(const GeometryEnvelope& a, const GeometryEnvelope& b) {
  return a.is_empty == b.is_empty && a.min_x == b.min_x && a.max_x == b.max_x &&
         a.min_y == b.min_y && a.max_y == b.max_y;
}

}  // namespace

LayerExtent::LayerExtent(db::Connection* connection, const char* layer, const char* index)
    : layer_(layer), index_(index) {
  db::Statement row = connection->Prepare(
      "SELECT min_x, max_x, min_y, max_y FROM gpkg_contents WHERE table_name = ? "
      "AND min_x IS NOT NULL AND max_x IS NOT NULL AND min_y IS NOT NULL AND max_y IS NOT NULL");
  if (row.Bind(std::string_view(layer)).Step()) {
    extent_ = {row.Number(0), row.Number(1), row.Number(2), row.Number(3), false};
  } else {
    is_known_ = false;
  }
}

void LayerExtent::Add(const GeometryEnvelope& envelope) {
  const auto back = std::find_if(gone_from_edge_.begin(), gone_from_edge_.end(),
                                 [&](const auto& gone) { return Same(gone, envelope); });
  if (back != gone_from_edge_.end()) {
    gone_from_edge_.erase(back);
    return;
  }
  if (extent_.is_empty) {
    extent_ = envelope;
    return;
  }
  extent_.min_x = std::min(extent_.min_x, envelope.min_x);
  extent_.max_x = std::max(extent_.max_x, envelope.max_x);
  extent_.min_y = std::min(extent_.min_y, envelope.min_y);
  extent_.max_y = std::max(extent_.max_y, envelope.max_y);
}

void LayerExtent::Remove(const GeometryEnvelope& envelope) {
  if (extent_.is_empty || envelope.is_empty || envelope.min_x <= extent_.min_x + kIndexSlackDeg ||
      envelope.max_x >= extent_.max_x - kIndexSlackDeg ||
      envelope.min_y <= extent_.min_y + kIndexSlackDeg ||
      envelope.max_y >= extent_.max_y - kIndexSlackDeg) {
    gone_from_edge_.push_back(envelope);
  }
}

void LayerExtent::Write(db::Connection* connection) const {
  GeometryEnvelope extent = extent_;
  if (is_known_ && !gone_from_edge_.empty()) {
    extent = IndexExtent(connection, index_, extent);
  }
  if (extent.is_empty || !is_known_) {
    connection->Execute(
        fmt::format("UPDATE gpkg_contents SET (min_x, min_y, max_x, max_y) = "
                    "(SELECT min(minx), min(miny), max(maxx), max(maxy) FROM {}) "
                    "WHERE table_name = '{}'",
                    index_, layer_));
  } else {
    connection
        ->Prepare(
            "UPDATE gpkg_contents SET min_x = ?, max_x = ?, min_y = ?, max_y = ? "
            "WHERE table_name = ?")
        .Bind(extent.min_x, extent.max_x, extent.min_y, extent.max_y, std::string_view(layer_))
        .Run();
  }
}

LayerExtents::LayerExtents(db::Connection* connection)
    : coverage(connection, "coverage", "rtree_coverage_geom"),
      keyframes(connection, "keyframes", "rtree_keyframes_geom") {}

void LayerExtents::Write(db::Connection* connection) const {
  coverage.Write(connection);
  keyframes.Write(connection);
  connection->Execute(
      "UPDATE gpkg_contents SET last_change = strftime('%Y-%m-%dT%H:%M:%fZ', 'now') "
      "WHERE table_name IN ('coverage', 'keyframes', 'cairn_sessions')");
}

}  // namespace cairn
