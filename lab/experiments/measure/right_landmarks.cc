#include "lab/experiments/measure/right_landmarks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "storage/codebook/descriptor_codec.h"
#include "storage/codebook/distance_statistics.h"
#include "storage/tile/tile.h"

namespace cairn {
namespace {

constexpr double kRightErrorPx = 4.0;        // At kReferenceFocalPx.
constexpr double kReferenceFocalPx = 500;    // Pixels.
constexpr double kMinRightErrorPx = 3.0;     // Lower limit at any focal length.
constexpr double kMatchableQuantile = 0.95;  // Of same-landmark distances.
constexpr double kBinPx = 16.0;

double RightErrorPx(double focal_px) {
  return std::max(kMinRightErrorPx, kRightErrorPx * focal_px / kReferenceFocalPx);
}

// The keypoints of a query, grouped by their position in the image.
class KeypointBins {
 public:
  explicit KeypointBins(const std::vector<Keypoint>& keypoints) {
    for (size_t i = 0; i < keypoints.size(); ++i) {
      bins_[Bin(keypoints[i].x_px, keypoints[i].y_px)].push_back(static_cast<int>(i));
    }
  }

  // Calls visit(keypoint_idx) for all keypoints within a bin of the pixel.
  template <typename Visit>
  void ForEachNear(const Eigen::Vector2d& pixel, const Visit& visit) const {
    for (const double dx : {-kBinPx, 0.0, kBinPx}) {
      for (const double dy : {-kBinPx, 0.0, kBinPx}) {
        if (const auto bin = bins_.find(Bin(pixel.x() + dx, pixel.y() + dy)); bin != bins_.end()) {
          std::for_each(bin->second.begin(), bin->second.end(), visit);
        }
      }
    }
  }

 private:
  static int64_t Bin(double x_px, double y_px) {
    return static_cast<int64_t>(std::floor(x_px / kBinPx)) * 1'000'000 +
           static_cast<int64_t>(std::floor(y_px / kBinPx));
  }

  std::unordered_map<int64_t, std::vector<int>> bins_;
};

// Returns the squared distance to the nearest descriptor of a landmark.
float NearestSquaredDistance(const SearchableTile& tile, const DescriptorCodec& codec,
                             uint32_t landmark_idx,
                             const Eigen::Ref<const Eigen::RowVectorXf>& of) {
  const std::span<const uint32_t> descriptor_begin = tile.landmarks().descriptor_begin;
  const uint32_t begin = descriptor_begin[landmark_idx];
  const auto count = static_cast<int>(descriptor_begin[landmark_idx + 1] - begin);
  const DescriptorMatrix decoded =
      codec.Decode(tile.codes().data() + size_t{begin} * tile.codebook().num_subspaces, count);
  return (decoded.rowwise() - of).rowwise().squaredNorm().minCoeff();
}

}  // namespace

bool IsRight(const QueryContext& query, const Rigid3d& true_cam_from_anchor, int keypoint_idx,
             const Eigen::Vector3d& x_in_anchor, double sigma_m) {
  const Eigen::Vector3d x_in_cam = true_cam_from_anchor * x_in_anchor;
  const auto pixel = query.camera.Project(x_in_cam);
  if (!pixel) {
    return false;
  }
  const Keypoint& keypoint = query.keypoints[keypoint_idx];
  const double focal_px = query.camera.focal_px();
  const double error_px = (*pixel - Eigen::Vector2d(keypoint.x_px, keypoint.y_px)).norm();
  return error_px <= RightErrorPx(focal_px) + focal_px * sigma_m / x_in_cam.norm();
}

std::vector<bool> MatchableKeypoints(const PreparedQuery& query,
                                     const Rigid3d& true_cam_from_anchor) {
  const KeypointBins bins(query.context.keypoints);
  std::vector<bool> matchable(query.context.keypoints.size(), false);
  for (const TileView& view : query.tiles) {
    const SearchableTile& tile = *view.tile;
    const double max_distance = SameLandmarkDistance(tile.codebook(), kMatchableQuantile);
    const DescriptorCodec codec(
        std::shared_ptr<const Codebook>(std::shared_ptr<void>(), &tile.codebook()));
    for (uint32_t i = 0; i < tile.landmarks().num_landmarks(); ++i) {
      const Eigen::Vector3d x_in_anchor =
          view.anchor_from_tile * tile.landmarks().x_in_tile[i].cast<double>();
      const auto pixel = query.context.camera.Project(true_cam_from_anchor * x_in_anchor);
      if (!pixel || !query.context.camera.Contains(*pixel)) {
        continue;
      }
      const double sigma_m = SigmaFromCode(tile.landmarks().sigma_codes[i]);
      bins.ForEachNear(*pixel, [&](int k) {
        if (!matchable[k] &&
            IsRight(query.context, true_cam_from_anchor, k, x_in_anchor, sigma_m)) {
          matchable[k] = NearestSquaredDistance(tile, codec, i, query.context.descriptors.row(k)) <=
                         max_distance * max_distance;
        }
      });
    }
  }
  return matchable;
}

}  // namespace cairn
