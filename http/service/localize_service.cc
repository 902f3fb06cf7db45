#include "http/service/localize_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "core/parallel_for.h"
#include "core/wire/problem.h"
#include "engine/empty_result.h"
#include "http/json/request_photos.h"
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

// Gives each camera of the query its features.
void GiveFeatures(std::vector<FeatureSet> of_image, LocalizeQuery* query) {
  query->features = std::move(of_image.front());
  for (size_t i = 0; i < query->other_cameras.size(); ++i) {
    query->other_cameras[i].features = std::move(of_image[i + 1]);
  }
}

}  // namespace

LocalizeService::LocalizeService(const ServerOptions& options)
    : options_(options),
      extractor_(options.sift),
      maps_({.path = options.map_path,
             .cache_bytes = options.cache_bytes,
             .localizer = MakeLocalizerOptions(options)}),
      gate_({.num_slots = NumCores(), .max_waiting = MaxWaiting(options)}) {}

std::unique_ptr<FairGate::Turn> LocalizeService::TakeTurn(FairGate::ClientId client,
                                                          TimePoint deadline) {
  auto turn = std::make_unique<FairGate::Turn>(&gate_, client, deadline);
  if (turn->outcome() == FairGate::Outcome::kRefused) {
    throw HttpError(ProblemCode::kUnavailable, "too many requests are waiting for their turn")
        .Hint("wait for the answers to earlier requests before you send more");
  }
  return turn;
}

std::unique_ptr<FairGate::Turn> LocalizeService::WaitForTurn(const HttpRequest& http) {
  auto turn = TakeTurn(http.client, http.arrival + milliseconds(options_.default_timeout_ms));
  if (turn->outcome() == FairGate::Outcome::kLate) {
    throw HttpError(ProblemCode::kUnavailable, "the turn of the request did not come in time");
  }
  return turn;
}

ImageFeatures LocalizeService::ExtractInTime(const LocalizeRequest& request,
                                             FairGate::Turn* turn) const {
  const auto deadline = *request.query.deadline;
  const ImageDecodeLimits limits{.max_pixels = options_.max_image_pixels, .should_stop = [&, turn] {
                                   if (!stopping_) {
                                     turn->MakeRoom();
                                   }
                                   return stopping_ || std::chrono::steady_clock::now() >= deadline;
                                 }};
  ImageFeatures features = ExtractImageFeatures(request, extractor_, limits);
  if (features.was_stopped && stopping_) {
    throw HttpError(ProblemCode::kUnavailable, "the server is stopping");
  }
  return features;
}

LocalizeService::Visit LocalizeService::Receive(const HttpRequest& http) {
  Visit visit;
  visit.map_ = maps_.Current();
  visit.client_ = http.client;
  visit.arrival_ = http.arrival;
  if (TakesLongToParse(http.Header("content-type"), http.body)) {
    const int timeout_ms =
        std::min(PeekTimeoutMs(http.body, request_limits()), options_.max_timeout_ms);
    visit.turn_ = TakeTurn(http.client, http.arrival + milliseconds(timeout_ms));
  }
  return visit;
}

// A request has one turn. During the turn its body is parsed (if that takes long), its photos' EXIF
// is read, its image becomes features, and the features become an answer.
LocalizeService::Answer LocalizeService::Compute(Visit visit, LocalizeRequest request) {
  request.timeout_ms = std::min(request.timeout_ms, options_.max_timeout_ms);
  const TimePoint deadline = visit.arrival_ + milliseconds(request.timeout_ms);
  request.query.deadline = deadline;
  const Localizer& localizer = *visit.map_->localizer;
  const MapSnapshot version = localizer.map().Snapshot(deadline);
  const bool is_over = std::chrono::steady_clock::now() >= deadline;
  if (!is_over && !request.has_images()) {  // Refuse it before it waits or computes.
    CheckCodec(version, request.query);
  }
  if (visit.turn_ == nullptr) {
    visit.turn_ = TakeTurn(visit.client_, deadline);
  }
  ServerTimes times;
  bool in_time = !visit.is_late();
  if (in_time && request.has_images()) {
    ReadPhotos(options_.exif_prior, &request);
    ImageFeatures features = ExtractInTime(request, visit.turn_.get());
    times = features.times;
    in_time = !features.was_stopped;
    if (in_time) {
      GiveFeatures(std::move(features.of_image), &request.query);
    }
  }
  if (!in_time) {  // What it says of the map is read without the deadline, which has passed.
    LocalizeResult late =
        LateResult(request.query, localizer.options(), localizer.map().Snapshot());
    return {std::move(request), std::move(late), times};
  }
  LocalizeResult result =
      ReadLatest(localizer.map(), version, deadline, [&](const MapSnapshot& readable) {
        CheckCodec(readable, request.query);
        return localizer.LocalizeIn(readable, request.query);
      });
  return {std::move(request), std::move(result), times};
}

void LocalizeService::Count(const Answer& answer) {
  const bool is_stale = answer.result.map_is_stale || !maps_.Problem().empty();
  metrics_.CountLocalize(answer.result, answer.times, is_stale);
}

LocalizeService::Answer LocalizeService::AnswerLate(const Visit& visit) {
  const Localizer& localizer = *visit.map_->localizer;
  Answer answer = {
      .request = {},
      .result = LateResult(LocalizeQuery(), localizer.options(), localizer.map().Snapshot()),
      .times = {}};
  Count(answer);
  return answer;
}

LocalizeService::Answer LocalizeService::Localize(Visit visit, LocalizeRequest request) {
  Answer answer = Compute(std::move(visit), std::move(request));
  Count(answer);
  return answer;
}

}  // namespace cairn
