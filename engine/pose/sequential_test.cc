#include "engine/pose/sequential_test.h"

#include <cmath>

namespace cairn {

SequentialTest::SequentialTest(double max_loss) : log_threshold_(-std::log(max_loss)) {}

void SequentialTest::SetGoodGain(double mean_gain) {
  if (mean_gain != good_gain_) {
    good_gain_ = mean_gain;
    Update();
  }
}

void SequentialTest::LearnBadGain(double mean_gain) {
  constexpr double kMemory = 0.95;
  // Computing the two logarithms takes as long as scoring 64 observations.
  constexpr double kTolerance = 0.05;
  bad_gain_ = kMemory * bad_gain_ + (1.0 - kMemory) * mean_gain;
  if (std::abs(bad_gain_ - used_bad_gain_) > kTolerance * used_bad_gain_) {
    Update();
  }
}

void SequentialTest::Update() {
  used_bad_gain_ = bad_gain_;
  const bool is_active = good_gain_ > bad_gain_ && good_gain_ < 1.0 && bad_gain_ > 0.0;
  log_if_inlier_ = is_active ? std::log(bad_gain_ / good_gain_) : 0.0;
  log_if_outlier_ = is_active ? std::log((1.0 - bad_gain_) / (1.0 - good_gain_)) : 0.0;
}

}  // namespace cairn
