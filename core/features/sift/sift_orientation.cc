#include "core/features/sift/sift_orientation.h"

#include <algorithm>
#include <cmath>

#include "core/angles.h"
#include "core/features/sift/arc_tangent.h"
#include "core/simd.h"

namespace cairn {
namespace {

constexpr int kNumBins = 36;
constexpr double kWindowSigmas = 1.5;  // Sigma of the window, in units of the keypoint's sigma.
constexpr double kWindowReach = 3.0;   // Radius of the window, in its own sigmas.
constexpr double kSecondPeakShare = 0.8;
constexpr int kNumSmoothings = 6;

// Fits the largest keypoint of an octave, which lies 1.5 levels above kSiftLevelsPerOctave.
constexpr int kMaxRadius = 21;
constexpr int kMaxSide = 2 * kMaxRadius + 1;

using Histogram = std::array<float, kNumBins>;

struct GradientRow {
  float weights[kMaxSide];  // Length of the gradient times the window.
  float bins[kMaxSide];     // Direction, in bins.
};

// Gradients of the `num` pixels of a row, beginning at `center`. `window` is the factor of the
// window that depends on x.
CAIRN_VECTOR_CLONES
void MeasureRow(const float* __restrict above, const float* __restrict center,
                const float* __restrict below, const float* __restrict window, float row_window,
                int num, GradientRow* __restrict row) {
  for (int i = 0; i < num; ++i) {
    const float dx = center[i + 1] - center[i - 1];
    const float dy = below[i] - above[i];
    row->weights[i] = row_window * window[i] * std::sqrt(dx * dx + dy * dy);
    row->bins[i] = DirectionInEighths(dy, dx) * (static_cast<float>(kNumBins) / 8.0f);
  }
}

// Bin i has its center at i + 0.5. Each gradient is shared between two bins.
void AddRow(const GradientRow& row, int first, int last, float* bins_around) {
  for (int i = first; i <= last; ++i) {
    const float place =
        row.bins[i] + 0.5f;  // In [0.5, kNumBins + 0.5], so there is one extra bin on either side.
    const int bin = static_cast<int>(place);
    const float share = place - static_cast<float>(bin);
    bins_around[bin] += (1.0f - share) * row.weights[i];
    bins_around[bin + 1] += share * row.weights[i];
  }
}

// If the image is blurred by two pixels or more, every second row has the same information as all
// rows.
int RowStep(const SiftExtremum& extremum) { return extremum.sigma_px < 2.0f ? 1 : 2; }

Histogram DirectionsAround(const FloatImage& gaussian, const SiftExtremum& extremum) {
  const double window_sigma = kWindowSigmas * extremum.sigma_px;
  const int radius = std::clamp(static_cast<int>(kWindowReach * window_sigma), 1, kMaxRadius);
  const int x = static_cast<int>(extremum.x_px + 0.5f), y = static_cast<int>(extremum.y_px + 0.5f);
  const int left = std::max(x - radius, 1), right = std::min(x + radius, gaussian.width_px() - 2);
  const int top = std::max(y - radius, 1), bottom = std::min(y + radius, gaussian.height_px() - 2);
  const auto falloff = [&](double distance) {
    return static_cast<float>(std::exp(-0.5 * distance * distance / (window_sigma * window_sigma)));
  };
  float window[kMaxSide];
  for (int i = left; i <= right; ++i) {
    window[i - left] = falloff(i - extremum.x_px);
  }
  const double sq_radius = radius * radius + 0.6;
  std::array<float, kNumBins + 2> bins_around = {};
  GradientRow gradients;
  for (int row = top; row <= bottom; row += RowStep(extremum)) {
    const double dy = row - extremum.y_px;
    const double reach = std::sqrt(std::max(sq_radius - dy * dy, 0.0));
    const int first = std::max(left, static_cast<int>(std::ceil(extremum.x_px - reach)));
    const int last = std::min(right, static_cast<int>(std::floor(extremum.x_px + reach)));
    if (first > last) {
      continue;
    }
    MeasureRow(gaussian.Row(row - 1) + first, gaussian.Row(row) + first,
               gaussian.Row(row + 1) + first, window + (first - left), falloff(dy),
               last - first + 1, &gradients);
    AddRow(gradients, 0, last - first, bins_around.data());
  }
  Histogram histogram;
  std::copy_n(bins_around.begin() + 1, kNumBins, histogram.begin());
  histogram[kNumBins - 1] += bins_around[0];
  histogram[0] += bins_around[kNumBins + 1];
  return histogram;
}

void Smooth(Histogram* histogram) {
  for (int i = 0; i < kNumSmoothings; ++i) {
    const Histogram before = *histogram;
    for (int bin = 0; bin < kNumBins; ++bin) {
      const float left = before[bin == 0 ? kNumBins - 1 : bin - 1];
      const float right = before[bin == kNumBins - 1 ? 0 : bin + 1];
      (*histogram)[bin] = (left + before[bin] + right) / 3.0f;
    }
  }
}

}  // namespace

SiftOrientations FindSiftOrientations(const ScaleSpaceOctave& octave,
                                      const SiftExtremum& extremum) {
  Histogram histogram = DirectionsAround(octave.Level(extremum.level), extremum);
  Smooth(&histogram);
  const float least =
      static_cast<float>(kSecondPeakShare) * *std::max_element(histogram.begin(), histogram.end());
  SiftOrientations orientations;
  for (int bin = 0; bin < kNumBins && orientations.num < kMaxSiftOrientations; ++bin) {
    const float left = histogram[bin == 0 ? kNumBins - 1 : bin - 1];
    const float right = histogram[bin == kNumBins - 1 ? 0 : bin + 1];
    const float value = histogram[bin];
    // For two equal bins, the first is the peak; interpolation puts the peak between them.
    if (!(value > least && value > left && value >= right)) {
      continue;
    }
    const float offset = -0.5f * (right - left) / (right + left - 2.0f * value);
    orientations.angles_rad[orientations.num++] =
        static_cast<float>(2.0 * kPi / kNumBins) * (static_cast<float>(bin) + offset + 0.5f);
  }
  return orientations;
}

}  // namespace cairn
