// Which focal lengths are tried for a camera that nobody calibrated, and what the answer makes of
// the focal length that was stated.
#ifndef CAIRN_ENGINE_FOCAL_FOCAL_SEARCH_H_
#define CAIRN_ENGINE_FOCAL_FOCAL_SEARCH_H_

#include <optional>
#include <vector>

#include "engine/pose/least_squares/refine_camera.h"
#include "engine/query/localize_query.h"
#include "engine/query/localize_result.h"

namespace cairn {

// A focal length of which nothing is said is taken to be right within this, relative.
inline constexpr double kAssumedFocalLogSigma = 0.01;
// Poses are found with a focal length that is at most so far off, relative; where it may be further
// off, others are tried.
inline constexpr double kMaxTrustedFocalLogSigma = 0.03;

// What a query says of its camera, which is not of a rig.
CameraPrior CameraPriorOf(const LocalizeQuery& query);

// Which focal lengths to try: factors of the prior's, three standard deviations to either side,
// near enough to each other for RefineWithCamera to reach what lies between.
//
// Likeliest first until one leads to a good score; then its neighbours, since a wrong focal length
// may have a fair score as well, and so on until the best one's neighbours are both worse.
class FocalSearch {
 public:
  FocalSearch(const FocalPrior& prior, double good_score);

  // The next factor to try; nothing if there is none, or no need.
  std::optional<double> Next();
  // Of the factor that Next() gave last.
  void Report(double score);

 private:
  std::vector<double> factors_;                // Ascending.
  std::vector<std::optional<double>> scores_;  // Parallel.
  double good_score_;
  int current_ = 0;
};

CameraEstimate MakeCameraEstimate(const CameraPrior& prior, const RefinedCamera& refined);

}  // namespace cairn

#endif  // CAIRN_ENGINE_FOCAL_FOCAL_SEARCH_H_
