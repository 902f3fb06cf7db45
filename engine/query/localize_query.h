// What a client asks: features of one image and what it knows about its pose.
#ifndef CAIRN_ENGINE_QUERY_LOCALIZE_QUERY_H_
#define CAIRN_ENGINE_QUERY_LOCALIZE_QUERY_H_

#include <Eigen/Core>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/features.h"
#include "core/focal_length.h"
#include "core/geodesy.h"
#include "core/rigid3.h"

namespace cairn {

// A rough position, as a GPS receiver reports it.
struct PositionPrior {
  Geodetic position;
  double accuracy_m = 15.0;  // Radius that holds the truth with 68 % probability.
  // Standard deviation of the height; nothing if the height is unknown or not to be trusted.
  std::optional<double> height_sigma_m;
};

// A further camera of a rig and what it saw at the same instant.
struct RigCamera {
  Camera camera;
  Rigid3d cam_from_first;  // From the frame of the query's own camera into this one's.
  FeatureSet features;     // In the descriptor space of the query's own.
};

struct LocalizeQuery {
  std::string id;  // Echoed; may be empty.
  Camera camera;
  // How well its focal length is known, if the client says so: it is then estimated along with the
  // pose. If not, it is taken to be right within 1 % and kept unless the inliers contradict it; see
  // LocalizeResult::camera. Not for a rig, whose cameras are what they are said to be.
  std::optional<FocalPrior> focal;
  FeatureSet features;  // Raw or projected; see DescriptorSpace.
  // Wire codec of projected features; must be the map's (Codebook::CodecName). Unused for raw ones.
  std::string codec;
  // The other cameras of a rig; all together are one query, whose pose is that of `camera`. Cameras
  // may have no features; at most kMaxOtherCameras.
  std::vector<RigCamera> other_cameras;
  std::optional<PositionPrior> prior;          // Without it the whole map is searched.
  std::optional<Eigen::Vector3d> down_in_cam;  // Unit vector; without it P3P replaces two points.
  // The best answer found by then is returned; nothing means no deadline.
  std::optional<std::chrono::steady_clock::time_point> deadline;

  static constexpr int kMaxOtherCameras = 7;

  // Of all cameras.
  int num_features() const;

  // Throws Error(kBadInput) naming the field on non-finite numbers, an accuracy outside (0, 100
  // km], a gravity vector that is not of unit length within 1e-3, inconsistent features, cameras of
  // a rig that are more than 100 m apart, or a focal prior that makes no sense or is of a rig.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_QUERY_LOCALIZE_QUERY_H_
