#include "http/localize_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "http/image_features.h"
#include "http/problem.h"

namespace cairn {
namespace {

int NumCores() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

LocalizerOptions MakeLocalizerOptions(const ServerOptions& options) {
  LocalizerOptions localizer = options.localizer;
  localizer.num_threads = options.threads_per_query > 0 ? options.threads_per_query : NumCores();
  return localizer;
}

// Throws unless the features are what the map's codebook takes.
void CheckCodec(const ServedMap& map, const LocalizeQuery& query) {
  const std::shared_ptr<const Codebook> codebook = map.store->Snapshot().CurrentCodebook();
  if (codebook == nullptr) return;  // An empty map: nothing is covered, whatever the features.
  const bool is_raw = query.features.space == DescriptorSpace::kRaw;
  const std::string codec = is_raw ? codebook->descriptor_type : codebook->CodecName();
  const bool unnamed = is_raw && query.codec.empty();
  if (!unnamed && query.codec != codec) {
    throw HttpError(
        ProblemCode::kWrongCodec,
        fmt::format("the features are of codec '{}', the map's is '{}'", query.codec, codec))
        .At("/features/codec")
        .Hint(fmt::format("send raw '{}' features, or project them for '{}'",
                          codebook->descriptor_type, codebook->CodecName()));
  }
  const int dim = is_raw ? codebook->raw_dim() : codebook->projected_dim();
  const auto check_dim = [&](const FeatureSet& features, const std::string& pointer) {
    if (features.size() > 0 && features.descriptors.cols() != dim) {
      throw HttpError(ProblemCode::kInvalidFeatures,
                      fmt::format("the descriptors have {} dimensions, codec '{}' has {}",
                                  features.descriptors.cols(), codec, dim))
          .At(pointer);
    }
  };
  check_dim(query.features, "/features");
  for (size_t i = 0; i < query.other_cameras.size(); ++i) {
    check_dim(query.other_cameras[i].features, fmt::format("/rig/{}/features", i));
  }
}

LocalizeResult LateResult(const ServedMap& map, const LocalizeQuery& query) {
  LocalizeResult late;
  late.reason = NotLocalizedReason::kTimeout;
  late.map_version = map.store->Snapshot().version();
  late.counters.num_keypoints = query.num_features();
  return late;
}

}  // namespace

LocalizeService::LocalizeService(const ServerOptions& options)
    : options_(options),
      maps_({.path = options.map_path,
             .cache_bytes = options.cache_bytes,
             .localizer = MakeLocalizerOptions(options)}),
      gate_(NumCores()) {}

LocalizeService::Answer LocalizeService::AnswerInTurn(const ServedMap& map,
                                                      LocalizeRequest* request) {
  Answer answer;
  LocalizeQuery& query = request->query;
  if (!gate_.Enter(*query.deadline)) {
    answer.result = LateResult(map, query);
    return answer;
  }
  // Left on every way out.
  const std::unique_ptr<FairGate, void (*)(FairGate*)> slot(&gate_,
                                                            [](FairGate* gate) { gate->Leave(); });
  if (request->has_images()) {
    ExtractQueryFeatures(options_.max_image_pixels, request, &answer.times);
    CheckCodec(map, query);
  }
  answer.result = map.localizer->Localize(query);
  return answer;
}

LocalizeService::Answer LocalizeService::Localize(std::chrono::steady_clock::time_point arrival,
                                                  LocalizeRequest* request) {
  request->query.deadline = arrival + std::chrono::milliseconds(request->timeout_ms);
  const std::shared_ptr<const ServedMap> map = maps_.Current();
  if (!request->has_images()) {
    CheckCodec(*map, request->query);
  }
  Answer answer = AnswerInTurn(*map, request);
  metrics_.CountLocalize(answer.result, answer.times);
  return answer;
}

}  // namespace cairn
