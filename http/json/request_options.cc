#include "http/json/request_options.h"

#include <optional>
#include <string>

#include "http/json/image_orientation.h"

namespace cairn {
namespace {

void ReadInclude(const JsonReader& json, ResponseOptions* options) {
  options->with_matches = options->with_timings = options->with_covariance = false;
  for (const JsonReader& element : json.Elements(0, 8)) {
    const std::string& name = element.String();
    if (name == "matches") {
      options->with_matches = true;
    } else if (name == "timings") {
      options->with_timings = true;
    } else if (name == "covariance") {
      options->with_covariance = true;
    } else {
      element.Fail("is unknown", "known: matches, timings, covariance");
    }
  }
}

ImageOrientation ReadImageOrientation(const JsonReader& name) {
  const std::optional<ImageOrientation> meant = ImageOrientationFromName(name.String());
  if (!meant) {
    name.Fail("is unknown", "known: stored, upright");
  }
  return *meant;
}

}  // namespace

void ReadOptions(const JsonReader& json, LocalizeRequest* request) {
  json.RequireOnly(
      {"innerFrame", "timeoutMs", "maxMatches", "include", "imageOrientation", "exifPrior"});
  if (const auto name = json.Find("innerFrame")) {
    const std::optional<InnerFrame> frame = InnerFrameFromName(name->String());
    if (!frame) {
      name->Fail("is unknown", "known: FLU, RDF, RUB, EUS");
    }
    request->answer.inner_frame = *frame;
  }
  if (const auto timeout = json.Find("timeoutMs")) {
    request->timeout_ms = static_cast<int>(timeout->Integer(1, kMaxTimeoutMs));
  }
  if (const auto max_matches = json.Find("maxMatches")) {
    request->answer.max_matches = static_cast<int>(max_matches->Integer(0, kMaxMatches));
  }
  if (const auto orientation = json.Find("imageOrientation")) {
    request->picture = ReadImageOrientation(*orientation);
  }
  if (const auto exif_prior = json.Find("exifPrior")) {
    request->exif_prior = exif_prior->Bool();
  }
  if (const auto include = json.Find("include")) {
    ReadInclude(*include, &request->answer);
  }
}

}  // namespace cairn
