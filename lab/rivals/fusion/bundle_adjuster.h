// Sliding-window visual-inertial bundle adjustment with the map held fixed: the filter's rival
// (paper, "Evaluation of the Pose Fusion"; Middelberg et al. 2014).
#ifndef CAIRN_LAB_RIVALS_FUSION_BUNDLE_ADJUSTER_H_
#define CAIRN_LAB_RIVALS_FUSION_BUNDLE_ADJUSTER_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/inertial/imu.h"
#include "core/inertial/imu_propagation.h"
#include "core/rigid3.h"
#include "fusion/estimator/fusion_types.h"
#include "fusion/tracks/track_table.h"
#include "lab/rivals/fusion/bundle_adjuster_options.h"
#include "lab/rivals/fusion/marginal_prior.h"
#include "lab/rivals/fusion/window_problem.h"
#include "lab/rivals/fusion/window_tracks.h"
#include "lab/rivals/fusion/window_variables.h"

namespace cairn::fusion {

// A camera frame with its tracked features.
struct AdjusterFrame {
  int64_t frame_id = 0;
  int64_t timestamp_ns = 0;
  // If the newest camera of the window is not a keyframe, the next frame replaces it.
  bool is_keyframe = true;
  std::span<const ImuStep> steps_since_previous;
  std::span<const TrackedFeature> features;
};

// The window holds the newest frame and keyframes before it. A match to the map turns its track
// from a variable landmark into a fixed one for all cameras that see it, so no observation counts
// twice.
//
// Not thread-safe. Results repeat up to rounding, because Ceres orders variables by their address.
class BundleAdjuster {
 public:
  // Starts at the frame `first`, at which the IMU has the state `state`. `covariance` is the
  // covariance of its error [theta, p, v, b_g, b_a]. Position and yaw define local, so their
  // covariance may be zero; the options then say how they are held. Throws the errors of Validate.
  BundleAdjuster(const BundleAdjusterOptions& options, const ImuState& state,
                 const Matrix15d& covariance, const AdjusterFrame& first);

  // Appends the next frame: prediction and preintegration. The inertial steps must have a positive
  // duration.
  void AddFrame(const AdjusterFrame& frame);

  // Sets or replaces global_from_local. Without it, matches have no effect.
  void SetGlobalFromLocal(const Rigid3d& global_from_local);

  // Gates the matches of a frame at the present estimate and adds those that pass. Returns the
  // number of added matches; 0 if the frame is not in the window.
  int AddMatches(int64_t frame_id, std::span<const MapMatch> matches);

  // Discards cameras beyond the size of the window, triangulates new tracks and optimizes.
  AdjustmentSummary Optimize();

  ImuState state() const { return cameras_.back()->State(); }
  std::optional<Rigid3d> global_from_local() const;
  int num_cameras() const { return static_cast<int>(cameras_.size()); }
  std::vector<int64_t> frame_ids() const;
  // Returns local_from_imu of a frame, or nullopt if the frame is not in the window.
  std::optional<Rigid3d> PoseOf(int64_t frame_id) const;

 private:
  // A keypoint that is not a tracked feature becomes a track of one observation. The ids of such
  // tracks start here.
  static constexpr uint64_t kFirstUntrackedId = uint64_t{1} << 63;

  using Camera = std::unique_ptr<WindowCamera>;

  WindowCamera* FindCamera(int64_t frame_id) const;
  void RemoveCamera(size_t idx);
  void DiscardOne();
  size_t FurthestFromNewest() const;
  void MarginalizeOldest();
  std::vector<WindowTrack*> SelectTracks();
  void RefreshPreintegration();
  void DropBadLandmarks(std::span<WindowTrack* const> tracks);

  const BundleAdjusterOptions options_;
  std::deque<Camera> cameras_;  // Ordered by time.
  std::optional<WindowAlignment> alignment_;
  WindowTracks tracks_;
  std::optional<MarginalPrior> prior_;
  WindowProblem problem_;
  uint64_t next_untracked_id_ = kFirstUntrackedId;
};

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RIVALS_FUSION_BUNDLE_ADJUSTER_H_
