#include "ingest/tiles/build_tile.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/check.h"
#include "core/frames.h"
#include "core/geodesy.h"
#include "core/keypoint_shape.h"
#include "core/statistics.h"
#include "ingest/tiles/tile_edit.h"

namespace cairn {
namespace {

// One descriptor of a landmark and where it was seen from.
struct TileObservation {
  uint32_t landmark_idx = 0;  // In PlacedSession::landmarks.
  uint32_t keyframe_idx = 0;  // In the tile.
  Eigen::Index row = 0;       // Of the tile's projected descriptors.
  int keypoint_idx = 0;
};

// Attributes of one mode.
struct ModeMeans {
  CircularMean orientation;
  CircularMean azimuth;
  double sum_log_size = 0.0;
  int num_sizes = 0;  // Members that have a size.
  int num_members = 0;
};

class TileBuilder {
 public:
  TileBuilder(const TileSource& source, TileId tile_id, const std::vector<KeyframeId>& keyframe_ids)
      : source_(source),
        images_(source.session->images_of_tile.at(tile_id)),
        ecef_from_tile_(EcefFromEnu(tile_id.Anchor())),
        tile_(EmptyTile(tile_id, source.codec->codebook().id,
                        source.codec->codebook().num_subspaces)) {
    CAIRN_CHECK(keyframe_ids.size() == images_.size(), "there must be one keyframe for each image");
    CAIRN_CHECK(source.landmark_ids.size() == source.session->landmarks.size(),
                "there must be one id for each landmark");
    for (size_t k = 0; k < images_.size(); ++k) {
      AddKeyframe(images_[k], keyframe_ids[k]);
    }
  }

  Tile Build() {
    ProjectDescriptors();
    std::stable_sort(observations_.begin(), observations_.end(),
                     [](const auto& a, const auto& b) { return a.landmark_idx < b.landmark_idx; });
    for (auto begin = observations_.begin(); begin != observations_.end();) {
      const auto end =
          std::find_if(begin, observations_.end(), [&](const TileObservation& observation) {
            return observation.landmark_idx != begin->landmark_idx;
          });
      AddLandmark({begin, end});
      begin = end;
    }
    EncodeDescriptors();
    AddCovisibility();
    return std::move(tile_);
  }

 private:
  void AddKeyframe(int image_idx, KeyframeId keyframe_id) {
    const Rigid3d cam_from_tile = source_.session->cam_from_ecef[image_idx] * ecef_from_tile_;
    // Down at the keyframe, not at the anchor: they differ by the curvature of the Earth.
    const Geodetic position =
        GeodeticFromEcef(source_.session->cam_from_ecef[image_idx].Inverse().translation);
    down_in_cam_.push_back(source_.session->cam_from_ecef[image_idx].rotation *
                           (EcefFromEnu(position).rotation * DownInEnu()));
    tile_.keyframes.push_back({keyframe_id, source_.session_id, cam_from_tile});
  }

  // Fills observations_ and projected_.
  void ProjectDescriptors() {
    size_t num_rows = 0;
    for (const int image_idx : images_) {
      num_rows += source_.session->observations_of_image[image_idx].size();
    }
    observations_.reserve(num_rows);
    projected_.resize(num_rows, source_.codec->codebook().projected_dim());
    for (uint32_t k = 0; k < images_.size(); ++k) {
      const auto& observations = source_.session->observations_of_image[images_[k]];
      const PackedFeatures& features = source_.reconstruction->images[images_[k]].features;
      const DescriptorMatrix raw = features.descriptors.Rows(KeypointsOf(observations)).Unpacked();
      const auto first_row = static_cast<Eigen::Index>(observations_.size());
      for (size_t i = 0; i < observations.size(); ++i) {
        observations_.push_back({observations[i].landmark_idx, k,
                                 first_row + static_cast<Eigen::Index>(i),
                                 observations[i].keypoint_idx});
      }
      projected_.middleRows(first_row, raw.rows()) = source_.codec->Project(raw);
    }
  }

