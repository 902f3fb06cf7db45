// Makes a small map that contains every kind of content, for tests of map tools.
#ifndef CAIRN_TESTS_SUPPORT_STREET_MAP_H_
#define CAIRN_TESTS_SUPPORT_STREET_MAP_H_

#include <string>

#include "core/camera.h"
#include "core/geodesy.h"
#include "storage/map/describe_tile.h"
#include "storage/map/map_store.h"
#include "support/map_builder.h"
#include "support/tile_builder.h"

namespace cairn::testing {

// Returns a level keyframe at a position, looking north.
inline KeyframeRecord KeyframeAt(const Geodetic& position, SessionId session_id) {
  KeyframeRecord keyframe;
  keyframe.session_id = session_id;
  keyframe.tile_id = TileId::Containing(position);
  keyframe.image_name = "images/0001.jpg";
  keyframe.camera =
      Camera(CameraModel::kSimpleRadial, 1241, 376, {718.8560001, 607.2, 185.2, -0.1});
  Eigen::Matrix3d cam_from_enu;
  cam_from_enu << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  keyframe.cam_from_ecef =
      Rigid3d(cam_from_enu, Eigen::Vector3d::Zero()) * EcefFromEnu(position).Inverse();
  return keyframe;
}

// Makes a map of two sessions along a street at 49.011 N, 8.416 E. The map has three tiles with 50
// landmarks and five keyframes each. Returns the path.
inline std::string MakeStreetMap(const std::string& path) {
  MapStore store = MapStore::Create(path);
  MapUpdate update = store.BeginUpdate();
  const CodebookId codebook_id = update.AddCodebook(RandomCodebook());
  const SessionId first = update.AddSession(NamedSession("first"));
  const SessionId second = update.AddSession(NamedSession("second"));
  for (int i = 0; i < 3; ++i) {
    const Geodetic place = Geodetic::FromDegrees(49.011, 8.416 + 0.0021 * i, 115.0);
    RandomTileOptions options;
    options.id = TileId::Containing(place);
    options.codebook_id = codebook_id;
    options.num_landmarks = 50;
    options.session_id = Value(i == 2 ? second : first);
    options.first_landmark_id = Value(update.ReserveLandmarkIds(50));
    options.seed = i;
    const KeyframeRecord keyframe = KeyframeAt(place, SessionId(options.session_id));
    for (int k = 0; k < options.num_keyframes; ++k) {
      const KeyframeId id = update.AddKeyframe(keyframe);
      options.first_keyframe_id = k == 0 ? Value(id) : options.first_keyframe_id;
    }
    Tile tile = RandomTile(options);
    for (TileKeyframe& in_tile : tile.keyframes) {
      in_tile.cam_from_tile = keyframe.cam_from_ecef * EcefFromEnu(tile.id.Anchor());
    }
    update.PutTile(DescribeTile(tile), EncodeTile(tile));
  }
  update.Publish();
  return path;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_STREET_MAP_H_
