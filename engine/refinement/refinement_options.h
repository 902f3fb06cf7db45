// Options of the refinement stage.
#ifndef CAIRN_ENGINE_REFINEMENT_REFINEMENT_OPTIONS_H_
#define CAIRN_ENGINE_REFINEMENT_REFINEMENT_OPTIONS_H_

namespace cairn {

enum class RefinementMode {
  kNever,
  kWhenWeak,  // If no pose has good_evidence.
  kAlways,
};

struct RefinementOptions {
  RefinementMode mode = RefinementMode::kWhenWeak;
  // If the best pose has at least this evidence (PoseEstimate::evidence), keyframes are not matched
  // again.
  double good_evidence = 120.0;
  int max_keyframes = 5;  // M: number of keyframes whose neighborhoods are matched again.
  // For this number of best poses, the keyframe that saw most of what the pose explains is also
  // matched again. A right pose then competes on equal terms with the poses that other keyframes
  // suggest.
  int max_pose_keyframes = 2;
  // Keyframes sharing most landmarks with a keyframe, matched with it.
  int neighbors_per_keyframe = 4;
  // A keyframe nearer than this to a better one that looks the same way (within 45 degrees) is at
  // the same location and not ranked, meters. Covers the neighbors of a walk or a slow drive.
  double min_separation_m = 3.0;
  // If the best pose has less evidence than this, gravity may be wrong. The stages from matching on
  // then run once more without gravity (not in mode kNever); see docs/decisions/0004.
  double min_trusted_evidence = 40.0;
  // Gravity may also be wrong if the best pose has less than good_evidence and its tilt contradicts
  // gravity by more than this number of standard deviations (PoseOptions::gravity_sigma_rad).
  double max_gravity_error_sigmas = 2.0;

  // Throws Error(kInvalidArgument), naming the field.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_REFINEMENT_REFINEMENT_OPTIONS_H_