  void AddLandmark(std::span<const TileObservation> observations) {
    const uint32_t landmark_idx = observations.front().landmark_idx;
    const PlacedLandmark& landmark = source_.session->landmarks[landmark_idx];
    const Eigen::Vector3d x_in_tile = ecef_from_tile_.Inverse() * landmark.x_in_ecef;

    DescriptorMatrix descriptors(observations.size(), projected_.cols());
    for (size_t i = 0; i < observations.size(); ++i) {
      descriptors.row(i) = projected_.row(observations[i].row);
    }
    const AppearanceModes modes = source_.summarizer->Summarize(descriptors);
    std::vector<ModeMeans> means(modes.centers.rows());
    for (size_t i = 0; i < observations.size(); ++i) {
      AddObservation(observations[i], x_in_tile, &means[modes.mode_of_descriptor[i]]);
    }
    for (const ModeMeans& mode : means) {
      AddAttributes(mode);
    }
    centers_.push_back(modes.centers);

    tile_.landmark_ids.push_back(source_.landmark_ids[landmark_idx]);
    const auto num_observations = static_cast<uint8_t>(std::min<size_t>(observations.size(), 255));
    tile_.history.push_back({source_.session_id, num_observations, num_observations});
    tile_.history_begin.push_back(static_cast<uint32_t>(tile_.history.size()));
    tile_.x_in_tile.push_back(QuantizePosition(x_in_tile));
    tile_.sigma_codes.push_back(SigmaCode(landmark.sigma_m));
    tile_.descriptor_begin.push_back(static_cast<uint32_t>(tile_.num_descriptors()));
  }

  void AddObservation(const TileObservation& observation, const Eigen::Vector3d& x_in_tile,
                      ModeMeans* mode) const {
    const ReconImage& image = source_.reconstruction->images[images_[observation.keyframe_idx]];
    const Camera& camera = source_.reconstruction->cameras[image.camera_idx];
    const Keypoint& keypoint = image.features.keypoints[observation.keypoint_idx];
    const Eigen::Vector3d to_camera =
        tile_.keyframes[observation.keyframe_idx].cam_from_tile.Inverse().translation - x_in_tile;
    if (const auto orientation_rad = GravityRectifiedOrientationRad(
            camera, keypoint, down_in_cam_[observation.keyframe_idx])) {
      mode->orientation.Add(*orientation_rad);
    }
    mode->azimuth.Add(std::atan2(to_camera.y(), to_camera.x()));
    if (HasScale(keypoint)) {
      const double size_m = keypoint.scale_px / camera.focal_px() * to_camera.norm();
      mode->sum_log_size += std::log(std::max(size_m, 1e-6));
      ++mode->num_sizes;
    }
    ++mode->num_members;
  }

  void AddAttributes(const ModeMeans& mode) {
    const auto orientation_rad = mode.orientation.AngleRad();
    tile_.orientation_codes.push_back(orientation_rad ? OrientationCode(*orientation_rad)
                                                      : kNoOrientation);
    tile_.size_codes.push_back(
        SizeCode(mode.num_sizes > 0 ? std::exp(mode.sum_log_size / mode.num_sizes) : 0.0));
    tile_.azimuth_codes.push_back(AzimuthCode(mode.azimuth.AngleRad().value_or(0.0)));
    tile_.weight_codes.push_back(WeightCode(mode.num_members));
  }

  void EncodeDescriptors() {
    DescriptorMatrix all(tile_.num_descriptors(), projected_.cols());
    Eigen::Index row = 0;
    for (const DescriptorMatrix& centers : centers_) {
      all.middleRows(row, centers.rows()) = centers;
      row += centers.rows();
    }
    tile_.codes = source_.codec->Encode(all);
  }

  // Observations are in the order of the tile's landmarks, so each keyframe's list ascends by
  // itself.
  void AddCovisibility() {
    std::vector<std::vector<uint32_t>> landmarks_of_keyframe(images_.size());
    uint32_t tile_landmark_idx = 0;
    for (size_t i = 0; i < observations_.size(); ++i) {
      if (i > 0 && observations_[i].landmark_idx != observations_[i - 1].landmark_idx) {
        ++tile_landmark_idx;
      }
      landmarks_of_keyframe[observations_[i].keyframe_idx].push_back(tile_landmark_idx);
    }
    for (const std::vector<uint32_t>& landmarks : landmarks_of_keyframe) {
      tile_.keyframe_landmarks.insert(tile_.keyframe_landmarks.end(), landmarks.begin(),
                                      landmarks.end());
      tile_.keyframe_begin.push_back(static_cast<uint32_t>(tile_.keyframe_landmarks.size()));
    }
  }

  const TileSource& source_;
  const std::vector<int>& images_;
  Rigid3d ecef_from_tile_;
  std::vector<Eigen::Vector3d> down_in_cam_;  // Per keyframe.
  std::vector<TileObservation> observations_;
  DescriptorMatrix projected_;             // A row per observation, in keyframe order.
  std::vector<DescriptorMatrix> centers_;  // Per landmark.
  Tile tile_;
};

}  // namespace

Tile BuildTile(const TileSource& source, TileId tile_id,
               const std::vector<KeyframeId>& keyframe_ids) {
  return TileBuilder(source, tile_id, keyframe_ids).Build();
}

}  // namespace cairn
