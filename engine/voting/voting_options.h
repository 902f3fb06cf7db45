// Options of the voting stage.
#ifndef CAIRN_ENGINE_VOTING_VOTING_OPTIONS_H_
#define CAIRN_ENGINE_VOTING_VOTING_OPTIONS_H_

#include <functional>
#include <vector>

namespace cairn {

struct Correspondence;
struct PoseCandidate;
struct StageCounters;
struct TileView;

// What thins out the matches before poses are estimated (paper, section "Co-Visibility-Based and
// Geometric Outlier Filtering").
enum class OutlierFilter {
  kVoting4d,  // Votes over (x, y, z, yaw). Needs gravity.
  // Votes over (x, y, yaw), as Zeisl, Sattler, Pollefeys, ICCV 2015: the cells reach through all
  // heights that the camera may have. Needs gravity.
  kVoting3d,
  kOther,  // VotingOptions::other_filter.
};

struct VotingOptions;

// A filter that the engine does not know: what a comparison brings along (lab/rivals/voting). Gives
// candidates, best first, and sets the counters of voting.
using CandidateFilter = std::function<std::vector<PoseCandidate>(
    const std::vector<TileView>& tiles, const std::vector<Correspondence>& correspondences,
    const VotingOptions& options, StageCounters* counters)>;

struct VotingOptions {
  // A query without gravity cannot be voted for; candidates then come from the best ranked
  // keyframes (see KeyframeCandidates).
  OutlierFilter filter = OutlierFilter::kVoting4d;
  CandidateFilter other_filter = {};  // Of OutlierFilter::kOther only.
  double cell_xy_m = 2.0;           // Horizontal cell of the accumulator, metres.
  double cell_z_m = 2.0;            // Vertical cell, metres.
  double yaw_step_rad = 0.0523599;  // 3 degrees.
  int max_candidates = 8;           // Maxima or components handed to pose estimation.
  // Weighted distinct keypoints that one of them needs; of voting, before candidates settle.
  double min_score = 3.0;
  // Landmarks farther from the camera than this do not vote, metres.
  double max_distance_m = 200.0;
  // The scale of a keypoint and the physical size of its match predict the distance; true distances
  // are taken to lie within this factor of it, up or down. SIFT repeats its scale within about 1.3;
  // the rest is for slanted views and merged observations. 0 switches the test off.
  double max_distance_factor = 2.5;
  // The camera sees a landmark from within this angle of the azimuth from which the map saw it,
  // radians; pi switches the test off. SIFT hardly matches beyond 50 degrees.
  double max_azimuth_difference_rad = 1.309;
  // A correspondence agrees with a candidate if its ray points to the landmark within this angle,
  // plus the angle that one horizontal cell subtends at the landmark. Radians; about half a yaw
  // step and twice the error of gravity.
  double direction_tolerance_rad = 0.06;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_VOTING_VOTING_OPTIONS_H_
