#include "core/wire/wire_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/check.h"
#include "core/wire/json_members.h"
#include "core/wire/stated_camera.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

// The contents that `include` names. One table serves both directions.
struct Content {
  const char* name;
  bool ResponseOptions::*wanted;
};
constexpr Content kContents[] = {
    {"matches", &ResponseOptions::with_matches},
    {"timings", &ResponseOptions::with_timings},
    {"covariance", &ResponseOptions::with_covariance},
};

Json IncludeJson(const ResponseOptions& answer) {
  Json names = Json::array();
  for (const Content& content : kContents) {
    if (answer.*content.wanted) {
      names.push_back(content.name);
    }
  }
  return names;
}

void ReadInclude(const JsonReader& json, ResponseOptions* answer) {
  for (const Content& content : kContents) {
    answer->*content.wanted = false;
  }
  for (const JsonReader& element : json.Elements(0, 8)) {
    const auto* const content =
        std::find_if(std::begin(kContents), std::end(kContents),
                     [&](const Content& known) { return known.name == element.String(); });
    if (content == std::end(kContents)) {
      element.Fail("is unknown", "known: matches, timings, covariance");
    }
    answer->*content->wanted = true;
  }
}

Json OptionsJson(const WireRequest& request) {
  Json json = {{"innerFrame", InnerFrameName(request.answer.inner_frame)},
               {"maxMatches", request.answer.max_matches},
               {"include", IncludeJson(request.answer)}};
  if (request.timeout_ms) {
    json[kTimeoutMember] = *request.timeout_ms;
  }
  if (request.picture != ImageOrientation::kAsSize) {
    json["imageOrientation"] = ImageOrientationName(request.picture);
  }
  if (!request.exif_prior) {
    json["exifPrior"] = false;  // Older servers refuse the member, and have no such prior.
  }
  return json;
}

void ReadOptions(const JsonReader& json, WireRequest* request) {
  json.RequireOnly(
      {"innerFrame", kTimeoutMember, "maxMatches", "include", "imageOrientation", "exifPrior"});
  if (const auto name = json.Find("innerFrame")) {
    const std::optional<InnerFrame> frame = InnerFrameFromName(name->String());
    if (!frame) {
      name->Fail("is unknown", "known: FLU, RDF, RUB, EUS");
    }
    request->answer.inner_frame = *frame;
  }
  if (const auto timeout = json.Find(kTimeoutMember)) {
    request->timeout_ms = static_cast<int>(timeout->Integer(1, kMaxTimeoutMs));
  }
  if (const auto max_matches = json.Find("maxMatches")) {
    request->answer.max_matches = static_cast<int>(max_matches->Integer(0, kMaxMatches));
  }
  if (const auto name = json.Find("imageOrientation")) {
    const std::optional<ImageOrientation> picture = ImageOrientationFromName(name->String());
    if (!picture) {
      name->Fail("is unknown", "known: stored, upright");
    }
    request->picture = *picture;
  }
  if (const auto exif_prior = json.Find("exifPrior")) {
    request->exif_prior = exif_prior->Bool();
  }
  if (const auto include = json.Find("include")) {
    ReadInclude(*include, &request->answer);
  }
}

Json PriorJson(const PositionPrior& prior) {
  Json json = {{"position", GeodeticJson(prior.position)}, {"accuracy", prior.accuracy_m}};
  if (prior.height_sigma_m) {
    json["altitudeAccuracy"] = *prior.height_sigma_m;
  }
  return json;
}

