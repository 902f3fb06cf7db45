#include "mapping/growth/draft.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/parallel_for.h"
#include "core/scene/triangulate.h"
#include "mapping/growth/camera_freedom.h"
#include "mapping/growth/consistent_point.h"

namespace cairn {
namespace {

// An adjusted focal length that leaves its prior by more standard deviations is not believed: along
// a straight walk, small biases of keypoints bend it.
constexpr double kMaxFocalSigmas = 2.0;

// False if the solver fails; the model is then what it was.
bool TryAdjust(const std::vector<CameraFreedom>& freedom, const AdjustPriors& priors,
               const AdjustOptions& options, Reconstruction* model,
               const AdjustProgress& progress = {}) {
  std::vector<Rigid3d> poses;
  for (const ReconImage& image : model->images) {
    poses.push_back(image.cam_from_world);
  }
  const std::vector<ReconLandmark> landmarks = model->landmarks;
  try {
    Adjust(freedom, priors, options, *model, progress);
    return true;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInternal) {
      throw;
    }
    for (size_t i = 0; i < poses.size(); ++i) {
      model->images[i].cam_from_world = poses[i];
    }
    model->landmarks = landmarks;
    return false;
  }
}

}  // namespace

TrackTable::TrackTable(const PhotoSet& set, std::span<const TwoView> views) {
  std::vector<PairMatches> pairs;
  for (const TwoView& view : views) {
    pairs.push_back({view.a, view.b, view.inliers});
  }
  std::vector<int> num_keypoints;
  for (const MappingPhoto& photo : set.photos) {
    num_keypoints.push_back(static_cast<int>(photo.keypoints.size()));
    track_of_keypoint.emplace_back(photo.keypoints.size(), -1);
  }
  tracks = BuildTracks(pairs, num_keypoints, 2);
  for (size_t track = 0; track < tracks.size(); ++track) {
    for (const ReconObservation& observation : tracks[track]) {
      track_of_keypoint[observation.image_idx][observation.keypoint_idx] = static_cast<int>(track);
    }
  }
}

Draft::Draft(const PhotoSet& set, const TrackTable& tracks, std::vector<Camera> cameras,
             int num_threads)
    : set_(set),
      tracks_(tracks),
      num_threads_(num_threads),
      image_of_photo_(set.photos.size(), -1),
      landmark_of_track_(tracks.tracks.size(), -1),
      is_held_(cameras.size(), 0) {
  model_.cameras = std::move(cameras);
}

Draft::Draft(const PhotoSet& set, const TrackTable& tracks, const Segment& segment, int num_threads)
    : Draft(set, tracks, segment.model.cameras, num_threads) {
  model_ = segment.model;
  photo_of_image_ = segment.photo_of_image;
  for (size_t i = 0; i < photo_of_image_.size(); ++i) {
    image_of_photo_[photo_of_image_[i]] = static_cast<int>(i);
  }
  IndexLandmarks();
}

bool Draft::IsNewCamera(int camera_idx) const {
  return std::none_of(model_.images.begin(), model_.images.end(),
                      [&](const ReconImage& image) { return image.camera_idx == camera_idx; });
}

std::vector<LandmarkObservation> Draft::ObservationsOf(int photo) const {
  const std::vector<Keypoint>& keypoints = set_.photos[photo].keypoints;
  std::vector<LandmarkObservation> observations;
  for (int i = 0; i < static_cast<int>(keypoints.size()); ++i) {
    const int track = tracks_.track_of_keypoint[photo][i];
    if (track >= 0 && landmark_of_track_[track] >= 0) {
      observations.push_back({i,
                              {keypoints[i].x_px, keypoints[i].y_px},
                              keypoints[i].scale_px,
                              model_.landmarks[landmark_of_track_[track]].x_in_world});
    }
  }
  return observations;
}

std::vector<int> Draft::CountObservations() const {
  std::vector<int> counts(image_of_photo_.size(), 0);
  for (const ReconLandmark& landmark : model_.landmarks) {
    for (const ReconObservation& observation : landmark.observations) {
      ++counts[photo_of_image_[observation.image_idx]];
    }
  }
  return counts;
}

void Draft::Add(int photo, const Rigid3d& cam_from_world) {
  const MappingPhoto& source = set_.photos[photo];
  ReconImage image;
  image.name = source.name;
  image.camera_idx = source.camera_idx;
  image.cam_from_world = cam_from_world;
  image.features.keypoints = source.keypoints;
  image.features.descriptors = PackedDescriptors(ByteDescriptorMatrix(source.keypoints.size(), 0));
  image.gps = source.gps;
  image.gps_accuracy_m = source.gps_accuracy_m;
  image_of_photo_[photo] = num_photos();
  photo_of_image_.push_back(photo);
  model_.images.push_back(std::move(image));
}

