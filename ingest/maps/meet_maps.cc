#include "ingest/maps/meet_maps.h"

#include <algorithm>
#include <map>
#include <memory>
#include <tuple>
#include <unordered_set>
#include <utility>

#include "core/error.h"
#include "core/evenly_of.h"
#include "core/geodesy.h"
#include "core/scene/reconstruction.h"
#include "ingest/place/keyframe_features.h"
#include "ingest/tiles/placed_session.h"

namespace cairn {
namespace {

// The keyframes of a map, or of a tile of it, in the form of a session.
struct MapAsSession {
  Reconstruction reconstruction;
  PlacedSession session;
  std::vector<std::pair<TileId, size_t>> keyframe_of_image;  // Tile and index in the tile.
};

// The records of a tile's keyframes, in the order of the tile.
std::vector<KeyframeRecord> RecordsOf(const Tile& tile, const MergeSource& map) {
  std::unordered_map<KeyframeId, KeyframeRecord> records;
  for (KeyframeRecord& record : map.KeyframesOfTile(tile.id)) {
    const KeyframeId id = record.id;
    records.emplace(id, std::move(record));
  }
  std::vector<KeyframeRecord> ordered;
  for (const TileKeyframe& keyframe : tile.keyframes) {
    const auto found = records.find(keyframe.id);
    if (found == records.end()) {
      throw Error(ErrorCode::kMapDamaged, map.path() + ": a keyframe of a tile is not in the map");
    }
    ordered.push_back(std::move(found->second));
  }
  return ordered;
}

// Adds a tile's keyframes as images without features.
void AddImages(const Tile& tile, const MergeSource& map, MapAsSession* view) {
  const std::vector<KeyframeRecord> records = RecordsOf(tile, map);
  for (size_t k = 0; k < tile.num_keyframes(); ++k) {
    const KeyframeRecord& record = records[k];
    const auto image_idx = static_cast<int>(view->reconstruction.images.size());
    ReconImage& image = view->reconstruction.images.emplace_back();
    image.name = record.image_name;
    image.camera_idx = static_cast<int>(view->reconstruction.cameras.size());
    view->reconstruction.cameras.push_back(record.camera);
    view->session.cam_from_ecef.push_back(record.cam_from_ecef);
    view->session.images_of_tile[tile.id].push_back(image_idx);
    view->session.observations_of_image.emplace_back();
    view->keyframe_of_image.emplace_back(tile.id, k);
  }
}

DescriptorMatrix DecodeAll(const Tile& tile, const DescriptorCodec& codec) {
  return codec.Decode(tile.codes.data(), static_cast<int>(tile.num_descriptors()));
}

// The tile as a session: its landmarks, and what its keyframes see of them.
MapAsSession ViewOf(const Tile& tile, const MergeSource& map, const DescriptorCodec& codec) {
  MapAsSession view;
  AddImages(tile, map, &view);
  const Rigid3d ecef_from_tile = EcefFromEnu(tile.id.Anchor());
  for (uint32_t i = 0; i < tile.num_landmarks(); ++i) {
    PlacedLandmark& landmark = view.session.landmarks.emplace_back();
    landmark.recon_idx = i;
    landmark.x_in_ecef = ecef_from_tile * tile.x_in_tile[i].cast<double>();
    landmark.sigma_m = SigmaFromCode(tile.sigma_codes[i]);
  }
  const DescriptorMatrix descriptors = DecodeAll(tile, codec);
  for (size_t k = 0; k < tile.num_keyframes(); ++k) {
    KeyframeFeatures seen =
        FeaturesOfKeyframe(tile, k, view.reconstruction.cameras[k], descriptors);
    for (size_t i = 0; i < seen.landmarks.size(); ++i) {
      view.session.observations_of_image[k].push_back({seen.landmarks[i], static_cast<int>(i)});
    }
    view.reconstruction.images[k].features = std::move(seen.features);
  }
  return view;
}

constexpr double kHalfDiagonalM = 0.71 * TileId::kSideM;

// A possible link between landmarks of two maps.
struct MapLink {
  float sq_distance = 0.0f;
  LandmarkId of_b{};
  LandmarkId of_a{};

