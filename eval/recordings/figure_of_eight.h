// A walk along a figure of eight, with exact derivatives.
#ifndef CAIRN_EVAL_RECORDINGS_FIGURE_OF_EIGHT_H_
#define CAIRN_EVAL_RECORDINGS_FIGURE_OF_EIGHT_H_

#include <cstdint>
#include <vector>

#include "eval/recordings/motion.h"

namespace cairn::fusion {

struct FigureOfEightOptions {
  uint64_t seed = 1;  // Seed of the path's shape and the gait's phases.
  double size_m =
      22.0;  // Half the length of the figure of eight; the path is some 6 times as long.
  double speed_m_s = 1.3;
  double gait_m = 0.025;         // Amplitude of the steps' bobbing at 1.8 Hz.
  double look_around_rad = 0.4;  // Amplitude of the slow turns of the head.
  // Times at which the walker starts (first, third, ...) and stops (second, ...) walking. Each
  // change takes one second. Empty: the walker never stops.
  std::vector<double> start_stop_s;
};

// A person walks along a figure of eight, looks around, and bobs with each step. The IMU's x axis
// points ahead, its z axis up. Immutable.
class FigureOfEight {
 public:
  explicit FigureOfEight(const FigureOfEightOptions& options);

  MotionState At(double time_s) const;

 private:
  struct PathTime {
    double tau, rate, acceleration;  // Time along the path and its derivatives.
  };
  PathTime Warp(double time_s) const;

  FigureOfEightOptions options_;
  double omega_;
  double phases_[6];
  double width_ratio_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_EVAL_RECORDINGS_FIGURE_OF_EIGHT_H_
