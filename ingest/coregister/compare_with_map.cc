#include "ingest/coregister/compare_with_map.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/frames.h"
#include "core/geodesy.h"
#include "engine/localizer.h"
#include "ingest/tiling/near_view.h"
#include "storage/map/tile_cache.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

constexpr size_t kCacheBytes = size_t{512} << 20;
constexpr int kMaxQueries = 60;  // Photos that are localized, evenly over the session.
// Accuracy of the priors. A session that is misplaced by more is not found.
constexpr double kSearchRadiusM = 15.0;

// Images of the session that stand near a photo of the map which looks the same way.
std::vector<int> ImagesThatMapShouldKnow(const PlacedSession& session, const MapStore& map) {
  const MapSnapshot snapshot = map.Snapshot();
  const double cos_near = std::cos(kNearViewRad);
  std::vector<int> images;
  for (const auto& [tile_id, images_of_tile] : session.images_of_tile) {
    const std::optional<TileRecord> record = snapshot.FindTile(tile_id);
    if (!record) {
      continue;
    }
    const Tile tile = DecodeTile(snapshot.LoadPayload(record->payload_id));
    const Rigid3d tile_from_ecef = EcefFromEnu(tile_id.Anchor()).Inverse();
    for (const int image_idx : images_of_tile) {
      const Rigid3d tile_from_cam =
          tile_from_ecef * session.cam_from_ecef[static_cast<size_t>(image_idx)].Inverse();
      const Eigen::Vector3d axis = tile_from_cam.rotation * Eigen::Vector3d::UnitZ();
      const bool is_near =
          std::any_of(tile.keyframes.begin(), tile.keyframes.end(), [&](const TileKeyframe& known) {
            const Rigid3d known_pose = known.cam_from_tile.Inverse();
            return (known_pose.translation - tile_from_cam.translation).norm() <= kNearViewM &&
                   (known_pose.rotation * Eigen::Vector3d::UnitZ()).dot(axis) >= cos_near;
          });
      if (is_near) {
        images.push_back(image_idx);
      }
    }
  }
  return images;
}

std::vector<int> EvenlyOf(const std::vector<int>& all, int count) {
  if (static_cast<int>(all.size()) <= count) {
    return all;
  }
  std::vector<int> some;
  for (int i = 0; i < count; ++i) {
    some.push_back(all[all.size() * static_cast<size_t>(i) / static_cast<size_t>(count)]);
  }
  return some;
}

LocalizeQuery QueryOf(const Reconstruction& reconstruction, const PlacedSession& session,
                      int image_idx) {
  const ReconImage& image = reconstruction.images[static_cast<size_t>(image_idx)];
  const Rigid3d& cam_from_ecef = session.cam_from_ecef[static_cast<size_t>(image_idx)];
  LocalizeQuery query;
  query.id = image.name;
  query.camera = reconstruction.cameras[static_cast<size_t>(image.camera_idx)];
  query.features = image.features;
  PositionPrior prior;
  prior.position = GeodeticFromEcef(cam_from_ecef.Inverse().translation);
  prior.accuracy_m = kSearchRadiusM;
  query.prior = prior;
  query.down_in_cam =
      (cam_from_ecef.rotation * (EcefFromEnu(prior.position).rotation * DownInEnu())).normalized();
  return query;
}

}  // namespace

std::vector<int> ImagesToCompare(const PlacedSession& session, const MapStore& map) {
  return EvenlyOf(ImagesThatMapShouldKnow(session, map), kMaxQueries);
}

MapComparison CompareWithMap(const Reconstruction& reconstruction, const PlacedSession& session,
                             const MapStore& map) {
  const std::vector<int> images = ImagesToCompare(session, map);
  MapComparison comparison;
  comparison.num_expected = static_cast<int>(images.size());
  if (images.empty()) {
    return comparison;
  }
  // The store outlives the localizer, which wants to share it.
  const std::shared_ptr<const MapStore> shared(std::shared_ptr<const MapStore>(), &map);
  const std::shared_ptr<const Codebook> codebook = map.Snapshot().CurrentCodebook();
  const Localizer localizer(shared, std::make_shared<TileCache>(kCacheBytes), LocalizerOptions());
  std::vector<PosePair> pairs;
  for (const int image_idx : images) {
    LocalizeQuery query = QueryOf(reconstruction, session, image_idx);
    query.codec = codebook->CodecName();
    const LocalizeResult result = localizer.Localize(query);
    if (result.localized) {
      pairs.push_back(
          {session.cam_from_ecef[static_cast<size_t>(image_idx)], result.cam_from_ecef});
    }
  }
  comparison.num_localized = static_cast<int>(pairs.size());
  if (!pairs.empty()) {
    comparison.fit = FitPlacement(pairs, PlacementFitOptions());
  }
  return comparison;
}

}  // namespace cairn
