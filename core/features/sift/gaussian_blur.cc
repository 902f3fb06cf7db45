#include "core/features/sift/gaussian_blur.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "core/check.h"
#include "core/simd.h"

namespace cairn {
namespace {

constexpr int kMaxRadius = 10;

// kernel[k] is the weight of the pixels at distance k. The weights of all 2 * radius + 1 pixels add
// up to one.
using Kernel = std::array<float, kMaxRadius + 1>;

Kernel MakeKernel(double sigma_px, int radius) {
  std::array<double, kMaxRadius + 1> weights = {};
  double sum = 0.0;
  for (int k = 0; k <= radius; ++k) {
    weights[k] = std::exp(-0.5 * k * k / (sigma_px * sigma_px));
    sum += k == 0 ? weights[k] : 2.0 * weights[k];
  }
  Kernel kernel = {};
  for (int k = 0; k <= radius; ++k) {
    kernel[k] = static_cast<float>(weights[k] / sum);
  }
  return kernel;
}

// Blurs one row of an image: first along the columns into `sums`, then along the row into
// `blurred`. K enumerates the pixels on one side, so that the compiler sees sums of fixed length
// and vectorizes over x. `sums` has room for kMaxRadius more values on either side.
template <size_t... K>
[[gnu::always_inline]] inline void BlurRow(const FloatImage& image, int row, const Kernel& kernel,
                                           float* __restrict sums, float* __restrict blurred,
                                           std::index_sequence<K...> /*radius*/) {
  const int width = image.width_px(), last_row = image.height_px() - 1;
  const std::array<float, sizeof...(K)> weights = {kernel[K + 1]...};
  const float center_weight = kernel[0];
  const std::array<const float*, sizeof...(K)> above = {
      image.Row(std::max(row - static_cast<int>(K) - 1, 0))...};
  const std::array<const float*, sizeof...(K)> below = {
      image.Row(std::min(row + static_cast<int>(K) + 1, last_row))...};
  const float* const center = image.Row(row);
  for (int x = 0; x < width; ++x) {
    float sum = center_weight * center[x];
    ((sum += weights[K] * (above[K][x] + below[K][x])), ...);
    sums[x] = sum;
  }
  for (int k = 1; k <= kMaxRadius; ++k) {
    sums[-k] = sums[0];
    sums[width - 1 + k] = sums[width - 1];
  }
  for (int x = 0; x < width; ++x) {
    float sum = center_weight * sums[x];
    ((sum += weights[K] * (sums[x - static_cast<int>(K) - 1] + sums[x + K + 1])), ...);
    blurred[x] = sum;
  }
}

template <int kRadius>
[[gnu::always_inline]] inline void BlurRows(const FloatImage& image, const Kernel& kernel,
                                            float* sums, FloatImage* blurred) {
  for (int row = 0; row < image.height_px(); ++row) {
    BlurRow(image, row, kernel, sums, blurred->Row(row), std::make_index_sequence<kRadius>());
  }
}

CAIRN_VECTOR_CLONES
void BlurAll(const FloatImage& image, const Kernel& kernel, int radius, float* sums,
             FloatImage* blurred) {
  switch (radius) {
    case 4:
      return BlurRows<4>(image, kernel, sums, blurred);
    case 5:
      return BlurRows<5>(image, kernel, sums, blurred);
    case 6:
      return BlurRows<6>(image, kernel, sums, blurred);
    case 8:
      return BlurRows<8>(image, kernel, sums, blurred);
    default:
      return BlurRows<kMaxRadius>(image, kernel, sums, blurred);
  }
}

// The smallest radius supported by BlurAll that covers three sigmas.
int RadiusOf(double sigma_px) {
  const double three_sigmas_px = 3.0 * sigma_px;
  for (const int radius : {4, 5, 6, 8}) {
    if (three_sigmas_px <= radius) {
      return radius;
    }
  }
  return kMaxRadius;
}

}  // namespace

FloatImage GaussianBlur(const FloatImage& image, double sigma_px) {
  CAIRN_CHECK(sigma_px > 0.0 && sigma_px <= kMaxBlurSigmaPx,
              "sigma_px must be in (0, kMaxBlurSigmaPx]");
  const int radius = RadiusOf(sigma_px);
  std::vector<float> sums(static_cast<size_t>(image.width_px()) + 2 * kMaxRadius);
  FloatImage blurred(image.width_px(), image.height_px());
  BlurAll(image, MakeKernel(sigma_px, radius), radius, sums.data() + kMaxRadius, &blurred);
  return blurred;
}

}  // namespace cairn
