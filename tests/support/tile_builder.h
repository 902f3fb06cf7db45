// Random but consistent tiles and codebooks for tests. Equal seeds give equal results.
#ifndef CAIRN_TESTS_SUPPORT_TILE_BUILDER_H_
#define CAIRN_TESTS_SUPPORT_TILE_BUILDER_H_

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "core/geodesy.h"
#include "core/rigid3.h"
#include "core/tile_id.h"
#include "storage/codebook/codebook.h"
#include "storage/tile/tile.h"

namespace cairn::testing {

struct RandomTileOptions {
  TileId id = TileId::Containing(Geodetic::FromDegrees(49.011, 8.416, 0.0));
  CodebookId codebook_id{1};
  int code_size = 8;
  int num_landmarks = 100;
  int max_descriptors_per_landmark = 4;  // Each landmark gets 1 to this many.
  int num_keyframes = 5;
  int num_landmarks_per_keyframe = 40;  // At most num_landmarks.
  int64_t first_keyframe_id = 1;
  int64_t session_id = 1;
  uint64_t first_landmark_id = 1;
  uint64_t seed = 1;
};

// Keyframes that each see a part of the tile's landmarks.
inline void AddRandomKeyframes(const RandomTileOptions& options, std::mt19937_64* random,
                               Tile* tile) {
  const auto uniform = [random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(*random);
  };
  tile->keyframe_begin = {0};
  for (int k = 0; k < options.num_keyframes; ++k) {
    const Eigen::Quaterniond rotation = Eigen::Quaterniond(
        Eigen::Vector4d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(0.1, 1)));
    const Eigen::Vector3d translation(uniform(-75, 75), uniform(-75, 75), uniform(0, 3));
    tile->keyframes.push_back({KeyframeId(options.first_keyframe_id + k),
                               SessionId(options.session_id), Rigid3d(rotation, translation)});
    // A keyframe sees a range of the Morton curve, with gaps.
    const int wanted = std::min(options.num_landmarks_per_keyframe, options.num_landmarks);
    const int span = std::min(options.num_landmarks, 2 * wanted);
    int remaining = wanted;
    const auto first = (*random)() % (options.num_landmarks - span + 1);
    for (int i = 0; i < span && remaining > 0; ++i) {
      if (static_cast<int>((*random)() % (span - i)) < remaining) {
        tile->keyframe_landmarks.push_back(static_cast<uint32_t>(first + i));
        --remaining;
      }
    }
    tile->keyframe_begin.push_back(static_cast<uint32_t>(tile->keyframe_landmarks.size()));
  }
}

// Landmarks are on a ground plane and facades within a 150 m square, in Morton order.
inline Tile RandomTile(const RandomTileOptions& options = {}) {
  std::mt19937_64 random(options.seed);
  const auto uniform = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto byte = [&random] { return static_cast<uint8_t>(random() >> 56); };

  std::vector<Eigen::Vector3f> positions(options.num_landmarks);
  for (size_t i = 0; i < positions.size(); ++i) {
    const double depth_m = uniform(0.0, 0.2);  // Facades and ground are rough.
    positions[i] =
        i % 4 == 0 ? QuantizePosition({uniform(-75.0, 75.0), uniform(-75.0, 75.0), depth_m})
                   : QuantizePosition({uniform(-75.0, 75.0), (i % 2 == 0 ? 9.0 : -9.0) + depth_m,
                                       uniform(0.0, 15.0)});
  }
  Tile tile;
  tile.id = options.id;
  tile.codebook_id = options.codebook_id;
  tile.code_size = options.code_size;
  tile.descriptor_begin = {0};
  tile.history_begin = {0};
  for (const uint32_t i : MortonOrder(positions)) {
    tile.x_in_tile.push_back(positions[i]);
    tile.landmark_ids.push_back(LandmarkId(options.first_landmark_id + tile.landmark_ids.size()));
    const auto num_observations = static_cast<uint8_t>(2 + random() % 8);
    tile.history.push_back({SessionId(options.session_id), num_observations, num_observations});
    tile.history_begin.push_back(static_cast<uint32_t>(tile.history.size()));
    tile.sigma_codes.push_back(SigmaCode(uniform(0.01, 0.5)));
    const auto num_descriptors = 1 + random() % options.max_descriptors_per_landmark;
    const double orientation_rad = uniform(-3.0, 3.0);
    const double size_m = uniform(0.02, 0.8);
    const double azimuth_rad = uniform(-3.0, 3.0);
    for (uint64_t d = 0; d < num_descriptors; ++d) {
      for (int b = 0; b < options.code_size; ++b) {
        tile.codes.push_back(byte());
      }
      tile.orientation_codes.push_back(random() % 50 == 0
                                           ? kNoOrientation
                                           : OrientationCode(orientation_rad + uniform(-0.2, 0.2)));
      tile.size_codes.push_back(SizeCode(size_m * uniform(0.8, 1.25)));
      tile.azimuth_codes.push_back(AzimuthCode(azimuth_rad + uniform(-0.3, 0.3)));
      tile.weight_codes.push_back(WeightCode(uniform(0.25, 4.0)));
    }
    tile.descriptor_begin.push_back(static_cast<uint32_t>(tile.orientation_codes.size()));
  }

  AddRandomKeyframes(options, &random, &tile);
  return tile;
}

