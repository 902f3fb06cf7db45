// The answer to a query, with its evidence.
#ifndef CAIRN_ENGINE_QUERY_LOCALIZE_RESULT_H_
#define CAIRN_ENGINE_QUERY_LOCALIZE_RESULT_H_

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/focal_length.h"
#include "core/geodesy.h"
#include "core/rigid3.h"
#include "core/tile_id.h"
#include "engine/query/inlier_traits.h"
#include "storage/ids.h"

namespace cairn {

// The reason why there is no pose. The wire uses the upper-case forms (NO_COVERAGE, ...).
enum class NotLocalizedReason {
  kNone,            // There is a pose.
  kNoCoverage,      // No tile near the prior.
  kTooFewFeatures,  // The query has fewer keypoints than a pose needs.
  kTooFewMatches,   // The map knows too few of the descriptors.
  kTooFewInliers,   // No pose explains enough of the matches.
  kAmbiguous,       // Two poses far apart explain the image about equally well.
  // The best pose is far from the prior and has too little evidence for that distance.
  kPriorMismatch,
  kTimeout,  // The deadline passed before an answer was found.
};
const char* NotLocalizedReasonName(NotLocalizedReason reason);

// The stages of a query, in order.
enum class Stage { kPrior, kTiles, kMatching, kVoting, kPose, kRefinement };
inline constexpr int kNumStages = 6;
const char* StageName(Stage stage);  // "prior", "tiles", ...

struct StageTimes {
  // Wall time, indexed by Stage; 0 if the stage did not run.
  std::array<double, kNumStages> seconds{};
  double total_seconds = 0.0;
};

struct StageCounters {
  int64_t num_keypoints = 0;
  // Tiles that meet the region of the prior; without a prior, tiles of the map.
  int64_t num_tiles_found = 0;
  int64_t num_tiles_searched = 0;  // After the limit of tiles or places, and the deadline.
  int64_t num_tiles_loaded = 0;    // Cache misses.
  // Places of the map that were searched because the query has no prior. The counters of the tiles
  // are those of all places. Counters of the other stages are those of the place of the answer.
  int64_t num_places_searched = 0;
  int64_t num_descriptors = 0;  // In the searched tiles.
  int64_t num_distances = 0;    // Descriptor distances computed.
  // Keypoint-landmark pairs that matching returns, and keypoints that have one. If the stages ran
  // again without gravity, num_matches, num_matched_keypoints, num_votes and num_candidates are
  // those of the last run.
  int64_t num_matches = 0;
  int64_t num_matched_keypoints = 0;
  int64_t num_votes = 0;
  int64_t num_candidates = 0;  // Maxima of voting that pose estimation received.
  int64_t num_ransac_iterations = 0;
  int64_t num_refined_keyframes = 0;  // 0 if the refinement stage was not needed.
  int64_t num_rematches = 0;          // Matches of the refinement stage.
  bool used_prior = false;
  bool used_gravity = false;  // The answer used gravity; without an answer, the query had gravity.
  // More tiles were found than searched.
  bool tile_limit_hit = false;
  // The deadline cut a stage short; with more time, the answer might be better.
  bool tiles_cut_short = false;  // Tiles were left out, or parts of their indices were not built.
  bool matching_cut_short = false;  // Some keypoints were not searched everywhere.
  bool pose_cut_short = false;      // Some candidates were not tried.
  bool refinement_cut_short = false;
};

// An inlier of the final pose.
struct LocalizeMatch {
  int keypoint_idx = 0;  // Into the features of its camera.
  int camera_idx = 0;    // 0 is the query's own camera, i is other_cameras[i - 1] of a rig.
  Eigen::Vector2d pixel;
  LandmarkId landmark_id{};
  int tile_idx = 0;  // Into LocalizeResult::tiles.
  Eigen::Vector3d x_in_anchor;
  double sigma_m = 0.0;            // Landmark position standard deviation.
  double right_probability = 0.0;  // Probability that the landmark is right if the pose is right.
  InlierTraits traits;             // Include the reprojection error.
};

struct LocalizeResult {
  bool localized = false;
  NotLocalizedReason reason = NotLocalizedReason::kNone;
  // Without a pose: the reason in words, with what to do; see ExplainMiss.
  std::string reason_text;

  // The fields from here to `camera` are meaningful if localized.
  Geodetic anchor;  // Origin of the anchor frame.
  Rigid3d cam_from_anchor;
  Rigid3d cam_from_ecef;
  Geodetic position;  // Of the camera center.
  // Covariance of (rotation, translation) of the camera in the anchor frame, perturbed on the left:
  // anchor_from_cam = (Exp(rotation), translation + .) applied to the estimate; rad^2, rad m, m^2.
  // Calibrated, and relative to the map: it holds the error of the pose among the landmarks, and
  // how far parts of the map disagree, but not where the map stands on Earth.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  // The radii of `covariance` that contain the truth with 68 % probability (core/radius68.h).
  double position_accuracy_m = 0.0;
  double rotation_accuracy_rad = 0.0;
  // How far the map itself is from its true place and direction on Earth, 68 % radii.
  double map_accuracy_m = 0.0;
  double map_accuracy_rad = 0.0;
  // The radii of the pose on Earth: the pose in the map, and the map on Earth.
  double EarthAccuracyM() const { return std::hypot(position_accuracy_m, map_accuracy_m); }
  double EarthAccuracyRad() const { return std::hypot(rotation_accuracy_rad, map_accuracy_rad); }
  // Measures how far the evidence is from chance: the logarithm of the likelihood ratio of the pose
  // against chance, minus the logarithm of the number of poses that the prior leaves. See
  // docs/math.
  double score = 0.0;
  double confidence = 0.0;  // Probability that the pose is within 3 m and 10 degrees of the truth.
  // Probability that a query that shows nothing of the map reaches this score.
  double false_alarm_rate = 0.0;
  // The position is farther from the prior than 99 % of positions are.
  bool prior_disagrees = false;
  std::vector<LocalizeMatch> matches;  // All inliers, by camera and keypoint.
  // Set if the camera was estimated with the pose, because the query has a focal prior or the
  // inliers contradict the focal length. The pose and the errors of the matches are then for this
  // camera.
  std::optional<CameraEstimate> camera;

  // Always set.
  MapVersion map_version{};
  bool map_is_stale = false;  // The map's store is silent: there may be a newer version.
  std::vector<TileId> tiles;  // The searched tiles, of one place.
  StageCounters counters;
  StageTimes times;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_QUERY_LOCALIZE_RESULT_H_
