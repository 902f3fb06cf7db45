#include "http/json/request_options.h"

#include <string>

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

}  // namespace

ImageOrientation ReadImageOrientation(const std::optional<JsonReader>& options) {
  const auto name = options ? options->Find("imageOrientation") : std::nullopt;
  if (!name) {
    return ImageOrientation::kAsSize;
  }
  const std::optional<ImageOrientation> meant = ImageOrientationFromName(name->String());
  if (!meant) {
    name->Fail("is unknown", "known: stored, upright");
  }
  return *meant;
}

void ReadOptions(const JsonReader& json, LocalizeRequest* request) {
  json.RequireOnly({"innerFrame", "timeoutMs", "maxMatches", "include", "imageOrientation"});
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
  if (const auto include = json.Find("include")) {
    ReadInclude(*include, &request->answer);
  }
}

}  // namespace cairn
