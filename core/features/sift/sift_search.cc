#include "core/features/sift/sift_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/features/sift/sift_descriptor.h"
#include "core/features/sift/sift_orientation.h"
#include "core/images/reduce_image.h"

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

void AppendDescriptors(const std::vector<float>& descriptors, FeatureSet* features) {
  const auto num_before = features->descriptors.rows();
  const auto num_added = static_cast<Eigen::Index>(descriptors.size() / kSiftDim);
  features->descriptors.conservativeResize(num_before + num_added, kSiftDim);
  features->descriptors.bottomRows(num_added) =
      Eigen::Map<const DescriptorMatrix>(descriptors.data(), num_added, kSiftDim);
}

}  // namespace

SiftSearch::OctaveImage SiftSearch::Doubled(const FloatImage& image) {
  return {.image = Double(image),
          .sigma_px = 2.0 * kSharpSigmaPx,
          .pixel_px = 0.5,
          .levels = {.last = kSiftLevelsPerOctave - kNumLevelsTakenOver}};
}

std::vector<SiftSearch::OctaveImage> SiftSearch::HalvedImages(const GrayImage& image) {
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

SiftSearch::ToPicture SiftSearch::PictureFrom(const GrayImage& reduced, const GrayImage& image) {
  const FullPicture full = image.full.value_or(FullPicture());
  return {.x_scale = full.pixel_px * image.width_px / reduced.width_px,
          .y_scale = full.pixel_px * image.height_px / reduced.height_px,
          .left_px = full.left_px,
          .top_px = full.top_px};
}

SiftSearch::SiftSearch(const GrayImage& image, const SiftOptions& options, StopFunction should_stop)
    : options_(options), should_stop_(std::move(should_stop)) {
  options.Validate();
  const bool sized = image.width_px > 0 && image.height_px > 0;
  if (!sized || image.pixels.size() != static_cast<size_t>(image.width_px) * image.height_px) {
    throw Error(ErrorCode::kBadInput,
                "the size of the gray image does not match its number of pixels");
  }
  if (static_cast<int64_t>(image.pixels.size()) <= options.max_pixels) {
    to_picture_ = PictureFrom(image, image);
    octaves_ = HalvedImages(image);
  } else {
    const GrayImage reduced = ReduceByArea(image, options.max_pixels);
    to_picture_ = PictureFrom(reduced, image);
    octaves_ = HalvedImages(reduced);
  }
}

void SiftSearch::AddNextOctave(FeatureSet* features) {
  OctaveImage octave = std::move(octaves_.back());
  octaves_.pop_back();
  AddOctave(octave, features);
  const bool is_doubled = octave.pixel_px == 1.0 && num_features_ < kFewFeatures;
  if ((is_doubled || !octaves_.empty()) && (is_full() || is_stopped())) {
    octaves_.clear();
  } else if (is_doubled) {
    octaves_.push_back(Doubled(octave.image));
  }
}

Keypoint SiftSearch::KeypointOf(const SiftExtremum& extremum, const OctaveImage& octave) const {
  const auto& [x_scale, y_scale, left_px, top_px] = to_picture_;
  return {.x_px = static_cast<float>(left_px + (extremum.x_px * octave.pixel_px + 0.5) * x_scale),
          .y_px = static_cast<float>(top_px + (extremum.y_px * octave.pixel_px + 0.5) * y_scale),
          .scale_px = static_cast<float>(extremum.sigma_px * octave.pixel_px *
                                         std::sqrt(x_scale * y_scale))};
}

void SiftSearch::AddOctave(const OctaveImage& octave_image, FeatureSet* features) {
  const ScaleSpaceOctave octave = MakeScaleSpaceOctave(octave_image.image, octave_image.sigma_px,
                                                       octave_image.levels, should_stop_);
  if (is_stopped()) {
    return;  // The octave may lack levels.
  }
  std::vector<SiftExtremum> extrema = DetectSiftExtrema(octave, {});
  std::stable_sort(
      extrema.begin(), extrema.end(),
      [](const SiftExtremum& a, const SiftExtremum& b) { return a.sigma_px > b.sigma_px; });
  std::vector<float> descriptors;  // Row-major.
  for (const SiftExtremum& extremum : extrema) {
    Keypoint keypoint = KeypointOf(extremum, octave_image);
    const SiftOrientations orientations = FindSiftOrientations(octave, extremum);
    for (int i = 0; i < orientations.num && !is_full(); ++i) {
      const float angle_rad = orientations.angles_rad[i];
      keypoint.orientation_rad = static_cast<float>(WrapAngleRad(angle_rad));
      features->keypoints.push_back(keypoint);
      descriptors.resize(descriptors.size() + kSiftDim);
      DescribeSift(octave, extremum, angle_rad,
                   std::span<float, kSiftDim>(descriptors.end() - kSiftDim, kSiftDim));
      ++num_features_;
    }
    if (is_full()) {
      break;
    }
  }
  AppendDescriptors(descriptors, features);
}

}  // namespace cairn
