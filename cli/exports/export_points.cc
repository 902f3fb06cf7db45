#include "cli/exports/export_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "cli/exports/spill_files.h"
#include "core/error.h"
#include "core/printable.h"
#include "core/replace_file.h"
#include "ingest/colmap/colmap_model_writer.h"
#include "storage/tile/tile.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

// A landmark as one of its tiles has it.
struct SpilledLandmark {
  uint64_t landmark_id;
  double x_in_world[3];
  float sigma_m;
  float height_over_cameras_m;
  int64_t session_id;
};

struct SpilledObservation {
  uint64_t landmark_id;
  uint32_t image_id;
  uint32_t keypoint_idx;
  float sigma_px;
};

// Landmarks by ranges of their ids.
class LandmarkSpill {
 public:
  LandmarkSpill(const std::string& folder, uint64_t num_ids) {
    constexpr uint64_t kMaxBuckets = 64, kIdsOfBucket = 1'000'000;
    ids_of_bucket_ = std::max(kIdsOfBucket, num_ids / kMaxBuckets + 1);
    for (uint64_t i = 0; i <= num_ids / ids_of_bucket_; ++i) {
      landmarks_.emplace_back(folder);
      observations_.emplace_back(folder);
    }
  }

  size_t num_buckets() const { return landmarks_.size(); }
  SpillFile<SpilledLandmark>& landmarks(size_t bucket) { return landmarks_[bucket]; }
  SpillFile<SpilledObservation>& observations(size_t bucket) { return observations_[bucket]; }
  // Ids of a damaged map may be too large; they join the last range.
  size_t BucketOf(uint64_t landmark_id) const {
    return std::min(static_cast<size_t>(landmark_id / ids_of_bucket_), num_buckets() - 1);
  }

 private:
  uint64_t ids_of_bucket_;
  std::deque<SpillFile<SpilledLandmark>> landmarks_;
  std::deque<SpillFile<SpilledObservation>> observations_;
};

// Gives each set of intrinsics an id.
class CameraIds {
 public:
  uint32_t IdOf(const Camera& camera, ColmapModelWriter* writer) {
    const auto [entry, is_new] = ids_.try_emplace(
        Key(camera.model(), camera.width_px(), camera.height_px(), camera.params()),
        static_cast<uint32_t>(ids_.size() + 1));
    if (is_new) {
      writer->AddCamera(entry->second, camera);
    }
    return entry->second;
  }
  int64_t size() const { return std::ssize(ids_); }

 private:
  using Key = std::tuple<CameraModel, int, int, std::vector<double>>;
  std::map<Key, uint32_t> ids_;
};

// A PLY file of points; the header comes first, so the number of points is filled in at the end.
class PlyWriter {
 public:
  explicit PlyWriter(const std::string& path) : file_(path) {
    file_.Write("ply\nformat binary_little_endian 1.0\nelement vertex ");
    count_position_ = file_.size();
    file_.Write(CountText(0));
    file_.Write(
        "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\n"
        "property uchar green\nproperty uchar blue\nproperty float sigma_m\n"
        "property int session\nend_header\n");
  }

  void Add(const SpilledLandmark& landmark, const Rgb& color) {
    std::string bytes;
    const auto put = [&bytes](const auto& value) {
      bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
    };
    put(landmark.x_in_world);
    put(color);
    put(landmark.sigma_m);
    put(static_cast<int32_t>(landmark.session_id));
    file_.Write(bytes);
    ++num_points_;
  }

  void Commit() {
    file_.Overwrite(count_position_, CountText(num_points_));
    file_.Commit();
  }

 private:
  // Of a fixed length; readers take leading zeros.
  static std::string CountText(uint64_t count) { return fmt::format("{:012}", count); }

  FileReplacement file_;
  uint64_t count_position_ = 0;
  uint64_t num_points_ = 0;
};

class PointExport {
 public:
  PointExport(const MapSnapshot& map, const ExportPointsOptions& options)
      : map_(map), options_(options), spill_(FolderOf(options), Value(map.NextLandmarkId())) {
    if (!options.colmap_dir.empty()) {
      model_.emplace(options.colmap_dir, options.colmap_format);
    }
    if (!options.ply_path.empty()) {
      ply_.emplace(options.ply_path);
    }
    for (const SessionRecord& session : map.Sessions()) {
      name_of_session_[session.id] = session.name;
    }
  }

  ExportedPoints Run() {
    const int64_t num_tiles = map_.Info().num_tiles;
    int64_t num_done = 0;
    TilePageRequest request;
    request.limit = 100;
    do {
      const TilePage page = map_.FindTilePage(request);
      for (const TileRecord& record : page.tiles) {
        AddTile(record);
        if (options_.progress) {
          options_.progress(++num_done, num_tiles);
        }
      }
      request.after = page.resume_after;
    } while (request.after);
    for (size_t i = 0; i < spill_.num_buckets(); ++i) {
      WriteBucket(i);
    }
    exported_.num_cameras = camera_ids_.size();
    if (model_) {
      model_->Commit();
    }
    if (ply_) {
      ply_->Commit();
    }
    return exported_;
  }

