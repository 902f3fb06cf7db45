#include "ingest/place/ask_keyframes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "core/evenly_of.h"
#include "core/frames.h"
#include "core/geodesy.h"
#include "core/parallel_for.h"
#include "engine/localizer.h"
#include "ingest/place/fit_placement.h"
#include "ingest/place/keyframe_features.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {
namespace {

constexpr double kNewsReachM = 60.0;  // The engine searches 50 m around a good prior.
constexpr int kLeastKeyframes = 12, kKeyframesOfTile = 2, kMostKeyframes = 200;
constexpr double kPriorAccuracyM = 15.0;

// Points in cells as wide as the reach.
class NearbyPoints {
 public:
  NearbyPoints(const std::vector<Eigen::Vector3d>& points, double reach_m) : reach_m_(reach_m) {
    for (const Eigen::Vector3d& point : points) {
      points_of_cell_[CellOf(point)].push_back(point);
    }
  }

  bool HasNear(const Eigen::Vector3d& place) const {
    const std::array<int64_t, 3> middle = CellOf(place);
    for (int i = 0; i < 27; ++i) {
      const auto found = points_of_cell_.find(
          {middle[0] + i % 3 - 1, middle[1] + i / 3 % 3 - 1, middle[2] + i / 9 - 1});
      if (found != points_of_cell_.end() &&
          std::any_of(found->second.begin(), found->second.end(),
                      [&](const auto& point) { return (point - place).norm() <= reach_m_; })) {
        return true;
      }
    }
    return false;
  }

 private:
  std::array<int64_t, 3> CellOf(const Eigen::Vector3d& at) const {
    const Eigen::Vector3d cell = (at / reach_m_).array().floor();
    return {static_cast<int64_t>(cell.x()), static_cast<int64_t>(cell.y()),
            static_cast<int64_t>(cell.z())};
  }

  double reach_m_;
  std::map<std::array<int64_t, 3>, std::vector<Eigen::Vector3d>> points_of_cell_;
};

Eigen::Vector3d CenterOf(const KeyframeRecord& keyframe) {
  return keyframe.cam_from_ecef.Inverse().translation;
}

// The features of keyframes, in the projected space of the map's codebook. Parallel to the
// keyframes; those that the tile does not have get no features.
std::vector<FeatureSet> FeaturesOf(const std::vector<KeyframeRecord>& keyframes,
                                   const RememberedTiles& map) {
  const DescriptorCodec codec(map.CurrentCodebook());
  std::map<TileId, std::vector<size_t>> keyframes_of_tile;
  for (size_t i = 0; i < keyframes.size(); ++i) {
    keyframes_of_tile[keyframes[i].tile_id].push_back(i);
  }
  std::vector<FeatureSet> features(keyframes.size());
  for (const auto& [tile_id, own] : keyframes_of_tile) {
    const std::shared_ptr<const Tile> known = map.Find(tile_id);
    if (known == nullptr || known->codebook_id != codec.codebook().id) {
      continue;
    }
    const Tile& tile = *known;
    const DescriptorMatrix descriptors =
        codec.Decode(tile.codes.data(), static_cast<int>(tile.num_descriptors()));
    for (const size_t i : own) {
      const auto found =
          std::find_if(tile.keyframes.begin(), tile.keyframes.end(),
                       [&](const TileKeyframe& seen) { return seen.id == keyframes[i].id; });
      if (found != tile.keyframes.end()) {
        features[i] = FeaturesOfKeyframe(tile, static_cast<size_t>(found - tile.keyframes.begin()),
                                         keyframes[i].camera, descriptors)
                          .features;
      }
    }
  }
  return features;
}

LocalizeQuery QueryAt(const Rigid3d& cam_from_ecef, const Camera& camera,
                      const FeatureSet& features) {
  LocalizeQuery query;
  query.camera = camera;
  query.features = features;
  query.prior.emplace();
  query.prior->position = GeodeticFromEcef(cam_from_ecef.Inverse().translation);
  query.prior->accuracy_m = kPriorAccuracyM;
  query.down_in_cam =
      (cam_from_ecef.rotation * (EcefFromEnu(query.prior->position).rotation * DownInEnu()))
          .normalized();
  return query;
}

// Whether each keyframe gets a right answer at its pose.
std::vector<char> AreRight(const std::vector<LocalizeQuery>& queries,
                           const std::vector<Rigid3d>& cam_from_ecef, const MapTiles& map,
                           TileMemory* memory, int num_threads) {
  const PlacementFitOptions right;
  const std::string codec = map.CurrentCodebook()->CodecName();
  const Localizer localizer(map, LocalizerOptions(), memory->searchable());
  std::vector<char> are_right(queries.size());
  ParallelFor(static_cast<int>(queries.size()), num_threads, [&](int i) {
    const auto idx = static_cast<size_t>(i);
    LocalizeQuery query = queries[idx];
    query.codec = codec;
    const LocalizeResult result = localizer.Localize(query);
    are_right[idx] =
        result.localized &&
        (result.cam_from_ecef.Inverse().translation - cam_from_ecef[idx].Inverse().translation)
                .norm() <= right.max_residual_m &&
        RotationAngleRad(result.cam_from_ecef.rotation, cam_from_ecef[idx].rotation) <=
            right.max_residual_rad;
  });
  return are_right;
}

}  // namespace

