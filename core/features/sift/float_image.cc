#include "core/features/sift/float_image.h"

#include <algorithm>
#include <vector>

#include "core/simd.h"

namespace cairn {
namespace {

CAIRN_VECTOR_CLONES
void ToFloats(const uint8_t* pixels, int num_pixels, float* values) {
  for (int i = 0; i < num_pixels; ++i) {
    values[i] = static_cast<float>(pixels[i]);
  }
}

// The second pixel of `sums` corresponds to the first pixel of the rows: `sums` has two more pixels
// on the left and one more on the right. `half` has (width + 1) / 2 pixels.
CAIRN_VECTOR_CLONES
void HalveRow(const float* const rows[5], int width, float* __restrict sums,
              float* __restrict half) {
  const float *a = rows[0], *b = rows[1], *c = rows[2], *d = rows[3], *e = rows[4];
  for (int x = 0; x < width; ++x) {
    sums[x + 2] = a[x] + e[x] + 4.0f * (b[x] + d[x]) + 6.0f * c[x];
  }
  sums[0] = sums[1] = sums[2];
  sums[width + 2] = sums[width + 3] = sums[width + 1];
  for (int x = 0; x < (width + 1) / 2; ++x) {
    half[x] =
        (1.0f / 256.0f) * (sums[2 * x] + sums[2 * x + 4] +
                           4.0f * (sums[2 * x + 1] + sums[2 * x + 3]) + 6.0f * sums[2 * x + 2]);
  }
}

// Writes the mean of two rows to `means`, and the same row at twice the width, interpolated, to
// `twice`.
CAIRN_VECTOR_CLONES
void DoubleRow(const float* above, const float* below, int width, float* __restrict means,
               float* __restrict twice) {
  for (int x = 0; x < width; ++x) {
    means[x] = 0.5f * (above[x] + below[x]);
  }
  means[width] = means[width - 1];
  for (int x = 0; x < width; ++x) {
    twice[2 * x] = means[x];
    twice[2 * x + 1] = 0.5f * (means[x] + means[x + 1]);
  }
}

}  // namespace

FloatImage ToFloatImage(const GrayImage& image) {
  FloatImage values(image.width_px, image.height_px);
  for (int row = 0; row < image.height_px; ++row) {
    const size_t first = static_cast<size_t>(row) * image.width_px;
    ToFloats(image.pixels.data() + first, image.width_px, values.Row(row));
  }
  return values;
}

FloatImage Halve(const FloatImage& image) {
  FloatImage half((image.width_px() + 1) / 2, (image.height_px() + 1) / 2);
  std::vector<float> sums(static_cast<size_t>(image.width_px()) + 4);
  for (int row = 0; row < half.height_px(); ++row) {
    const float* rows[5];
    for (int i = 0; i < 5; ++i) {
      rows[i] = image.Row(std::clamp(2 * row + i - 2, 0, image.height_px() - 1));
    }
    HalveRow(rows, image.width_px(), sums.data(), half.Row(row));
  }
  return half;
}

FloatImage Double(const FloatImage& image) {
  FloatImage twice(2 * image.width_px(), 2 * image.height_px());
  std::vector<float> means(static_cast<size_t>(image.width_px()) + 1);
  for (int row = 0; row < twice.height_px(); ++row) {
    const int below = std::min((row + 1) / 2, image.height_px() - 1);
    DoubleRow(image.Row(row / 2), image.Row(below), image.width_px(), means.data(), twice.Row(row));
  }
  return twice;
}

}  // namespace cairn
