#include "http/handlers/map_handlers.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "core/angles.h"
#include "core/cell_name.h"
#include "core/wire/problem.h"
#include "engine/tiles/search_region.h"
#include "http/handlers/compact_response.h"
#include "http/json/tile_square.h"
#include "http/json/version_json.h"
#include "storage/map/read_latest.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

constexpr int64_t kDefaultLimit = 1000;
constexpr int64_t kMaxLimit = 10'000;

std::optional<double> ParseNumber(std::string_view text) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) {
    return std::nullopt;
  }
  return number;
}

[[noreturn]] void RefuseParameter(const char* name, const std::string& detail) {
  throw HttpError(ProblemCode::kInvalidField,
                  fmt::format("the query parameter '{}' {}", name, detail));
}

double NumberInRange(const char* name, std::string_view text, double min, double max) {
  const std::optional<double> number = ParseNumber(text);
  if (!number || !(*number >= min && *number <= max)) {
    RefuseParameter(name, fmt::format("must be a number in [{}, {}]", min, max));
  }
  return *number;
}

const std::string* FindParameter(const HttpRequest& request, const char* name) {
  const auto it = request.query.find(name);
  return it == request.query.end() ? nullptr : &it->second;
}

double RequiredNumber(const HttpRequest& request, const char* name, double min, double max) {
  const std::string* text = FindParameter(request, name);
  if (text == nullptr) {
    RefuseParameter(name, "is missing");
  }
  return NumberInRange(name, *text, min, max);
}

int64_t Limit(const HttpRequest& request) {
  const std::string* text = FindParameter(request, "limit");
  return text == nullptr ? kDefaultLimit
                         : static_cast<int64_t>(NumberInRange("limit", *text, 1, kMaxLimit));
}

// Reads west,south,east,north in degrees, in the order of GeoJSON. West > east crosses the
// antimeridian.
std::optional<GeoBox> BoundingBox(const HttpRequest& request) {
  const std::string* text = FindParameter(request, "bbox");
  if (text == nullptr) {
    return std::nullopt;
  }
  double values[4];
  std::string_view rest = *text;
  for (int i = 0; i < 4; ++i) {
    const size_t comma = rest.find(',');
    const bool is_last = i == 3;
    if ((comma == std::string_view::npos) != is_last) {
      RefuseParameter("bbox", "must be west,south,east,north in degrees");
    }
    const double bound = i % 2 == 0 ? 180.0 : 90.0;
    values[i] = NumberInRange("bbox", rest.substr(0, comma), -bound, bound);
    rest.remove_prefix(is_last ? 0 : comma + 1);
  }
  if (values[1] > values[3]) {
    RefuseParameter("bbox", "has a south greater than its north");
  }
  return GeoBox{.south_rad = values[1] / kDegPerRad,
                .west_rad = values[0] / kDegPerRad,
                .north_rad = values[3] / kDegPerRad,
                .east_rad = values[2] / kDegPerRad};
}

TilePage FindTiles(const HttpRequest& request, const MapSnapshot& snapshot) {
  TilePageRequest page{.box = BoundingBox(request), .after = {}, .limit = Limit(request)};
  if (const std::string* after = FindParameter(request, "after")) {
    page.after = TileId::Parse(*after);
  }
  return snapshot.FindTilePage(page);
}

// Adds where the page stands in the list, and the version of the map.
void AddPosition(const TilePage& page, MapVersion version, Json* json) {
  (*json)["truncated"] = page.resume_after.has_value();
  if (page.resume_after) {
    (*json)["next"] = page.resume_after->ToString();
  }
  (*json)["map"] = {{"version", Value(version)}};
}

Json TileJson(const TileRecord& tile, const ServedMap& map) {
  return {{"id", tile.tile_id.ToString()},   {"etag", map.TileTag(tile)},
          {"landmarks", tile.num_landmarks}, {"descriptors", tile.num_descriptors},
          {"keyframes", tile.num_keyframes}, {"bytes", tile.num_bytes},
          {"minHeight", tile.min_h_m},       {"maxHeight", tile.max_h_m}};
}

TileRecord RequireTile(const std::string& id, const MapSnapshot& snapshot) {
  const std::optional<TileRecord> tile = snapshot.FindTile(TileId::Parse(id));
  if (!tile) {
    throw HttpError(ProblemCode::kNotFound, fmt::format("the map has no tile {}", id));
  }
  return *tile;
}

}  // namespace

