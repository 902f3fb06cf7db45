// Gray images of floats, with functions to halve and double them.
#ifndef CAIRN_CORE_FEATURES_SIFT_FLOAT_IMAGE_H_
#define CAIRN_CORE_FEATURES_SIFT_FLOAT_IMAGE_H_

#include <cstddef>

#include "core/images/gray_image.h"
#include "core/large_vector.h"

namespace cairn {

// Rows are aligned to cache lines. A new image has undefined values.
class FloatImage {
 public:
  FloatImage() = default;
  FloatImage(int width_px, int height_px)
      : width_px_(width_px),
        height_px_(height_px),
        stride_((static_cast<size_t>(width_px) + kLineFloats - 1) / kLineFloats * kLineFloats),
        values_(stride_ * height_px) {}

  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }
  // The number of floats from a value to the value below it.
  size_t stride() const { return stride_; }

  float* Row(int row) { return values_.data() + row * stride_; }
  const float* Row(int row) const { return values_.data() + row * stride_; }

 private:
  static constexpr size_t kLineFloats = 64 / sizeof(float);

  int width_px_ = 0;
  int height_px_ = 0;
  size_t stride_ = 0;
  LargeVector<float> values_;
};

// Converts to gray levels from 0 to 255.
FloatImage ToFloatImage(const GrayImage& image);

// Halves width and height, rounded up. Filters with 1 4 6 4 1 along each axis (variance
// kHalvingVariancePx2) and keeps every second pixel, beginning with the first.
inline constexpr double kHalvingVariancePx2 = 1.0;
FloatImage Halve(const FloatImage& image);

// Doubles width and height by linear interpolation. Every second pixel, beginning with the first,
// is a pixel of `image`.
FloatImage Double(const FloatImage& image);

}  // namespace cairn

#endif  // CAIRN_CORE_FEATURES_SIFT_FLOAT_IMAGE_H_