void Draft::Add(int photo, const LocalizedPhoto& localized) {
  if (const int camera_idx = set_.photos[photo].camera_idx; IsNewCamera(camera_idx)) {
    SetCamera(camera_idx, localized.camera);
  }
  Add(photo, localized.cam_from_world);
}

void Draft::Remove(std::span<const int> photos) {
  if (photos.empty()) {
    return;
  }
  for (const int photo : photos) {
    image_of_photo_[photo] = -1;
  }
  std::vector<int> new_image(model_.images.size(), -1);
  int num_left = 0;
  for (int i = 0; i < static_cast<int>(new_image.size()); ++i) {
    if (image_of_photo_[photo_of_image_[i]] == i) {
      new_image[i] = num_left;
      image_of_photo_[photo_of_image_[i]] = num_left;
      photo_of_image_[num_left] = photo_of_image_[i];
      if (num_left != i) {
        model_.images[num_left] = std::move(model_.images[i]);
      }
      ++num_left;
    }
  }
  model_.images.resize(num_left);
  photo_of_image_.resize(num_left);
  for (ReconLandmark& landmark : model_.landmarks) {
    for (ReconObservation& observation : landmark.observations) {
      observation.image_idx = new_image[observation.image_idx];
    }
    std::erase_if(landmark.observations,
                  [](const ReconObservation& observation) { return observation.image_idx < 0; });
  }
  std::erase_if(model_.landmarks,
                [](const ReconLandmark& landmark) { return landmark.observations.size() < 2; });
  IndexLandmarks();
}

int Draft::TrackOf(const ReconLandmark& landmark) const {
  const ReconObservation& first = landmark.observations.front();
  return tracks_.track_of_keypoint[photo_of_image_[first.image_idx]][first.keypoint_idx];
}

void Draft::IndexLandmarks() {
  std::fill(landmark_of_track_.begin(), landmark_of_track_.end(), -1);
  for (size_t i = 0; i < model_.landmarks.size(); ++i) {
    landmark_of_track_[TrackOf(model_.landmarks[i])] = static_cast<int>(i);
  }
}

std::vector<int> Draft::TracksSeenBy(std::span<const int> photos) const {
  std::vector<int> tracks;
  for (const int photo : photos) {
    for (const int track : tracks_.track_of_keypoint[photo]) {
      if (track >= 0) {
        tracks.push_back(track);
      }
    }
  }
  std::sort(tracks.begin(), tracks.end());
  tracks.erase(std::unique(tracks.begin(), tracks.end()), tracks.end());
  return tracks;
}

std::optional<ReconLandmark> Draft::MakeLandmark(int track) const {
  std::vector<ReconObservation> observations;
  for (const ReconObservation& observation : tracks_.tracks[track]) {
    if (Has(observation.image_idx)) {
      observations.push_back({image_of_photo_[observation.image_idx], observation.keypoint_idx});
    }
  }
  if (observations.size() < 2) {
    return std::nullopt;
  }
  std::optional<Eigen::Vector3d> guess;
  if (landmark_of_track_[track] >= 0) {
    guess = model_.landmarks[landmark_of_track_[track]].x_in_world;
  }
  const auto point = TriangulateConsistent(PointObservationsOf(model_, {{}, observations}), guess);
  if (!point) {
    return std::nullopt;
  }
  ReconLandmark landmark{point->x_in_world, {}};
  for (const int i : point->observations) {
    landmark.observations.push_back(observations[i]);
  }
  return landmark;
}

void Draft::Triangulate(std::span<const int> photos) {
  constexpr int kBatch = 256;
  const std::vector<int> tracks = TracksSeenBy(photos);
  std::vector<std::optional<ReconLandmark>> made(tracks.size());
  const int num_batches = (static_cast<int>(tracks.size()) + kBatch - 1) / kBatch;
  ParallelFor(num_batches, num_threads_, [&](int batch) {
    const size_t end = std::min(tracks.size(), static_cast<size_t>(batch + 1) * kBatch);
    for (size_t i = static_cast<size_t>(batch) * kBatch; i < end; ++i) {
      made[i] = MakeLandmark(tracks[i]);
    }
  });
  for (size_t i = 0; i < tracks.size(); ++i) {
    if (!made[i]) {
      continue;
    }
    int& landmark = landmark_of_track_[tracks[i]];
    if (landmark < 0) {
      landmark = static_cast<int>(model_.landmarks.size());
      model_.landmarks.push_back(std::move(*made[i]));
    } else {
      model_.landmarks[landmark] = std::move(*made[i]);
    }
  }
}

