// Grey images of floats, and halving and doubling them.
#ifndef CAIRN_INGEST_FEATURES_FLOAT_IMAGE_H_
#define CAIRN_INGEST_FEATURES_FLOAT_IMAGE_H_

#include <cstddef>

#include "core/large_vector.h"
#include "ingest/images/gray_image.h"

namespace cairn {

// Rows begin on cache lines. The values of a new image are undefined.
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
  // Floats from a value to the one below it.
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

// Grey levels, 0 to 255.
FloatImage ToFloatImage(const GrayImage& image);

// Half the width and height, rounded up: every second pixel, from the first on, after a filter of
// 1 4 6 4 1 along each axis, whose variance is kHalvingVariancePx2.
inline constexpr double kHalvingVariancePx2 = 1.0;
FloatImage Halve(const FloatImage& image);

// Twice the width and height, by linear interpolation; every second pixel is one of `image`, the
// first is its first.
FloatImage Double(const FloatImage& image);

}  // namespace cairn

#endif  // CAIRN_INGEST_FEATURES_FLOAT_IMAGE_H_
