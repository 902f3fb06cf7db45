#include "core/features/sift/sift_extractor.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/features/sift/scale_space.h"
#include "core/features/sift/sift_descriptor.h"
#include "core/features/sift/sift_detector.h"
#include "core/features/sift/sift_orientation.h"
#include "core/images/reduce_image.h"
#include "core/require.h"

namespace cairn {
namespace {

// Smaller octaves have no room for the window of a keypoint.
constexpr int kMinOctaveSidePx = 16;
// Photos with fewer features are doubled to find more. Doubling takes four times as long as all
// other octaves together. Photos of half a megapixel or more have this many features.
constexpr int kFewFeatures = 800;
// The octave of the original image takes over the coarsest levels of the doubled image. Each such
// level costs one more blur, instead of a pyramid of four times the pixels.
constexpr int kNumLevelsTakenOver = 1;

// An image from which an octave is computed.
struct OctaveImage {
  FloatImage image;
  double sigma_px = 0.0;  // Blur, in the image's own pixels.
  double pixel_px = 0.0;  // Pixel size, in pixels of the reduced image.
  SiftLevels levels;
};

OctaveImage Doubled(const FloatImage& image) {
  return {.image = Double(image),
          .sigma_px = 2.0 * kSharpSigmaPx,
          .pixel_px = 0.5,
          .levels = {.last = kSiftLevelsPerOctave - kNumLevelsTakenOver}};
}

// The image and its successive halvings, from the finest to the coarsest.
std::vector<OctaveImage> HalvedImages(const GrayImage& image) {
  std::vector<OctaveImage> octaves;
  // VLFeat starts from the doubled image and ignores that interpolation has blurred that image by a
  // variance of 0.5 of its squared pixels. Subtracting that variance gives the same blur here.
  double variance_px2 = kSharpSigmaPx * kSharpSigmaPx - 0.125;
  octaves.push_back({.image = ToFloatImage(image),
                     .sigma_px = std::sqrt(variance_px2),
                     .pixel_px = 1.0,
                     .levels = {.first = 1 - kNumLevelsTakenOver}});
  while (true) {
    const OctaveImage& last = octaves.back();
    if (std::min(last.image.width_px(), last.image.height_px()) < 2 * kMinOctaveSidePx) {
      return octaves;
    }
    variance_px2 = (variance_px2 + kHalvingVariancePx2) / 4.0;
    OctaveImage half{.image = Halve(last.image),
                     .sigma_px = std::sqrt(variance_px2),
                     .pixel_px = 2.0 * last.pixel_px,
                     .levels = {}};
    octaves.push_back(std::move(half));
  }
}

// Takes positions in the searched image to positions in the picture that the image shows.
struct ToPicture {
  double x_scale = 1.0, y_scale = 1.0;
  double left_px = 0.0, top_px = 0.0;
};

// From an image that was reduced to `reduced` before the search.
ToPicture PictureFrom(const GrayImage& reduced, const GrayImage& image) {
  const FullPicture full = image.full.value_or(FullPicture());
  return {.x_scale = full.pixel_px * image.width_px / reduced.width_px,
          .y_scale = full.pixel_px * image.height_px / reduced.height_px,
          .left_px = full.left_px,
          .top_px = full.top_px};
}

// Collects the features of the octaves in turn until there are enough.
class FeatureCollector {
 public:
  FeatureCollector(const SiftOptions& options, const StopFunction& should_stop,
                   const ToPicture& to_picture)
      : options_(options), should_stop_(should_stop), to_picture_(to_picture) {}

  int size() const { return features_.size(); }
  bool is_full() const { return size() == options_.max_features; }
  bool is_stopped() const { return should_stop_ && should_stop_(); }

  // Adds the largest keypoints first, as long as there is room.
  void AddOctave(const OctaveImage& octave_image) {
    const ScaleSpaceOctave octave = MakeScaleSpaceOctave(octave_image.image, octave_image.sigma_px,
                                                         octave_image.levels, should_stop_);
    if (is_stopped()) {
      return;  // The octave may lack levels.
    }
    std::vector<SiftExtremum> extrema = DetectSiftExtrema(octave, {});
    std::stable_sort(
        extrema.begin(), extrema.end(),
        [](const SiftExtremum& a, const SiftExtremum& b) { return a.sigma_px > b.sigma_px; });
    for (const SiftExtremum& extremum : extrema) {
      const SiftOrientations orientations = FindSiftOrientations(octave, extremum);
      for (int i = 0; i < orientations.num && !is_full(); ++i) {
        Add(octave, extremum, orientations.angles_rad[i], octave_image);
      }
    }
  }

  FeatureSet Take() {
    features_.descriptors =
        Eigen::Map<const DescriptorMatrix>(descriptors_.data(), features_.size(), kSiftDim);
    return std::move(features_);
  }

 private:
  void Add(const ScaleSpaceOctave& octave, const SiftExtremum& extremum, float angle_rad,
           const OctaveImage& o) {
    const auto& [x_scale, y_scale, left_px, top_px] = to_picture_;
    features_.keypoints.push_back(
        {.x_px = static_cast<float>(left_px + (extremum.x_px * o.pixel_px + 0.5) * x_scale),
         .y_px = static_cast<float>(top_px + (extremum.y_px * o.pixel_px + 0.5) * y_scale),
         .scale_px =
             static_cast<float>(extremum.sigma_px * o.pixel_px * std::sqrt(x_scale * y_scale)),
         .orientation_rad = static_cast<float>(WrapAngleRad(angle_rad))});
    descriptors_.resize(descriptors_.size() + kSiftDim);
    DescribeSift(octave, extremum, angle_rad,
                 std::span<float, kSiftDim>(descriptors_.end() - kSiftDim, kSiftDim));
  }

  const SiftOptions& options_;
  const StopFunction& should_stop_;
  const ToPicture to_picture_;
  FeatureSet features_;
  std::vector<float> descriptors_;  // Row-major.
};

FeatureSet ExtractFrom(const GrayImage& image, const ToPicture& to_picture,
                       const SiftOptions& options, const StopFunction& should_stop) {
  FeatureCollector collector(options, should_stop, to_picture);
  std::vector<OctaveImage> octaves = HalvedImages(image);
  for (; !octaves.empty() && !collector.is_full() && !collector.is_stopped(); octaves.pop_back()) {
    collector.AddOctave(octaves.back());
    if (octaves.size() == 1 && collector.size() < kFewFeatures && !collector.is_stopped()) {
      collector.AddOctave(Doubled(octaves.back().image));
    }
  }
  return collector.Take();
}

}  // namespace

void SiftOptions::Validate() const {
  RequireOption(max_features >= 1, "sift.max_features must be at least 1");
  RequireOption(max_pixels >= 1, "sift.max_pixels must be at least 1");
}

FeatureSet ExtractSift(const GrayImage& image, const SiftOptions& options,
                       const StopFunction& should_stop) {
  options.Validate();
  const bool sized = image.width_px > 0 && image.height_px > 0;
  if (!sized || image.pixels.size() != static_cast<size_t>(image.width_px) * image.height_px) {
    throw Error(ErrorCode::kBadInput,
                "the size of the gray image does not match its number of pixels");
  }
  if (static_cast<int64_t>(image.pixels.size()) <= options.max_pixels) {
    return ExtractFrom(image, PictureFrom(image, image), options, should_stop);
  }
  const GrayImage reduced = ReduceByArea(image, options.max_pixels);
  return ExtractFrom(reduced, PictureFrom(reduced, image), options, should_stop);
}

}  // namespace cairn
