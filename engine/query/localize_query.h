// The request of a client: the features of one image and what the client knows about its pose.
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
#include "core/position_prior.h"
#include "core/rig_camera.h"

namespace cairn {

struct LocalizeQuery {
  std::string id;  // Copied to the answer; may be empty.
  Camera camera;
  // The uncertainty of the focal length, if the client knows it. The focal length is then estimated
  // with the pose. Otherwise the focal length is assumed to be right within 1 % and kept unless the
  // inliers contradict it; see LocalizeResult::camera. Must be empty for a rig, whose cameras are
  // taken as stated.
  std::optional<FocalPrior> focal;
  FeatureSet features;  // Raw or projected; see DescriptorSpace.
  // Wire codec of projected features; must be the map's (Codebook::CodecName). Ignored for raw
  // features.
  std::string codec;
  // The other cameras of a rig, at most RigCamera::kMaxOthers. All cameras together are one query,
  // whose pose is that of `camera`. A camera may have no features.
  std::vector<RigCamera> other_cameras;
  std::optional<PositionPrior> prior;  // If empty, the places of the map are searched
  // that look most like the photo.
  // Unit vector. If empty, P3P replaces the two-point solver.
  std::optional<Eigen::Vector3d> down_in_cam;
  // At the deadline, the best answer found so far is returned. Empty means no deadline.
  std::optional<std::chrono::steady_clock::time_point> deadline;

  // Sum over all cameras.
  int num_features() const;

  // Throws Error(kBadInput), naming the field, if
  //  - a number is not finite;
  //  - the accuracy is outside (0, 100 km];
  //  - the gravity vector's length differs from 1 by more than 1e-3;
  //  - features are inconsistent;
  //  - a camera of a rig is more than 100 m from the first;
  //  - the focal prior is invalid or the query is a rig's.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_QUERY_LOCALIZE_QUERY_H_
