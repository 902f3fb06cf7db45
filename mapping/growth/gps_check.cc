#include "mapping/growth/gps_check.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/geodesy.h"
#include "core/statistics.h"

namespace cairn {
namespace {

struct CenterPair {
  Eigen::Vector3d in_world;
  Eigen::Vector3d in_ecef;
  double accuracy_m = 0.0;
};

Sim3d FitSimilarity(const std::vector<CenterPair>& pairs) {
  Eigen::Matrix3Xd world(3, pairs.size()), ecef(3, pairs.size());
  for (size_t i = 0; i < pairs.size(); ++i) {
    world.col(i) = pairs[i].in_world;
    ecef.col(i) = pairs[i].in_ecef;
  }
  const Eigen::Matrix4d fit = Eigen::umeyama(world, ecef, true);
  Sim3d similarity;
  similarity.scale = std::cbrt(fit.topLeftCorner<3, 3>().determinant());
  similarity.rotation =
      Eigen::Quaterniond(Eigen::Matrix3d(fit.topLeftCorner<3, 3>() / similarity.scale));
  similarity.translation = fit.topRightCorner<3, 1>();
  return similarity;
}

// Leaves out what is farther off than three times the median.
std::vector<CenterPair> WithoutOutliers(const std::vector<CenterPair>& pairs, const Sim3d& fit) {
  std::vector<double> errors;
  for (const CenterPair& pair : pairs) {
    errors.push_back((fit * pair.in_world - pair.in_ecef).norm());
  }
  const double limit = 3.0 * Median(errors);
  std::vector<CenterPair> kept;
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (errors[i] <= limit) {
      kept.push_back(pairs[i]);
    }
  }
  return kept;
}

}  // namespace

GpsCheck::GpsCheck(const PhotoSet& set, const Draft& draft, double default_accuracy_m)
    : set_(set), default_accuracy_m_(default_accuracy_m) {
  std::vector<CenterPair> pairs;
  for (const int photo : draft.photos()) {
    const MappingPhoto& source = set.photos[photo];
    if (source.gps && source.gps_has_height) {
      pairs.push_back({draft.PoseOf(photo).Inverse().translation, EcefFromGeodetic(*source.gps),
                       source.gps_accuracy_m.value_or(default_accuracy_m)});
    }
  }
  if (static_cast<int>(pairs.size()) < kMinPositions) {
    return;
  }
  const std::vector<CenterPair> kept = WithoutOutliers(pairs, FitSimilarity(pairs));
  if (static_cast<int>(kept.size()) < kMinPositions) {
    return;
  }
  for (const CenterPair& pair : kept) {
    middle_in_ecef_ += pair.in_ecef / static_cast<double>(kept.size());
  }
  const Sim3d fit = FitSimilarity(kept);
  std::vector<double> accuracies_m;
  for (const CenterPair& pair : kept) {
    accuracies_m.push_back(pair.accuracy_m);
    spread_m_ += (pair.in_ecef - middle_in_ecef_).squaredNorm() / static_cast<double>(kept.size());
    fit_sigma_m_ +=
        (fit * pair.in_world - pair.in_ecef).squaredNorm() / static_cast<double>(kept.size());
  }
  spread_m_ = std::sqrt(spread_m_);
  fit_sigma_m_ = std::sqrt(fit_sigma_m_);
  if (spread_m_ >= 2.0 * Median(accuracies_m) && fit.scale > 0.0) {
    ecef_from_world_ = fit;
  }
}

bool GpsCheck::Contradicts(int photo, const Rigid3d& cam_from_world) const {
  const MappingPhoto& source = set_.photos[photo];
  if (!ecef_from_world_ || !source.gps || !source.gps_has_height) {
    return false;
  }
  const double accuracy_m = source.gps_accuracy_m.value_or(default_accuracy_m_);
  const Eigen::Vector3d in_ecef = *ecef_from_world_ * cam_from_world.Inverse().translation;
  // A line of photos does not determine its turn about itself; positions along it determine the
  // rest within the error of one over the spread.
  const double reach = 1.0 + (in_ecef - middle_in_ecef_).norm() / spread_m_;
  const double sigma_m = std::hypot(accuracy_m, reach * std::max(fit_sigma_m_, accuracy_m));
  return (in_ecef - EcefFromGeodetic(*source.gps)).norm() > 3.0 * sigma_m;
}

}  // namespace cairn
