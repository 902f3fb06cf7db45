// What finds features in an image.
#ifndef CAIRN_CORE_FEATURES_FEATURE_EXTRACTOR_H_
#define CAIRN_CORE_FEATURES_FEATURE_EXTRACTOR_H_

#include <string>

#include "core/features.h"
#include "core/images/gray_image.h"
#include "core/stop_function.h"

namespace cairn {

// A program chooses an extractor and passes it to what needs features of photos. Safe to call from
// any thread.
class FeatureExtractor {
 public:
  virtual ~FeatureExtractor() = default;

  // The kind of the descriptors, as maps and requests name it: "sift". Only descriptors of one type
  // can be compared.
  virtual std::string descriptor_type() const = 0;
  // The numbers of a descriptor.
  virtual int descriptor_dim() const = 0;
  // Names the values of all options: extractors of one type with equal settings find the same
  // features.
  virtual std::string settings() const = 0;

  // Returns raw features. Descriptors are whole numbers from 0 to 255, which mapping keeps as
  // bytes. Keypoints are in pixels of the picture that the image shows (GrayImage::full). An
  // extractor that knows no size or no orientation of keypoints gives the values of
  // core/keypoint_shape.h. Polls `should_stop`; once it returns true, returns only some of the
  // features. Throws Error(kBadInput) if the image's size does not match the number of its pixels.
  virtual FeatureSet Extract(const GrayImage& image,
                             const StopFunction& should_stop = {}) const = 0;
};

}  // namespace cairn

#endif  // CAIRN_CORE_FEATURES_FEATURE_EXTRACTOR_H_
