// The part of SimulatedMapping that maps a tile.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/angles.h"
#include "core/geodesy.h"
#include "core/parallel_for.h"
#include "core/scene/triangulate.h"
#include "lab/city/camera_angles.h"
#include "lab/city/clutter.h"
#include "lab/city/hashed_random.h"
#include "lab/city/mapping_streams.h"
#include "lab/city/simulated_mapping.h"

namespace cairn {
namespace {

// Distance of a wrong observation from the right one, pixels.
constexpr double kWrongPx = 6.0;
constexpr int kTriangulationBatch = 4096;

// The tile's square, in site.
CityBox BoxOfTile(TileId tile_id, const Rigid3d& site_from_ecef) {
  CityBox box;
  for (const Geodetic& corner : tile_id.Corners()) {
    box.extend(Eigen::Vector2d((site_from_ecef * EcefFromGeodetic(corner)).head<2>()));
  }
  return box;
}

}  // namespace

// Makes one chunk. Its functions are called in the order in which they are declared.
class SimulatedMapping::ChunkMaker {
 public:
  ChunkMaker(const SimulatedMapping& mapping, TileId tile_id, int num_threads)
      : mapping_(mapping),
        options_(mapping.options_),
        camera_(mapping.options_.rig.MakeCamera()),
        num_threads_(num_threads),
        box_(BoxOfTile(tile_id, mapping.city_.ecef_from_site().Inverse())) {
    chunk_.tile_id = tile_id;
  }

  MappedChunk Make(int first_pass, int last_pass) {
    for (int pass = first_pass; pass <= last_pass; ++pass) {
      Drive(pass);
    }
    if (!images_.empty()) {
      chunk_.reconstruction.cameras = {camera_};
      LinkTracks();
      FillImages();
      Triangulate();
    }
    return std::move(chunk_);
  }

 private:
  // A look in one image. Descriptors are made later, and only for looks that are in a track.
  struct Observation {
    uint64_t track = 0;
    uint64_t landmark = 0;
    uint64_t ornament = 0;
    uint64_t thing = 0;
    uint64_t view = 0;
    Keypoint keypoint;
    float azimuth_rad = 0.0f, elevation_rad = 0.0f, log2_scale = 0.0f;
    bool is_wrong = false;
    int keypoint_idx = -1;  // Index into the image's features, if the look is in a track.
  };
  struct Image {
    uint64_t id = 0;
    int pass = 0;
    std::vector<Observation> observations;
  };
  struct TrackEntry {
    uint64_t track = 0;
    uint32_t image_idx = 0, observation_idx = 0;
  };

  void Drive(int pass) {
    std::vector<RigKeyframe> keyframes = mapping_.KeyframesIn(box_, pass);
    std::erase_if(keyframes, [&](const RigKeyframe& keyframe) {
      return TileAt(mapping_.city_, keyframe.center_in_site) != chunk_.tile_id;
    });
    if (keyframes.empty()) {
      return;
    }
    const double reach_m = options_.detector.max_range_m;
    CityBox reach = BoxAroundPoint(keyframes.front().center_in_site.head<2>(), reach_m);
    for (const RigKeyframe& keyframe : keyframes) {
      reach.extend(BoxAroundPoint(keyframe.center_in_site.head<2>(), reach_m));
    }
    const CityRegion region(mapping_.city_, reach, options_.TimeYears(pass));
    const size_t first_image = images_.size();
    const int num_cameras = options_.rig.num_cameras;
    for (const RigKeyframe& keyframe : keyframes) {
      AddImages(keyframe);
    }
    ParallelFor(static_cast<int>(images_.size() - first_image), num_threads_, [&](int i) {
      const size_t image_idx = first_image + static_cast<size_t>(i);
      Observe(region, keyframes[static_cast<size_t>(i / num_cameras)].id, image_idx);
    });
    chunk_.num_keyframes += static_cast<int>(keyframes.size());
  }

  // Adds each image's true pose and its pose in the reconstruction.
  void AddImages(const RigKeyframe& keyframe) {
    HashedRandom noise(HashOf(keyframe.id, kPoseNoiseStream));
    const auto draw = [&noise](double sigma) {
      const double x = noise.Normal(), y = noise.Normal(), z = noise.Normal();
      return Eigen::Vector3d(sigma * Eigen::Vector3d(x, y, z));
    };
    const Eigen::Vector2d at = keyframe.center_in_site.head<2>();
    const SmoothField& drift = mapping_.drift_[static_cast<size_t>(keyframe.pass)];
    const Eigen::Vector3d shift = mapping_.deformation_.ShiftM(at) + drift.ShiftM(at) +
                                  draw(options_.noise.camera_position_m);
    const Eigen::Vector3d turn = mapping_.deformation_.RotationRad(at) + drift.RotationRad(at) +
                                 draw(options_.noise.camera_rotation_rad);
    const Eigen::Vector3d gps_in_site = keyframe.center_in_site + draw(options_.noise.gps_m);
    const Geodetic gps = GeodeticFromEcef(mapping_.city_.ecef_from_site() * gps_in_site);
    for (int k = 0; k < options_.rig.num_cameras; ++k) {
      const double step_rad = 2.0 * kPi / options_.rig.num_cameras;
      const Rigid3d cam_from_site = CamFromEnu(
          keyframe.center_in_site, {.yaw_rad = keyframe.heading_rad + (k + 0.5) * step_rad,
                                    .pitch_rad = options_.rig.pitch_rad});
      const Rigid3d site_from_cam = cam_from_site.Inverse();
      const Rigid3d world_from_cam(ExpSo3(turn) * site_from_cam.rotation,
                                   site_from_cam.translation + shift);
      images_.push_back({HashOf(keyframe.id, kImageStream, k), keyframe.pass, {}});
      chunk_.cam_from_site.push_back(cam_from_site);
      ReconImage image;
      image.name = fmt::format("pass{:02}/{:016x}_{}.jpg", keyframe.pass, keyframe.id, k);
      image.cam_from_world = world_from_cam.Inverse();
      image.gps = gps;
      chunk_.reconstruction.images.push_back(std::move(image));
    }
  }

