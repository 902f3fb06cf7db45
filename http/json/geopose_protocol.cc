#include "http/json/geopose_protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/angles.h"
#include "core/error.h"
#include "core/images/exif.h"
#include "core/images/orient_image.h"
#include "core/images/photo_camera.h"
#include "core/wire/accept.h"
#include "core/wire/base64.h"
#include "core/wire/json_members.h"
#include "core/wire/multipart.h"
#include "core/wire/problem.h"
#include "core/wire/stated_camera.h"
#include "http/json/geopose_readings.h"
#include "http/json/image_orientation.h"

namespace cairn {
namespace {

constexpr char kMediaType[] = "application/vnd.oscp+json";
constexpr char kJsonMediaType[] = "application/json";
constexpr char kOgcMediaType[] = "application/geopose+json";
// Pictures of a rig must be taken within this time of each other.
constexpr double kMaxRigDelayMs = 10.0;

// Browser clients send data URLs.
std::string_view WithoutDataUrlPrefix(std::string_view text) {
  constexpr std::string_view kMarker = ";base64,";
  if (!text.starts_with("data:")) {
    return text;
  }
  const size_t marker = text.substr(0, 128).find(kMarker);
  return marker == std::string_view::npos ? text : text.substr(marker + kMarker.size());
}

RequestImage ReadImage(const JsonReader& reading) {
  RequestImage sent;
  if (const auto format = reading.Find("imageFormat")) {
    sent.format = format->String(16);
  }
  const JsonReader image = reading.At("imageBytes");
  auto bytes = DecodeBase64OfClient(WithoutDataUrlPrefix(image.String()));
  if (!bytes || bytes->empty()) {
    image.Fail("is not an image in base64");
  }
  sent.bytes = std::move(*bytes);
  return sent;
}

// Returns nothing if the reading has no size: no member, no numbers, or zeros.
std::optional<ImageSize> StatedSize(const JsonReader& reading) {
  const auto size = reading.Find("size");
  if (!size) {
    return std::nullopt;
  }
  const std::vector<double> sides = size->Numbers(0, 2);
  const bool is_unset = std::all_of(sides.begin(), sides.end(), [](double s) { return s == 0.0; });
  return is_unset ? std::nullopt : std::optional(ReadImageSize(*size));
}

// The `model` member of `params`, unless it is marked unknown.
std::optional<JsonReader> StatedModel(const JsonReader& params) {
  const auto model = params.Find("model");
  if (!model) {
    return std::nullopt;
  }
  const std::string& name = model->String();
  const bool is_unknown = name.empty() || name == "UNKNOWN" || name == "UNKNOWN_CAMERA";
  return is_unknown ? std::nullopt : model;
}

std::optional<JsonReader> StatedParams(const JsonReader& params) {
  const auto numbers = params.Find("modelParams");
  return numbers && numbers->Numbers(0, 16).empty() ? std::nullopt : numbers;
}

// Sets how the image is turned (its EXIF may decide) and returns the size of the turned image.
ImageSize SettleSize(const JsonReader& reading, RequestImage* image) {
  const std::optional<ImageSize> stated = StatedSize(reading);
  const std::optional<PictureHeader> header = ReadPictureHeader(image->bytes);
  if (stated && !header) {
    return *stated;
  }
  if (!header) {
    reading.At("size").Fail("is missing, and the image data do not contain the size");
  }
  if (stated) {
    image->orientation =
        OrientationToApply(*header, ImageOrientation::kAsSize, stated->width_px, stated->height_px);
    return *stated;
  }
  image->orientation = ReadRotationDeg(reading) ? 1 : header->exif_orientation;
  ImageSize size{header->width_px, header->height_px};
  if (SwapsSides(image->orientation)) {
    std::swap(size.width_px, size.height_px);
  }
  return size;
}

// The camera from the reading; without parameters, from EXIF; without EXIF, unknown.
StatedCamera ReadCamera(const JsonReader& reading, RequestImage* image) {
  const ImageSize size = SettleSize(reading, image);
  std::optional<JsonReader> model, params;
  if (const auto members = reading.Find("params")) {
    model = StatedModel(*members);
    params = StatedParams(*members);
  }
  StatedCamera stated = ReadCameraParts(model, size, params);
  if (params) {
    return stated;
  }
  ExifInfo exif;
  try {
    exif = ReadExif(image->bytes);
  } catch (const Error&) {  // Raw pixels, or an image that does not decode.
  }
  PhotoCamera camera = CameraOfPhoto(exif, size.width_px, size.height_px);
  return {std::move(camera.camera), camera.focal};
}

// The id of the reading's sensor; empty if it has none.
std::string SensorIdOf(const JsonReader& reading) {
  const auto id = reading.Find("sensorId");
  return id ? id->String() : std::string();
}

bool IsPicture(const JsonReader& reading) {
  const auto format = reading.Find("imageFormat");
  return !format || format->String() != "DEPTH";
}

// Adds the pictures that other cameras on the first camera's rig took at the same time, one a
// camera.
void ReadOtherCameras(const JsonReader& request, const std::vector<JsonReader>& pictures,
                      LocalizeRequest* out) {
  const auto first_place = RigPlaceOf(request, pictures.front());
  if (!first_place || out->query.focal) {
    return;
  }
  const auto first_time_ms = TimeOf(pictures.front());
  std::set<std::string> used = {SensorIdOf(pictures.front())};
  for (const JsonReader& picture : pictures) {
    const auto place = RigPlaceOf(request, picture);
    const auto time_ms = TimeOf(picture);
    const bool is_late =
        first_time_ms && time_ms && std::abs(*time_ms - *first_time_ms) > kMaxRigDelayMs;
    const bool is_full = out->query.other_cameras.size() == RigCamera::kMaxOthers;
    if (!place || place->rig != first_place->rig || is_late || is_full) {
      continue;
    }
    if (used.contains(SensorIdOf(picture))) {
      continue;
    }
    RequestImage image = ReadImage(picture);
    StatedCamera stated = ReadCamera(picture, &image);
    if (stated.focal) {
      continue;  // Rigs need cameras with a known focal length.
    }
    used.insert(SensorIdOf(picture));
    out->query.other_cameras.push_back(
        {std::move(stated.camera),
         place->sensor_from_rig * first_place->sensor_from_rig.Inverse(),
         {}});
    out->images.push_back(std::move(image));
  }
}

void ReadCameras(const JsonReader& request, LocalizeRequest* out) {
  const JsonReader readings = request.At("sensorReadings").At("cameraReadings");
  std::vector<JsonReader> pictures = readings.Elements(1, kMaxReadings);
  std::erase_if(pictures, [](const JsonReader& reading) { return !IsPicture(reading); });
  if (pictures.empty()) {
    readings.Fail("has no picture: all readings have the format DEPTH");
  }
  const JsonReader& first = pictures.front();
  if (const auto rotation_deg = ReadRotationDeg(first)) {
    out->answer_from_cam = UprightFromSent(*rotation_deg);
  }
  RequestImage image = ReadImage(first);
  StatedCamera stated = ReadCamera(first, &image);
  out->query.camera = std::move(stated.camera);
  out->query.focal = stated.focal;
  out->images.push_back(std::move(image));
  ReadOtherCameras(request, pictures, out);
  out->query.prior = ReadGeoPosePrior(request, TimeOf(first));
  out->query.down_in_cam = ReadGeoPoseGravity(request, first);
}

// The pose of the answered camera as an OGC GeoPose.
nlohmann::ordered_json GeoPoseJson(const LocalizeResult& result, const LocalizeRequest& request) {
  const Rigid3d answer_from_cam(request.answer_from_cam, Eigen::Vector3d::Zero());
  const GeoPose geopose =
      GeoPoseFromCamera(answer_from_cam * result.cam_from_ecef, request.answer.inner_frame);
  return {{"position", GeodeticJson(geopose.position)},
          {"quaternion", QuaternionJson(geopose.enu_from_inner)}};
}

std::string Dump(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace

LocalizeRequest ParseGeoPoseRequest(std::string_view content_type, std::string_view body,
                                    const RequestLimits& limits) {
  const std::string media_type = MediaType(content_type);
  if (media_type != kJsonMediaType && media_type != kMediaType) {
    throw HttpError(ProblemCode::kUnsupportedMediaType, "the content type is not accepted")
        .Hint(fmt::format("send application/json or {}", kMediaType));
  }
  const JsonDocument document = ParseJson(body);
  const JsonReader json(document);
  LocalizeRequest request;
  request.picture.reset();  // ReadCameras settles the orientations.
  request.timeout_ms = limits.default_timeout_ms;
  if (const JsonReader readings = json.At("sensorReadings"); readings.IsArray()) {
    readings.Fail(
        "is an array, as in GeoPoseProtocol 1; this server speaks version 2",
        "version 2 groups the readings: {\"cameraReadings\": [...], \"geolocationReadings\": "
        "[...]}");
  }
  if (const auto id = json.Find("id")) {
    request.query.id = id->String(kMaxIdLength);
  }
  if (const auto timestamp = json.Find("timestamp")) {
    // Reference clients send fractions of milliseconds.
    request.timestamp_ms =
        static_cast<int64_t>(timestamp->Number(-kMaxExactInteger, kMaxExactInteger));
  }
  if (const auto type = json.Find("type"); type && type->String() != "geopose") {
    type->Fail("is not 'geopose'");
  }
  ReadCameras(json, &request);
  return request;
}

std::string GeoPoseResponseJson(const LocalizeResult& result, const LocalizeRequest& request) {
  nlohmann::ordered_json json = {{"id", request.query.id}};
  json["timestamp"] = request.timestamp_ms.value_or(0);
  json["type"] = "geopose";
  json["accuracy"] = {{"position", result.EarthAccuracyM()},
                      {"orientation", result.EarthAccuracyRad() * kDegPerRad}};
  json["geopose"] = GeoPoseJson(result, request);
  return Dump(json);
}

std::string OgcGeoPoseJson(const LocalizeResult& result, const LocalizeRequest& request) {
  return Dump(GeoPoseJson(result, request));
}

std::string GeoPoseContentType(std::string_view accept) {
  return Prefers(accept, kMediaType, kJsonMediaType) ? fmt::format("{};version=2.0", kMediaType)
                                                     : kJsonMediaType;
}

bool WantsOgcGeoPose(std::string_view accept) {
  return Prefers(accept, kOgcMediaType, kJsonMediaType);
}

}  // namespace cairn
