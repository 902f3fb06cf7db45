#include "fusion/tracks/rotation_only.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/statistics.h"
#include "fusion/filter/camera_view.h"
#include "fusion/filter/chi_square.h"

namespace cairn::fusion {

std::optional<double> MedianParallaxPx(const FilterState& state, const Camera& camera,
                                       const TrackTable& tracks, int from, int to) {
  constexpr size_t kMinTracks = 15;
  const Clone& old_clone = state.clones()[static_cast<size_t>(from)];
  const Clone& new_clone = state.clones()[static_cast<size_t>(to)];
  const CameraView old_view(state.rig(), old_clone);
  const CameraView new_view(state.rig(), new_clone);
  const Eigen::Matrix3d new_from_old =
      new_view.cam_from_local_rotation * old_view.cam_from_local_rotation.transpose();
  std::vector<double> parallaxes_px;
  for (const Track& track : tracks.tracks()) {
    const Observation* before = nullptr;
    const Observation* after = nullptr;
    for (const Observation& observation : track.observations) {
      before = observation.frame_id == old_clone.frame_id ? &observation : before;
      after = observation.frame_id == new_clone.frame_id ? &observation : after;
    }
    const auto turned = before != nullptr && after != nullptr
                            ? camera.Project(new_from_old * before->ray_in_cam)
                            : std::nullopt;
    if (turned) {
      parallaxes_px.push_back((after->pixel - *turned).norm());
    }
  }
  if (parallaxes_px.size() < kMinTracks) {
    return std::nullopt;
  }
  return Median(std::move(parallaxes_px));
}

std::optional<Measurement> RotationOnlyMeasurement(const FilterState& state, const Camera& camera,
                                                   double parallax_px, int from, int to) {
  // Half of the visible points are within this distance. This is a bound, not an estimate.
  constexpr double kMedianDistanceM = 20.0;
  const double sigma_m = kMedianDistanceM * parallax_px / camera.focal_px();
  const int a = state.CloneIdx(from) + 3;
  const int b = state.CloneIdx(to) + 3;
  const auto covariance = state.covariance();
  const Eigen::Matrix3d way_covariance =
      covariance.block<3, 3>(a, a) + covariance.block<3, 3>(b, b) - covariance.block<3, 3>(a, b) -
      covariance.block<3, 3>(b, a);
  if (way_covariance.trace() < 3.0 * sigma_m * sigma_m) {
    return std::nullopt;
  }
  Measurement measurement;
  measurement.blocks = {{a, 3}, {b, 3}};
  measurement.jacobian.resize(3, 6);
  measurement.jacobian << -Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity();
  measurement.jacobian /= sigma_m;
  measurement.residual = (state.clones()[static_cast<size_t>(from)].local_from_imu.translation -
                          state.clones()[static_cast<size_t>(to)].local_from_imu.translation) /
                         sigma_m;
  return measurement;
}

bool RotationOnlyUpdates::Update(const TrackTable& tracks, FilterState* state) {
  constexpr double kGateQuantile = 3.09;  // Passes 99.9 %.
  const auto& clones = state->clones();
  const auto begin = std::find_if(clones.begin(), clones.end(), [this](const Clone& clone) {
    return clone.timestamp_ns >= last_update_ns_;
  });
  const int from = static_cast<int>(begin - clones.begin());
  const int to = static_cast<int>(clones.size()) - 1;
  if (2 * (to - from) < max_clones_) {
    return false;
  }
  const auto parallax_px = MedianParallaxPx(*state, camera_, tracks, from, to);
  const auto measurement =
      parallax_px ? RotationOnlyMeasurement(*state, camera_, *parallax_px, from, to) : std::nullopt;
  if (!measurement ||
      !(state->SquaredMahalanobis(*measurement) < ChiSquareQuantile(3, kGateQuantile))) {
    return false;
  }
  state->Update(*measurement);
  last_update_ns_ = clones.back().timestamp_ns;
  return true;
}

}  // namespace cairn::fusion