HttpResponse HandleAvailability(const HttpRequest& request, const LocalizeService& service) {
  PositionPrior prior;
  prior.position = Geodetic::FromDegrees(RequiredNumber(request, "lat", -90.0, 90.0),
                                         RequiredNumber(request, "lon", -180.0, 180.0), 0.0);
  if (const std::string* accuracy = FindParameter(request, "accuracy")) {
    prior.accuracy_m = NumberInRange("accuracy", *accuracy, 1e-3, 1e5);
  }
  const std::shared_ptr<const ServedMap> map = service.map();
  const MapSnapshot snapshot = map->store().Snapshot();
  const SearchRegion region = RegionOfPrior(prior, map->localizer->options().prior);
  Json tiles = Json::array();
  for (const TileRecord& tile : snapshot.FindTiles(RegionBounds(region))) {
    tiles.push_back(tile.tile_id.ToString());
  }
  const std::shared_ptr<const Codebook> codebook = snapshot.CurrentCodebook();
  Json json = {{"available", !tiles.empty()},
               {"radius", region.radius_m},
               {"cell", CellName(prior.position)},
               {"tiles", std::move(tiles)},
               {"codec", codebook ? Json(codebook->CodecName()) : Json(nullptr)},
               {"map", {{"version", Value(snapshot.version())}}}};
  return HttpResponse::Json(json.dump());
}

HttpResponse HandleCoverage(const HttpRequest& request, LocalizeService* service) {
  const auto turn = service->WaitForTurn(request);
  const std::shared_ptr<const ServedMap> map = service->map();
  const MapSnapshot snapshot = map->store().Snapshot();
  const TilePage page = FindTiles(request, snapshot);
  Json features = Json::array();
  for (const TileRecord& tile : page.tiles) {
    Json properties = TileJson(tile, *map);
    properties.erase("id");
    features.push_back({{"type", "Feature"},
                        {"id", tile.tile_id.ToString()},
                        {"geometry", TileSquareJson(tile.tile_id)},
                        {"properties", std::move(properties)}});
  }
  Json json = {{"type", "FeatureCollection"}, {"features", std::move(features)}};
  AddPosition(page, snapshot.version(), &json);
  HttpResponse response = HttpResponse::Json(json.dump());
  response.content_type = "application/geo+json";
  return Compact(request, std::move(response));
}

HttpResponse HandleTiles(const HttpRequest& request, LocalizeService* service) {
  const auto turn = service->WaitForTurn(request);
  const std::shared_ptr<const ServedMap> map = service->map();
  const MapSnapshot snapshot = map->store().Snapshot();
  const TilePage page = FindTiles(request, snapshot);
  Json json = {{"tiles", Json::array()}};
  for (const TileRecord& tile : page.tiles) {
    json["tiles"].push_back(TileJson(tile, *map));
  }
  AddPosition(page, snapshot.version(), &json);
  return Compact(request, HttpResponse::Json(json.dump()));
}

HttpResponse HandleVersions(const HttpRequest& request, LocalizeService* service) {
  const auto turn = service->WaitForTurn(request);
  const auto limit = static_cast<size_t>(Limit(request));
  const std::shared_ptr<const ServedMap> map = service->map();
  const MapSnapshot snapshot = map->store().Snapshot();
  std::vector<VersionRecord> versions = snapshot.Versions(static_cast<int64_t>(limit) + 1);
  const bool truncated = versions.size() > limit;
  if (truncated) {
    versions.resize(limit);
  }
  Json list = Json::array();
  for (const VersionRecord& version : versions) {
    list.push_back(VersionJson(version));
  }
  Json json = {{"versions", std::move(list)},
               {"truncated", truncated},
               {"map", {{"version", Value(snapshot.version())}}}};
  return Compact(request,
                 HttpResponse::Json(json.dump(-1, ' ', false, Json::error_handler_t::replace)));
}

HttpResponse HandleTile(const HttpRequest& request, const std::string& id,
                        const LocalizeService& service) {
  const std::shared_ptr<const ServedMap> map = service.map();
  const TileRecord tile = RequireTile(id, map->store().Snapshot());
  const std::string tag = map->TileTag(tile);
  if (IsUnchanged(request, tag)) {
    return WithTag({.status = 304}, tag);
  }
  return WithTag(HttpResponse::Json(TileJson(tile, *map).dump()), tag);
}

HttpResponse HandleTilePayload(const HttpRequest& request, const std::string& id,
                               LocalizeService* service) {
  const auto turn = service->WaitForTurn(request);
  const std::shared_ptr<const ServedMap> map = service->map();
  return ReadLatest(map->store(), {}, [&](const MapSnapshot& snapshot) {
    const TileRecord tile = RequireTile(id, snapshot);
    const std::string tag = map->TileTag(tile);
    if (IsUnchanged(request, tag)) {
      return WithTag({.status = 304}, tag);
    }
    const LargeVector<uint8_t> payload = snapshot.LoadPayload(tile.payload_id);
    return WithTag({.status = 200,
                    .content_type = "application/octet-stream",
                    .body = std::string(payload.begin(), payload.end()),
                    .headers = {}},
                   tag);
  });
}

}  // namespace cairn
