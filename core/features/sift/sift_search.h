// Searches an image for SIFT features octave by octave.
#ifndef CAIRN_CORE_FEATURES_SIFT_SIFT_SEARCH_H_
#define CAIRN_CORE_FEATURES_SIFT_SIFT_SEARCH_H_

#include <vector>

#include "core/features.h"
#include "core/features/sift/float_image.h"
#include "core/features/sift/scale_space.h"
#include "core/features/sift/sift_detector.h"
#include "core/features/sift/sift_extractor.h"
#include "core/images/gray_image.h"
#include "core/stop_function.h"

namespace cairn {

// The search of ExtractSift, step by step: a step is an octave, from the coarsest to that of the
// image. If the image has few features, the doubled image is the last step. After the last step,
// the features are those of ExtractSift. Use from one thread.
class SiftSearch {
 public:
  // Throws as ExtractSift. Keeps copies of its arguments.
  SiftSearch(const GrayImage& image, const SiftOptions& options, StopFunction should_stop = {});

  // True if there is no further step: the octaves have all been searched, there are max_features,
  // or the search was stopped.
  bool is_done() const { return octaves_.empty(); }

  // Searches the next octave, which there must be, and adds its features behind those that
  // `features` has.
  void AddNextOctave(FeatureSet* features);

 private:
  // An image from which an octave is computed.
  struct OctaveImage {
    FloatImage image;
    double sigma_px = 0.0;  // Blur, in the image's own pixels.
    double pixel_px = 0.0;  // Pixel size, in pixels of the reduced image.
    SiftLevels levels;
  };

  // Takes positions in the searched image to positions in the picture that the image shows.
  struct ToPicture {
    double x_scale = 1.0, y_scale = 1.0;
    double left_px = 0.0, top_px = 0.0;
  };

  static OctaveImage Doubled(const FloatImage& image);
  // The image and its successive halvings, from the finest to the coarsest.
  static std::vector<OctaveImage> HalvedImages(const GrayImage& image);
  // From an image that was reduced to `reduced` before the search.
  static ToPicture PictureFrom(const GrayImage& reduced, const GrayImage& image);

  bool is_full() const { return num_features_ == options_.max_features; }
  bool is_stopped() const { return should_stop_ && should_stop_(); }
  // The keypoint of an extremum, without orientation.
  Keypoint KeypointOf(const SiftExtremum& extremum, const OctaveImage& octave) const;
  // Adds the largest keypoints of the octave first, as long as there is room.
  void AddOctave(const OctaveImage& octave_image, FeatureSet* features);

  const SiftOptions options_;
  const StopFunction should_stop_;
  ToPicture to_picture_;
  std::vector<OctaveImage> octaves_;  // Those that have not been searched; the next one is last.
  int num_features_ = 0;              // Those that the search has added.
};

}  // namespace cairn

#endif  // CAIRN_CORE_FEATURES_SIFT_SIFT_SEARCH_H_
