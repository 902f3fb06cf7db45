// Judges voting candidates by the ground truth of a scene.
#ifndef CAIRN_TESTS_SUPPORT_VOTING_TRUTH_H_
#define CAIRN_TESTS_SUPPORT_VOTING_TRUTH_H_

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "core/features.h"
#include "engine/query/pose_candidate.h"
#include "support/pose_scene.h"

namespace cairn::testing {

// Returns the yaw of the true pose, which is the yaw of the viewing direction (the x axis of the
// level frame).
inline double TrueYawRad(const PoseScene& scene) {
  const Eigen::Vector3d forward =
      scene.cam_from_anchor.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  return std::atan2(forward.y(), forward.x());
}

// Returns the index of the first candidate within 4 m and 6 degrees of the truth, or -1.
inline int RankOfTruth(const PoseScene& scene, const std::vector<PoseCandidate>& candidates) {
  constexpr double kMaxErrorM = 4.0;
  constexpr double kMaxErrorRad = 0.105;
  for (size_t i = 0; i < candidates.size(); ++i) {
    const PoseCandidate& candidate = candidates[i];
    if ((candidate.center_in_anchor - scene.center_in_anchor()).norm() < kMaxErrorM &&
        std::abs(WrapAngleRad(candidate.yaw_rad - TrueYawRad(scene))) < kMaxErrorRad) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_VOTING_TRUTH_H_
