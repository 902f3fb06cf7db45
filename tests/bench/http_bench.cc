// Measures the time to read a query of 1,000 features from the wire, by encoding. Each benchmark
// checks that the features arrive.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "core/wire/base64.h"
#include "core/wire/feature_codec.h"
#include "http/json/localize_request.h"

namespace cairn {
namespace {

constexpr int kNumFeatures = 1000;
constexpr int kRawDim = 128;
constexpr int kProjectedDim = 16;
constexpr char kCamera[] =
    R"("camera":{"model":"PINHOLE","size":[640,480],"modelParams":[500,500,320,240]})";

WireFeatures MakeFeatures(DescriptorSpace space) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  const bool is_raw = space == DescriptorSpace::kRaw;
  WireFeatures wire{.features = {},
                    .codec = is_raw ? "sift" : "sift-128-16-1",
                    .width_px = 640,
                    .height_px = 480};
  wire.features.space = space;
  wire.features.descriptors.resize(kNumFeatures, is_raw ? kRawDim : kProjectedDim);
  for (float& value : wire.features.descriptors.reshaped()) {
    value = is_raw ? std::floor(255.0f * unit(rng)) : unit(rng) - 0.5f;
  }
  for (int i = 0; i < kNumFeatures; ++i) {
    wire.features.keypoints.push_back({640.0f * unit(rng), 480.0f * unit(rng), 2.0f, 0.0f});
  }
  return wire;
}

std::vector<uint8_t> Blob(DescriptorSpace space, const FeatureEncoding& encoding) {
  return EncodeFeatures(MakeFeatures(space), encoding);
}

void Parse(const std::string& content_type, const std::string& body, benchmark::State* state) {
  for (auto _ : *state) {
    const LocalizeRequest request = ParseLocalizeRequest(content_type, body, RequestLimits{});
    if (request.query.features.size() != kNumFeatures) {
      state->SkipWithError("features lost");
    }
  }
  state->counters["body_bytes"] = static_cast<double>(body.size());
}

void ParseMultipart(const std::vector<uint8_t>& blob, benchmark::State* state) {
  Parse("multipart/form-data; boundary=B",
        fmt::format("--B\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{{{}}}\r\n"
                    "--B\r\nContent-Disposition: form-data; name=\"features\"\r\n\r\n{}\r\n--B--",
                    kCamera, std::string(blob.begin(), blob.end())),
        state);
}

void ParseBase64(const std::vector<uint8_t>& blob, benchmark::State* state) {
  Parse("application/json",
        fmt::format(R"({{{},"features":{{"data":"{}"}}}})", kCamera, EncodeBase64(blob)), state);
}

constexpr FeatureEncoding kRawBytes{GeometryEncoding::kFloat32, DescriptorEncoding::kUint8};
constexpr FeatureEncoding kHalf{GeometryEncoding::kCompact, DescriptorEncoding::kFloat16};
constexpr FeatureEncoding kScaled{GeometryEncoding::kCompact, DescriptorEncoding::kUint8Scaled};

void BM_MultipartRawSift(benchmark::State& state) {
  ParseMultipart(Blob(DescriptorSpace::kRaw, kRawBytes), &state);
}
BENCHMARK(BM_MultipartRawSift)->Unit(benchmark::kMicrosecond);

void BM_Base64RawSift(benchmark::State& state) {
  ParseBase64(Blob(DescriptorSpace::kRaw, kRawBytes), &state);
}
BENCHMARK(BM_Base64RawSift)->Unit(benchmark::kMicrosecond);

void BM_MultipartProjectedHalf(benchmark::State& state) {
  ParseMultipart(Blob(DescriptorSpace::kProjected, kHalf), &state);
}
BENCHMARK(BM_MultipartProjectedHalf)->Unit(benchmark::kMicrosecond);

void BM_Base64ProjectedHalf(benchmark::State& state) {
  ParseBase64(Blob(DescriptorSpace::kProjected, kHalf), &state);
}
BENCHMARK(BM_Base64ProjectedHalf)->Unit(benchmark::kMicrosecond);

void BM_MultipartProjectedScaled(benchmark::State& state) {
  ParseMultipart(Blob(DescriptorSpace::kProjected, kScaled), &state);
}
BENCHMARK(BM_MultipartProjectedScaled)->Unit(benchmark::kMicrosecond);

// What the server refuses, for comparison: the same raw descriptors as JSON numbers.
void BM_JsonNumbersRawSift(benchmark::State& state) {
  const WireFeatures wire = MakeFeatures(DescriptorSpace::kRaw);
  nlohmann::json rows = nlohmann::json::array();
  for (int i = 0; i < kNumFeatures; ++i) {
    const auto row = wire.features.descriptors.row(i);
    rows.push_back(std::vector<float>(row.begin(), row.end()));
  }
  const std::string body = rows.dump();
  for (auto _ : state) {
    const nlohmann::json parsed = nlohmann::json::parse(body);
    if (parsed.size() != kNumFeatures) {
      state.SkipWithError("features lost");
    }
  }
  state.counters["body_bytes"] = static_cast<double>(body.size());
}
BENCHMARK(BM_JsonNumbersRawSift)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace cairn
