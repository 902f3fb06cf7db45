#include "mapping/growth/consistent_point.h"

#include <cmath>
#include <utility>

namespace cairn {
namespace {

// Observations with larger errors do not belong to a landmark; as in the adjustment.
constexpr double kMaxErrorSigmas = 4.0;
// Pairs of a track's photos from which a landmark is tried if not all its observations agree.
constexpr int kMaxTriedPairs = 10;

double SqErrorSigmas(const PointObservation& observation, const Eigen::Vector3d& x_in_world) {
  const auto pixel = observation.camera->Project(observation.cam_from_world * x_in_world);
  return pixel ? (*pixel - observation.pixel).squaredNorm() /
                     (observation.sigma_px * observation.sigma_px)
               : 1e12;
}

std::vector<int> AgreeingObservations(const std::vector<PointObservation>& observations,
                                      const Eigen::Vector3d& x_in_world) {
  std::vector<int> agreeing;
  for (int i = 0; i < static_cast<int>(observations.size()); ++i) {
    if (SqErrorSigmas(observations[i], x_in_world) <= kMaxErrorSigmas * kMaxErrorSigmas) {
      agreeing.push_back(i);
    }
  }
  return agreeing;
}

std::vector<PointObservation> Selected(const std::vector<PointObservation>& observations,
                                       const std::vector<int>& which) {
  std::vector<PointObservation> selected;
  for (const int i : which) {
    selected.push_back(observations[i]);
  }
  return selected;
}

bool HasParallax(const std::vector<PointObservation>& observations,
                 const Eigen::Vector3d& x_in_world) {
  std::vector<Eigen::Vector3d> rays;
  std::vector<double> sigmas_rad;
  for (const PointObservation& observation : observations) {
    rays.push_back((observation.cam_from_world.Inverse().translation - x_in_world).normalized());
    sigmas_rad.push_back(observation.sigma_px / observation.camera->focal_px());
  }
  for (size_t i = 0; i < rays.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const double sigma_rad = std::hypot(sigmas_rad[i], sigmas_rad[j]);
      if (rays[i].cross(rays[j]).norm() > kMinRayAngleSigmas * sigma_rad) {
        return true;
      }
    }
  }
  return false;
}

// The observations that agree on the best point that all observations, or a pair of them, give.
std::vector<int> ConsistentObservations(const std::vector<PointObservation>& observations) {
  std::vector<int> best;
  const auto try_observations = [&](const std::vector<PointObservation>& chosen) {
    if (const auto x_in_world = TriangulatePoint(chosen)) {
      std::vector<int> agreeing = AgreeingObservations(observations, *x_in_world);
      if (agreeing.size() > best.size()) {
        best = std::move(agreeing);
      }
    }
  };
  try_observations(observations);
  const int count = static_cast<int>(observations.size());
  int num_tried = 0;
  for (int gap = count - 1; gap >= 1; --gap) {
    for (int i = 0; i + gap < count; ++i) {
      if (count < 3 || 2 * static_cast<int>(best.size()) > count || num_tried == kMaxTriedPairs) {
        return best;
      }
      try_observations({observations[i], observations[i + gap]});
      ++num_tried;
    }
  }
  return best;
}

}  // namespace

std::optional<ConsistentPoint> TriangulateConsistent(
    const std::vector<PointObservation>& observations,
    const std::optional<Eigen::Vector3d>& guess) {
  std::vector<int> agreeing;
  if (guess) {
    agreeing = AgreeingObservations(observations, *guess);
  }
  if (agreeing.size() < 2) {
    agreeing = ConsistentObservations(observations);
  }
  if (agreeing.size() < 2) {
    return std::nullopt;
  }
  const std::vector<PointObservation> chosen = Selected(observations, agreeing);
  const auto x_in_world = TriangulatePoint(chosen);
  if (!x_in_world || AgreeingObservations(chosen, *x_in_world).size() < chosen.size() ||
      !HasParallax(chosen, *x_in_world)) {
    return std::nullopt;
  }
  return ConsistentPoint{*x_in_world, std::move(agreeing)};
}

}  // namespace cairn
