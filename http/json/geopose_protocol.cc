#include "http/json/geopose_protocol.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <utility>

#include "http/base64.h"
#include "http/json/stated_camera.h"
#include "http/multipart.h"
#include "http/problem.h"

namespace cairn {
namespace {

constexpr char kMediaType[] = "application/vnd.oscp+json";
constexpr double kUnknownAccuracyM = 25.0;
constexpr double kMaxAccuracyM = 100'000.0;
constexpr double kMaxHeightM = 1e5;
constexpr size_t kMaxReadings = 1000;
constexpr int64_t kMaxTimestampMs = int64_t{1} << 53;

PositionPrior ReadGeolocation(const JsonReader& reading) {
  PositionPrior prior;
  prior.position = Geodetic::FromDegrees(reading.At("latitude").Number(-90.0, 90.0),
                                         reading.At("longitude").Number(-180.0, 180.0), 0.0);
  const auto accuracy = reading.Find("accuracy");
  const double accuracy_m = accuracy ? accuracy->Number(0.0, kMaxAccuracyM) : 0.0;
  prior.accuracy_m = accuracy_m > 0.0 ? accuracy_m : kUnknownAccuracyM;
  const auto altitude = reading.Find("altitude");
  const auto altitude_accuracy = reading.Find("altitudeAccuracy");
  if (altitude) prior.position.h_m = altitude->Number(-kMaxHeightM / 10.0, kMaxHeightM);
  if (altitude && altitude_accuracy && altitude_accuracy->Number(0.0, kMaxAccuracyM) > 0.0) {
    prior.height_sigma_m = altitude_accuracy->Number(0.0, kMaxAccuracyM);
  }
  return prior;
}

// Clients in browsers send data URLs.
std::string_view WithoutDataUrlPrefix(std::string_view text) {
  constexpr std::string_view kMarker = ";base64,";
  if (!text.starts_with("data:")) return text;
  const size_t marker = text.substr(0, 128).find(kMarker);
  return marker == std::string_view::npos ? text : text.substr(marker + kMarker.size());
}

void ReadCameraReading(const JsonReader& reading, LocalizeRequest* request) {
  std::optional<JsonReader> model, model_params;
  if (const auto params = reading.Find("params")) {
    model = params->Find("model");
    model_params = params->Find("modelParams");
  }
  StatedCamera stated = ReadCameraParts(model, reading.At("size"), model_params);
  request->query.camera = std::move(stated.camera);
  request->query.focal = stated.focal;
  if (const auto orientation = reading.Find("imageOrientation")) {
    const auto mirrored = orientation->Find("mirrored");
    if (mirrored && mirrored->Bool()) {
      mirrored->Fail("is true: a mirrored image cannot be localized; send the camera's own pixels");
    }
  }
  RequestImage sent;
  if (const auto format = reading.Find("imageFormat")) {
    sent.format = format->String(16);
  }
  const JsonReader image = reading.At("imageBytes");
  auto bytes = DecodeBase64(WithoutDataUrlPrefix(image.String()));
  if (!bytes || bytes->empty()) image.Fail("is not the base64 of an image");
  sent.bytes = std::move(*bytes);
  request->images.push_back(std::move(sent));
}

}  // namespace

LocalizeRequest ParseGeoPoseRequest(std::string_view content_type, std::string_view body,
                                    const RequestLimits& limits) {
  const std::string media_type = MediaType(content_type);
  if (media_type != "application/json" && media_type != kMediaType) {
    throw HttpError(ProblemCode::kUnsupportedMediaType, "the content type is not accepted")
        .Hint(fmt::format("send application/json or {}", kMediaType));
  }
  const JsonDocument document = ParseJson(body);
  const JsonReader json(document);
  LocalizeRequest request;
  request.timeout_ms = limits.default_timeout_ms;
  if (const auto id = json.Find("id")) request.query.id = id->String(128);
  if (const auto timestamp = json.Find("timestamp")) {
    // Reference clients send fractions of milliseconds.
    request.timestamp_ms = static_cast<int64_t>(
        timestamp->Number(-static_cast<double>(kMaxTimestampMs), kMaxTimestampMs));
  }
  if (const auto type = json.Find("type"); type && type->String() != "geopose") {
    type->Fail("is not 'geopose'");
  }
  const JsonReader readings = json.At("sensorReadings");
  ReadCameraReading(readings.At("cameraReadings").Elements(1, kMaxReadings).front(), &request);
  if (const auto geolocations = readings.Find("geolocationReadings")) {
    const std::vector<JsonReader> elements = geolocations->Elements(0, kMaxReadings);
    if (!elements.empty()) request.query.prior = ReadGeolocation(elements.front());
  }
  return request;
}

std::string GeoPoseResponseJson(const LocalizeResult& result, const LocalizeRequest& request) {
  const GeoPose geopose = GeoPoseFromCamera(result.cam_from_ecef, request.answer.inner_frame);
  const Eigen::Quaterniond& q = geopose.enu_from_inner;
  nlohmann::ordered_json json = {{"id", request.query.id}};
  json["timestamp"] = request.timestamp_ms.value_or(0);
  json["type"] = "geopose";
  json["accuracy"] = {{"position", result.position_accuracy_m},
                      {"orientation", result.rotation_accuracy_rad * 180.0 / std::numbers::pi}};
  json["geopose"] = {{"position",
                      {{"lat", geopose.position.lat_deg()},
                       {"lon", geopose.position.lon_deg()},
                       {"h", geopose.position.h_m}}},
                     {"quaternion", {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}}}};
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string GeoPoseContentType(std::string_view accept) {
  return accept.find(kMediaType) != std::string_view::npos
             ? fmt::format("{};version=2.0", kMediaType)
             : "application/json";
}

}  // namespace cairn
