// Inner frames of an OGC GeoPose: the axes that the quaternion of an answer rotates.
#ifndef CAIRN_CORE_WIRE_INNER_FRAME_H_
#define CAIRN_CORE_WIRE_INNER_FRAME_H_

#include <Eigen/Geometry>
#include <optional>
#include <string_view>

#include "core/geodesy.h"
#include "core/rigid3.h"

namespace cairn {

// Each inner frame is fixed to the camera. The name lists the directions of its x, y, z axes.
//
//          x        y      z         identity quaternion means         used by
//   FLU    forward  left   up        looks east, upright               ROS, robotics, cars
//   RDF    right    down   forward   looks up, image x to the east     OpenCV, COLMAP; our `cam`
//   RUB    right    up     back      looks down, image x to the east   OpenGL, ARKit, WebXR
//   EUS    right    up     back      as RUB                            ARCore's camera
//
// EUS is named after the directions of the axes when the camera is level and looks north: east, up,
// south. The outer frame is always east-north-up at the camera, as in OGC GeoPose. ARCore's own
// geospatial quaternion also has the outer frame EUS. To get that quaternion, multiply ours from
// the left by the rotation of -90 degrees about x, (-sqrt(1/2), 0, 0, sqrt(1/2)).
enum class InnerFrame { kFlu, kRdf, kRub, kEus };

const char* InnerFrameName(InnerFrame frame);
std::optional<InnerFrame> InnerFrameFromName(std::string_view name);

// The constant rotation cam_from_inner: its columns are the inner axes in the camera frame.
Eigen::Matrix3d CamFromInner(InnerFrame frame);

// A GeoPose: the position and the orientation of a camera.
struct GeoPose {
  Geodetic position;                  // Of the camera center.
  Eigen::Quaterniond enu_from_inner;  // enu is at `position`; w >= 0.
};

GeoPose GeoPoseFromCamera(const Rigid3d& cam_from_ecef, InnerFrame frame);
Rigid3d CameraFromGeoPose(const GeoPose& geopose, InnerFrame frame);  // Returns cam_from_ecef.

}  // namespace cairn

#endif  // CAIRN_CORE_WIRE_INNER_FRAME_H_