  void Observe(const CityRegion& region, uint64_t place_id, size_t image_idx) {
    Image& image = images_[image_idx];
    const std::vector<Detection> detections = DetectLandmarks(
        region, camera_, chunk_.cam_from_site[image_idx], options_.detector, image.id, place_id);
    image.observations.reserve(detections.size());
    for (const Detection& detection : detections) {
      Observation observation;
      observation.landmark = detection.look.landmark;
      observation.ornament = detection.look.ornament;
      observation.thing = ThingOf(*detection.landmark);
      observation.view = ViewOf(observation.thing, detection.look);
      observation.track = TrackOf(detection.look, image.pass);
      observation.keypoint = detection.keypoint;
      observation.azimuth_rad = static_cast<float>(detection.look.view_azimuth_rad);
      observation.elevation_rad = static_cast<float>(detection.look.view_elevation_rad);
      observation.log2_scale = static_cast<float>(detection.look.log2_scale);
      HashedRandom wrong(HashOf(image.id, kWrongStream, observation.landmark));
      if (wrong.Chance(options_.noise.wrong_observation_share)) {
        observation.is_wrong = true;
        Shift(kWrongPx * wrong.Normal(), kWrongPx * wrong.Normal(), &observation.keypoint);
      }
      image.observations.push_back(observation);
    }
  }

  void Shift(double dx_px, double dy_px, Keypoint* keypoint) const {
    keypoint->x_px =
        static_cast<float>(std::clamp<double>(keypoint->x_px + dx_px, 0.0, camera_.width_px()));
    keypoint->y_px =
        static_cast<float>(std::clamp<double>(keypoint->y_px + dy_px, 0.0, camera_.height_px()));
  }

  // Names what looks like that at that place, to the centimeter.
  static uint64_t ThingOf(const CityLandmark& landmark) {
    const Eigen::Matrix<int64_t, 3, 1> place =
        (100.0 * landmark.x_in_site).array().round().cast<int64_t>();
    return HashOf(landmark.ornament, place.x(), place.y(), place.z());
  }

  uint64_t ViewOf(uint64_t thing, const DescriptorLook& look) const {
    HashedRandom phases(HashOf(thing, kTrackStream));
    const double azimuth = look.view_azimuth_rad / options_.track_view_rad + phases.Uniform();
    const double scale = look.log2_scale / options_.track_octaves + phases.Uniform();
    return HashOf(thing, static_cast<int64_t>(std::floor(azimuth)),
                  static_cast<int64_t>(std::floor(scale)));
  }

  // Looks at one landmark get the same track number if matching would connect them.
  uint64_t TrackOf(const DescriptorLook& look, int pass) const {
    HashedRandom phases(HashOf(look.landmark, kTrackStream));
    const double azimuth = look.view_azimuth_rad / options_.track_view_rad + phases.Uniform();
    const double scale = look.log2_scale / options_.track_octaves + phases.Uniform();
    const bool joins = HashedRandom(HashOf(options_.seed, kJoinStream, look.landmark, pass))
                           .Chance(options_.pass_join_share);
    return HashOf(look.landmark, joins ? 0 : pass + 1, static_cast<int64_t>(std::floor(azimuth)),
                  static_cast<int64_t>(std::floor(scale)));
  }