// Returns true if all numbers of the two tiles are equal bit by bit.
inline bool SameTile(const Tile& a, const Tile& b) {
  const auto same_keyframe = [](const TileKeyframe& x, const TileKeyframe& y) {
    return x.id == y.id && x.session_id == y.session_id &&
           x.cam_from_tile.rotation.coeffs() == y.cam_from_tile.rotation.coeffs() &&
           x.cam_from_tile.translation == y.cam_from_tile.translation;
  };
  return a.id == b.id && a.codebook_id == b.codebook_id && a.code_size == b.code_size &&
         a.landmark_ids == b.landmark_ids && a.history_begin == b.history_begin &&
         a.history == b.history && a.weight_codes == b.weight_codes && a.x_in_tile == b.x_in_tile &&
         a.sigma_codes == b.sigma_codes && a.descriptor_begin == b.descriptor_begin &&
         a.codes == b.codes && a.orientation_codes == b.orientation_codes &&
         a.size_codes == b.size_codes && a.azimuth_codes == b.azimuth_codes &&
         a.keyframe_begin == b.keyframe_begin && a.keyframe_landmarks == b.keyframe_landmarks &&
         std::equal(a.keyframes.begin(), a.keyframes.end(), b.keyframes.begin(), b.keyframes.end(),
                    same_keyframe);
}

struct RandomCodebookOptions {
  int raw_dim = 128;
  int projected_dim = 16;
  int num_subspaces = 8;
  uint64_t seed = 1;
};

// Returns a codebook whose projection has small random entries and whose words are those of a
// standard normal distribution. The codebook is valid but not trained.
inline Codebook RandomCodebook(const RandomCodebookOptions& options = {}) {
  std::mt19937_64 random(options.seed);
  std::normal_distribution<float> normal;
  Codebook codebook;
  codebook.id = CodebookId(1);
  codebook.descriptor_type = "sift";
  codebook.mean =
      Eigen::VectorXf::NullaryExpr(options.raw_dim, [&] { return 0.1f * normal(random); });
  codebook.projection = DescriptorMatrix::NullaryExpr(options.projected_dim, options.raw_dim,
                                                      [&] { return 0.1f * normal(random); });
  codebook.num_subspaces = options.num_subspaces;
  codebook.words.resize(Codebook::kNumWords * options.projected_dim);
  std::generate(codebook.words.begin(), codebook.words.end(), [&] { return normal(random); });
  for (int i = 1; i <= 19; ++i) {
    codebook.same_landmark_distance_quantiles.push_back(0.1f * i);
    codebook.other_landmark_distance_quantiles.push_back(0.1f * i + 1.0f);
  }
  return codebook;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_TILE_BUILDER_H_
