#include "mapping/growth/draft.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/parallel_for.h"
#include "ingest/sfm/triangulate.h"

namespace cairn {
namespace {

// Observations with larger errors do not belong to a landmark; as in the adjustment.
constexpr double kMaxErrorSigmas = 4.0;
// Smallest angle between two rays of a landmark. Keypoints of 0.5 to 2 px at a focal length of
// 1,000 px then place the landmark within 3 to 12 % of its distance.
constexpr double kMinRayAngleRad = 0.0175;
// Photos of one camera from which its distortion can be told apart from its focal length.
constexpr int kMinImagesForDistortion = 5;
// Pairs of a track's photos from which a landmark is tried if not all its observations agree.
constexpr int kMaxTriedPairs = 10;

double SqErrorSigmas(const PointView& view, const Eigen::Vector3d& x_in_world) {
  const auto pixel = view.camera->Project(view.cam_from_world * x_in_world);
  return pixel ? (*pixel - view.pixel).squaredNorm() / (view.sigma_px * view.sigma_px) : 1e12;
}

std::vector<int> AgreeingViews(const std::vector<PointView>& views,
                               const Eigen::Vector3d& x_in_world) {
  std::vector<int> agreeing;
  for (int i = 0; i < static_cast<int>(views.size()); ++i) {
    if (SqErrorSigmas(views[i], x_in_world) <= kMaxErrorSigmas * kMaxErrorSigmas) {
      agreeing.push_back(i);
    }
  }
  return agreeing;
}

std::vector<PointView> Selected(const std::vector<PointView>& views,
                                const std::vector<int>& which) {
  std::vector<PointView> selected;
  for (const int i : which) {
    selected.push_back(views[i]);
  }
  return selected;
}

bool HasParallax(const std::vector<PointView>& views, const Eigen::Vector3d& x_in_world) {
  std::vector<Eigen::Vector3d> rays;
  for (const PointView& view : views) {
    rays.push_back((view.cam_from_world.Inverse().translation - x_in_world).normalized());
  }
  const double max_cosine = std::cos(kMinRayAngleRad);
  for (size_t i = 0; i < rays.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      if (rays[i].dot(rays[j]) < max_cosine) {
        return true;
      }
    }
  }
  return false;
}

// The views that agree on the best point that all views, or a pair of them, give.
std::vector<int> ConsistentViews(const std::vector<PointView>& views) {
  std::vector<int> best;
  const auto try_views = [&](const std::vector<PointView>& chosen) {
    if (const auto x_in_world = TriangulatePoint(chosen)) {
      std::vector<int> agreeing = AgreeingViews(views, *x_in_world);
      if (agreeing.size() > best.size()) {
        best = std::move(agreeing);
      }
    }
  };
  try_views(views);
  const int count = static_cast<int>(views.size());
  int num_tried = 0;
  for (int gap = count - 1; gap >= 1; --gap) {
    for (int i = 0; i + gap < count; ++i) {
      if (count < 3 || 2 * static_cast<int>(best.size()) > count || num_tried == kMaxTriedPairs) {
        return best;
      }
      try_views({views[i], views[i + gap]});
      ++num_tried;
    }
  }
  return best;
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
      landmark_of_track_(tracks.tracks.size(), -1) {
  model_.cameras = std::move(cameras);
}

bool Draft::IsNewCamera(int camera_idx) const {
  return std::none_of(model_.images.begin(), model_.images.end(),
                      [&](const ReconImage& image) { return image.camera_idx == camera_idx; });
}

std::vector<LandmarkSight> Draft::SightsOf(int photo) const {
  const std::vector<Keypoint>& keypoints = set_.photos[photo].keypoints;
  std::vector<LandmarkSight> sights;
  for (int i = 0; i < static_cast<int>(keypoints.size()); ++i) {
    const int track = tracks_.track_of_keypoint[photo][i];
    if (track >= 0 && landmark_of_track_[track] >= 0) {
      sights.push_back({i,
                        {keypoints[i].x_px, keypoints[i].y_px},
                        KeypointSigmaPx(keypoints[i].scale_px),
                        model_.landmarks[landmark_of_track_[track]].x_in_world});
    }
  }
  return sights;
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
  image.features.descriptors.resize(source.keypoints.size(), 0);
  image.gps = source.gps;
  image.gps_accuracy_m = source.gps_accuracy_m;
  image_of_photo_[photo] = num_photos();
  photo_of_image_.push_back(photo);
  model_.images.push_back(std::move(image));
}

void Draft::Remove(std::span<const int> photos) {
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
  const std::vector<PointView> views = ViewsOf(model_, {{}, observations});
  std::vector<int> agreeing;
  if (landmark_of_track_[track] >= 0) {
    agreeing = AgreeingViews(views, model_.landmarks[landmark_of_track_[track]].x_in_world);
  }
  if (agreeing.size() < 2) {
    agreeing = ConsistentViews(views);
  }
  if (agreeing.size() < 2) {
    return std::nullopt;
  }
  const std::vector<PointView> chosen = Selected(views, agreeing);
  const auto x_in_world = TriangulatePoint(chosen);
  if (!x_in_world || AgreeingViews(chosen, *x_in_world).size() < chosen.size() ||
      !HasParallax(chosen, *x_in_world)) {
    return std::nullopt;
  }
  ReconLandmark landmark{*x_in_world, {}};
  for (const int i : agreeing) {
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

void Draft::AdjustAround(std::span<const int> photos) {
  std::vector<int> image_of_part, landmark_of_part;
  Reconstruction part = Surroundings(photos, &image_of_part, &landmark_of_part);
  if (part.images.size() < 2) {
    return;
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
  Adjust(freedom, priors, options, part);

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
}

CameraFreedom Draft::FreedomOf(int camera_idx, int num_images) const {
  switch (set_.cameras[camera_idx].source) {
    case FocalSource::kCalibration:
      return CameraFreedom::kFixed;
    case FocalSource::kExif:
    case FocalSource::kGuess:
      return num_images >= kMinImagesForDistortion ? CameraFreedom::kFocalAndDistortion
                                                   : CameraFreedom::kFocal;
  }
  return CameraFreedom::kFixed;
}

AdjustReport Draft::AdjustAll() {
  std::vector<int> num_images(model_.cameras.size(), 0);
  for (const ReconImage& image : model_.images) {
    ++num_images[image.camera_idx];
  }
  std::vector<CameraFreedom> freedom;
  AdjustPriors priors;
  for (size_t i = 0; i < model_.cameras.size(); ++i) {
    freedom.push_back(num_images[i] > 0 ? FreedomOf(static_cast<int>(i), num_images[i])
                                        : CameraFreedom::kFixed);
    priors.focal_sigma_of_camera.push_back(set_.cameras[i].source == FocalSource::kCalibration
                                               ? 0.0
                                               : set_.cameras[i].focal.log_sigma);
  }
  AdjustOptions options;
  options.num_threads = num_threads_;
  options.min_ray_angle_rad = kMinRayAngleRad;
  const AdjustReport report = Adjust(freedom, priors, options, model_);
  IndexLandmarks();
  Triangulate(photo_of_image_);
  return report;
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
