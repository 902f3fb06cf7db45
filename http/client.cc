#include "http/client.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include "core/cell_name.h"
#include "core/error.h"
#include "core/printable.h"
#include "core/wire/feature_codec.h"
#include "core/wire/json_error.h"
#include "core/wire/json_reader.h"
#include "core/wire/multipart.h"
#include "core/wire/wire_request.h"
#include "http/exchange/bounded_client.h"
#include "http/json/localize_response.h"

namespace cairn {
namespace {

std::string RequestJson(const LocalizeQuery& query, const ClientOptions& client) {
  WireRequest wire{.id = query.id, .camera = query.camera, .focal = query.focal};
  for (const RigCamera& other : query.other_cameras) {
    wire.other_cameras.push_back({other.camera, other.cam_from_first, {}});  // Features are parts.
  }
  wire.prior = query.prior;
  wire.down_in_cam = query.down_in_cam;
  if (query.deadline) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(
        *query.deadline - std::chrono::steady_clock::now());
    wire.timeout_ms = static_cast<int>(std::clamp<int64_t>(left.count(), 1, kMaxTimeoutMs));
  }
  wire.picture = client.image_orientation;
  wire.exif_prior = client.exif_prior;
  wire.answer = {.inner_frame = InnerFrame::kRdf,
                 .max_matches = kMaxMatches,
                 .with_matches = client.want_matches};
  return WireRequestJson(wire);
}

// The body of a refusal; empty if it is not JSON, as in the response of another program.
JsonDocument ParseRefusal(const std::string& body) {
  try {
    return ParseJson(body);
  } catch (const JsonError&) {
    return {};
  }
}

// A text member; empty if the member is missing or is not a string.
std::string TextOf(const JsonReader& problem, const char* name) {
  const std::optional<JsonReader> member = problem.Find(name);
  return member && member->IsString() ? member->String() : "";
}

// Where a redirect sends requests: the address of a server if the redirect keeps their path.
std::string NewAddress(const std::string& location, const std::string& path) {
  const bool keeps_path = location.size() > path.size() && location.ends_with(path);
  return Excerpt(keeps_path ? location.substr(0, location.size() - path.size()) : location);
}

// The explanation of a refused request for `path`.
std::string Explanation(const ClientResponse& response, const std::string& path) {
  std::string text = fmt::format("the server answered {}", response.status);
  const std::string location = response.Header("Location");
  if (response.status / 100 == 3 && !location.empty()) {
    return fmt::format("{} and points to {}; give that address, because redirects are not followed",
                       text, NewAddress(location, path));
  }
  const JsonDocument document = ParseRefusal(response.body);
  if (document.empty() || !JsonReader(document).IsObject()) {
    return text;
  }
  const JsonReader problem(document);
  const std::string detail = TextOf(problem, "detail");
  const std::string reason = detail.empty() ? TextOf(problem, "title") : detail;
  const std::string hint = TextOf(problem, "hint");
  if (!reason.empty()) {
    text += ": " + reason;
  }
  if (!hint.empty()) {
    text += fmt::format(" ({})", hint);
  }
  return text;
}

// What a client can do that has no key, or a wrong one.
std::string AdviceOnKey(int status, bool has_key) {
  if (status != 401 || has_key) {
    return "";
  }
  return "; give a key with --api-key-file or CAIRN_API_KEY";
}

// The text without the key, which a server may repeat.
std::string WithoutKey(std::string text, const std::string& key) {
  constexpr std::string_view kMask = "[API key]";
  for (size_t at = 0; !key.empty() && (at = text.find(key, at)) != std::string::npos;) {
    text.replace(at, key.size(), kMask);
    at += kMask.size();
  }
  return text;
}

ErrorCode CodeOfStatus(int status) {
  switch (status) {
    case 404:
      return ErrorCode::kNotFound;
    case 409:
      return ErrorCode::kConflict;
    case 429:
    case 503:
      return ErrorCode::kUnavailable;
    default:
      return status >= 500 ? ErrorCode::kInternal : ErrorCode::kBadInput;
  }
}

std::string_view AsText(std::span<const uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

struct LocalizeClient::Impl {
  ClientOptions options;
  BoundedClient http;
  std::string last_cell;  // The cell that the server named last; empty before.
  std::atomic<bool> is_stopped = false;

  explicit Impl(const ClientOptions& client_options)
      : options(client_options),
        http({.url = client_options.url,
              .ca_file = client_options.ca_file,
              .api_key = client_options.api_key,
              .allow_plain_key = client_options.allow_plain_key,
              .timeout_ms = client_options.timeout_ms}) {
    if (!options.wait) {
      options.wait = [](std::chrono::seconds pause) { std::this_thread::sleep_for(pause); };
    }
  }

  // The server may close a silent connection just when the next request is on its way. An exchange
  // that fails at once is therefore repeated on a new connection. A front answers 502 if its server
  // died; the second exchange then meets another server. Every request can safely be repeated.
  ClientResponse SendTwice(const ClientRequest& request) {
    const auto start = std::chrono::steady_clock::now();
    ClientResponse response = http.Send(request);
    const auto elapsed = std::chrono::steady_clock::now() - start;
    const bool has_failed =
        !is_stopped && ((response.status == 0 && !response.is_garbled) || response.status == 502);
    if (has_failed && elapsed < std::chrono::milliseconds(options.timeout_ms) / 2) {
      response = http.Send(request);
    }
    return response;
  }

  // Returns the response with status 200. If there are too many requests, repeats the request when
  // the server says, unless the timeout would be over by then.
  ClientResponse ResponseTo(const ClientRequest& request) {
    const auto end =
        std::chrono::steady_clock::now() + std::chrono::milliseconds(options.timeout_ms);
    is_stopped = false;
    ClientResponse response = SendTwice(request);
    while (const auto pause = response.RetryAfter()) {
      if (std::chrono::steady_clock::now() + *pause >= end) {
        break;
      }
      options.wait(*pause);
      response = SendTwice(request);
    }
    if (response.status == 0) {
      throw Error(ErrorCode::kUnavailable,
                  fmt::format("no answer from {}: {}; is the server running?", options.url,
                              response.failure));
    }
    if (response.status != 200) {
      throw ServerRefusal(CodeOfStatus(response.status),
                          WithoutKey(Explanation(response, request.path), options.api_key) +
                              AdviceOnKey(response.status, !options.api_key.empty()),
                          response.status);
    }
    return response;
  }

  // Sends one part for each camera, with the camera's bytes. `own_name` names the part of the
  // query's own camera.
  LocalizeResult Post(const LocalizeQuery& query, const std::string& own_name,
                      const std::vector<std::vector<uint8_t>>& blobs) {
    MultipartWriter writer;
    writer.Add("request", "application/json", RequestJson(query, options));
    for (size_t i = 0; i < blobs.size(); ++i) {
      writer.Add(i == 0 ? own_name : fmt::format("rig{}", i - 1), "application/octet-stream",
                 AsText(blobs[i]));
    }
    ClientRequest request{.method = "POST",
                          .path = "/v1/localize",
                          .headers = {{"Content-Type", MultipartWriter::ContentType()}},
                          .body = std::move(writer).Finish()};
    if (const std::string cell = CellOf(query); !cell.empty()) {
      request.headers.emplace_back(kCellHeader, cell);
    }
    const ClientResponse response = ResponseTo(request);
    if (const std::string cell = response.Header(kCellHeader); IsCellName(cell)) {
      last_cell = cell;
    }
    return ParseLocalizeResponse(response.body);
  }

  // The cell of the prior, or else of the last answer. A front sends the query to the server that
  // has the tiles of the cell in memory.
  std::string CellOf(const LocalizeQuery& query) const {
    return query.prior ? CellName(query.prior->position) : last_cell;
  }
};

LocalizeClient::LocalizeClient(const ClientOptions& options)
    : impl_(std::make_unique<Impl>(options)) {}

LocalizeClient::~LocalizeClient() = default;

LocalizeResult LocalizeClient::LocalizeImages(const LocalizeQuery& query,
                                              const std::vector<std::vector<uint8_t>>& images) {
  return impl_->Post(query, "image", images);
}

LocalizeResult LocalizeClient::LocalizeFeatures(const LocalizeQuery& query) {
  const auto encode = [&](const FeatureSet& features, const Camera& camera) {
    const WireFeatures wire{.features = features,
                            .codec = features.space == DescriptorSpace::kRaw ? "" : query.codec,
                            .width_px = camera.width_px(),
                            .height_px = camera.height_px()};
    return EncodeFeatures(wire, LosslessEncoding(features));
  };
  std::vector<std::vector<uint8_t>> blobs = {encode(query.features, query.camera)};
  for (const RigCamera& other : query.other_cameras) {
    blobs.push_back(encode(other.features, other.camera));
  }
  return impl_->Post(query, "features", blobs);
}

std::string LocalizeClient::Get(const std::string& path) {
  return impl_->ResponseTo({.path = path}).body;
}

void LocalizeClient::Stop() {
  impl_->is_stopped = true;
  impl_->http.Stop();
}

}  // namespace cairn
