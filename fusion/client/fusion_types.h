// What goes into the client library and what comes out of it.
#ifndef CAIRN_FUSION_CLIENT_FUSION_TYPES_H_
#define CAIRN_FUSION_CLIENT_FUSION_TYPES_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/rigid3.h"
#include "fusion/filter/filter_state.h"
#include "fusion/filter/imu_propagation.h"
#include "fusion/tracks/track_table.h"

namespace cairn::fusion {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

enum class ImuStatus {
  kAccepted,
  kBadInput,    // A number is not finite.
  kOutOfOrder,  // Not newer than the last one: dropped.
  kRestarted,   // The clock jumped, or a gap was too long to bridge: `local` begins anew.
};

enum class FrameStatus {
  kAccepted,    // Processed, or waiting for the inertial samples up to it.
  kBadInput,    // Negative timestamp.
  kOutOfOrder,  // Not newer than the last frame, or than the filter: dropped.
  kQueueFull,   // Too many frames wait for inertial samples: dropped.
};

// What one camera frame showed.
struct Frame {
  int64_t timestamp_ns = 0;  // Of the camera's clock; see Rig::time_offset_s.
  std::span<const TrackedFeature> features;
};

// A pose and the covariance of its (rotation, translation), perturbed on the left in the target
// frame, as LocalizeResult::covariance; rad^2, rad m, m^2.
struct PosePrior {
  Rigid3d global_from_cam;
  Matrix6d covariance;
};

// A frame that the map should be asked about.
struct Query {
  int64_t query_id = 0;
  int64_t timestamp_ns = 0;  // Of the frame.
  std::vector<TrackedFeature> features;
  Eigen::Vector3d down_in_cam;     // Unit vector.
  double down_sigma_rad = 0.0;     // Per axis.
  std::optional<PosePrior> prior;  // Once aligned.
};

// A landmark of the map found in a queried frame.
struct MapMatch {
  Eigen::Vector2d pixel;
  std::optional<uint64_t> track_id;  // If the keypoint is a tracked feature of the frame.
  Eigen::Vector3d x_in_global;
  double sigma_m = 0.0;  // Standard deviation of the landmark per axis.
  uint64_t landmark_id = 0;
  uint64_t tile_id = 0;
};

// The answer to a query. `global` is the same frame for all answers of a session: whoever talks to
// the server moves them there.
struct Answer {
  int64_t query_id = 0;
  bool localized = false;
  Rigid3d global_from_cam;
  std::vector<MapMatch> matches;
};

// What became of an answer.
enum class AnswerOutcome {
  kApplied,
  kAwaitsAlignment,  // Kept, until enough answers agree.
  kNotLocalized,     // The server had no pose.
  kUnknownQuery,     // Never asked, already answered, or given up before `local` began anew.
  kCloneGone,        // Came after QueryOptions::timeout_s.
  kBadInput,         // A number is not finite, a sigma negative.
  kTooFewMatches,
  kGravityMismatch,  // Its pose contradicts gravity.
  kDisagrees,        // Its matches contradict the state.
};

struct AnswerReport {
  int64_t query_id = 0;
  AnswerOutcome outcome = AnswerOutcome::kApplied;
  int num_matches = 0;  // That were applied.
};

enum class SubmitStatus { kQueued, kQueueFull };

enum class Mode {
  kInitializing,  // Waiting for a start.
  kTracking,      // Locally, without a map.
  kAligning,      // Some answers are there, not yet enough that agree.
  kLocalized,
  kCoasting,  // Localized, but without an answer for a while.
  kLost,      // The track of `local` was lost; waiting for a start.
};

// The state at one instant. Covariances are perturbed on the left, in local (global_from_imu: in
// global). Of the two poses in global, a robot takes global_from_imu, a display the steady one.
struct Estimate {
  Mode mode = Mode::kInitializing;
  int64_t timestamp_ns = 0;  // Of the imu's clock.
  int64_t epoch = 0;  // Counts how often `local` began anew; poses of two epochs do not compare.
  // Continuous: what the map corrects of it is passed on slowly, global_from_local takes the rest.
  ImuState imu;
  Matrix15d covariance = Matrix15d::Zero();  // Of [theta, p, v, b_g, b_a].
  bool has_global = false;
  Rigid3d global_from_local;
  // Of [rotation, translation] of global_from_local = true value (Exp(rotation), translation) on
  // the right, in local.
  Matrix6d global_covariance = Matrix6d::Zero();
  Rigid3d global_from_imu;  // The best estimate; jumps where it is corrected.
  Matrix6d global_from_imu_covariance = Matrix6d::Zero();
  // The same without jumps from frame to frame: what is corrected of the last frame's pose passes
  // over FusionOptions::steady.time_constant_s, but at once if it is an alignment or exceeds the
  // bounds there. Off by no more than global_from_imu and the difference; equal to it if that is 0.
  Rigid3d steady_global_from_imu;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_CLIENT_FUSION_TYPES_H_
