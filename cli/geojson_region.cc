#include "cli/geojson_region.h"

#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/file_bytes.h"
#include "core/printable.h"

namespace cairn {
namespace {

using Json = nlohmann::json;

constexpr int kMaxDepth = 20;
constexpr uint64_t kMaxBytes = uint64_t{64} << 20;

GeoPolygon ParsePolygon(const Json& coordinates) {
  GeoPolygon polygon;
  for (const Json& ring : coordinates) {
    polygon.emplace_back();
    for (const Json& corner : ring) {
      polygon.back().push_back({corner.at(0).get<double>(), corner.at(1).get<double>()});
    }
  }
  return polygon;
}

// Appends the polygons of any GeoJSON object.
void Collect(const Json& object, int depth, std::vector<GeoPolygon>* polygons) {
  const auto type = object.at("type").get<std::string>();
  if (depth > kMaxDepth) {
    throw Error(ErrorCode::kBadInput, "is nested too deeply");
  }
  if (type == "Polygon") {
    polygons->push_back(ParsePolygon(object.at("coordinates")));
  } else if (type == "MultiPolygon") {
    for (const Json& polygon : object.at("coordinates")) {
      polygons->push_back(ParsePolygon(polygon));
    }
  } else if (type == "Feature") {
    Collect(object.at("geometry"), depth + 1, polygons);
  } else if (type == "FeatureCollection" || type == "GeometryCollection") {
    const bool has_features = type == "FeatureCollection";
    for (const Json& part : object.at(has_features ? "features" : "geometries")) {
      Collect(part, depth + 1, polygons);
    }
  } else {
    throw Error(ErrorCode::kBadInput, "has a '" + Excerpt(type) + "', which is no polygon");
  }
}

}  // namespace

GeoRegion ReadGeoJsonRegion(const std::string& path) {
  const std::string text = ReadTextFile(path, kMaxBytes);
  try {
    std::vector<GeoPolygon> polygons;
    Collect(Json::parse(text), 0, &polygons);
    return GeoRegion::OfPolygons(std::move(polygons));
  } catch (const Json::exception& error) {
    throw Error(ErrorCode::kBadInput, path + ": is not GeoJSON: " + Excerpt(error.what()));
  } catch (const Error& error) {
    throw Error(error.code(), path + ": " + error.what());
  }
}

}  // namespace cairn
