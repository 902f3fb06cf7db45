// Early rejection of poses (Matas, Chum, "Randomized RANSAC with sequential probability ratio
// test", ICCV 2005).
#ifndef CAIRN_ENGINE_POSE_SEQUENTIAL_TEST_H_
#define CAIRN_ENGINE_POSE_SEQUENTIAL_TEST_H_

namespace cairn {

// Wald's test of "the pose is as good as the best so far" against "the pose is bad". It uses the
// mean gain of the observations seen so far, in random order. Gains lie in [0, 1] and count as
// fractions of an inlier. Wald's bound still holds: by convexity, the likelihood ratio of a
// fraction is at most that of an inlier with this probability. Gains carry more information than
// inlier counts: within the threshold, a random match gains one half on average, a right match
// nearly 1. Not thread-safe.
class SequentialTest {
 public:
  // At most the share `max_loss` in (0, 1) of the good poses is rejected.
  explicit SequentialTest(double max_loss);

  // Sets the mean gain of a good pose from now on. Nothing is rejected unless it lies between
  // bad_gain() and 1.
  void SetGoodGain(double mean_gain);
  // Adds the mean gain of a rejected pose to the running mean of bad poses, which starts at 0.01.
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
  double used_bad_gain_ = 0.01;  // The bad gain from which the logarithms were computed.
  double log_if_inlier_ = 0.0;
  double log_if_outlier_ = 0.0;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_SEQUENTIAL_TEST_H_
