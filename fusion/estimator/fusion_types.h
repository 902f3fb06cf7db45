// Inputs and outputs of the client library.
#ifndef CAIRN_FUSION_ESTIMATOR_FUSION_TYPES_H_
#define CAIRN_FUSION_ESTIMATOR_FUSION_TYPES_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/inertial/imu.h"
#include "core/inertial/imu_propagation.h"
#include "core/rigid3.h"
#include "fusion/filter/pose_covariance.h"
#include "fusion/map_updates/map_match.h"
#include "fusion/tracks/track_table.h"

namespace cairn::fusion {

enum class ImuStatus {
  kAccepted,
  kBadInput,    // A number is not finite.
  kOutOfOrder,  // Not newer than the last one: dropped.
  kRestarted,   // Clock jump, or gap too long to bridge: `local` starts over.
};

enum class FrameStatus {
  kAccepted,    // Processed, or waits for its inertial samples.
  kBadInput,    // Negative timestamp.
  kOutOfOrder,  // Not newer than the last frame or the filter: dropped.
  kQueueFull,   // Too many frames wait for inertial samples: dropped.
};

// The features of one camera frame.
struct Frame {
  int64_t timestamp_ns = 0;  // In the camera's clock; see Rig::time_offset_s.
  std::span<const TrackedFeature> features;
};

// A question to the map about one frame.
struct Query {
  int64_t query_id = 0;
  int64_t timestamp_ns = 0;  // Time of the frame.
  std::vector<TrackedFeature> features;
  Eigen::Vector3d down_in_cam;     // Unit vector.
  double down_sigma_rad = 0.0;     // Per axis.
  std::optional<PosePrior> prior;  // Set once aligned.
};

// The answer to a query. All answers of a session must use the same `global` frame; the code that
// talks to the server transforms them.
struct Answer {
  int64_t query_id = 0;
  bool localized = false;
  Rigid3d global_from_cam;
  std::vector<MapMatch> matches;
};

// The outcome of an answer.
enum class AnswerOutcome {
  kApplied,
  kAwaitsAlignment,  // Kept until enough answers agree.
  kNotLocalized,     // The server found no pose.
  kUnknownQuery,     // Never asked, already answered, or from before `local` restarted.
  kCloneGone,        // Came after QueryOptions::timeout_s.
  kBadInput,         // A number is not finite, or a sigma is negative.
  kTooFewMatches,
  kGravityMismatch,  // The pose contradicts gravity.
  kDisagrees,        // The matches contradict the state.
};

struct AnswerReport {
  int64_t query_id = 0;
  AnswerOutcome outcome = AnswerOutcome::kApplied;
  int num_matches = 0;  // Matches that were applied.
};

enum class SubmitStatus { kQueued, kQueueFull };

enum class Mode {
  kInitializing,  // Waiting for a start.
  kTracking,      // Tracking locally, not yet aligned to the map.
  kAligning,      // There are answers, but too few agree.
  kLocalized,
  kCoasting,  // Localized, but without a recent answer.
  kLost,      // `local` was lost; waiting for a start.
};

// The state at one time. Covariances are perturbed on the left, in local; that of global_from_imu
// in global. There are two poses in global: a robot should use global_from_imu, a display
// steady_global_from_imu.
struct Estimate {
  Mode mode = Mode::kInitializing;
  int64_t timestamp_ns = 0;  // In the IMU's clock.
  // Counts the restarts of `local`. Poses of different epochs are not comparable.
  int64_t epoch = 0;
  // Free of jumps: corrections by the map reach `imu` slowly; global_from_local takes the rest at
  // once.
  ImuState imu;
  Matrix15d covariance = Matrix15d::Zero();  // Order: theta, p, v, b_g, b_a.
  bool has_global = false;
  Rigid3d global_from_local;
  // Covariance of [rotation, translation] of global_from_local. The error is on the right, in
  // local: global_from_local = true value * (Exp(rotation), translation).
  Matrix6d global_covariance = Matrix6d::Zero();
  Rigid3d global_from_imu;  // Best estimate; jumps at corrections.
  Matrix6d global_from_imu_covariance = Matrix6d::Zero();
  // The same pose without jumps from frame to frame. A correction of the last frame's pose is
  // blended in over FusionOptions::steady.time_constant_s. An alignment, and a correction beyond
  // the bounds of FusionOptions::steady, takes effect at once. The error is at most that of
  // global_from_imu plus the difference of the two poses. With a time constant of 0 the two poses
  // are equal.
  Rigid3d steady_global_from_imu;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_ESTIMATOR_FUSION_TYPES_H_
