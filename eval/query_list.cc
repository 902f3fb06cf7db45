// The query list format, specified in docs/formats/query_list_v1.md.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/file_bytes.h"
#include "core/printable.h"
#include "eval/eval_query.h"

namespace cairn {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

constexpr const char* kFormat = "cairn query list";
constexpr int kVersion = 1;
constexpr uint64_t kMaxListBytes = uint64_t{64} << 20;

// A JSON value and its position in the document, for messages such as "queries.json:
// /queries/3/prior/accuracy: is missing".
class Field {
 public:
  Field(const std::string& file, std::string pointer, const Json& value)
      : file_(&file), pointer_(std::move(pointer)), value_(&value) {}

  [[noreturn]] void Fail(const std::string& what) const {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: {}: {}", *file_, pointer_.empty() ? "/" : pointer_, what));
  }

  bool Has(const char* key) const { return value_->is_object() && value_->contains(key); }

  Field At(const char* key) const {
    const Field child(*file_, pointer_ + "/" + key, *value_);
    if (!value_->is_object()) {
      Fail("must be an object");
    }
    const auto found = value_->find(key);
    if (found == value_->end()) {
      child.Fail("is missing");
    }
    return Field(*file_, child.pointer_, *found);
  }

  std::vector<Field> Elements() const {
    if (!value_->is_array()) {
      Fail("must be an array");
    }
    std::vector<Field> elements;
    for (size_t i = 0; i < value_->size(); ++i) {
      elements.emplace_back(*file_, fmt::format("{}/{}", pointer_, i), (*value_)[i]);
    }
    return elements;
  }

  std::vector<double> Numbers(size_t count) const {
    std::vector<double> numbers;
    for (const Field& element : Elements()) {
      numbers.push_back(element.Number());
    }
    if (numbers.size() != count) {
      Fail(fmt::format("must have {} numbers, has {}", count, numbers.size()));
    }
    return numbers;
  }

  double Number() const {
    if (!value_->is_number() || !std::isfinite(value_->get<double>())) {
      Fail("must be a finite number");
    }
    return value_->get<double>();
  }

  int Integer() const {
    constexpr double kMax = 1e9;
    const double number = Number();
    if (number != std::floor(number) || std::abs(number) > kMax) {
      Fail("must be a whole number");
    }
    return static_cast<int>(number);
  }

  std::string Text() const {
    if (!value_->is_string()) {
      Fail("must be a string");
    }
    return value_->get<std::string>();
  }

  // Runs a constructor that checks its arguments. Prefixes the field's position to an error
  // message.
  template <typename Make>
  auto Checked(const Make& make) const {
    try {
      return make();
    } catch (const Error& error) {
      Fail(error.what());
    }
  }

