// Writes the trajectories of the example as a table, a plot and a few figures.
#ifndef CAIRN_EXAMPLES_TRACK_AND_LOCALIZE_WRITE_RESULTS_H_
#define CAIRN_EXAMPLES_TRACK_AND_LOCALIZE_WRITE_RESULTS_H_

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace cairn {

// Positions of the IMU at one frame, in enu at the origin of the street.
struct TrackPoint {
  double time_s = 0.0;
  Eigen::Vector3d truth = Eigen::Vector3d::Zero();
  Eigen::Vector3d local = Eigen::Vector3d::Zero();  // Tracked without the map from the true start.
  Eigen::Vector3d fused = Eigen::Vector3d::Zero();  // Tracked with the map; valid if is_fused.
  Eigen::Vector3d shown = Eigen::Vector3d::Zero();  // The steady pose; valid if is_fused.
  bool is_fused = false;
};

// Writes <dir>/trajectory.csv and <dir>/trajectory.gnuplot. If gnuplot is installed, also writes
// <dir>/trajectory.png. Returns true if the plot exists. Throws Error(kIo).
bool WriteResults(const std::filesystem::path& dir, const std::vector<TrackPoint>& points);

// Root mean square distance to the truth in meters, over the fused frames.
struct TrackErrors {
  double local_rmse_m = 0.0;
  double fused_rmse_m = 0.0;
  double local_final_m = 0.0;
  double fused_final_m = 0.0;
  double shown_rmse_m = 0.0;
  // Root mean square change of the error from frame to frame.
  double fused_change_m = 0.0;
  double shown_change_m = 0.0;
  int num_fused = 0;
};
TrackErrors ErrorsOf(const std::vector<TrackPoint>& points);

}  // namespace cairn

#endif  // CAIRN_EXAMPLES_TRACK_AND_LOCALIZE_WRITE_RESULTS_H_
