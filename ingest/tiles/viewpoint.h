// Where a keyframe stands and where it looks. Private to ingest.
#ifndef CAIRN_INGEST_TILES_VIEWPOINT_H_
#define CAIRN_INGEST_TILES_VIEWPOINT_H_

#include "storage/tile/tile.h"

namespace cairn {

struct Viewpoint {
  Eigen::Vector3d center_in_tile;  // Meters.
  Eigen::Vector3d axis_in_tile;    // Optical axis, unit.
};

inline Viewpoint ViewpointOf(const TileKeyframe& keyframe) {
  const Rigid3d tile_from_cam = keyframe.cam_from_tile.Inverse();
  return {tile_from_cam.translation, tile_from_cam.rotation * Eigen::Vector3d::UnitZ()};
}

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_VIEWPOINT_H_