std::vector<KeyframeRecord> KeyframesNear(const MapSnapshot& map,
                                          const std::vector<Eigen::Vector3d>& news_in_ecef,
                                          const Sim3d& after_from_map, SessionId without) {
  std::set<TileId> tiles;
  const Sim3d map_from_after = after_from_map.Inverse();
  for (const Eigen::Vector3d& place : news_in_ecef) {
    for (const TileRecord& tile :
         map.FindTiles(BoxAround(GeodeticFromEcef(map_from_after * place), kNewsReachM))) {
      tiles.insert(tile.tile_id);
    }
  }
  const NearbyPoints news(news_in_ecef, kNewsReachM);
  std::vector<KeyframeRecord> all;
  int num_tiles = 0;
  for (const TileId tile_id : tiles) {
    const size_t before = all.size();
    for (KeyframeRecord& keyframe : map.KeyframesOfTile(tile_id)) {
      if (keyframe.session_id != without && news.HasNear(after_from_map * CenterOf(keyframe))) {
        all.push_back(std::move(keyframe));
      }
    }
    num_tiles += all.size() > before ? 1 : 0;
  }
  const auto most = static_cast<size_t>(
      std::clamp(kKeyframesOfTile * num_tiles, kLeastKeyframes, kMostKeyframes));
  return EvenlyOf(std::move(all), most);
}

KeyframeAnswers AskKeyframes(const std::vector<KeyframeRecord>& keyframes,
                             const RememberedTiles& before, const MapTiles& after,
                             const Sim3d& after_from_before, int num_threads) {
  KeyframeAnswers answers;
  if (keyframes.empty()) {
    return answers;
  }
  answers.num_asked = static_cast<int>(keyframes.size());
  const std::vector<FeatureSet> features = FeaturesOf(keyframes, before);
  std::vector<LocalizeQuery> queries;
  std::vector<Rigid3d> cam_from_ecef;
  for (size_t i = 0; i < keyframes.size(); ++i) {
    cam_from_ecef.push_back(CamFromTarget(keyframes[i].cam_from_ecef, after_from_before));
    queries.push_back(QueryAt(cam_from_ecef.back(), keyframes[i].camera, features[i]));
  }
  TileMemory* memory = before.memory().get();
  const std::vector<char> are_right_after =
      AreRight(queries, cam_from_ecef, after, memory, num_threads);
  std::vector<LocalizeQuery> doubtful;
  std::vector<Rigid3d> doubtful_cam_from_ecef;
  for (size_t i = 0; i < keyframes.size(); ++i) {
    if (!are_right_after[i]) {
      doubtful_cam_from_ecef.push_back(keyframes[i].cam_from_ecef);
      doubtful.push_back(QueryAt(keyframes[i].cam_from_ecef, keyframes[i].camera, features[i]));
    }
  }
  const std::vector<char> were_right =
      AreRight(doubtful, doubtful_cam_from_ecef, before, memory, num_threads);
  answers.num_lost = static_cast<int>(std::count(were_right.begin(), were_right.end(), 1));
  return answers;
}

}  // namespace cairn
