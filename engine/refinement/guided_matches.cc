#include "engine/refinement/guided_matches.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "core/angles.h"
#include "core/keypoint_shape.h"
#include "engine/refinement/near_keyframes.h"
#include "storage/codebook/distance_statistics.h"
#include "storage/tile/tile.h"

namespace cairn {
namespace {

constexpr double kMaxDistanceQuantile = 0.95;
// A keypoint's scale is within this factor of the predicted one, as
// VotingOptions assumes.
constexpr double kMaxSizeFactor = 2.5;

// `predicted_px` is 0 if the landmark has no size.
bool HasAboutSize(const Keypoint& keypoint, double predicted_px) {
  return !HasScale(keypoint) || predicted_px == 0.0 ||
         (keypoint.scale_px <= kMaxSizeFactor * predicted_px &&
          predicted_px <= kMaxSizeFactor * keypoint.scale_px);
}

// Finds the keypoints of one camera near a pixel.
class KeypointGrid {
 public:
  KeypointGrid(const QueryContext& query, int camera_idx)
      : query_(query),
        cell_px_(CellPxOf(query.CameraAt(camera_idx))),
        num_x_(CellOf(query.CameraAt(camera_idx).width_px()) + 1),
        num_y_(CellOf(query.CameraAt(camera_idx).height_px()) + 1),
        cells_(static_cast<size_t>(num_x_) * num_y_) {
    for (int i = 0; i < query.num_keypoints(); ++i) {
      const Keypoint& keypoint = query.keypoints[i];
      if (query.CameraIdxOf(i) == camera_idx) {
        cells_[IndexOf(ClampedX(keypoint.x_px), ClampedY(keypoint.y_px))].push_back(i);
      }
    }
  }

  // Calls visit(keypoint_idx) for each keypoint within the radius.
  template <typename Visit>
  void ForEachWithin(const Eigen::Vector2d& pixel, double radius_px, const Visit& visit) const {
    const int last_x = ClampedX(pixel.x() + radius_px), last_y = ClampedY(pixel.y() + radius_px);
    for (int y = ClampedY(pixel.y() - radius_px); y <= last_y; ++y) {
      for (int x = ClampedX(pixel.x() - radius_px); x <= last_x; ++x) {
        for (const int i : cells_[IndexOf(x, y)]) {
          const Eigen::Vector2d at(query_.keypoints[i].x_px, query_.keypoints[i].y_px);
          if ((at - pixel).squaredNorm() <= radius_px * radius_px) {
            visit(i);
          }
        }
      }
    }
  }

 private:
  // The image of a query may be as large as a camera allows; the larger cells bound the memory.
  static double CellPxOf(const Camera& camera) {
    constexpr double kMinCellPx = 16.0, kMaxCellsPerSide = 256.0;
    return std::max(kMinCellPx, std::max(camera.width_px(), camera.height_px()) / kMaxCellsPerSide);
  }
  int CellOf(double px) const {
    return static_cast<int>(std::min(double{Camera::kMaxSidePx}, std::max(0.0, px)) / cell_px_);
  }
  int ClampedX(double x_px) const { return std::min(CellOf(x_px), num_x_ - 1); }
  int ClampedY(double y_px) const { return std::min(CellOf(y_px), num_y_ - 1); }
  size_t IndexOf(int x, int y) const { return static_cast<size_t>(y) * num_x_ + x; }

  const QueryContext& query_;
  double cell_px_;  // Stands before num_x_ and num_y_, which need it.
  int num_x_, num_y_;
  std::vector<std::vector<int>> cells_;
};

// Where a camera should see a landmark.
struct Prediction {
  Eigen::Vector2d pixel;
  double radius_px = 0.0;
  double px_per_m = 0.0;
};

// Predicts the images of landmarks in one camera under a pose.
class Predictor {
 public:
  Predictor(const QueryContext& query, int camera_idx, const PoseEstimate& estimate,
            const PoseOptions& options)
      : camera_(query.CameraAt(camera_idx)),
        own_from_anchor_((query.OwnFromFirst(camera_idx) * estimate.cam_from_anchor).ToMatrix()),
        center_in_anchor_(estimate.cam_from_anchor.Inverse().translation),
        pose_covariance_(estimate.covariance),
        max_error_px_(options.MaxErrorPx(camera_.focal_px())) {}