  bool operator<(const MapLink& other) const {
    return std::tie(sq_distance, of_b, of_a) < std::tie(other.sq_distance, other.of_b, other.of_a);
  }
};

// The tiles of b that are near tiles of a; if there are none, some of all, evenly.
std::vector<TileId> TilesToCompare(const MergeSource& a, const MergeSource& b) {
  constexpr size_t kMaxFar = 12;
  std::vector<TileId> all, near;
  for (const TileId tile_id : b.TileIds()) {
    all.push_back(tile_id);
    if (!a.snapshot().FindTiles(BoxAround(tile_id.Anchor(), kHalfDiagonalM + kReachM)).empty()) {
      near.push_back(tile_id);
    }
  }
  return near.empty() ? EvenlyOf(all, kMaxFar) : near;
}

}  // namespace

MapComparison CompareMaps(const MergeSource& a, const MergeSource& b, int num_threads) {
  MapAsSession view;
  for (const TileId tile_id : TilesToCompare(a, b)) {
    AddImages(*b.LoadTile(tile_id), b, &view);
  }
  // Only the images that the map is asked for get features, so that memory is bounded.
  std::map<TileId, std::vector<int>> images_of_tile;
  const KnownTiles known(a.snapshot(), SessionId{}, a.tiles().memory());
  const PhotosToAsk photos = ChoosePhotos(view.session, known);
  for (const std::vector<int>* images :
       {&photos.expected, &photos.sought_near, &photos.sought_anywhere}) {
    for (const int image_idx : *images) {
      images_of_tile[view.keyframe_of_image[static_cast<size_t>(image_idx)].first].push_back(
          image_idx);
    }
  }
  const DescriptorCodec codec(a.codebook());
  for (const auto& [tile_id, images] : images_of_tile) {
    const std::shared_ptr<const Tile> tile = b.LoadTile(tile_id);
    const DescriptorMatrix descriptors = DecodeAll(*tile, codec);
    for (const int image_idx : images) {
      const auto idx = static_cast<size_t>(image_idx);
      view.reconstruction.images[idx].features =
          FeaturesOfKeyframe(*tile, view.keyframe_of_image[idx].second,
                             view.reconstruction.cameras[idx], descriptors)
              .features;
    }
  }
  return CompareWithMap(view.reconstruction, view.session, known,
                        {.may_bend = false, .num_threads = num_threads});
}

std::unordered_map<LandmarkId, LandmarkId> LinkMaps(const MergeSource& a, const MergeSource& b,
                                                    const std::vector<TileId>& tiles,
                                                    const DescriptorCodec& codec,
                                                    const LinkOptions& options) {
  std::vector<MapLink> possible;
  for (const TileId tile_id : tiles) {
    const std::shared_ptr<const Tile> known = a.LoadTile(tile_id);
    const std::shared_ptr<const Tile> fresh = b.LoadTile(tile_id);
    const MapAsSession view = ViewOf(*fresh, b, codec);
    for (const LinkProposal& proposal :
         ProposeLinks(view.reconstruction, view.session, *known, codec, options)) {
      possible.push_back(
          {proposal.sq_distance, fresh->landmark_ids[proposal.landmark_idx], proposal.known_id});
    }
  }
  std::sort(possible.begin(), possible.end());
  std::unordered_map<LandmarkId, LandmarkId> links;
  std::unordered_set<LandmarkId> taken;
  for (const MapLink& link : possible) {
    if (!links.contains(link.of_b) && taken.insert(link.of_a).second) {
      links.emplace(link.of_b, link.of_a);
    }
  }
  return links;
}

}  // namespace cairn