 private:
  static std::string FolderOf(const ExportPointsOptions& options) {
    if (!options.colmap_dir.empty()) {
      return options.colmap_dir;
    }
    const std::string folder = std::filesystem::path(options.ply_path).parent_path().string();
    return folder.empty() ? "." : folder;
  }

  bool IsExported(SessionId session_id) const {
    return !options_.session || *options_.session == session_id;
  }

  void AddTile(const TileRecord& record) {
    const Tile tile = DecodeTile(map_.LoadPayload(record.payload_id));
    const std::vector<SpilledLandmark> landmarks = LandmarksOf(tile, record);
    std::vector<bool> is_seen(landmarks.size(), false);
    AddKeyframes(tile, landmarks, &is_seen);
    for (size_t i = 0; i < landmarks.size(); ++i) {
      if (is_seen[i] || WasSeen(tile, i)) {
        spill_.landmarks(spill_.BucketOf(landmarks[i].landmark_id)).Add(landmarks[i]);
      }
    }
  }

  std::vector<SpilledLandmark> LandmarksOf(const Tile& tile, const TileRecord& record) const {
    const Rigid3d ecef_from_tile = EcefFromEnu(tile.id.Anchor());
    const double camera_height_m = 0.5 * (record.min_h_m + record.max_h_m);
    std::vector<SpilledLandmark> landmarks(tile.num_landmarks());
    for (size_t i = 0; i < landmarks.size(); ++i) {
      const Eigen::Vector3d x_in_tile = tile.x_in_tile[i].cast<double>();
      const Eigen::Vector3d x_in_world = options_.world_from_ecef * (ecef_from_tile * x_in_tile);
      const auto history = tile.HistoryOf(i);
      landmarks[i] = {.landmark_id = Value(tile.landmark_ids[i]),
                      .x_in_world = {x_in_world.x(), x_in_world.y(), x_in_world.z()},
                      .sigma_m = static_cast<float>(SigmaFromCode(tile.sigma_codes[i])),
                      .height_over_cameras_m = static_cast<float>(x_in_tile.z() - camera_height_m),
                      .session_id = history.empty() ? 0 : Value(history.front().session_id)};
    }
    return landmarks;
  }

  bool WasSeen(const Tile& tile, size_t landmark_idx) const {
    const auto history = tile.HistoryOf(landmark_idx);
    return !options_.session ||
           std::any_of(history.begin(), history.end(), [&](const HistoryEntry& entry) {
             return entry.session_id == *options_.session;
           });
  }

  void AddKeyframes(const Tile& tile, const std::vector<SpilledLandmark>& landmarks,
                    std::vector<bool>* is_seen) {
    std::map<KeyframeId, size_t> idx_of_id;
    for (size_t i = 0; i < tile.num_keyframes(); ++i) {
      idx_of_id[tile.keyframes[i].id] = i;
    }
    for (const KeyframeRecord& keyframe : map_.KeyframesOfTile(tile.id)) {
      if (!IsExported(keyframe.session_id)) {
        continue;
      }
      const auto found = idx_of_id.find(keyframe.id);
      AddKeyframe(keyframe,
                  found == idx_of_id.end() ? std::span<const uint32_t>()
                                           : tile.LandmarksOfKeyframe(found->second),
                  landmarks, is_seen);
    }
  }

  void AddKeyframe(const KeyframeRecord& keyframe, std::span<const uint32_t> seen,
                   const std::vector<SpilledLandmark>& landmarks, std::vector<bool>* is_seen) {
    const uint32_t image_id = ImageId(keyframe.id);
    const Rigid3d cam_from_world = CamFromTarget(keyframe.cam_from_ecef, options_.world_from_ecef);
    std::vector<ColmapKeypoint> keypoints;
    for (const uint32_t landmark_idx : seen) {
      const SpilledLandmark& landmark = landmarks[landmark_idx];
      const Eigen::Vector3d x_in_cam =
          cam_from_world * Eigen::Map<const Eigen::Vector3d>(landmark.x_in_world);
      const std::optional<Eigen::Vector2d> pixel = keyframe.camera.Project(x_in_cam);
      if (!pixel || !keyframe.camera.Contains(*pixel)) {
        continue;
      }
      const double sigma_in_world = landmark.sigma_m * options_.world_from_ecef.scale;
      spill_.observations(spill_.BucketOf(landmark.landmark_id))
          .Add({.landmark_id = landmark.landmark_id,
                .image_id = image_id,
                .keypoint_idx = static_cast<uint32_t>(keypoints.size()),
                .sigma_px = static_cast<float>(keyframe.camera.focal_px() * sigma_in_world /
                                               x_in_cam.norm())});
      keypoints.push_back({.x_px = pixel->x(),
                           .y_px = pixel->y(),
                           .point_id = static_cast<int64_t>(landmark.landmark_id)});
      (*is_seen)[landmark_idx] = true;
    }
    exported_.num_images += 1;
    exported_.num_observations += std::ssize(keypoints);
    if (model_) {
      model_->AddImage(image_id, ImageName(keyframe), camera_ids_.IdOf(keyframe.camera, &*model_),
                       cam_from_world, keypoints);
    }
  }

