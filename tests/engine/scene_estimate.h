// Estimates the pose of a scene, and compares it with the truth.
#ifndef CAIRN_TESTS_ENGINE_SCENE_ESTIMATE_H_
#define CAIRN_TESTS_ENGINE_SCENE_ESTIMATE_H_

#include <cstdint>
#include <optional>

#include "engine/pose/estimate_pose.h"
#include "support/pose_scene.h"

namespace cairn::testing {

inline std::optional<PoseEstimate> Estimate(const PoseScene& scene, const PoseOptions& options = {},
                                            uint64_t seed = 1) {
  return EstimatePose(scene.query, scene.correspondences, scene.AllIndices(), options, seed);
}

// Returns whether there is an estimate within 0.5 m and one degree of the truth.
inline bool IsRight(const std::optional<PoseEstimate>& estimate, const PoseScene& scene) {
  return estimate && CenterErrorM(estimate->cam_from_anchor, scene.cam_from_anchor) < 0.5 &&
         RotationAngleRad(estimate->cam_from_anchor.rotation, scene.cam_from_anchor.rotation) <
             0.0175;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_ENGINE_SCENE_ESTIMATE_H_