  // Returns nothing if the landmark is not in view.
  std::optional<Prediction> Predict(const Eigen::Vector3d& x_in_anchor, double sigma_m) const {
    const Eigen::Matrix3d own_from_anchor = own_from_anchor_.leftCols<3>();
    const Eigen::Vector3d x_in_own = own_from_anchor * x_in_anchor + own_from_anchor_.col(3);
    Eigen::Matrix<double, 2, 3> of_point;
    const auto pixel = camera_.ProjectWithJacobian(x_in_own, &of_point);
    if (!pixel || !camera_.Contains(*pixel)) {
      return std::nullopt;
    }
    // The camera turns by w about its center and moves by d: the point moves by v x w - d in the
    // anchor frame, where v leads from the center to the point.
    const Eigen::Vector3d v = x_in_anchor - center_in_anchor_;
    const Eigen::Matrix<double, 2, 3> of_move = -of_point * own_from_anchor;
    Eigen::Matrix<double, 2, 6> jacobian;
    for (int row = 0; row < 2; ++row) {
      jacobian.row(row).head<3>() = v.cross(of_move.row(row));
    }
    jacobian.rightCols<3>() = of_move;
    const double sq_pose_px = (jacobian * pose_covariance_).cwiseProduct(jacobian).sum();
    const double px_per_m = camera_.focal_px() / x_in_own.norm();
    const double landmark_px = std::min(3.0 * px_per_m * sigma_m, 1.7320508 * max_error_px_);
    return Prediction{
        *pixel,
        std::sqrt(max_error_px_ * max_error_px_ + landmark_px * landmark_px + 4.0 * sq_pose_px),
        px_per_m};
  }

 private:
  const Camera& camera_;
  const Eigen::Matrix<double, 3, 4> own_from_anchor_;
  const Eigen::Vector3d center_in_anchor_;
  const Eigen::Matrix<double, 6, 6> pose_covariance_;
  const double max_error_px_;
};

float SqDistance(const Codebook& codebook, const float* descriptor, const uint8_t* code) {
  const int dim = codebook.subspace_dim();
  float sum = 0.0f;
  for (int s = 0; s < codebook.num_subspaces; ++s) {
    const float* word = codebook.words.data() + (size_t{Codebook::kNumWords} * s + code[s]) * dim;
    for (int i = 0; i < dim; ++i) {
      const float difference = descriptor[s * dim + i] - word[i];
      sum += difference * difference;
    }
  }
  return sum;
}

// The descriptor that fits a keypoint best so far.
struct Nearest {
  int tile_idx = -1;  // Negative if there is none.
  uint32_t landmark_idx = 0;
  uint32_t descriptor_idx = 0;
  float sq_distance = std::numeric_limits<float>::infinity();
  float search_area_sq_px = 0.0f;
};

// Compares the keypoints of one camera with landmarks.
class GuidedSearch {
 public:
  GuidedSearch(const QueryContext& query, const std::vector<TileView>& tiles, int camera_idx,
               const PoseEstimate& estimate, const PoseOptions& options)
      : query_(query),
        tiles_(tiles),
        grid_(query, camera_idx),
        predictor_(query, camera_idx, estimate, options),
        nearest_(query.num_keypoints()),
        seen_(tiles.size()) {
    for (const TileView& view : tiles) {
      anchor_from_tiles_.push_back(view.anchor_from_tile.ToMatrix());
    }
  }

  // Compares with the landmarks of a keyframe that its tile has not compared before.
  void Add(const KeyframeRef& keyframe) {
    const SearchableTile& tile = *tiles_[keyframe.tile_idx].tile;
    std::vector<bool>& seen = seen_[keyframe.tile_idx];
    seen.resize(tile.landmarks().landmark_ids.size());
    const double max_distance = SameLandmarkDistance(tile.codebook(), kMaxDistanceQuantile);
    for (const uint32_t landmark_idx :
         tile.covisibility().LandmarksOfKeyframe(keyframe.keyframe_idx)) {
      if (!seen[landmark_idx]) {
        seen[landmark_idx] = true;
        AddLandmark(keyframe.tile_idx, landmark_idx,
                    static_cast<float>(max_distance * max_distance));
      }
    }
  }

  // Appends the match of each keypoint that has one, in order of keypoint.
  void Take(std::vector<Correspondence>* matches) const {
    for (int i = 0; i < query_.num_keypoints(); ++i) {
      if (nearest_[i].tile_idx >= 0) {
        matches->push_back(MatchOf(i));
      }
    }
  }

 private:
  Eigen::Vector3d InAnchor(int tile_idx, uint32_t landmark_idx) const {
    const Eigen::Vector3d x_in_tile =
        tiles_[tile_idx].tile->landmarks().x_in_tile[landmark_idx].cast<double>();
    return anchor_from_tiles_[tile_idx] * x_in_tile.homogeneous();
  }

