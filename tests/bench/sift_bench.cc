// Measures the steps of feature extraction from a photo, and OpenCV's default SIFT on the same
// photo. Each benchmark checks its result. The photo is a synthetic one of one megapixel, or the
// one that the environment variable CAIRN_BENCH_PHOTO names.
#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/features/sift/sift_descriptor.h"
#include "core/features/sift/sift_extractor.h"
#include "core/features/sift/sift_orientation.h"
#include "core/images/reduce_image.h"

namespace cairn {
namespace {

// Rectangles of all sizes and grays before one another, as on facades, with the noise of a sensor.
cv::Mat MadeUpPhoto() {
  cv::Mat photo(864, 1152, CV_8UC1, cv::Scalar(128));
  cv::RNG rng(1);
  for (int i = 0; i < 2500; ++i) {
    const int side = static_cast<int>(4.0 * std::exp(rng.uniform(0.0, 3.5)));
    const cv::Rect rect(rng.uniform(-side, photo.cols), rng.uniform(-side, photo.rows),
                        rng.uniform(2, side), rng.uniform(2, side));
    cv::rectangle(photo, rect, cv::Scalar(rng.uniform(30, 225)), cv::FILLED);
  }
  cv::GaussianBlur(photo, photo, cv::Size(), 0.7);
  cv::Mat noise(photo.size(), CV_8SC1);
  rng.fill(noise, cv::RNG::NORMAL, 0.0, 2.0);
  cv::add(photo, noise, photo, cv::noArray(), CV_8UC1);
  return photo;
}

const std::vector<uint8_t>& JpegBytes() {
  static const std::vector<uint8_t> bytes = [] {
    if (const char* path = std::getenv("CAIRN_BENCH_PHOTO")) {
      return ReadImageBytes(path);
    }
    std::vector<uint8_t> jpeg;
    cv::imencode(".jpg", MadeUpPhoto(), jpeg, {cv::IMWRITE_JPEG_QUALITY, 90});
    return jpeg;
  }();
  return bytes;
}

const GrayImage& Photo() {
  static const GrayImage photo = DecodeGrayImage(JpegBytes());
  return photo;
}

const ScaleSpaceOctave& FullOctave() {
  static const ScaleSpaceOctave octave = MakeScaleSpaceOctave(ToFloatImage(Photo()), kSharpSigmaPx);
  return octave;
}

const std::vector<SiftExtremum>& Extrema() {
  static const std::vector<SiftExtremum> extrema = DetectSiftExtrema(FullOctave(), {});
  return extrema;
}

void CountMegapixels(benchmark::State* state) {
  state->counters["megapixels"] = 1e-6 * static_cast<double>(Photo().pixels.size());
}

void BM_Decode(benchmark::State& state) {
  for (auto _ : state) {
    if (DecodeGrayImage(JpegBytes()).pixels != Photo().pixels) {
      state.SkipWithError("other pixels");
    }
  }
  CountMegapixels(&state);
}
BENCHMARK(BM_Decode)->Unit(benchmark::kMillisecond);

// The peer.
void BM_OpenCvDecode(benchmark::State& state) {
  for (auto _ : state) {
    const cv::Mat image = cv::imdecode(JpegBytes(), cv::IMREAD_GRAYSCALE);
    if (image.total() != Photo().pixels.size()) {
      state.SkipWithError("other size");
    }
  }
  CountMegapixels(&state);
}
BENCHMARK(BM_OpenCvDecode)->Unit(benchmark::kMillisecond);

void BM_ScaleSpaceOfFullOctave(benchmark::State& state) {
  const FloatImage image = ToFloatImage(Photo());
  for (auto _ : state) {
    const ScaleSpaceOctave octave = MakeScaleSpaceOctave(image, kSharpSigmaPx);
    if (octave.Level(5).Row(9)[9] != FullOctave().Level(5).Row(9)[9]) {
      state.SkipWithError("other levels");
    }
  }
}
BENCHMARK(BM_ScaleSpaceOfFullOctave)->Unit(benchmark::kMillisecond);

void BM_DetectionInFullOctave(benchmark::State& state) {
  for (auto _ : state) {
    if (DetectSiftExtrema(FullOctave(), {}).size() != Extrema().size()) {
      state.SkipWithError("other extrema");
    }
  }
  state.counters["extrema"] = static_cast<double>(Extrema().size());
}
BENCHMARK(BM_DetectionInFullOctave)->Unit(benchmark::kMillisecond);

void BM_OrientationOfOne(benchmark::State& state) {
  size_t i = 0;
  for (auto _ : state) {
    const SiftOrientations found = FindSiftOrientations(FullOctave(), Extrema()[i]);
    if (found.num == 0) {
      state.SkipWithError("no orientation");
    }
    i = (i + 1) % Extrema().size();
  }
}
BENCHMARK(BM_OrientationOfOne)->Unit(benchmark::kMicrosecond);

void BM_DescriptorOfOne(benchmark::State& state) {
  std::array<float, kSiftDim> descriptor;
  size_t i = 0;
  for (auto _ : state) {
    DescribeSift(FullOctave(), Extrema()[i], 0.3f, descriptor);
    double sq_norm = 0.0;
    for (const float value : descriptor) {
      sq_norm += value * value;
    }
    if (std::abs(std::sqrt(sq_norm) - 512.0) > 20.0) {
      state.SkipWithError("not of length 512");
    }
    i = (i + 1) % Extrema().size();
  }
}
BENCHMARK(BM_DescriptorOfOne)->Unit(benchmark::kMicrosecond);

void BM_Extraction(benchmark::State& state) {
  const FeatureSet expected = ExtractSift(Photo());
  for (auto _ : state) {
    if (ExtractSift(Photo()).descriptors != expected.descriptors) {
      state.SkipWithError("other features");
    }
  }
  CountMegapixels(&state);
  state.counters["features"] = expected.size();
}
BENCHMARK(BM_Extraction)->Unit(benchmark::kMillisecond);

void BM_ReductionOf12Megapixels(benchmark::State& state) {
  GrayImage large{4000, 3000, std::vector<uint8_t>(12'000'000)};
  for (size_t i = 0; i < large.pixels.size(); ++i) {
    large.pixels[i] = static_cast<uint8_t>(i * i >> 9);
  }
  for (auto _ : state) {
    const GrayImage reduced = ReduceByArea(large, 3'000'000);
    if (reduced.width_px != 2000 || reduced.height_px != 1500) {
      state.SkipWithError("other size");
    }
  }
}
BENCHMARK(BM_ReductionOf12Megapixels)->Unit(benchmark::kMillisecond);

// The peer, on one thread.
void BM_OpenCvDefaultSift(benchmark::State& state) {
  cv::setNumThreads(1);
  const cv::Mat image = cv::imdecode(JpegBytes(), cv::IMREAD_GRAYSCALE);
  const auto sift = cv::SIFT::create();
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  for (auto _ : state) {
    sift->detectAndCompute(image, cv::noArray(), keypoints, descriptors);
    if (keypoints.empty()) {
      state.SkipWithError("no features");
    }
  }
  CountMegapixels(&state);
  state.counters["features"] = static_cast<double>(keypoints.size());
}
BENCHMARK(BM_OpenCvDefaultSift)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace cairn
