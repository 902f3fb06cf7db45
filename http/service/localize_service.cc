#include "http/service/localize_service.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/parallel_for.h"
#include "core/wire/problem.h"
#include "engine/empty_result.h"
#include "http/json/request_photos.h"
#include "http/service/image_features.h"
#include "storage/map/read_latest.h"

namespace cairn {
namespace {

using std::chrono::milliseconds;

LocalizerOptions MakeLocalizerOptions(const ServerOptions& options) {
  LocalizerOptions localizer = options.localizer;
  localizer.num_threads = options.threads_per_query > 0 ? options.threads_per_query : NumCores();
  return localizer;
}

int MaxWaiting(const ServerOptions& options) {
  if (options.max_waiting > 0) {
    return options.max_waiting;
  }
  const int num_threads = NumThreads(options);
  const int num_entered = 2 * NumCores();  // At most, see fair_gate.h.
  return std::max(1, std::min(num_threads * 3 / 4, num_threads - num_entered - num_threads / 8));
}

[[noreturn]] void RefuseForLackOfTurns() {
  throw HttpError(ProblemCode::kUnavailable, "too many requests are waiting for their turn")
      .Hint("wait for the answers to earlier requests before you send more");
}

// Throws unless the features fit the map's codebook.
void CheckCodec(const MapSnapshot& map, const LocalizeQuery& query) {
  const std::shared_ptr<const Codebook> codebook = map.CurrentCodebook();
  if (codebook == nullptr) {
    return;  // An empty map covers no query, whatever the features.
  }
  const bool is_raw = query.features.space == DescriptorSpace::kRaw;
  const std::string codec = is_raw ? codebook->descriptor_type : codebook->CodecName();
  const bool unnamed = is_raw && query.codec.empty();
  if (!unnamed && query.codec != codec) {
    throw HttpError(
        ProblemCode::kWrongCodec,
        fmt::format("the features have codec '{}', but the map has '{}'", query.codec, codec))
        .At("/features/codec")
        .Hint(fmt::format("send raw '{}' features, or project them for '{}'",
                          codebook->descriptor_type, codebook->CodecName()));
  }
  const int dim = is_raw ? codebook->raw_dim() : codebook->projected_dim();
  const auto check_dim = [&](const FeatureSet& features, const std::string& pointer) {
    if (features.size() > 0 && features.descriptors.cols() != dim) {
      throw HttpError(ProblemCode::kInvalidFeatures,
                      fmt::format("the descriptors have {} dimensions, but codec '{}' has {}",
                                  features.descriptors.cols(), codec, dim))
          .At(pointer);
    }
  };
  check_dim(query.features, "/features");
  for (size_t i = 0; i < query.other_cameras.size(); ++i) {
    check_dim(query.other_cameras[i].features, fmt::format("/rig/{}/features", i));
  }
}

LocalizeResult LateAnswer(const ServedMap& map, const LocalizeQuery& query) {
  return LateResult(query, map.localizer->options(), map.store().Snapshot());
}

}  // namespace

LocalizeService::LocalizeService(const ServerOptions& options)
    : options_(options),
      extractor_(options.sift),
      maps_({.path = options.map_path,
             .cache_bytes = options.cache_bytes,
             .localizer = MakeLocalizerOptions(options)}),
      gate_({.num_slots = NumCores(), .max_waiting = MaxWaiting(options)}) {}

LocalizeRequest LocalizeService::Read(const ServedMap& map, const HttpRequest& http,
                                      BodyParser& parse) const {
  LocalizeRequest request = parse(http.Header("content-type"), http.body, request_limits());
  request.timeout_ms = std::min(request.timeout_ms, options_.max_timeout_ms);
  request.query.deadline = http.arrival + milliseconds(request.timeout_ms);
  if (!request.has_images()) {  // Refuse it before it waits for its turn.
    CheckCodec(map.store().Snapshot(), request.query);
  }
  return request;
}

bool LocalizeService::ExtractInTime(FairGate::Turn* turn, LocalizeRequest* request,
                                    ServerTimes* times) const {
  const auto deadline = *request->query.deadline;
  const ImageDecodeLimits limits{.max_pixels = options_.max_image_pixels, .should_stop = [&, turn] {
                                   if (!stopping_) {
                                     turn->MakeRoom();
                                   }
                                   return stopping_ || std::chrono::steady_clock::now() >= deadline;
                                 }};
  try {
    ExtractQueryFeatures(limits, extractor_, request, times);
    return true;
  } catch (const DecodingStopped&) {
    if (stopping_) {
      throw HttpError(ProblemCode::kUnavailable, "the server is stopping");
    }
    return false;
  }
}

std::unique_ptr<FairGate::Turn> LocalizeService::WaitForTurn(const HttpRequest& http) {
  auto turn = std::make_unique<FairGate::Turn>(
      &gate_, http.client, http.arrival + milliseconds(options_.default_timeout_ms));
  if (turn->outcome() == FairGate::Outcome::kRefused) {
    RefuseForLackOfTurns();
  }
  if (turn->outcome() == FairGate::Outcome::kLate) {
    throw HttpError(ProblemCode::kUnavailable, "the turn of the request did not come in time");
  }
  return turn;
}

// A request has one turn. During the turn its body is parsed (if that takes long), its photos' EXIF
// is read, its image becomes features, and the features become an answer.
LocalizeService::Answer LocalizeService::AnswerInTurn(const ServedMap& map, const HttpRequest& http,
                                                      BodyParser& parse) {
  Answer answer;
  LocalizeRequest& request = answer.request;
  const bool reads_in_turn = TakesLongToParse(http.Header("content-type"), http.body);
  if (!reads_in_turn) {
    request = Read(map, http, parse);
  }
  const int timeout_ms =
      reads_in_turn ? std::min(PeekTimeoutMs(http.body, request_limits()), options_.max_timeout_ms)
                    : request.timeout_ms;
  FairGate::Turn turn(&gate_, http.client, http.arrival + milliseconds(timeout_ms));
  if (turn.outcome() == FairGate::Outcome::kRefused) {
    RefuseForLackOfTurns();
  }
  if (turn.outcome() == FairGate::Outcome::kLate) {
    answer.result = LateAnswer(map, request.query);
    return answer;
  }
  if (reads_in_turn) {
    request = Read(map, http, parse);
  }
  if (request.has_images()) {
    ReadPhotos(options_.exif_prior, &request);
    if (!ExtractInTime(&turn, &request, &answer.times)) {
      answer.result = LateAnswer(map, request.query);
      return answer;
    }
  }
  answer.result = ReadLatest(map.store(), request.query.deadline, [&](const MapSnapshot& version) {
    CheckCodec(version, request.query);
    return map.localizer->LocalizeIn(version, request.query);
  });
  return answer;
}

LocalizeService::Answer LocalizeService::Localize(const HttpRequest& http, BodyParser& parse) {
  const std::shared_ptr<const ServedMap> map = maps_.Current();
  Answer answer = AnswerInTurn(*map, http, parse);
  const bool is_stale = answer.result.map_is_stale || !maps_.Problem().empty();
  metrics_.CountLocalize(answer.result, answer.times, is_stale);
  return answer;
}

}  // namespace cairn
