// The frames in which results and exports state poses: cam_from_world and x_in_world.
#ifndef CAIRN_CLI_BATCH_WORLD_FRAME_H_
#define CAIRN_CLI_BATCH_WORLD_FRAME_H_

#include <optional>
#include <string>

#include "core/geodesy.h"
#include "core/rigid3.h"
#include "storage/map/map_store.h"

namespace cairn {

struct WorldFrame {
  std::string name = "ecef";            // "ecef", "enu" or "model".
  std::optional<Geodetic> origin = {};  // Of "enu".
  Sim3d ecef_from_world = {};           // Only "model" has a scale other than 1.

  // For people, e.g. "east-north-up at 55.7,13.2,100 (latitude, longitude, ellipsoidal height)".
  std::string Text() const;
  Rigid3d CamFromWorld(const Rigid3d& cam_from_ecef) const;
};

WorldFrame EnuFrame(const Geodetic& origin);

// The place of the map's first keyframe: degrees to six digits, the height to the meter, so that
// its text is exact. It stays as the map grows. Throws Error(kBadInput) if the map is empty.
Geodetic MapOrigin(const MapSnapshot& map);

// The frame of a COLMAP model of which the map has images, by their names. Throws as
// ReadColmapModel, and Error(kBadInput) if the map has fewer than three of them or other poses.
WorldFrame ModelFrame(const std::string& model_dir, const MapSnapshot& map);

}  // namespace cairn

#endif  // CAIRN_CLI_BATCH_WORLD_FRAME_H_
