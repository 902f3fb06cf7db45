// Finds the camera of a query whose focal length is uncertain.
#ifndef CAIRN_ENGINE_FIND_CAMERA_H_
#define CAIRN_ENGINE_FIND_CAMERA_H_

#include <cstdint>

#include "engine/localizer_options.h"
#include "engine/pose/pose_hypotheses.h"
#include "engine/query/localize_query.h"
#include "engine/refinement/match_keyframes.h"

namespace cairn {

// What finding poses has taken, as StageCounters count it.
struct PoseWork {
  int64_t num_ransac_iterations = 0;
  int64_t num_refined_keyframes = 0;
  int64_t num_rematches = 0;
  bool pose_cut_short = false;
  bool refinement_cut_short = false;

  void Add(const PoseWork& other);
  void Add(const TriedPoses& poses);
  void Add(const KeyframePoses& poses);
};

// The camera with which a query explains most.
struct FoundCamera {
  Camera camera;
  double focal_log_sigma = 0.0;  // Standard deviation of the logarithm of its focal length.
  double evidence = 0.0;         // Of its best pose; 0 if there is none.
  // The largest evidence of a pose with another camera, whose focal length differs by more than
  // three standard deviations.
  double rival_evidence = 0.0;
  bool is_complete = true;  // The deadline left out nothing.
  PoseWork work = {};

  // Returns true if the camera is known from now on: its pose has at least `min_evidence`, no rival
  // has a share of that (kMinShareOfBest), and the focal length is certain enough for pose
  // estimation (kMaxTrustedFocalLogSigma).
  bool IsCertain(double min_evidence) const;
};

// Tries all guesses of the focal length (FocalGuesses), voting and estimating poses with each, and
// refines the poses together with the camera. If `may_refine` is set and no pose is good, tries
// them again with the stage `refinement`, as a known camera would be. Returns the camera of the
// best pose, or the stated one if there is no pose. The context of `matched` has any camera of the
// query's size; `stated` holds what the client knows about the camera.
FoundCamera FindCamera(const MatchedQuery& matched, const LocalizeQuery& stated,
                       const LocalizerOptions& options, bool may_refine, const QueryBudget& budget);

}  // namespace cairn

#endif  // CAIRN_ENGINE_FIND_CAMERA_H_
