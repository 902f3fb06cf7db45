#include "ingest/maps/plan_json.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <type_traits>
#include <utility>

#include "core/error.h"
#include "core/printable.h"
#include "ingest/ingest_option_visit.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "cairn plan";
constexpr int kFormatVersion = 1;

[[noreturn]] void Refuse(const std::string& what) { throw Error(ErrorCode::kBadInput, what); }

// JSON has no infinite numbers.
Json NumberJson(double number) {
  if (std::isinf(number)) {
    return number > 0.0 ? "infinity" : "-infinity";
  }
  return number;
}

double NumberFromJson(const Json& json) {
  if (json == "infinity" || json == "-infinity") {
    const double infinity = std::numeric_limits<double>::infinity();
    return json == "infinity" ? infinity : -infinity;
  }
  return json.get<double>();
}

template <typename T>
Json ValueJson(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    return static_cast<int64_t>(value);
  } else if constexpr (std::is_floating_point_v<T>) {
    return NumberJson(value);
  } else {
    return value;
  }
}

// Reads a whole number and refuses one that the type cannot hold.
template <typename T>
T WholeFromJson(const Json& json) {
  if (!json.is_number_integer() && !json.is_number_unsigned()) {
    Refuse("expected a whole number");
  }
  const auto value = json.get<T>();
  if (Json(value) != json) {
    Refuse("a whole number is out of range");
  }
  return value;
}

template <typename T>
void ReadValue(const Json& json, T* value) {
  if constexpr (std::is_enum_v<T>) {
    const auto number = WholeFromJson<int>(json);
    if (number < 0 || number > 2) {  // Those that do not exist are refused by Validate or unused.
      Refuse("a choice is out of range");
    }
    *value = static_cast<T>(number);
  } else if constexpr (std::is_floating_point_v<T>) {
    *value = NumberFromJson(json);
  } else {
    *value = WholeFromJson<T>(json);
  }
}

template <typename Id>
Id IdFromJson(const Json& json) {
  const auto value = WholeFromJson<std::underlying_type_t<Id>>(json);
  if (value > std::underlying_type_t<Id>{1} << 62) {
    Refuse("an id is out of range");
  }
  return Id(value);
}

// Writes options as members whose names have the section before a dot: "linking.max_ratio".
class OptionsWriter {
 public:
  OptionsWriter(std::string prefix, Json* json) : prefix_(std::move(prefix)), json_(*json) {}

  template <typename T>
  void Visit(std::string_view name, const T& value, const OptionRange&, std::string_view) const {
    json_[fmt::format("{}{}", prefix_, name)] = ValueJson(value);
  }
  template <typename Options>
  void Section(std::string_view name, const Options& options, std::string_view) const {
    VisitOptions(options, OptionsWriter(fmt::format("{}.", name), &json_));
  }

 private:
  std::string prefix_;
  Json& json_;
};

// Reads what OptionsWriter writes.
class OptionsReader {
 public:
  OptionsReader(std::string prefix, const Json* json) : prefix_(std::move(prefix)), json_(*json) {}

  template <typename T>
  void Visit(std::string_view name, T& value, const OptionRange&, std::string_view) const {
    ReadValue(json_.at(fmt::format("{}{}", prefix_, name)), &value);
  }
  template <typename Options>
  void Section(std::string_view name, Options& options, std::string_view) const {
    VisitOptions(options, OptionsReader(fmt::format("{}.", name), &json_));
  }

 private:
  std::string prefix_;
  const Json& json_;
};

Json OptionsJson(const TileOptions& options) {
  Json json = Json::object();
  VisitOptions(options, OptionsWriter("", &json));
  return json;
}

TileOptions OptionsFromJson(const Json& json) {
  TileOptions options;
  VisitOptions(options, OptionsReader("", &json));
  if (options.joining > SessionJoining::kApart ||
      options.selection.kind > LandmarkSelectionKind::kCoverage) {
    Refuse("a choice is out of range");
  }
  options.Validate();
  return options;
}

Json SessionJson(const SessionRecord& session) {
  Json json = {{"id", Value(session.id)},
               {"name", session.name},
               {"source", session.source},
               {"recordedAt", session.recorded_at},
               {"contentDigest", session.content_digest},
               {"images", session.num_images},
               {"landmarks", session.num_landmarks},
               {"georefMedianResidualM", NumberJson(session.georef_median_residual_m)}};
  if (session.accuracy) {
    json["accuracy"] = {{"inMapM", NumberJson(session.accuracy->in_map_m)},
                        {"onEarthM", NumberJson(session.accuracy->on_earth_m)},
                        {"onEarthRad", NumberJson(session.accuracy->on_earth_rad)}};
  }
  return json;
}

