// Options of the refinement stage.
#ifndef CAIRN_ENGINE_REFINEMENT_REFINEMENT_OPTIONS_H_
#define CAIRN_ENGINE_REFINEMENT_REFINEMENT_OPTIONS_H_

namespace cairn {

enum class RefinementMode {
  kNever,
  kWhenWeak,  // If no candidate has good_evidence.
  kAlways,
};

struct RefinementOptions {
  RefinementMode mode = RefinementMode::kWhenWeak;
  // A best candidate with at least this evidence (PoseEstimate::evidence) needs no keyframe
  // re-matching.
  double good_evidence = 120.0;
  int max_keyframes = 5;  // M: keyframes whose neighbourhoods are matched again.
  // Of so many of the best poses so far, the keyframe that saw most of what the pose explains is
  // matched again, too, so that a right pose competes with what other keyframes suggest by matches
  // of the same kind.
  int max_pose_keyframes = 2;
  int neighbors_per_keyframe = 4;  // Keyframes that share most landmarks with it, matched along.
  // A keyframe nearer than this to a better one that looks the same way (within 45 degrees) is the
  // same location and not ranked, metres. Covers the neighbours of a walk or a slow drive.
  double min_separation_m = 3.0;
  double relaxed_distance_quantile = 0.95;  // Threshold of the re-matching.
  // Gravity is doubted, and everything from matching on is tried once more as if the query had had
  // none (not in mode kNever), if the best pose has less evidence than this;
  // docs/decisions/0004.
  double min_trusted_evidence = 40.0;
  // It is doubted, too, if the best pose has less than good_evidence and is tilted
  // against gravity by more than so many standard deviations (PoseOptions::gravity_sigma_rad).
  double max_gravity_error_sigmas = 2.0;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_REFINEMENT_REFINEMENT_OPTIONS_H_
