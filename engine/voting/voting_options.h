// Options of the voting stage.
#ifndef CAIRN_ENGINE_VOTING_VOTING_OPTIONS_H_
#define CAIRN_ENGINE_VOTING_VOTING_OPTIONS_H_

namespace cairn {

struct VotingOptions {
  double cell_xy_m = 2.0;          // Horizontal cell of the accumulator, metres.
  double cell_z_m = 2.0;           // Vertical cell, metres.
  double yaw_step_rad = 0.0523599; // 3 degrees.
  int max_candidates = 8;          // Maxima handed to pose estimation.
  double min_score = 3.0;          // Weighted distinct keypoints a maximum needs.
  // Landmarks farther from the camera than this do not vote, metres.
  double max_distance_m = 200.0;

  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_VOTING_VOTING_OPTIONS_H_
