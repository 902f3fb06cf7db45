#include "cli/exports/export_geojson.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/angles.h"
#include "core/replace_file.h"
#include "http/json/tile_square.h"

namespace cairn {
namespace {

using GeoJson = nlohmann::ordered_json;

// A FeatureCollection, a feature a line.
class FeatureFile {
 public:
  explicit FeatureFile(const std::string& path) : file_(path) {
    file_.Write("{\"type\": \"FeatureCollection\", \"features\": [");
  }

  void Add(GeoJson geometry, GeoJson properties) {
    const GeoJson feature = {{"type", "Feature"},
                             {"geometry", std::move(geometry)},
                             {"properties", std::move(properties)}};
    file_.Write(num_features_++ == 0 ? "\n" : ",\n");
    file_.Write(feature.dump(-1, ' ', false, GeoJson::error_handler_t::replace));
  }

  int64_t Commit() {
    file_.Write("\n]}\n");
    file_.Commit();
    return num_features_;
  }

 private:
  FileReplacement file_;
  int64_t num_features_ = 0;
};

// GeoJSON has longitudes first. Nine digits are a tenth of a millimeter.
GeoJson Coordinates(const Geodetic& position) {
  const auto rounded = [](double value, double steps) { return std::round(value * steps) / steps; };
  return {rounded(position.lon_deg(), 1e9), rounded(position.lat_deg(), 1e9),
          rounded(position.h_m, 1e4)};
}

void ForEachTile(const MapSnapshot& map, const std::function<void(const TileRecord&)>& visit) {
  TilePageRequest request;
  do {
    const TilePage page = map.FindTilePage(request);
    for (const TileRecord& tile : page.tiles) {
      visit(tile);
    }
    request.after = page.resume_after;
  } while (request.after);
}

void AddKeyframeFeature(const KeyframeRecord& keyframe, const std::string& session,
                        FeatureFile* file) {
  const Rigid3d ecef_from_cam = keyframe.cam_from_ecef.Inverse();
  const Geodetic position = GeodeticFromEcef(ecef_from_cam.translation);
  const Eigen::Vector3d forward_in_enu = EcefFromEnu(position).rotation.conjugate() *
                                         (ecef_from_cam.rotation * Eigen::Vector3d::UnitZ());
  const double heading_deg = std::atan2(forward_in_enu.x(), forward_in_enu.y()) * kDegPerRad;
  const auto to_hundredths = [](double value) { return std::round(100.0 * value) / 100.0; };
  file->Add({{"type", "Point"}, {"coordinates", Coordinates(position)}},
            {{"image", keyframe.image_name},
             {"session", session},
             {"keyframe", Value(keyframe.id)},
             {"tile", keyframe.tile_id.ToString()},
             {"heading_deg", to_hundredths(heading_deg < 0.0 ? heading_deg + 360.0 : heading_deg)},
             {"pitch_deg",
              to_hundredths(std::asin(std::clamp(forward_in_enu.z(), -1.0, 1.0)) * kDegPerRad)}});
}

}  // namespace

int64_t ExportKeyframesGeoJson(const MapSnapshot& map, const std::optional<SessionId>& session,
                               const std::string& path) {
  std::map<SessionId, std::string> name_of_session;
  for (const SessionRecord& record : map.Sessions()) {
    name_of_session[record.id] = record.name;
  }
  FeatureFile file(path);
  ForEachTile(map, [&](const TileRecord& tile) {
    for (const KeyframeRecord& keyframe : map.KeyframesOfTile(tile.tile_id)) {
      if (!session || keyframe.session_id == *session) {
        AddKeyframeFeature(keyframe, name_of_session[keyframe.session_id], &file);
      }
    }
  });
  return file.Commit();
}

int64_t ExportCoverageGeoJson(const MapSnapshot& map, const std::string& path) {
  FeatureFile file(path);
  ForEachTile(map, [&](const TileRecord& tile) {
    file.Add(TileSquareJson(tile.tile_id), {{"tile", tile.tile_id.ToString()},
                                            {"landmarks", tile.num_landmarks},
                                            {"descriptors", tile.num_descriptors},
                                            {"keyframes", tile.num_keyframes},
                                            {"bytes", tile.num_bytes}});
  });
  return file.Commit();
}

}  // namespace cairn