  static uint32_t ImageId(KeyframeId id) {
    if (Value(id) <= 0 || Value(id) >= std::numeric_limits<uint32_t>::max()) {
      throw Error(
          ErrorCode::kBadInput,
          fmt::format("keyframe {} has an id that COLMAP's 32 bits cannot hold", Value(id)));
    }
    return static_cast<uint32_t>(Value(id));
  }

  // Throws Error(kBadInput) if the model cannot hold the name.
  std::string ImageName(const KeyframeRecord& keyframe) const {
    const auto session = name_of_session_.find(keyframe.session_id);
    const bool is_alone = name_of_session_.size() <= 1 || options_.session;
    const std::string name = is_alone || session == name_of_session_.end()
                                 ? keyframe.image_name
                                 : session->second + "/" + keyframe.image_name;
    // COLMAP's reader splits lines at blanks.
    if (options_.colmap_format == ColmapModelFormat::kText &&
        name.find_first_of(" \t\r\n\v\f") != std::string::npos) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("COLMAP's text models cannot hold the name '{}', which has a blank; "
                              "leave out --text",
                              Excerpt(name)));
    }
    return name;
  }

  Rgb ColorOf(const SpilledLandmark& landmark) const {
    switch (options_.color) {
      case PointColor::kHeight:
        return ColorOfHeight(landmark.height_over_cameras_m);
      case PointColor::kUncertainty:
        return ColorOfUncertainty(landmark.sigma_m);
      case PointColor::kSession:
        break;
    }
    return ColorOfSession(SessionId(landmark.session_id));
  }

  // Of the copies of a landmark, the most accurate counts, or else that of the first tile.
  void WriteBucket(size_t bucket) {
    std::vector<SpilledLandmark> landmarks = spill_.landmarks(bucket).TakeAll();
    std::vector<SpilledObservation> observations = spill_.observations(bucket).TakeAll();
    std::stable_sort(landmarks.begin(), landmarks.end(), [](const auto& a, const auto& b) {
      return std::pair(a.landmark_id, a.sigma_m) < std::pair(b.landmark_id, b.sigma_m);
    });
    std::stable_sort(observations.begin(), observations.end(),
                     [](const auto& a, const auto& b) { return a.landmark_id < b.landmark_id; });
    auto observation = observations.begin();
    for (size_t i = 0; i < landmarks.size(); ++i) {
      if (i > 0 && landmarks[i].landmark_id == landmarks[i - 1].landmark_id) {
        continue;
      }
      const auto first = observation;
      while (observation != observations.end() &&
             observation->landmark_id == landmarks[i].landmark_id) {
        ++observation;
      }
      WriteLandmark(landmarks[i], {first, observation});
    }
  }

  void WriteLandmark(const SpilledLandmark& landmark,
                     std::span<const SpilledObservation> observations) {
    const Rgb color = ColorOf(landmark);
    ++exported_.num_points;
    if (ply_) {
      ply_->Add(landmark, color);
    }
    if (observations.empty()) {
      ++exported_.num_unseen;
      return;
    }
    if (model_) {
      std::vector<ColmapTrackElement> track;
      double sum_sq_px = 0.0;
      for (const SpilledObservation& observation : observations) {
        track.push_back(
            {.image_id = observation.image_id, .keypoint_idx = observation.keypoint_idx});
        sum_sq_px += double{observation.sigma_px} * observation.sigma_px;
      }
      model_->AddPoint(landmark.landmark_id, Eigen::Map<const Eigen::Vector3d>(landmark.x_in_world),
                       color, std::sqrt(sum_sq_px / static_cast<double>(observations.size())),
                       track);
    }
  }

  const MapSnapshot& map_;
  const ExportPointsOptions& options_;
  LandmarkSpill spill_;
  std::optional<ColmapModelWriter> model_;
  std::optional<PlyWriter> ply_;
  CameraIds camera_ids_;
  std::map<SessionId, std::string> name_of_session_;
  ExportedPoints exported_;
};

}  // namespace

ExportedPoints ExportPoints(const MapSnapshot& map, const ExportPointsOptions& options) {
  return PointExport(map, options).Run();
}

}  // namespace cairn