SessionRecord SessionFromJson(const Json& json) {
  SessionRecord session;
  session.id = IdFromJson<SessionId>(json.at("id"));
  session.name = json.at("name").get<std::string>();
  session.source = json.at("source").get<std::string>();
  session.recorded_at = json.at("recordedAt").get<std::string>();
  session.content_digest = json.at("contentDigest").get<std::string>();
  session.num_images = WholeFromJson<int64_t>(json.at("images"));
  session.num_landmarks = WholeFromJson<int64_t>(json.at("landmarks"));
  session.georef_median_residual_m = NumberFromJson(json.at("georefMedianResidualM"));
  if (const auto accuracy = json.find("accuracy"); accuracy != json.end()) {
    session.accuracy = {NumberFromJson(accuracy->at("inMapM")),
                        NumberFromJson(accuracy->at("onEarthM")),
                        NumberFromJson(accuracy->at("onEarthRad"))};
  }
  return session;
}

Json IdsJson(const SessionPlan& plan) {
  const auto range = [](auto first, auto count) {
    return Json{{"first", Value(first)}, {"count", count}};
  };
  return {{"codebooks", range(plan.first_ids.codebook, plan.id_counts.num_codebooks)},
          {"sessions", range(plan.first_ids.session, plan.id_counts.num_sessions)},
          {"keyframes", range(plan.first_ids.keyframe, plan.id_counts.num_keyframes)},
          {"landmarks", range(plan.first_ids.landmark, plan.id_counts.num_landmarks)}};
}

template <typename Id, typename Count>
void ReadRange(const Json& json, Id* first, Count* count) {
  *first = IdFromJson<Id>(json.at("first"));
  *count = WholeFromJson<Count>(json.at("count"));
  if (*count < Count{0} || *count > Count{1} << 48) {
    Refuse("a number of ids is out of range");
  }
}

void ReadIds(const Json& json, SessionPlan* plan) {
  ReadRange(json.at("codebooks"), &plan->first_ids.codebook, &plan->id_counts.num_codebooks);
  ReadRange(json.at("sessions"), &plan->first_ids.session, &plan->id_counts.num_sessions);
  ReadRange(json.at("keyframes"), &plan->first_ids.keyframe, &plan->id_counts.num_keyframes);
  ReadRange(json.at("landmarks"), &plan->first_ids.landmark, &plan->id_counts.num_landmarks);
}

Json ComparisonJson(const MapComparison& comparison) {
  return {{"photosExpected", comparison.num_expected},
          {"photosRecognized", comparison.num_localized},
          {"photosSought", comparison.num_sought},
          {"photosFound", comparison.num_found},
          {"photosFromBehind", comparison.num_from_behind},
          {"photosExpectedAfter", comparison.num_expected_after},
          {"photosAgreeingAfter", comparison.num_agreeing_after},
          {"photosAgreeing", comparison.fit.num_agreeing},
          {"movedM", NumberJson(comparison.fit.moved_m)},
          {"raisedM", NumberJson(comparison.fit.raised_m)},
          {"turnedRad", NumberJson(comparison.fit.turned_rad)},
          {"scale", NumberJson(comparison.fit.scale)},
          {"medianResidualM", NumberJson(comparison.fit.median_residual_m)}};
}

MapComparison ComparisonFromJson(const Json& json) {
  MapComparison comparison;
  comparison.num_expected = WholeFromJson<int>(json.at("photosExpected"));
  comparison.num_localized = WholeFromJson<int>(json.at("photosRecognized"));
  comparison.num_sought = WholeFromJson<int>(json.at("photosSought"));
  comparison.num_found = WholeFromJson<int>(json.at("photosFound"));
  comparison.num_from_behind = WholeFromJson<int>(json.at("photosFromBehind"));
  comparison.num_expected_after = WholeFromJson<int>(json.at("photosExpectedAfter"));
  comparison.num_agreeing_after = WholeFromJson<int>(json.at("photosAgreeingAfter"));
  comparison.fit.num_agreeing = WholeFromJson<int>(json.at("photosAgreeing"));
  comparison.fit.moved_m = NumberFromJson(json.at("movedM"));
  comparison.fit.raised_m = NumberFromJson(json.at("raisedM"));
  comparison.fit.turned_rad = NumberFromJson(json.at("turnedRad"));
  comparison.fit.scale = NumberFromJson(json.at("scale"));
  comparison.fit.median_residual_m = NumberFromJson(json.at("medianResidualM"));
  return comparison;
}

Json TilesJson(const PlanManifest& manifest) {
  Json tiles = Json::array();
  for (size_t i = 0; i < manifest.plan.tiles.size(); ++i) {
    const PlannedTile& tile = manifest.plan.tiles[i];
    tiles.push_back({{"tile", tile.tile_id.ToString()},
                     {"base", tile.base_digest},
                     {"shard", manifest.shard_digests[i]},
                     {"firstKeyframe", Value(tile.first_keyframe)},
                     {"keyframes", tile.num_keyframes},
                     {"work", tile.work}});
  }
  return tiles;
}

