// The coordinate frames of the project, listed once.
//
//   ecef    Earth-centred Earth-fixed WGS84, metres.
//   enu     East-north-up at some geodetic point, metres; the point is always named beside it.
//   tile    The enu frame at a tile's anchor (TileId::Anchor).
//   anchor  The enu frame of one query; every tile the query touches is moved into it.
//   world   The arbitrary, arbitrarily scaled frame of a reconstruction before georegistration.
//   cam     x right, y down, z forward; metres.
//   imu     The body frame of an inertial unit.
//   local   A client's gravity-aligned tracking frame (z up).
//   global  The map frame a client is aligned to.
//
// A transform is `target_from_source`, a point `x_in_frame`. Neighbouring names cancel:
// `cam_from_ecef = cam_from_tile * tile_from_ecef`. Gravity in a query is `down_in_cam`, a unit
// vector.
#ifndef CAIRN_CORE_FRAMES_H_
#define CAIRN_CORE_FRAMES_H_

#include <Eigen/Core>

namespace cairn {

// Unit vector that points down in any of the enu, tile, anchor frames.
inline Eigen::Vector3d DownInEnu() { return -Eigen::Vector3d::UnitZ(); }

}  // namespace cairn

#endif  // CAIRN_CORE_FRAMES_H_
