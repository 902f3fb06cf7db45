// Whether the positions of photos contradict a pose.
#ifndef CAIRN_MAPPING_GROWTH_GPS_CHECK_H_
#define CAIRN_MAPPING_GROWTH_GPS_CHECK_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/rigid3.h"
#include "mapping/growth/draft.h"
#include "mapping/photo_set.h"

namespace cairn {

// Where a draft is on Earth, by the positions of its photos. A facade that repeats puts photos at
// the wrong copy, and all photos that show it agree; their positions do not. Positions without a
// height do not count.
class GpsCheck {
 public:
  // What a photo is near to, of the pose of another and its position.
  enum class Nearer { kNeither, kPose, kPosition };

  // Fits a similarity to the positions of at least half of the photos. Checks nothing if the
  // positions do not determine one: fewer than kMinPositions, or a spread too small for their
  // errors. Deterministic by seed.
  GpsCheck(const PhotoSet& set, const Draft& draft, double default_accuracy_m, uint64_t seed);

  // True if the photo has a position with a height and the pose is farther from it, horizontally,
  // than 3.5 standard deviations of the position and of the fit there, plus the drift that a
  // draft may have. Positions along a line do not tell the fit's turn about it, so a pose beside
  // the line may be off by 3.5 standard deviations of that turn more.
  // `is_doubted`: two views of the photo contradict the pose, too; then 2.5 instead of 3.5.
  bool Contradicts(int photo, const Rigid3d& cam_from_world, bool is_doubted = false) const;

  // Whether the position of `witness` is at most half as far from the pose of `photo` as from the
  // position of `photo`, or the other way, horizontally. Neither if one of the photos has no
  // position or nothing is checked.
  Nearer NearerTo(int witness, int photo, const Rigid3d& cam_from_world) const;

  // The photos, in the order of the set, on the smaller side of the largest step in the errors of
  // the positions, if that step is more than chance and drift make: ascending, or none. One photo
  // after the other, walks have errors that are random or change slowly, and a copy of a facade
  // moves all photos from one on by the same vector, which may be too short for Contradicts(). None
  // unless KnowsPlace(): a wrong scale makes steps. Single positions that are far off do not count.
  std::vector<int> BeyondStep() const;

  // True if the positions determine where the draft is: its scale and turn to a quarter. To
  // contradict photos near the others, half is enough.
  bool KnowsPlace() const;

  // How many times what they state the positions err, about the fit to all of them or to most; at
  // least 1, also if nothing is checked.
  double noise_of_stated() const { return noise_of_stated_; }

  static constexpr int kMinPositions = 4;

 private:
  // How far the fit has a photo from its position.
  struct Miss {
    int photo = 0;
    Eigen::Vector2d error_m;
    Eigen::Vector2d in_enu;  // The position.
    double sigma_m = 0.0;    // Of the position, an axis.
  };

  // Those near the median of all: one position that is far off is no step.
  static std::vector<Miss> UsualOf(const std::vector<Miss>& misses, double noise_m);
  // The step from the mean of some misses to that of others, relative to what chance and drift
  // make.
  double StepShare(const std::vector<Miss>& before, const std::vector<Miss>& after,
                   double noise_m) const;
  // The noise an axis that photos in a row show, whatever steps there are between some of them.
  double NoiseOfRow() const;
  double SigmaOf(const MappingPhoto& photo) const;
  Eigen::Vector2d PositionInEnu(int photo) const;
  Eigen::Vector2d PoseInEnu(const Rigid3d& cam_from_world) const;
  // How far the fit may err at a point because it may turn about the line of its photos.
  double TurnErrorM(const Eigen::Vector3d& x_in_enu) const;

  const PhotoSet& set_;
  double default_accuracy_m_;
  std::optional<Sim3d> enu_from_world_;
  Rigid3d enu_from_ecef_;
  Eigen::Vector2d middle_in_enu_ = Eigen::Vector2d::Zero();
  // How many times the stated accuracy the positions err. Those that state none may do better than
  // the default.
  double noise_of_stated_ = 1.0, noise_of_unstated_ = 1.0;
  double fit_sigma_m_ = 0.0;  // Of the fit in the middle.
  double spread_m_ = 0.0;     // Root mean square distance of the positions from their middle.
  // The line that fits the fitted photos best, and their root mean square distance from it.
  Eigen::ParametrizedLine<double, 3> line_in_enu_{Eigen::Vector3d::Zero(),
                                                  Eigen::Vector3d::UnitX()};
  double across_m_ = 0.0;
  std::vector<Miss> misses_;  // Of the draft's photos that have a position, by photo.
};

}  // namespace cairn

#endif  // CAIRN_MAPPING_GROWTH_GPS_CHECK_H_
