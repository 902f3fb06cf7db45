// Early rejection of poses (sequential probability ratio test; Matas, Chum, "Randomized RANSAC with
// sequential probability ratio test", ICCV 2005).
#ifndef CAIRN_ENGINE_POSE_SAMPLING_SEQUENTIAL_TEST_H_
#define CAIRN_ENGINE_POSE_SAMPLING_SEQUENTIAL_TEST_H_

namespace cairn {

// Wald's test of "the pose is as good as the best so far" against "it is a bad one", by the mean
// gain of the observations seen so far, in random order. Gains lie in [0, 1]; counted as fractions
// of an inlier they keep Wald's bound, since by convexity the likelihood ratio of a fraction is at
// most that of an inlier with this probability. They tell more than counts of inliers: a random
// match within the threshold gains a half in the mean, a right one nearly 1. Not thread-safe.
class SequentialTest {
 public:
  // `max_loss` in (0, 1): at most so many of the good poses are rejected.
  explicit SequentialTest(double max_loss);

  // The mean gain of a good pose, from now on. Outside (bad gain, 1) nothing is rejected.
  void SetGoodGain(double mean_gain);
  // Takes the mean gain of a rejected pose into the running mean of the bad ones; starts at 0.01.
  void LearnBadGain(double mean_gain);

  bool Rejects(double num_tested, double sum_of_gains) const {
    return sum_of_gains * log_if_inlier_ + (num_tested - sum_of_gains) * log_if_outlier_ >
           log_threshold_;
  }

  double bad_gain() const { return bad_gain_; }

 private:
  void Update();

  double log_threshold_;
  double good_gain_ = 0.0;
  double bad_gain_ = 0.01;
  double used_bad_gain_ = 0.01;  // That the logarithms are of.
  double log_if_inlier_ = 0.0;
  double log_if_outlier_ = 0.0;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_SAMPLING_SEQUENTIAL_TEST_H_
