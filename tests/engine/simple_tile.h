// Builds tiles from descriptors that are written by hand.
#ifndef CAIRN_TESTS_ENGINE_SIMPLE_TILE_H_
#define CAIRN_TESTS_ENGINE_SIMPLE_TILE_H_

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/geodesy.h"
#include "core/tile_id.h"
#include "engine/matching/matching_options.h"
#include "engine/query/query_context.h"
#include "engine/tiles/searchable_tile.h"
#include "storage/codebook/codebook.h"
#include "storage/tile/tile.h"

namespace cairn::testing {

// Descriptors are points in four dimensions whose coordinates are multiples of 0.1 in [0, 1.5]. The
// median same-landmark distance is 1, the 0.9-quantile 1.8.
inline std::shared_ptr<const Codebook> LatticeCodebook(CodebookId id = CodebookId{1}) {
  auto codebook = std::make_shared<Codebook>();
  codebook->id = id;
  codebook->descriptor_type = "lattice";
  codebook->normalization = DescriptorNormalization::kNone;
  codebook->mean = Eigen::VectorXf::Zero(4);
  codebook->projection = DescriptorMatrix::Identity(4, 4);
  codebook->num_subspaces = 2;
  for (int word = 0; word < 2 * Codebook::kNumWords; ++word) {
    codebook->words.push_back(0.1f * static_cast<float>(word % Codebook::kNumWords / 16));
    codebook->words.push_back(0.1f * static_cast<float>(word % 16));
  }
  for (int i = 1; i <= 19; ++i) {
    codebook->same_landmark_distance_quantiles.push_back(0.1f * static_cast<float>(i));
    codebook->other_landmark_distance_quantiles.push_back(0.2f * static_cast<float>(i));
  }
  return codebook;
}

struct SimpleDescriptor {
  float x = 0.0f;  // The first dimension; the others are 0.
  std::optional<double> orientation_rad;
};

struct SimpleLandmark {
  uint64_t id = 0;
  std::vector<SimpleDescriptor> descriptors;
  Eigen::Vector3d x_in_tile = Eigen::Vector3d::Zero();
};

inline TileId SimpleTileId() {
  return TileId::Containing(Geodetic::FromDegrees(49.011, 8.416, 0.0));
}

// Each entry of `keyframes` lists the indices of the landmarks that one keyframe sees.
inline Tile SimpleTile(const std::vector<SimpleLandmark>& landmarks,
                       const std::vector<std::vector<uint32_t>>& keyframes = {}) {
  Tile tile;
  tile.id = SimpleTileId();
  tile.codebook_id = CodebookId{1};
  tile.code_size = 2;
  tile.descriptor_begin = {0};
  tile.history_begin = {0};
  for (const SimpleLandmark& landmark : landmarks) {
    tile.landmark_ids.push_back(LandmarkId{landmark.id});
    tile.history.push_back({SessionId{1}, 2, 2});
    tile.history_begin.push_back(static_cast<uint32_t>(tile.history.size()));
    tile.x_in_tile.push_back(QuantizePosition(landmark.x_in_tile));
    tile.sigma_codes.push_back(SigmaCode(0.05));
    for (const SimpleDescriptor& descriptor : landmark.descriptors) {
      tile.codes.push_back(static_cast<uint8_t>(16 * std::lround(10.0f * descriptor.x)));
      tile.codes.push_back(0);
      tile.orientation_codes.push_back(descriptor.orientation_rad
                                           ? OrientationCode(*descriptor.orientation_rad)
                                           : kNoOrientation);
      tile.size_codes.push_back(SizeCode(0.1));
      tile.azimuth_codes.push_back(AzimuthCode(1.0));
      tile.weight_codes.push_back(WeightCode(2.0));
    }
    tile.descriptor_begin.push_back(static_cast<uint32_t>(tile.orientation_codes.size()));
  }
  tile.keyframe_begin = {0};
  for (size_t i = 0; i < keyframes.size(); ++i) {
    tile.keyframes.push_back({KeyframeId{static_cast<int64_t>(i) + 1}, SessionId{1}, Rigid3d()});
    tile.keyframe_landmarks.insert(tile.keyframe_landmarks.end(), keyframes[i].begin(),
                                   keyframes[i].end());
    tile.keyframe_begin.push_back(static_cast<uint32_t>(tile.keyframe_landmarks.size()));
  }
  return tile;
}

// Wide cells and many probes, so that the search misses nothing in LatticeCodebook's box.
inline IndexOptions ExhaustiveGrids() {
  IndexOptions options;
  options.grids = {.num_grids = 1,
                   .num_hashed_dims = 4,
                   .cell_width_sigmas = 100.0,
                   .num_probes = 16,
                   .max_candidates_per_cell = 10'000};
  return options;
}

inline TileView SimpleView(Tile tile, const Rigid3d& anchor_from_tile = Rigid3d(),
                           const IndexOptions& options = ExhaustiveGrids()) {
  const auto codebook = LatticeCodebook(tile.codebook_id);
  return {std::make_shared<const SearchableTile>(std::move(tile), codebook, options),
          anchor_from_tile};
}

// One keypoint per descriptor.
inline QueryContext SimpleQuery(const std::vector<SimpleDescriptor>& descriptors) {
  QueryContext query;
  query.descriptors = DescriptorMatrix::Zero(static_cast<Eigen::Index>(descriptors.size()), 4);
  for (size_t i = 0; i < descriptors.size(); ++i) {
    query.keypoints.push_back({.x_px = static_cast<float>(i), .y_px = 0.0f});
    query.rays_in_cam.push_back(Eigen::Vector3d::UnitZ());
    query.descriptors(static_cast<Eigen::Index>(i), 0) = descriptors[i].x;
    std::optional<float> orientation_rad;
    if (descriptors[i].orientation_rad) {
      orientation_rad = static_cast<float>(*descriptors[i].orientation_rad);
    }
    query.gravity_orientations_rad.push_back(orientation_rad);
  }
  return query;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_ENGINE_SIMPLE_TILE_H_