  void LinkTracks() {
    std::vector<TrackEntry> entries;
    for (uint32_t i = 0; i < images_.size(); ++i) {
      for (uint32_t j = 0; j < images_[i].observations.size(); ++j) {
        entries.push_back({images_[i].observations[j].track, i, j});
      }
    }
    std::sort(entries.begin(), entries.end(), [](const TrackEntry& a, const TrackEntry& b) {
      return a.track != b.track ? a.track < b.track : a.image_idx < b.image_idx;
    });
    std::vector<int> num_keypoints(images_.size(), 0);
    for (auto begin = entries.begin(); begin != entries.end();) {
      const auto end = std::find_if(begin, entries.end(), [&](const TrackEntry& entry) {
        return entry.track != begin->track;
      });
      if (end - begin >= options_.min_observations) {
        ReconLandmark landmark;
        landmark.x_in_world.setZero();
        for (auto entry = begin; entry != end; ++entry) {
          Observation& observation = images_[entry->image_idx].observations[entry->observation_idx];
          observation.keypoint_idx = num_keypoints[entry->image_idx]++;
          landmark.observations.push_back(
              {static_cast<int>(entry->image_idx), observation.keypoint_idx});
        }
        chunk_.reconstruction.landmarks.push_back(std::move(landmark));
        const Observation& first = images_[begin->image_idx].observations[begin->observation_idx];
        chunk_.city_landmarks.push_back(first.landmark);
        chunk_.things.push_back(first.thing);
        chunk_.views.push_back(first.view);
      }
      begin = end;
    }
    for (Image& image : images_) {
      std::erase_if(image.observations,
                    [](const Observation& observation) { return observation.keypoint_idx < 0; });
      image.observations.shrink_to_fit();
    }
  }

  void FillImages() {
    ParallelFor(static_cast<int>(images_.size()), num_threads_, [&](int i) {
      Image& image = images_[static_cast<size_t>(i)];
      FeatureSet features;
      const auto num_seen = static_cast<int>(image.observations.size());
      const int num_clutter = static_cast<int>(std::lround(options_.clutter_ratio * num_seen));
      features.keypoints.resize(static_cast<size_t>(num_seen));
      features.descriptors.resize(num_seen + num_clutter, DescriptorModel::kDim);
      for (const Observation& observation : image.observations) {
        features.keypoints[static_cast<size_t>(observation.keypoint_idx)] = observation.keypoint;
        features.descriptors.row(observation.keypoint_idx) = Describe(image, observation);
      }
      AppendClutter(camera_, options_.detector, mapping_.model_, HashOf(image.id, kClutterStream),
                    num_clutter, &features);
      chunk_.reconstruction.images[static_cast<size_t>(i)].features = std::move(features);
      image.observations = {};
    });
  }

  DescriptorModel::Descriptor Describe(const Image& image, const Observation& observation) const {
    if (observation.is_wrong) {
      return mapping_.model_.DescribeClutter(HashOf(image.id, kWrongStream, observation.landmark));
    }
    DescriptorLook look;
    look.ornament = observation.ornament;
    look.landmark = observation.landmark;
    look.appearance_mode = options_.AppearanceMode(image.pass);
    look.view_azimuth_rad = observation.azimuth_rad;
    look.view_elevation_rad = observation.elevation_rad;
    look.log2_scale = observation.log2_scale;
    look.observation = image.id;
    return mapping_.model_.Describe(look);
  }

  // Triangulates the landmarks as bundle adjustment would leave them: from the noisy keypoints and
  // the noisy cameras. Drops landmarks that cannot be triangulated.
  void Triangulate() {
    Reconstruction& reconstruction = chunk_.reconstruction;
    const auto count = static_cast<int>(reconstruction.landmarks.size());
    std::vector<char> is_found(static_cast<size_t>(count), 0);
    const int num_batches = (count + kTriangulationBatch - 1) / kTriangulationBatch;
    ParallelFor(num_batches, num_threads_, [&](int batch) {
      const int end = std::min(count, (batch + 1) * kTriangulationBatch);
      for (int i = batch * kTriangulationBatch; i < end; ++i) {
        ReconLandmark& landmark = reconstruction.landmarks[static_cast<size_t>(i)];
        if (const auto x_in_world =
                TriangulatePoint(PointObservationsOf(reconstruction, landmark))) {
          landmark.x_in_world = *x_in_world;
          is_found[static_cast<size_t>(i)] = 1;
        }
      }
    });
    size_t kept = 0;
    for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
      if (is_found[i] != 0) {
        std::swap(reconstruction.landmarks[kept], reconstruction.landmarks[i]);
        chunk_.things[kept] = chunk_.things[i];
        chunk_.views[kept] = chunk_.views[i];
        chunk_.city_landmarks[kept++] = chunk_.city_landmarks[i];
      }
    }
    reconstruction.landmarks.resize(kept);
    chunk_.city_landmarks.resize(kept);
    chunk_.things.resize(kept);
    chunk_.views.resize(kept);
  }

  const SimulatedMapping& mapping_;
  const SimulatedMappingOptions& options_;
  Camera camera_;
  int num_threads_;
  CityBox box_;
  MappedChunk chunk_;
  std::vector<Image> images_;  // Parallel to chunk_.reconstruction.images.
};

MappedChunk SimulatedMapping::MapTile(TileId tile_id, int num_threads) const {
  return ChunkMaker(*this, tile_id, num_threads).Make(0, options_.num_passes - 1);
}

MappedChunk SimulatedMapping::MapTileInPass(TileId tile_id, int pass, int num_threads) const {
  return ChunkMaker(*this, tile_id, num_threads).Make(pass, pass);
}

}  // namespace cairn