 private:
  const std::string* file_;
  std::string pointer_;
  const Json* value_;
};

Geodetic ReadPosition(const Field& field) {
  const double lat_deg = field.At("lat").Number(), lon_deg = field.At("lon").Number();
  const double h_m = field.At("h").Number();
  return field.Checked([&] {
    const Geodetic position = Geodetic::FromDegrees(lat_deg, lon_deg, h_m);
    ValidateGeodetic(position, "position");
    return position;
  });
}

Camera ReadCamera(const Field& field) {
  const std::vector<Field> size = field.At("size").Elements();
  if (size.size() != 2) {
    field.At("size").Fail("must be [width, height]");
  }
  const int width_px = size[0].Integer(), height_px = size[1].Integer();
  const Field model_field = field.At("model");
  const CameraModel model =
      model_field.Checked([&] { return CameraModelFromName(model_field.Text()); });
  const std::vector<double> params = field.At("modelParams").Numbers(NumCameraParams(model));
  return field.Checked([&] { return Camera(model, width_px, height_px, params); });
}

Rigid3d ReadReference(const Field& field) {
  const Geodetic position = ReadPosition(field.At("position"));
  const Field quaternion = field.At("quaternion");
  const Eigen::Quaterniond enu_from_cam(quaternion.At("w").Number(), quaternion.At("x").Number(),
                                        quaternion.At("y").Number(), quaternion.At("z").Number());
  if (std::abs(enu_from_cam.norm() - 1.0) > 1e-3) {
    quaternion.Fail(fmt::format("must be of unit length, is {}", enu_from_cam.norm()));
  }
  const Rigid3d enu_from_camera(enu_from_cam, Eigen::Vector3d::Zero());
  return (EcefFromEnu(position) * enu_from_camera).Inverse();
}

PositionPrior ReadPrior(const Field& field) {
  PositionPrior prior;
  prior.position = ReadPosition(field.At("position"));
  prior.accuracy_m = field.At("accuracy").Number();
  if (field.Has("altitudeAccuracy")) {
    prior.height_sigma_m = field.At("altitudeAccuracy").Number();
  }
  return prior;
}

std::string ReadPath(const Field& field, const fs::path& folder) {
  const std::string path = field.Text();
  if (path.empty()) {
    field.Fail("must not be empty");
  }
  return (folder / path).lexically_normal().string();
}

EvalQuery ReadQuery(const Field& field, const fs::path& folder) {
  EvalQuery query;
  query.name = field.At("name").Text();
  query.query.id = query.name;
  if (field.Has("features")) {
    query.features_path = ReadPath(field.At("features"), folder);
  }
  if (field.Has("image") || !field.Has("features")) {
    query.image_path = ReadPath(field.At("image"), folder);
  }
  query.query.camera = ReadCamera(field.At("camera"));
  query.cam_from_ecef = ReadReference(field.At("reference"));
  if (field.Has("prior")) {
    query.query.prior = ReadPrior(field.At("prior"));
  }
  if (field.Has("gravity")) {
    const std::vector<double> down = field.At("gravity").Numbers(3);
    query.query.down_in_cam = Eigen::Vector3d(down[0], down[1], down[2]);
  }
  field.Checked([&] {
    query.query.Validate();
    return true;
  });
  return query;
}

Json PositionAsJson(const Geodetic& position) {
  return {{"lat", position.lat_deg()}, {"lon", position.lon_deg()}, {"h", position.h_m}};
}

Json QueryAsJson(const EvalQuery& query, const fs::path& folder) {
  const Rigid3d ecef_from_cam = query.cam_from_ecef.Inverse();
  const Geodetic position = GeodeticFromEcef(ecef_from_cam.translation);
  const Eigen::Quaterniond enu_from_cam =
      (EcefFromEnu(position).Inverse() * ecef_from_cam).rotation.normalized();
  const Camera& camera = query.query.camera;
  Json json = {{"name", query.name},
               {"camera",
                {{"model", CameraModelName(camera.model())},
                 {"size", {camera.width_px(), camera.height_px()}},
                 {"modelParams", camera.params()}}},
               {"reference",
                {{"position", PositionAsJson(position)},
                 {"quaternion",
                  {{"x", enu_from_cam.x()},
                   {"y", enu_from_cam.y()},
                   {"z", enu_from_cam.z()},
                   {"w", enu_from_cam.w()}}}}}};
  const auto add_path = [&](const char* key, const std::string& path) {
    if (!path.empty()) {
      json[key] = fs::absolute(path).lexically_proximate(folder).generic_string();
    }
  };
  add_path("image", query.image_path);
  add_path("features", query.features_path);
  if (const auto& prior = query.query.prior) {
    json["prior"] = {{"position", PositionAsJson(prior->position)},
                     {"accuracy", prior->accuracy_m}};
    if (prior->height_sigma_m) {
      json["prior"]["altitudeAccuracy"] = *prior->height_sigma_m;
    }
  }
  if (const auto& down = query.query.down_in_cam) {
    json["gravity"] = {down->x(), down->y(), down->z()};
  }
  return json;
}

Json ParseFile(const std::string& path) {
  try {
    return Json::parse(ReadTextFile(path, kMaxListBytes));
  } catch (const Json::exception& exception) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: the file is not JSON: {}", path, Excerpt(exception.what(), 200)));
  }
}

}  // namespace

std::vector<EvalQuery> ReadQueryList(const std::string& path) {
  const Json json = ParseFile(path);
  const Field root(path, "", json);
  if (const std::string format = root.At("format").Text(); format != kFormat) {
    root.At("format").Fail(fmt::format("is '{}', not '{}'", Excerpt(format), kFormat));
  }
  if (const int version = root.At("version").Integer(); version != kVersion) {
    root.At("version").Fail(
        fmt::format("is {}, but this version of Cairn reads {}", version, kVersion));
  }
  const fs::path folder = fs::path(path).parent_path();
  std::vector<EvalQuery> queries;
  for (const Field& field : root.At("queries").Elements()) {
    queries.push_back(ReadQuery(field, folder));
  }
  return queries;
}

void WriteQueryList(const std::string& path, const std::vector<EvalQuery>& queries) {
  const fs::path folder = fs::absolute(path).parent_path();
  Json list = Json::array();
  for (const EvalQuery& query : queries) {
    list.push_back(QueryAsJson(query, folder));
  }
  const Json json = {{"format", kFormat}, {"version", kVersion}, {"queries", std::move(list)}};
  std::ofstream file(path, std::ios::binary);
  file << json.dump(1, ' ', false, Json::error_handler_t::replace) << '\n';
  if (!file.flush()) {
    throw Error(ErrorCode::kIo, path + ": cannot write");
  }
}

}  // namespace cairn
