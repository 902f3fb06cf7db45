// Options of the voting stage.
#ifndef CAIRN_ENGINE_VOTING_VOTING_OPTIONS_H_
#define CAIRN_ENGINE_VOTING_VOTING_OPTIONS_H_

#include <functional>
#include <vector>

namespace cairn {

struct Correspondence;
struct PoseCandidate;
struct TileView;

// How matches are thinned out before poses are estimated (paper, section "Co-Visibility-Based and
// Geometric Outlier Filtering").
enum class OutlierFilter {
  kVoting4d,  // Votes over (x, y, z, yaw). Needs gravity.
  // Votes over (x, y, yaw), as in Zeisl, Sattler, Pollefeys, ICCV 2015. A cell covers all heights
  // that the camera may have. Needs gravity.
  kVoting3d,
  kOther,  // VotingOptions::other_filter.
};

struct VotingOptions;

// A filter that the engine does not know, for comparisons (lab/rivals). Returns candidates,
// best first.
using CandidateFilter = std::function<std::vector<PoseCandidate>(
    const std::vector<TileView>& tiles, const std::vector<Correspondence>& correspondences,
    const VotingOptions& options)>;

struct VotingOptions {
  // Voting needs gravity. Candidates of a query without gravity come from the best ranked keyframes
  // (see KeyframeCandidates).
  OutlierFilter filter = OutlierFilter::kVoting4d;
  CandidateFilter other_filter = {};  // For OutlierFilter::kOther only.
  double cell_xy_m = 2.0;             // Horizontal cell of the accumulator, meters.
  double cell_z_m = 2.0;              // Vertical cell, meters.
  double yaw_step_rad = 0.0523599;    // 3 degrees.
  int max_candidates = 8;             // Maxima or components passed to pose estimation.
  // Weighted number of distinct keypoints that a maximum needs, before candidates settle.
  double min_score = 3.0;
  // Landmarks farther from the camera than this do not vote, meters.
  double max_distance_m = 200.0;
  // The scale of a keypoint and the physical size of its match predict the distance. The true
  // distance is assumed to be within this factor of the prediction, up or down. SIFT repeats its
  // scale within about 1.3; the rest allows for slanted views and merged observations. 0 disables
  // the test.
  double max_distance_factor = 2.5;
  // The camera sees a landmark from within this angle of the azimuth from which the map saw it,
  // radians; pi disables the test. SIFT rarely matches beyond 50 degrees.
  double max_azimuth_difference_rad = 1.309;
  // A correspondence agrees with a candidate if its ray points to the landmark within this angle,
  // plus the angle that one horizontal cell subtends at the landmark. Radians; about half a yaw
  // step plus twice the error of gravity.
  double direction_tolerance_rad = 0.06;

  // Throws Error(kInvalidArgument), naming the field.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_VOTING_VOTING_OPTIONS_H_