Reconstruction Draft::Surroundings(std::span<const int> photos, std::vector<int>* image_of_part,
                                   std::vector<int>* landmark_of_part) const {
  Reconstruction part;
  part.cameras = model_.cameras;
  std::vector<int> part_of_image(model_.images.size(), -1);
  for (const int track : TracksSeenBy(photos)) {
    if (landmark_of_track_[track] < 0) {
      continue;
    }
    ReconLandmark landmark = model_.landmarks[landmark_of_track_[track]];
    for (ReconObservation& observation : landmark.observations) {
      int& image = part_of_image[observation.image_idx];
      if (image < 0) {
        image = static_cast<int>(part.images.size());
        part.images.push_back(model_.images[observation.image_idx]);
        image_of_part->push_back(observation.image_idx);
      }
      observation.image_idx = image;
    }
    part.landmarks.push_back(std::move(landmark));
    landmark_of_part->push_back(landmark_of_track_[track]);
  }
  return part;
}

bool Draft::AdjustAround(std::span<const int> photos) {
  std::vector<int> image_of_part, landmark_of_part;
  Reconstruction part = Surroundings(photos, &image_of_part, &landmark_of_part);
  if (part.images.size() < 2) {
    return true;
  }
  std::vector<uint8_t> is_free(model_.images.size(), 0);
  for (const int photo : photos) {
    is_free[image_of_photo_[photo]] = 1;
  }
  AdjustPriors priors;
  for (const int image : image_of_part) {
    priors.image_is_fixed.push_back(is_free[image] ? 0 : 1);
  }
  const std::vector<CameraFreedom> freedom(part.cameras.size(), CameraFreedom::kFixed);
  AdjustOptions options;
  options.max_iterations = 10;
  options.max_rounds = 1;
  options.num_threads = num_threads_;
  if (!TryAdjust(freedom, priors, options, &part)) {
    return false;
  }
  for (size_t i = 0; i < image_of_part.size(); ++i) {
    model_.images[image_of_part[i]].cam_from_world = part.images[i].cam_from_world;
  }
  // The adjustment removed landmarks, but kept their order.
  for (const int landmark : landmark_of_part) {
    model_.landmarks[landmark].observations.clear();
  }
  for (ReconLandmark& landmark : part.landmarks) {
    for (ReconObservation& observation : landmark.observations) {
      observation.image_idx = image_of_part[observation.image_idx];
    }
    model_.landmarks[landmark_of_track_[TrackOf(landmark)]] = std::move(landmark);
  }
  std::erase_if(model_.landmarks,
                [](const ReconLandmark& landmark) { return landmark.observations.size() < 2; });
  IndexLandmarks();
  return true;
}

bool Draft::HoldStrayCameras() {
  bool has_strayed = false;
  for (size_t i = 0; i < model_.cameras.size(); ++i) {
    const MappingCamera& known = set_.cameras[i];
    const double stray = std::abs(std::log(model_.cameras[i].focal_px() / known.camera.focal_px()));
    if (known.source == FocalSource::kExif && stray > kMaxFocalSigmas * known.focal.log_sigma) {
      model_.cameras[i] = known.camera;
      is_held_[i] = 1;
      has_strayed = true;
    }
  }
  return has_strayed;
}

bool Draft::AdjustAll(bool is_final, const AdjustProgress& progress) {
  std::vector<int> num_images(model_.cameras.size(), 0);
  for (const ReconImage& image : model_.images) {
    ++num_images[image.camera_idx];
  }
  std::vector<CameraFreedom> freedom;
  AdjustPriors priors;
  for (size_t i = 0; i < model_.cameras.size(); ++i) {
    const MappingCamera& known = set_.cameras[i];
    freedom.push_back(is_held_[i] ? CameraFreedom::kFixed
                                  : FreedomOf(known, num_images[i], is_final));
    priors.camera_means.push_back(known.camera);
    priors.focal_sigma_of_camera.push_back(
        known.source == FocalSource::kCalibration ? 0.0 : known.focal.log_sigma);
  }
  AdjustOptions options;
  options.num_threads = num_threads_;
  if (!TryAdjust(freedom, priors, options, &model_, progress)) {
    return false;
  }
  IndexLandmarks();
  if (HoldStrayCameras()) {
    return AdjustAll(is_final, progress);
  }
  Triangulate(photo_of_image_);
  return true;
}

Segment Draft::Finish() const {
  Segment segment;
  segment.photo_of_image = photo_of_image_;
  std::sort(segment.photo_of_image.begin(), segment.photo_of_image.end());
  segment.model.cameras = model_.cameras;
  std::vector<int> new_image(model_.images.size());
  for (const int photo : segment.photo_of_image) {
    new_image[image_of_photo_[photo]] = static_cast<int>(segment.model.images.size());
    segment.model.images.push_back(model_.images[image_of_photo_[photo]]);
  }
  segment.model.landmarks = model_.landmarks;
  for (ReconLandmark& landmark : segment.model.landmarks) {
    for (ReconObservation& observation : landmark.observations) {
      observation.image_idx = new_image[observation.image_idx];
    }
    std::sort(landmark.observations.begin(), landmark.observations.end(),
              [](const ReconObservation& p, const ReconObservation& q) {
                return p.image_idx < q.image_idx;
              });
  }
  return segment;
}

}  // namespace cairn
