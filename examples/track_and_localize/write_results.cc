#include "write_results.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <string>

#include "core/file_bytes.h"

namespace cairn {
namespace {

// Returns three columns, each after a comma. The columns are empty if there is no position.
std::string Columns(bool is_there, const Eigen::Vector3d& x) {
  return is_there ? fmt::format(",{:.4f},{:.4f},{:.4f}", x.x(), x.y(), x.z()) : ",,,";
}

std::string Csv(const std::vector<TrackPoint>& points) {
  std::string text =
      "time_s,truth_e,truth_n,truth_u,local_e,local_n,local_u,fused_e,fused_n,fused_u,"
      "local_error_m,fused_error_m,shown_e,shown_n,shown_u\n";
  for (const TrackPoint& point : points) {
    text += fmt::format("{:.3f}", point.time_s);
    text += Columns(true, point.truth) + Columns(true, point.local);
    text += Columns(point.is_fused, point.fused);
    text += fmt::format(",{:.4f}", (point.local - point.truth).norm());
    text += point.is_fused ? fmt::format(",{:.4f}", (point.fused - point.truth).norm()) : ",";
    text += Columns(point.is_fused, point.shown) + "\n";
  }
  return text;
}

constexpr char kScript[] = R"(set datafile separator ","
set terminal pngcairo size 1200,900
set output "trajectory.png"
set multiplot layout 2,1
set key top left
set grid
set size ratio -1
set title "Seen from above"
set xlabel "east [m]"
set ylabel "north [m]"
plot "trajectory.csv" every ::1 using 2:3 with lines lw 3 lc rgb "gray" title "truth", \
     "" every ::1 using 5:6 with lines lw 2 lc rgb "red" title "tracked alone", \
     "" every ::1 using 13:14 with lines lw 2 lc rgb "blue" title "fused with the map, as shown"
set size noratio
set title "Distance to the truth"
set xlabel "time [s]"
set ylabel "error [m]"
plot "trajectory.csv" every ::1 using 1:11 with lines lw 2 lc rgb "red" title "tracked alone", \
     "" every ::1 using 1:12 with lines lw 2 lc rgb "blue" title "fused with the map"
unset multiplot
)";

}  // namespace

bool WriteResults(const std::filesystem::path& dir, const std::vector<TrackPoint>& points) {
  WriteTextFile((dir / "trajectory.csv").string(), Csv(points));
  WriteTextFile((dir / "trajectory.gnuplot").string(), kScript);
  const std::string command =
      "cd '" + dir.string() + "' && gnuplot trajectory.gnuplot > /dev/null 2>&1";
  return std::system(command.c_str()) == 0;
}

TrackErrors ErrorsOf(const std::vector<TrackPoint>& points) {
  TrackErrors errors;
  double sq_local = 0.0, sq_fused = 0.0, sq_shown = 0.0;
  double sq_fused_change = 0.0, sq_shown_change = 0.0;
  int num_changes = 0;
  const TrackPoint* last = nullptr;
  for (const TrackPoint& point : points) {
    if (!point.is_fused) {
      last = nullptr;
      continue;
    }
    sq_local += (point.local - point.truth).squaredNorm();
    sq_fused += (point.fused - point.truth).squaredNorm();
    sq_shown += (point.shown - point.truth).squaredNorm();
    errors.local_final_m = (point.local - point.truth).norm();
    errors.fused_final_m = (point.fused - point.truth).norm();
    ++errors.num_fused;
    if (last != nullptr) {
      const Eigen::Vector3d moved = point.truth - last->truth;
      sq_fused_change += (point.fused - last->fused - moved).squaredNorm();
      sq_shown_change += (point.shown - last->shown - moved).squaredNorm();
      ++num_changes;
    }
    last = &point;
  }
  if (errors.num_fused > 0) {
    errors.local_rmse_m = std::sqrt(sq_local / errors.num_fused);
    errors.fused_rmse_m = std::sqrt(sq_fused / errors.num_fused);
    errors.shown_rmse_m = std::sqrt(sq_shown / errors.num_fused);
  }
  if (num_changes > 0) {
    errors.fused_change_m = std::sqrt(sq_fused_change / num_changes);
    errors.shown_change_m = std::sqrt(sq_shown_change / num_changes);
  }
  return errors;
}

}  // namespace cairn
