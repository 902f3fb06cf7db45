#include "lab/rivals/fusion/bundle_adjuster.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lab/rivals/fusion/marginalize_camera.h"

namespace cairn::fusion {
namespace {

const BundleAdjusterOptions& Validated(const BundleAdjusterOptions& options) {
  options.Validate();
  return options;
}

}  // namespace

BundleAdjuster::BundleAdjuster(const BundleAdjusterOptions& options, const ImuState& state,
                               const Matrix15d& covariance, const AdjusterFrame& first)
    : options_(Validated(options)), tracks_(options.camera, options.rig), problem_(options_) {
  auto camera = std::make_unique<WindowCamera>(
      state, Preintegration(options_.imu_noise, state.gyro_bias, state.accel_bias));
  camera->frame_id = first.frame_id;
  camera->timestamp_ns = first.timestamp_ns;
  camera->is_keyframe = true;
  tracks_.AddFeatures(camera.get(), first.features);
  Matrix15d known = covariance;
  known.diagonal().segment<3>(kThetaIdx).array() +=
      options_.gauge_sigma_rad * options_.gauge_sigma_rad;
  known.diagonal().segment<3>(kPositionIdx).array() +=
      options_.gauge_sigma_m * options_.gauge_sigma_m;
  prior_ = PriorFromCovariance(camera.get(), known);
  cameras_.push_back(std::move(camera));
}

void BundleAdjuster::AddFrame(const AdjusterFrame& frame) {
  ImuState state = cameras_.back()->State();
  Preintegration since_previous(options_.imu_noise, state.gyro_bias, state.accel_bias);
  if (!cameras_.back()->is_keyframe) {
    since_previous = cameras_.back()->since_previous;
  }
  since_previous.Append(frame.steps_since_previous);
  for (const ImuStep& step : frame.steps_since_previous) {
    state = IntegrateImu(state, step, options_.gravity_m_s2);
  }
  if (!cameras_.back()->is_keyframe) {
    tracks_.DropCamera(cameras_.back().get());
    cameras_.pop_back();
  }
  auto camera = std::make_unique<WindowCamera>(state, since_previous);
  camera->frame_id = frame.frame_id;
  camera->timestamp_ns = frame.timestamp_ns;
  camera->is_keyframe = frame.is_keyframe;
  camera->imu_sqrt_information = since_previous.SqrtInformation();
  tracks_.AddFeatures(camera.get(), frame.features);
  cameras_.push_back(std::move(camera));
}

void BundleAdjuster::SetGlobalFromLocal(const Rigid3d& global_from_local) {
  if (!alignment_) {
    alignment_.emplace();
  }
  alignment_->Set(global_from_local, state().local_from_imu.translation);
}

std::optional<Rigid3d> BundleAdjuster::global_from_local() const {
  return alignment_ ? std::optional(alignment_->GlobalFromLocal()) : std::nullopt;
}

std::vector<int64_t> BundleAdjuster::frame_ids() const {
  std::vector<int64_t> ids;
  for (const Camera& camera : cameras_) {
    ids.push_back(camera->frame_id);
  }
  return ids;
}

WindowCamera* BundleAdjuster::FindCamera(int64_t frame_id) const {
  for (const Camera& camera : cameras_) {
    if (camera->frame_id == frame_id) {
      return camera.get();
    }
  }
  return nullptr;
}

std::optional<Rigid3d> BundleAdjuster::PoseOf(int64_t frame_id) const {
  const WindowCamera* camera = FindCamera(frame_id);
  return camera == nullptr ? std::nullopt : std::optional(camera->State().local_from_imu);
}

int BundleAdjuster::AddMatches(int64_t frame_id, std::span<const MapMatch> matches) {
  WindowCamera* camera = FindCamera(frame_id);
  if (camera == nullptr || !alignment_) {
    return 0;
  }
  const Rigid3d cam_from_global = options_.rig.cam_from_imu *
                                  camera->State().local_from_imu.Inverse() *
                                  alignment_->GlobalFromLocal().Inverse();
  int num_passed = 0;
  for (const MapMatch& match : matches) {
    const Eigen::Vector3d x_in_cam = cam_from_global * match.x_in_global;
    const auto pixel = options_.camera.Project(x_in_cam);
    if (!pixel || x_in_cam.z() < options_.triangulate.min_depth_m ||
        (*pixel - match.pixel).norm() > options_.match_gate_px) {
      continue;
    }
    const uint64_t track_id = match.track_id ? *match.track_id : next_untracked_id_++;
    if (!match.track_id) {
      tracks_.AddFeatures(camera, {{{track_id, match.pixel}}});
    }
    if (WindowTrack* track = tracks_.Find(track_id)) {
      track->map_landmark = {match.x_in_global, match.sigma_m};
      ++num_passed;
    }
  }
  return num_passed;
}

size_t BundleAdjuster::FurthestFromNewest() const {
  const Eigen::Vector3d newest = state().local_from_imu.translation;
  const auto distance = [&](const Camera& camera) {
    return (camera->State().local_from_imu.translation - newest).norm();
  };
  // The furthest of the other cameras; the first if several are equally far.
  const auto furthest =
      std::max_element(cameras_.begin(), cameras_.end() - 1,
                       [&](const Camera& a, const Camera& b) { return distance(a) < distance(b); });
  return static_cast<size_t>(furthest - cameras_.begin());
}

// Removes a camera. Its successor takes over the motion since the camera before.
void BundleAdjuster::RemoveCamera(size_t idx) {
  tracks_.DropCamera(cameras_[idx].get());
  if (idx > 0) {
    WindowCamera& next = *cameras_[idx + 1];
    Preintegration merged = cameras_[idx]->since_previous;
    merged.Append(next.since_previous.steps());
    next.since_previous = std::move(merged);
    next.imu_sqrt_information = next.since_previous.SqrtInformation();
  }
  cameras_.erase(cameras_.begin() + static_cast<std::ptrdiff_t>(idx));
}

void BundleAdjuster::MarginalizeOldest() {
  std::vector<WindowCamera*> cameras;
  for (const Camera& camera : cameras_) {
    cameras.push_back(camera.get());
  }
  prior_ =
      MarginalizeCamera(options_, cameras, alignment_ ? &*alignment_ : nullptr, prior_, &tracks_);
  RemoveCamera(0);
}

void BundleAdjuster::DiscardOne() {
  if (options_.discard == DiscardPolicy::kMarginalize) {
    MarginalizeOldest();
    return;
  }
  const size_t idx = FurthestFromNewest();
  if (idx == 0) {
    prior_.reset();
  }
  RemoveCamera(idx);
}

std::vector<WindowTrack*> BundleAdjuster::SelectTracks() {
  std::vector<WindowTrack*> global;
  std::vector<WindowTrack*> local;
  tracks_.ForEach([&](WindowTrack* track) {
    if (track->map_landmark) {
      if (alignment_) {
        global.push_back(track);
      }
    } else if (static_cast<int>(track->observations.size()) >= options_.min_views) {
      local.push_back(track);
    }
  });
  std::stable_sort(local.begin(), local.end(), [](const WindowTrack* a, const WindowTrack* b) {
    return a->observations.size() > b->observations.size();
  });
  const auto num_wanted = static_cast<size_t>(options_.max_local_tracks);
  size_t num_chosen = 0;
  for (WindowTrack* track : local) {
    if (num_chosen == num_wanted) {
      break;
    }
    if (track->is_triangulated ||
        tracks_.TriangulateTrack(options_.track_sigma_px, options_.triangulate, track)) {
      global.push_back(track);
      ++num_chosen;
    }
  }
  return global;
}

void BundleAdjuster::RefreshPreintegration() {
  for (size_t i = 1; i < cameras_.size(); ++i) {
    const ImuState from = cameras_[i - 1]->State();
    Preintegration& motion = cameras_[i]->since_previous;
    const ImuState& at = motion.delta();
    if ((from.gyro_bias - at.gyro_bias).norm() > options_.max_gyro_bias_change_rad_s ||
        (from.accel_bias - at.accel_bias).norm() > options_.max_accel_bias_change_m_s2) {
      motion.Reintegrate(from.gyro_bias, from.accel_bias);
      cameras_[i]->imu_sqrt_information = motion.SqrtInformation();
    }
  }
}

// After an optimization, drops outliers and points that left the view of a camera.
void BundleAdjuster::DropBadLandmarks(std::span<WindowTrack* const> tracks) {
  const double sq_limit = std::pow(
      options_.track_gate_sigmas * options_.track_sigma_px / options_.camera.focal_px(), 2);
  for (WindowTrack* track : tracks) {
    if (track->map_landmark) {
      continue;
    }
    double sq_sum = 0.0;
    bool is_in_front = true;
    for (const WindowObservation& observation : track->observations) {
      const Eigen::Vector3d x_in_cam = observation.camera->ToCam(track->x_in_local);
      is_in_front = is_in_front && x_in_cam.z() > options_.triangulate.min_depth_m;
      sq_sum += (x_in_cam.hnormalized() - observation.normalized).squaredNorm();
    }
    if (!is_in_front || sq_sum > 2.0 * sq_limit * static_cast<double>(track->observations.size())) {
      tracks_.Forget(track);
    }
  }
}

AdjustmentSummary BundleAdjuster::Optimize() {
  while (num_cameras() > options_.num_cameras) {
    DiscardOne();
  }
  if (cameras_.size() < 2) {
    return {};
  }
  RefreshPreintegration();
  std::vector<WindowCamera*> cameras;
  for (const Camera& camera : cameras_) {
    camera->Rebase();
    camera->Prepare(options_.rig);
    cameras.push_back(camera.get());
  }
  if (alignment_) {
    SetGlobalFromLocal(alignment_->GlobalFromLocal());
    alignment_->Prepare();
  }
  const std::vector<WindowTrack*> tracks = SelectTracks();
  const AdjustmentSummary summary = problem_.Solve(cameras, alignment_ ? &*alignment_ : nullptr,
                                                   tracks, prior_ ? &*prior_ : nullptr);
  for (WindowCamera* camera : cameras) {
    camera->Prepare(options_.rig);
  }
  DropBadLandmarks(tracks);
  return summary;
}

}  // namespace cairn::fusion
