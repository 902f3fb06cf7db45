#include "http/json/localize_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "core/error.h"
#include "core/wire/feature_codec.h"
#include "core/wire/json_members.h"
#include "core/wire/multipart.h"
#include "core/wire/problem.h"
#include "http/json/part_encoding.h"

namespace cairn {
namespace {

// Decodes the features of one camera. `camera_pointer` points to the camera in the request.
WireFeatures DecodeFeaturesOf(const Camera& camera, const std::string& camera_pointer,
                              std::span<const uint8_t> blob, int max_features) {
  WireFeatures wire = DecodeFeatures(blob, max_features);
  if (wire.width_px != camera.width_px() || wire.height_px != camera.height_px()) {
    throw HttpError(
        ProblemCode::kInvalidFeatures,
        fmt::format("the features come from an image of {} x {} pixels, but the camera's "
                    "images are {} x {}",
                    wire.width_px, wire.height_px, camera.width_px(), camera.height_px()))
        .At(camera_pointer + "/size");
  }
  return wire;
}

void SetFeatures(std::span<const uint8_t> blob, int max_features, LocalizeRequest* request) {
  WireFeatures wire = DecodeFeaturesOf(request->query.camera, "/camera", blob, max_features);
  request->query.codec = std::move(wire.codec);
  request->query.features = std::move(wire.features);
}

// Sets the features of rig[index]. Call it after the query's own features have been set.
void SetRigFeatures(std::span<const uint8_t> blob, size_t index, int max_features,
                    LocalizeRequest* request) {
  LocalizeQuery& query = request->query;
  RigCamera& other = query.other_cameras[index];
  const std::string pointer = fmt::format("/rig/{}", index);
  WireFeatures wire = DecodeFeaturesOf(other.camera, pointer + "/camera", blob, max_features);
  if (wire.codec != query.codec) {
    throw HttpError(
        ProblemCode::kWrongCodec,
        fmt::format("the features have codec '{}', but those of the first camera have '{}'",
                    wire.codec, query.codec))
        .At(pointer + "/features");
  }
  other.features = std::move(wire.features);
  if (query.num_features() > max_features) {
    throw HttpError(
        ProblemCode::kTooManyFeatures,
        fmt::format("the cameras of the rig together have more than {} features", max_features))
        .At(pointer + "/features");
  }
}

// JSON members that describe the features must agree with the blob.
void CheckFeatureMembers(const JsonReader& json, const LocalizeQuery& query) {
  if (const auto codec = json.Find("codec"); codec && codec->String(64) != query.codec) {
    codec->Fail(fmt::format("is '{}', but the data state '{}'", codec->String(), query.codec));
  }
  if (const auto count = json.Find("count");
      count && count->Integer(0, 1 << 30) != query.features.size()) {
    count->Fail(fmt::format("does not match the {} features in the data", query.features.size()));
  }
}

void ReadJsonFeatures(const JsonReader& json, int max_features, LocalizeRequest* request) {
  constexpr char kHint[] =
      "send the binary form (docs/formats/features_v1.md) as a multipart part or as base64 in "
      "features.data; JSON numbers take ten times the bytes and sixty times the time to read";
  if (json.IsArray()) {
    json.Fail("may not be an array of numbers", kHint);
  }
  for (const char* member : {"descriptors", "keypoints"}) {
    if (const auto numbers = json.Find(member)) {
      numbers->Fail("is not accepted as JSON", kHint);
    }
  }
  json.RequireOnly({"codec", "count", "encoding", "data"});
  const JsonReader data = json.At("data");
  if (data.IsArray()) {
    data.Fail("may not be an array of numbers", kHint);
  }
  if (const auto encoding = json.Find("encoding");
      encoding && encoding->String() != "features_v1") {
    encoding->Fail("is unknown", "known: features_v1; the data contain all other properties");
  }
  SetFeatures(ReadBase64(data), max_features, request);
  CheckFeatureMembers(json, request->query);
}

RequestImage ReadJsonImage(const JsonReader& json) {
  json.RequireOnly({"format", "data"});
  RequestImage image;
  if (const auto format = json.Find("format")) {
    image.format = format->String(16);
  }
  image.bytes = ReadBase64(json.At("data"));
  if (image.bytes.empty()) {
    json.At("data").Fail("is empty");
  }
  return image;
}

// Reads everything except images and features.
LocalizeRequest ReadCommon(const JsonReader& json, const RequestLimits& limits) {
  WireRequest wire = ReadWireRequest(json);
  LocalizeRequest request;
  request.query.id = std::move(wire.id);
  request.query.camera = std::move(wire.camera);
  request.query.focal = wire.focal;
  request.query.other_cameras = std::move(wire.other_cameras);
  request.query.prior = wire.prior;
  request.query.down_in_cam = wire.down_in_cam;
  request.timestamp_ms = wire.timestamp_ms;
  request.picture = wire.picture;
  request.exif_prior = wire.exif_prior;
  request.timeout_ms = wire.timeout_ms.value_or(limits.default_timeout_ms);
  request.answer = wire.answer;
  return request;
}

// The member `kind` ("features" or "image") of element `index` of the rig. `kind` is the one that
// the first camera sends.
JsonReader RigMember(const JsonReader& json, size_t index, const char* kind) {
  const JsonReader element = json.At("rig").Elements(0, RigCamera::kMaxOthers)[index];
  const bool is_image = std::string_view(kind) == "image";
  if (const auto other = element.Find(is_image ? "features" : "image")) {
    other->Fail("differs from the first camera",
                "send images for all cameras or features for all cameras");
  }
  return element.At(kind);
}

void ReadJsonFeaturesOfAll(const JsonReader& json, int max_features, LocalizeRequest* request) {
  ReadJsonFeatures(json.At("features"), max_features, request);
  for (size_t i = 0; i < request->query.other_cameras.size(); ++i) {
    const JsonReader member = RigMember(json, i, "features");
    member.RequireOnly({"data"});
    SetRigFeatures(ReadBase64(member.At("data")), i, max_features, request);
  }
}

void ReadJsonImagesOfAll(const JsonReader& json, LocalizeRequest* request) {
  request->images.push_back(ReadJsonImage(json.At("image")));
  for (size_t i = 0; i < request->query.other_cameras.size(); ++i) {
    request->images.push_back(ReadJsonImage(RigMember(json, i, "image")));
  }
}

LocalizeRequest ParseJsonBody(std::string_view body, const RequestLimits& limits) {
  const JsonDocument document = ParseJson(body);
  const JsonReader json(document);
  LocalizeRequest request = ReadCommon(json, limits);
  const bool has_image = json.Find("image").has_value();
  if (has_image == json.Find("features").has_value()) {
    json.Fail("must have either an image or features, not both");
  }
  if (has_image) {
    ReadJsonImagesOfAll(json, &request);
  } else {
    ReadJsonFeaturesOfAll(json, limits.max_features, &request);
  }
  return request;
}

std::span<const uint8_t> AsBytes(std::string_view text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

// The parts of a multipart body.
struct RequestParts {
  std::optional<std::string_view> request, image, features;
  std::array<std::optional<std::string_view>, RigCamera::kMaxOthers> rig;
};

// Data sent as parts must not also occur in the JSON.
void RefuseMembersOfParts(const JsonReader& json) {
  for (const char* member : {"image", "features"}) {
    if (const auto twice = json.Find(member)) {
      twice->Fail("is already present as a multipart part");
    }
  }
}

RequestParts SortParts(const std::vector<MultipartPart>& parts) {
  constexpr std::string_view kRig = "rig";
  RequestParts sorted;
  for (const MultipartPart& part : parts) {
    const bool is_rig = part.name.size() == kRig.size() + 1 && part.name.starts_with(kRig);
    const int index = is_rig ? part.name.back() - '0' : -1;
    if (part.name == "request") {
      sorted.request = part.content;
    } else if (part.name == "image") {
      sorted.image = part.content;
    } else if (part.name == "features") {
      sorted.features = part.content;
    } else if (index >= 0 && index < RigCamera::kMaxOthers) {
      sorted.rig[index] = part.content;
    } else {
      throw HttpError(ProblemCode::kInvalidMultipart,
                      fmt::format("the part '{}' is unknown", part.name.substr(0, 64)))
          .Hint("known: request, image, features, and rig0, rig1, ... for a rig's other cameras");
    }
  }
  if (!sorted.request || sorted.image.has_value() == sorted.features.has_value()) {
    throw HttpError(ProblemCode::kInvalidMultipart,
                    "the body must have a part 'request' and either 'image' or 'features'");
  }
  return sorted;
}

// The parts of the rig's other cameras. There must be one for each camera in the request.
std::vector<std::string_view> RigParts(const JsonReader& json, const RequestParts& parts,
                                       size_t num_others) {
  std::vector<std::string_view> contents;
  for (size_t i = 0; i < parts.rig.size(); ++i) {
    if (parts.rig[i].has_value() != (i < num_others)) {
      throw HttpError(
          ProblemCode::kInvalidMultipart,
          fmt::format("the request has {} cameras in 'rig' and needs one part for each: "
                      "rig0, rig1, ...",
                      num_others));
    }
    if (i < num_others) {
      const JsonReader element = json.At("rig").Elements(0, RigCamera::kMaxOthers)[i];
      RefuseMembersOfParts(element);
      contents.push_back(*parts.rig[i]);
    }
  }
  return contents;
}

RequestImage ImageOfPart(std::string_view content, std::string_view name) {
  if (content.empty()) {
    throw HttpError(ProblemCode::kInvalidImage, fmt::format("the part '{}' is empty", name))
        .At(fmt::format("/{}", name));
  }
  RefuseImageAsText(content, name);
  const std::span<const uint8_t> bytes = AsBytes(content);
  return {.bytes = {bytes.begin(), bytes.end()}, .format = ""};
}

LocalizeRequest ParseMultipartBody(std::string_view content_type, std::string_view body,
                                   const RequestLimits& limits) {
  std::vector<MultipartPart> sent = ParseMultipart(content_type, body);
  std::vector<std::vector<uint8_t>> decoded;
  DecodeParts(&sent, &decoded);
  const RequestParts parts = SortParts(sent);
  if (parts.request->size() > kMaxShortJsonBytes) {
    throw HttpError(ProblemCode::kInvalidMultipart,
                    fmt::format("the part 'request' is longer than {} bytes", kMaxShortJsonBytes));
  }
  const JsonDocument document = ParseJson(*parts.request);
  const JsonReader json(document);
  LocalizeRequest request = ReadCommon(json, limits);
  RefuseMembersOfParts(json);
  if (parts.features) {
    SetFeatures(AsBytes(*parts.features), limits.max_features, &request);
  } else {
    request.images.push_back(ImageOfPart(*parts.image, "image"));
  }
  const std::vector<std::string_view> others =
      RigParts(json, parts, request.query.other_cameras.size());
  for (size_t i = 0; i < others.size(); ++i) {
    if (parts.features) {
      SetRigFeatures(AsBytes(others[i]), i, limits.max_features, &request);
    } else {
      request.images.push_back(ImageOfPart(others[i], fmt::format("rig{}", i)));
    }
  }
  return request;
}

// True for features and for base64. False for a body that is refused at once.
bool HasSlowPart(std::string_view content_type, std::string_view body) {
  try {
    const std::vector<MultipartPart> parts = ParseMultipart(content_type, body);
    return std::any_of(parts.begin(), parts.end(), [](const MultipartPart& part) {
      return part.name == "features" || part.is_base64;
    });
  } catch (const HttpError&) {
    return false;
  }
}

}  // namespace

bool TakesLongToParse(std::string_view content_type, std::string_view body) {
  return body.size() > kMaxShortJsonBytes &&
         (!IsMultipart(content_type) || HasSlowPart(content_type, body));
}

int PeekTimeoutMs(std::string_view body, const RequestLimits& limits) {
  // Inside a string, the quotes would be escaped by backslashes.
  const std::string name = fmt::format("\"{}\"", kTimeoutMember);
  constexpr size_t kMaxBlanks = 64;
  const size_t at = body.find(name);
  if (at == std::string_view::npos) {
    return limits.default_timeout_ms;
  }
  std::string_view rest = body.substr(at + name.size(), kMaxBlanks);
  rest.remove_prefix(std::min(rest.find_first_not_of(" \t\r\n:"), rest.size()));
  int timeout_ms = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), timeout_ms);
  return error == std::errc() ? std::clamp(timeout_ms, 1, kMaxTimeoutMs)
                              : limits.default_timeout_ms;
}

LocalizeRequest ParseLocalizeRequest(std::string_view content_type, std::string_view body,
                                     const RequestLimits& limits) {
  if (IsMultipart(content_type)) {
    return ParseMultipartBody(content_type, body, limits);
  }
  if (MediaType(content_type) == "application/json") {
    return ParseJsonBody(body, limits);
  }
  throw HttpError(ProblemCode::kUnsupportedMediaType,
                  fmt::format("the content type '{}' is not accepted", content_type.substr(0, 64)))
      .Hint("send application/json or multipart/form-data");
}

}  // namespace cairn