  void AddLandmark(int tile_idx, uint32_t landmark_idx, float max_sq_distance) {
    const SearchableTile& tile = *tiles_[tile_idx].tile;
    const TileLandmarks& landmarks = tile.landmarks();
    const auto predicted = predictor_.Predict(InAnchor(tile_idx, landmark_idx),
                                              SigmaFromCode(landmarks.sigma_codes[landmark_idx]));
    if (!predicted) {
      return;
    }
    near_.clear();
    grid_.ForEachWithin(predicted->pixel, predicted->radius_px,
                        [&](int keypoint_idx) { near_.push_back(keypoint_idx); });
    if (near_.empty()) {
      return;
    }
    const auto area_sq_px = static_cast<float>(kPi * predicted->radius_px * predicted->radius_px);
    for (uint32_t i = landmarks.descriptor_begin[landmark_idx];
         i < landmarks.descriptor_begin[landmark_idx + 1]; ++i) {
      const double predicted_px = predicted->px_per_m * SizeFromCode(landmarks.size_codes[i]);
      const uint8_t* code = tile.codes().data() + size_t{i} * tile.codebook().num_subspaces;
      for (const int keypoint_idx : near_) {
        if (!HasAboutSize(query_.keypoints[keypoint_idx], predicted_px)) {
          continue;
        }
        const float sq_distance =
            SqDistance(tile.codebook(), query_.descriptors.row(keypoint_idx).data(), code);
        if (sq_distance < std::min(max_sq_distance, nearest_[keypoint_idx].sq_distance)) {
          nearest_[keypoint_idx] = {tile_idx, landmark_idx, i, sq_distance, area_sq_px};
        }
      }
    }
  }

  Correspondence MatchOf(int keypoint_idx) const {
    const Nearest& nearest = nearest_[keypoint_idx];
    const TileLandmarks& landmarks = tiles_[nearest.tile_idx].tile->landmarks();
    const uint32_t descriptor_idx = nearest.descriptor_idx;
    const uint8_t orientation = landmarks.orientation_codes[descriptor_idx];
    return {
        .keypoint_idx = keypoint_idx,
        .tile_idx = nearest.tile_idx,
        .landmark_idx = nearest.landmark_idx,
        .x_in_anchor = InAnchor(nearest.tile_idx, nearest.landmark_idx),
        .sq_distance = nearest.sq_distance,
        .sigma_m = static_cast<float>(SigmaFromCode(landmarks.sigma_codes[nearest.landmark_idx])),
        .azimuth_rad = static_cast<float>(AzimuthFromCode(landmarks.azimuth_codes[descriptor_idx])),
        .size_m = static_cast<float>(SizeFromCode(landmarks.size_codes[descriptor_idx])),
        .descriptor_sq_distance = nearest.sq_distance,
        .orientation_rad =
            orientation == kNoOrientation
                ? std::nullopt
                : std::optional(static_cast<float>(OrientationFromCode(orientation))),
        .search_area_sq_px = nearest.search_area_sq_px};
  }

  const QueryContext& query_;
  const std::vector<TileView>& tiles_;
  const KeypointGrid grid_;
  const Predictor predictor_;
  std::vector<Eigen::Matrix<double, 3, 4>> anchor_from_tiles_;
  std::vector<Nearest> nearest_;         // Per keypoint.
  std::vector<std::vector<bool>> seen_;  // Per tile and landmark; empty before its first keyframe.
  std::vector<int> near_;                // Scratch.
};

}  // namespace

std::vector<Correspondence> GuidedMatches(const QueryContext& query,
                                          const std::vector<TileView>& tiles,
                                          const PoseEstimate& estimate,
                                          const PoseOptions& options) {
  constexpr int kMaxKeyframes = 16;
  const std::vector<KeyframeRef> keyframes =
      NearKeyframes(tiles, estimate.cam_from_anchor.Inverse(), kMaxKeyframes);
  std::vector<Correspondence> matches;
  for (int camera_idx = 0; camera_idx < query.num_cameras(); ++camera_idx) {
    GuidedSearch search(query, tiles, camera_idx, estimate, options);
    for (const KeyframeRef& keyframe : keyframes) {
      search.Add(keyframe);
    }
    search.Take(&matches);
  }
  std::stable_sort(matches.begin(), matches.end(),
                   [](const Correspondence& a, const Correspondence& b) {
                     return a.keypoint_idx < b.keypoint_idx;
                   });
  return matches;
}

}  // namespace cairn
