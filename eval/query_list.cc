// The query list format, specified in docs/formats/query_list_v1.md.
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/printable.h"
#include "core/wire/json_file.h"
#include "core/wire/json_members.h"
#include "core/wire/stated_camera.h"
#include "eval/eval_query.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "cairn query list";
constexpr int kVersion = 1;
constexpr uint64_t kMaxListBytes = uint64_t{64} << 20;

// A query has about 40 values.
constexpr JsonLimits kListLimits{.max_values = 8'000'000, .max_elements = 200'000};

// Runs a constructor that checks its arguments. Prefixes the position of `json` to an error
// message.
template <typename Make>
auto Checked(const JsonReader& json, const Make& make) {
  try {
    return make();
  } catch (const Error& error) {
    json.Fail(error.what());
  }
}

Camera ReadCamera(const JsonReader& json) {
  const std::vector<JsonReader> size = json.At("size").Elements(2, 2);
  const auto width_px = static_cast<int>(size[0].Integer(1, Camera::kMaxSidePx));
  const auto height_px = static_cast<int>(size[1].Integer(1, Camera::kMaxSidePx));
  const JsonReader model_json = json.At("model");
  const std::string& name = model_json.String();
  const CameraModel model = Checked(model_json, [&] { return CameraModelFromName(name); });
  const size_t num_params = NumCameraParams(model);
  const std::vector<double> params = json.At("modelParams").Numbers(num_params, num_params);
  return Checked(json, [&] { return Camera(model, width_px, height_px, params); });
}

Rigid3d ReadReference(const JsonReader& json) {
  constexpr double kTolerance = 1e-3;
  const Rigid3d enu_from_cam(ReadQuaternion(json.At("quaternion"), kTolerance),
                             Eigen::Vector3d::Zero());
  return (EcefFromEnu(ReadGeodetic(json.At("position"))) * enu_from_cam).Inverse();
}

PositionPrior ReadPrior(const JsonReader& json) {
  PositionPrior prior;
  prior.position = ReadGeodetic(json.At("position"));
  prior.accuracy_m = json.At("accuracy").Number();
  if (const auto altitude_accuracy = json.Find("altitudeAccuracy")) {
    prior.height_sigma_m = altitude_accuracy->Number();
  }
  return prior;
}

std::string ReadPath(const JsonReader& json, const fs::path& folder) {
  if (json.String().empty()) {
    json.Fail("is empty");
  }
  return (folder / json.String()).lexically_normal().string();
}

EvalQuery ReadQuery(const JsonReader& json, const fs::path& folder) {
  EvalQuery query;
  query.name = json.At("name").String();
  query.query.id = query.name;
  if (const auto features = json.Find("features")) {
    query.features_path = ReadPath(*features, folder);
  }
  if (json.Has("image") || !json.Has("features")) {
    query.image_path = ReadPath(json.At("image"), folder);
  }
  query.query.camera = ReadCamera(json.At("camera"));
  query.cam_from_ecef = ReadReference(json.At("reference"));
  if (const auto prior = json.Find("prior")) {
    query.query.prior = ReadPrior(*prior);
  }
  if (const auto gravity = json.Find("gravity")) {
    query.query.down_in_cam = ReadVector(*gravity);
  }
  Checked(json, [&] { query.query.Validate(); });
  return query;
}

std::vector<EvalQuery> ReadQueries(const JsonReader& root, const fs::path& folder) {
  const JsonReader format = root.At("format");
  if (format.String() != kFormat) {
    format.Fail(fmt::format("is '{}', not '{}'", Excerpt(format.String()), kFormat));
  }
  const JsonReader version = root.At("version");
  if (const int64_t number = version.Integer(0, kMaxExactInteger); number != kVersion) {
    version.Fail(fmt::format("is {}, but this version of Cairn reads {}", number, kVersion));
  }
  std::vector<EvalQuery> queries;
  for (const JsonReader& query : root.At("queries").Elements(0, kListLimits.max_elements)) {
    queries.push_back(ReadQuery(query, folder));
  }
  return queries;
}

nlohmann::json QueryAsJson(const EvalQuery& query, const fs::path& folder) {
  const Rigid3d ecef_from_cam = query.cam_from_ecef.Inverse();
  const Geodetic position = GeodeticFromEcef(ecef_from_cam.translation);
  const Eigen::Quaterniond enu_from_cam =
      (EcefFromEnu(position).Inverse() * ecef_from_cam).rotation.normalized();
  nlohmann::json json = {
      {"name", query.name},
      {"camera", CameraJson(query.query.camera)},
      {"reference",
       {{"position", GeodeticJson(position)}, {"quaternion", QuaternionJson(enu_from_cam)}}}};
  const auto add_path = [&](const char* key, const std::string& path) {
    if (!path.empty()) {
      json[key] = fs::absolute(path).lexically_proximate(folder).generic_string();
    }
  };
  add_path("image", query.image_path);
  add_path("features", query.features_path);
  if (const auto& prior = query.query.prior) {
    json["prior"] = {{"position", GeodeticJson(prior->position)}, {"accuracy", prior->accuracy_m}};
    if (prior->height_sigma_m) {
      json["prior"]["altitudeAccuracy"] = *prior->height_sigma_m;
    }
  }
  if (const auto& down = query.query.down_in_cam) {
    json["gravity"] = VectorJson(*down);
  }
  return json;
}

}  // namespace

std::vector<EvalQuery> ReadQueryList(const std::string& path) {
  return ReadJsonFile(path, kMaxListBytes, kListLimits, [&](const JsonReader& json) {
    return ReadQueries(json, fs::path(path).parent_path());
  });
}

void WriteQueryList(const std::string& path, const std::vector<EvalQuery>& queries) {
  const fs::path folder = fs::absolute(path).parent_path();
  nlohmann::json list = nlohmann::json::array();
  for (const EvalQuery& query : queries) {
    list.push_back(QueryAsJson(query, folder));
  }
  const nlohmann::json json = {
      {"format", kFormat}, {"version", kVersion}, {"queries", std::move(list)}};
  WriteTextFile(path, json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + '\n');
}

}  // namespace cairn
