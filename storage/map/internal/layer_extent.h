// Keeps the extent of a layer in gpkg_contents up to date; private to storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_LAYER_EXTENT_H_
#define CAIRN_STORAGE_MAP_INTERNAL_LAYER_EXTENT_H_

#include <vector>

#include "storage/database/connection.h"
#include "storage/inspection/geopackage.h"

namespace cairn {

// The extent of one layer during an update. GeoPackage readers show the extent without reading the
// layer.
class LayerExtent {
 public:
  // Reads the extent from gpkg_contents. `layer` and `index` are the names of the layer's table and
  // of its R*Tree; they must outlive the extent.
  LayerExtent(db::Connection* connection, const char* layer, const char* index);

  void Add(const GeometryEnvelope& envelope);
  void Remove(const GeometryEnvelope& envelope);

  // Writes the extent. Reads the edges of the index if a geometry there is gone, and the whole
  // index if the file did not have the extent.
  void Write(db::Connection* connection) const;

 private:
  const char* layer_;
  const char* index_;
  bool is_known_ = true;     // False if the file did not have the extent.
  GeometryEnvelope extent_;  // Contains that of the layer, if known.
  std::vector<GeometryEnvelope> gone_from_edge_;
};

// The extents of both layers of a map.
struct LayerExtents {
  explicit LayerExtents(db::Connection* connection);
  void Write(db::Connection* connection) const;  // Also writes the time of the change.

  LayerExtent coverage;
  LayerExtent keyframes;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_LAYER_EXTENT_H_