void ReadTiles(const Json& json, PlanManifest* manifest) {
  for (const Json& entry : json) {
    PlannedTile tile;
    tile.tile_id = TileId::Parse(entry.at("tile").get<std::string>());
    tile.base_digest = entry.at("base").get<std::string>();
    tile.first_keyframe = IdFromJson<KeyframeId>(entry.at("firstKeyframe"));
    tile.num_keyframes = WholeFromJson<int64_t>(entry.at("keyframes"));
    tile.work = WholeFromJson<int64_t>(entry.at("work"));
    std::vector<PlannedTile>& tiles = manifest->plan.tiles;
    if (!tiles.empty() && tiles.back().tile_id >= tile.tile_id) {
      Refuse("the tiles are not in the order of their ids");
    }
    tiles.push_back(std::move(tile));
    manifest->shard_digests.push_back(entry.at("shard").get<std::string>());
  }
}

Json TimesJson(const SessionTimes& times) {
  Json json = Json::array();
  for (const auto& [session_id, years] : times) {
    json.push_back({Value(session_id), NumberJson(years)});
  }
  return json;
}

void RequireThisProgram(const Json& json) {
  if (!json.is_object() || json.value("format", Json()) != kFormat) {
    Refuse("is no manifest of a plan");
  }
  if (json.at("formatVersion") != kFormatVersion || json.at("cairn") != CAIRN_VERSION) {
    Refuse(fmt::format("was made by Cairn {}, this is Cairn " CAIRN_VERSION
                       "; use one version for plan, build-tiles and publish",
                       Excerpt(json.at("cairn").get<std::string>())));
  }
}

PlanManifest Read(const Json& json) {
  RequireThisProgram(json);
  PlanManifest manifest;
  SessionPlan& plan = manifest.plan;
  manifest.map_path = json.at("map").at("path").get<std::string>();
  plan.map_created_at = json.at("map").at("createdAt").get<std::string>();
  plan.base_version = IdFromJson<MapVersion>(json.at("map").at("version"));
  plan.session = SessionFromJson(json.at("session"));
  plan.replaced_session = IdFromJson<SessionId>(json.at("replacedSession"));
  plan.is_unchanged = json.at("unchanged").get<bool>();
  auto codebook = std::make_shared<Codebook>();
  codebook->id = IdFromJson<CodebookId>(json.at("codebook").at("id"));
  plan.codebook = std::move(codebook);
  plan.adds_codebook = json.at("codebook").at("isNew").get<bool>();
  manifest.codebook_digest = json.at("codebook").at("digest").get<std::string>();
  ReadIds(json.at("ids"), &plan);
  plan.options = OptionsFromJson(json.at("options"));
  plan.gate.max_lost_share = NumberFromJson(json.at("gate").at("maxLostShare"));
  plan.gate.Validate();
  for (const Json& time : json.at("sessionTimes")) {
    plan.session_times[IdFromJson<SessionId>(time.at(0))] = NumberFromJson(time.at(1));
  }
  plan.comparison = ComparisonFromJson(json.at("comparison"));
  plan.num_landmarks_dropped = WholeFromJson<int64_t>(json.at("landmarksDropped"));
  ReadTiles(json.at("tiles"), &manifest);
  return manifest;
}

}  // namespace

std::string ManifestAsJson(const PlanManifest& manifest) {
  const SessionPlan& plan = manifest.plan;
  const Json json = {{"format", kFormat},
                     {"formatVersion", kFormatVersion},
                     {"cairn", CAIRN_VERSION},
                     {"map",
                      {{"path", manifest.map_path},
                       {"createdAt", plan.map_created_at},
                       {"version", Value(plan.base_version)}}},
                     {"session", SessionJson(plan.session)},
                     {"replacedSession", Value(plan.replaced_session)},
                     {"unchanged", plan.is_unchanged},
                     {"codebook",
                      {{"id", plan.codebook ? Value(plan.codebook->id) : 0},
                       {"isNew", plan.adds_codebook},
                       {"digest", manifest.codebook_digest}}},
                     {"ids", IdsJson(plan)},
                     {"options", OptionsJson(plan.options)},
                     {"gate", {{"maxLostShare", NumberJson(plan.gate.max_lost_share)}}},
                     {"sessionTimes", TimesJson(plan.session_times)},
                     {"comparison", ComparisonJson(plan.comparison)},
                     {"landmarksDropped", plan.num_landmarks_dropped},
                     {"tiles", TilesJson(manifest)}};
  return json.dump(1, ' ', true, Json::error_handler_t::replace) + "\n";
}

PlanManifest ManifestFromJson(std::string_view json) {
  try {
    return Read(Json::parse(json));
  } catch (const nlohmann::json::exception& error) {
    Refuse(fmt::format("is no manifest of a plan: {}", Excerpt(error.what())));
  } catch (const Error& error) {
    throw Error(ErrorCode::kBadInput, error.what());
  }
}

}  // namespace cairn
