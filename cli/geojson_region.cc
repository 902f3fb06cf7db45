#include "cli/geojson_region.h"

#include <cstdint>
#include <utility>
#include <vector>

#include "core/wire/json_file.h"

namespace cairn {
namespace {

constexpr uint64_t kMaxBytes = uint64_t{64} << 20;
constexpr size_t kMaxCorners =
    1 << 20;  // The largest number of corners, rings or polygons in one list.
constexpr JsonLimits kLimits{.max_values = 4'000'000, .max_elements = kMaxCorners};

GeoPolygon ReadPolygon(const JsonReader& coordinates) {
  constexpr size_t kMaxAxes = 4;  // Longitude, latitude, and values that are ignored.
  GeoPolygon polygon;
  for (const JsonReader& ring : coordinates.Elements(1, kMaxCorners)) {
    polygon.emplace_back();
    for (const JsonReader& corner : ring.Elements(3, kMaxCorners)) {
      const std::vector<double> axes = corner.Numbers(2, kMaxAxes);
      polygon.back().push_back({axes[0], axes[1]});
    }
  }
  return polygon;
}

// Appends the polygons of any GeoJSON object.
void Collect(const JsonReader& object, std::vector<GeoPolygon>* polygons) {
  const std::string& type = object.At("type").String();
  if (type == "Polygon") {
    polygons->push_back(ReadPolygon(object.At("coordinates")));
  } else if (type == "MultiPolygon") {
    for (const JsonReader& polygon : object.At("coordinates").Elements(1, kMaxCorners)) {
      polygons->push_back(ReadPolygon(polygon));
    }
  } else if (type == "Feature") {
    Collect(object.At("geometry"), polygons);
  } else if (type == "FeatureCollection" || type == "GeometryCollection") {
    const bool has_features = type == "FeatureCollection";
    for (const JsonReader& part :
         object.At(has_features ? "features" : "geometries").Elements(1, kMaxCorners)) {
      Collect(part, polygons);
    }
  } else {
    object.At("type").Fail("has to be a kind of polygon, a feature or a collection of them");
  }
}

}  // namespace

GeoRegion ReadGeoJsonRegion(const std::string& path) {
  return ReadJsonFile(path, kMaxBytes, kLimits, [](const JsonReader& json) {
    std::vector<GeoPolygon> polygons;
    Collect(json, &polygons);
    return GeoRegion::OfPolygons(std::move(polygons));
  });
}

}  // namespace cairn
