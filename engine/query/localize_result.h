// The answer to a query, with the evidence behind it.
#ifndef CAIRN_ENGINE_QUERY_LOCALIZE_RESULT_H_
#define CAIRN_ENGINE_QUERY_LOCALIZE_RESULT_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/geodesy.h"
#include "core/rigid3.h"
#include "core/tile_id.h"
#include "engine/query/inlier_traits.h"
#include "storage/ids.h"

namespace cairn {

// Why there is no pose. Names on the wire are the upper-case forms (NO_COVERAGE, ...).
enum class NotLocalizedReason {
  kNone,            // There is a pose.
  kNoCoverage,      // No tile near the prior.
  kTooFewFeatures,  // The query has fewer keypoints than a pose needs.
  kTooFewMatches,   // The map knows too few of the descriptors.
  kTooFewInliers,   // No pose explains enough of the matches.
  kAmbiguous,       // Two poses far apart explain the image about equally well.
  kPriorMismatch,   // The best pose is too far from the prior for how little speaks for it.
  kTimeout,         // The deadline left no time to find an answer.
};
const char* NotLocalizedReasonName(NotLocalizedReason reason);

// The stages of a query, in order.
enum class Stage { kPrior, kTiles, kMatching, kVoting, kPose, kRefinement };
inline constexpr int kNumStages = 6;
const char* StageName(Stage stage);  // "prior", "tiles", ...

struct StageTimes {
  std::array<double, kNumStages> seconds{};  // Wall time, indexed by Stage; 0: it did not run.
  double total_seconds = 0.0;
};

struct StageCounters {
  int64_t num_keypoints = 0;
  int64_t num_tiles_found = 0;     // By the geo-query.
  int64_t num_tiles_searched = 0;  // After the tile limit, and the deadline.
  int64_t num_tiles_loaded = 0;    // Cache misses.
  int64_t num_descriptors = 0;     // In the tiles searched.
  int64_t num_distances = 0;       // Descriptor distances computed.
  // Keypoint-landmark pairs under the threshold; this and the next three are of the last try, which
  // may have been the one without gravity.
  int64_t num_matches = 0;
  int64_t num_matched_keypoints = 0;
  int64_t num_votes = 0;
  int64_t num_candidates = 0;  // Voting maxima handed to pose estimation.
  int64_t num_ransac_iterations = 0;
  int64_t num_refined_keyframes = 0;  // 0 if the refinement stage was not needed.
  int64_t num_rematches = 0;          // Matches of the refinement stage.
  bool used_prior = false;
  bool used_gravity = false;    // By the answer; in the query, if there is none.
  bool tile_limit_hit = false;  // More tiles in the region than the limit: a part was not seen.
  // The deadline kept a stage from all of its work; with more time the answer might be better.
  bool tiles_cut_short = false;     // Tiles left out, or parts of their indices not yet built.
  bool matching_cut_short = false;  // Not all keypoints searched everywhere.
  bool pose_cut_short = false;      // Candidates not tried.
  bool refinement_cut_short = false;

  bool is_cut_short() const {
    return tiles_cut_short || matching_cut_short || pose_cut_short || refinement_cut_short;
  }
};

// An inlier of the final pose.
struct LocalizeMatch {
  int keypoint_idx = 0;  // Into the features of its camera.
  int camera_idx = 0;    // 0 is the query's own, i is other_cameras[i - 1] of a rig.
  Eigen::Vector2d pixel;
  LandmarkId landmark_id{};
  int tile_idx = 0;  // Into LocalizeResult::tiles.
  Eigen::Vector3d x_in_anchor;
  double sigma_m = 0.0;            // Landmark position standard deviation.
  double right_probability = 0.0;  // That this is the right landmark, if the pose is right.
  InlierTraits traits;             // Its reprojection error among them.
};

// The camera of an answer, where that is not simply the query's.
struct CameraEstimate {
  Camera camera;
  double focal_sigma_px = 0.0;  // Standard deviation of its focal length.
  // What the query said, or was taken to say, of it, and the standard deviation of that.
  double assumed_focal_px = 0.0;
  double assumed_focal_sigma_px = 0.0;
  // The inliers say something else, by more than three standard deviations.
  bool focal_disagrees = false;
};

struct LocalizeResult {
  bool localized = false;
  NotLocalizedReason reason = NotLocalizedReason::kNone;

  // Below: meaningful if localized.
  Geodetic anchor;  // Origin of the anchor frame.
  Rigid3d cam_from_anchor;
  Rigid3d cam_from_ecef;
  Geodetic position;  // Of the camera centre.
  // Of (rotation, translation) of the camera in the anchor frame, perturbed on the left:
  // anchor_from_cam = (Exp(rotation), translation + .) applied to the estimate; rad^2, rad m, m^2.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double position_accuracy_m = 0.0;  // Radius that holds the truth with 68 % probability.
  double rotation_accuracy_rad = 0.0;
  // How far the evidence is from chance: the logarithm of the likelihood ratio of the pose against
  // chance, less the logarithm of the number of poses that the prior leaves, see docs/math.
  double score = 0.0;
  double confidence = 0.0;  // Probability that the pose is within 3 m and 10 degrees.
  // Probability that a query that shows nothing of the map gets an answer of this score.
  double false_alarm_rate = 0.0;
  // The position is farther from the prior than one position in a hundred.
  bool prior_disagrees = false;
  std::vector<LocalizeMatch> matches;  // All inliers, by camera and keypoint.
  // Set if the camera was estimated along with the pose: the query has a focal prior, or the
  // inliers contradict its focal length. The pose and the errors of the matches go with it.
  std::optional<CameraEstimate> camera;

  // Always set.
  MapVersion map_version{};
  std::vector<TileId> tiles;  // Searched.
  StageCounters counters;
  StageTimes times;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_QUERY_LOCALIZE_RESULT_H_