PositionPrior ReadPrior(const JsonReader& json) {
  json.RequireOnly({"position", "accuracy", "altitudeAccuracy", "altitudeReference"});
  const JsonReader position = json.At("position");
  position.RequireOnly({"lat", "lon", "h"});
  PositionPrior prior;
  prior.position = ReadGeodetic(position.At("lat"), position.At("lon"), position.Find("h"));
  if (const auto reference = json.Find("altitudeReference")) {
    prior.position = WithEllipsoidalHeight(prior.position, ReadHeightReference(*reference));
  }
  if (const auto accuracy = json.Find("accuracy")) {
    prior.accuracy_m = accuracy->Number(1e-3, PositionPrior::kMaxAccuracyM);
  }
  if (const auto altitude_accuracy = json.Find("altitudeAccuracy")) {
    if (!position.Has("h")) {
      altitude_accuracy->Fail("needs the height position.h");
    }
    prior.height_sigma_m = altitude_accuracy->Number(1e-3, PositionPrior::kMaxAccuracyM);
  }
  return prior;
}

Eigen::Vector3d ReadGravity(const JsonReader& json) {
  const Eigen::Vector3d down = ReadVector(json);
  const double norm = down.norm();
  if (!(std::abs(norm - 1.0) <= kUnitNormTolerance)) {
    json.Fail(fmt::format("has length {}, not 1", norm),
              "send the unit vector that points down in the camera frame (x right, y down, "
              "z forward)");
  }
  return down / norm;
}

// Reads the request's own camera. In a rig, its focal length must also be known.
void ReadOwnCamera(const JsonReader& json, WireRequest* request) {
  if (!request->other_cameras.empty()) {
    request->camera = ReadKnownCamera(json);
    return;
  }
  StatedCamera stated = ReadStatedCamera(json);
  request->camera = std::move(stated.camera);
  request->focal = stated.focal;
}

}  // namespace

std::optional<ImageOrientation> ImageOrientationFromName(std::string_view name) {
  for (const ImageOrientation orientation :
       {ImageOrientation::kStored, ImageOrientation::kUpright}) {
    if (name == ImageOrientationName(orientation)) {
      return orientation;
    }
  }
  return std::nullopt;
}

const char* ImageOrientationName(ImageOrientation orientation) {
  CAIRN_CHECK(orientation != ImageOrientation::kAsSize, "kAsSize has no name");
  return orientation == ImageOrientation::kStored ? "stored" : "upright";
}

std::string WireRequestJson(const WireRequest& request) {
  Json json = Json::object();
  if (!request.id.empty()) {
    json["id"] = request.id;
  }
  if (request.timestamp_ms) {
    json["timestamp"] = *request.timestamp_ms;
  }
  json["camera"] = StatedCameraJson(request.camera, request.focal);
  for (const RigCamera& other : request.other_cameras) {
    json["rig"].push_back(RigCameraJson(other));
  }
  if (request.prior) {
    json["prior"] = PriorJson(*request.prior);
  }
  if (request.down_in_cam) {
    json["gravity"] = VectorJson(*request.down_in_cam);
  }
  json["options"] = OptionsJson(request);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

WireRequest ReadWireRequest(const JsonReader& json) {
  json.RequireOnly(
      {"id", "timestamp", "camera", "image", "features", "rig", "prior", "gravity", "options"});
  WireRequest request;
  if (const auto id = json.Find("id")) {
    request.id = id->String(kMaxIdLength);
  }
  if (const auto timestamp = json.Find("timestamp")) {
    request.timestamp_ms = timestamp->Integer(-kMaxExactInteger, kMaxExactInteger);
  }
  if (const auto rig = json.Find("rig")) {
    for (const JsonReader& element : rig->Elements(0, RigCamera::kMaxOthers)) {
      element.RequireOnly({"camera", "camFromFirst", "features", "image"});
      request.other_cameras.push_back(ReadRigCamera(element));
    }
  }
  ReadOwnCamera(json.At("camera"), &request);
  if (const auto prior = json.Find("prior")) {
    request.prior = ReadPrior(*prior);
  }
  if (const auto gravity = json.Find("gravity")) {
    request.down_in_cam = ReadGravity(*gravity);
  }
  if (const auto options = json.Find("options")) {
    ReadOptions(*options, &request);
  }
  return request;
}

}  // namespace cairn
