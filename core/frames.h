// The coordinate frames of the project.
//
//   ecef    Earth-centered Earth-fixed WGS84, meters.
//   enu     East-north-up at a geodetic point, meters; a comment always names the point.
//   tile    The enu frame at a tile's anchor (TileId::Anchor).
//   anchor  The enu frame of one query; every tile of the query is transformed to it.
//   world   The frame of a reconstruction before georegistration; its pose and scale are arbitrary.
//   cam     x right, y down, z forward; meters.
//   imu     The body frame of an inertial unit.
//   local   A client's gravity-aligned tracking frame (z up).
//   global  The map frame to which a client is aligned.
//
// A transform is named `target_from_source`, a point `x_in_frame`. Neighboring names cancel:
// `cam_from_ecef = cam_from_tile * tile_from_ecef`. The gravity direction of a query is
// `down_in_cam`, a unit vector.
#ifndef CAIRN_CORE_FRAMES_H_
#define CAIRN_CORE_FRAMES_H_

#include <Eigen/Core>

namespace cairn {

// The unit vector that points down in the enu, tile and anchor frames.
inline Eigen::Vector3d DownInEnu() { return -Eigen::Vector3d::UnitZ(); }

}  // namespace cairn

#endif  // CAIRN_CORE_FRAMES_H_
