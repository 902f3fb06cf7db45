// Whether the positions of photos contradict a pose.
#ifndef CAIRN_MAPPING_GROWTH_GPS_CHECK_H_
#define CAIRN_MAPPING_GROWTH_GPS_CHECK_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/rigid3.h"
#include "mapping/growth/draft.h"
#include "mapping/photo_set.h"

namespace cairn {

// Where a draft is on Earth, by the positions of its photos. Positions without a height do not
// count.
class GpsCheck {
 public:
  // Fits a similarity to the positions, with outliers left out. Checks nothing if the positions do
  // not determine one: fewer than kMinPositions, or a spread of less than twice the median of their
  // accuracies.
  GpsCheck(const PhotoSet& set, const Draft& draft, double default_accuracy_m);

  // True if the photo has a position with a height and the pose is farther from it than three
  // standard deviations: of the position, of the fit, and of the fit's turn at this distance.
  bool Contradicts(int photo, const Rigid3d& cam_from_world) const;

  static constexpr int kMinPositions = 4;

 private:
  const PhotoSet& set_;
  double default_accuracy_m_;
  std::optional<Sim3d> ecef_from_world_;
  Eigen::Vector3d middle_in_ecef_ = Eigen::Vector3d::Zero();
  double fit_sigma_m_ = 0.0;  // Root mean square distance of the positions from the fit.
  double spread_m_ = 0.0;     // Root mean square distance of the positions from their middle.
};

}  // namespace cairn

#endif  // CAIRN_MAPPING_GROWTH_GPS_CHECK_H_
