#include "core/features/sift/sift_descriptor.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/features/sift/arc_tangent.h"
#include "core/simd.h"

namespace cairn {
namespace {

constexpr int kNumCells = 4;  // Along each axis.
constexpr int kNumDirections = 8;
constexpr double kCellSigmas = 3.0;
constexpr double kWindowCells = 2.0;  // Sigma of the Gaussian window, in cells.
constexpr float kLargestShare = 0.2f;
constexpr float kLength = 512.0f;
constexpr float kLargestValue = 255.0f;

constexpr int kSamplesPerCell = 4;
// Linear interpolation between cells reaches half a cell beyond the outermost cells.
constexpr int kNumSamples = (kNumCells + 1) * kSamplesPerCell;
constexpr int kPatchSide = kNumSamples + 2;  // One more on every side, for the differences.
constexpr int kRowFloats = 24;               // Rounded up to whole vectors.
static_assert(kNumSamples <= kRowFloats && kPatchSide <= kRowFloats);

// Has one row of gray levels more than needed, because differences of whole vectors read beyond the
// end.
using Patch = std::array<float, kPatchSide * kRowFloats + kRowFloats>;
// Gradients, indexed by row of cells, direction, and column of samples.
using Columns = std::array<std::array<std::array<float, kRowFloats>, kNumDirections>, kNumCells>;

// share[cell][sample] is the linear interpolation weight times the window.
struct SampleShares {
  float share[kNumCells][kRowFloats] = {};

  SampleShares() {
    for (int i = 0; i < kNumSamples; ++i) {
      const double place = (i + 0.5) / kSamplesPerCell - 0.5 * (kNumCells + 1);
      const double window = std::exp(-0.5 * place * place / (kWindowCells * kWindowCells));
      for (int cell = 0; cell < kNumCells; ++cell) {
        const double distance = std::abs(place - (cell - 0.5 * (kNumCells - 1)));
        share[cell][i] = static_cast<float>(window * std::max(0.0, 1.0 - distance));
      }
    }
  }
};

const SampleShares& Shares() {
  static const SampleShares shares;
  return shares;
}

// Maps samples to pixels of the octave.
struct PatchFrame {
  float origin_x, origin_y;  // Position of the patch's first sample.
  float along_x, along_y;  // Step to the next sample of a row; the step to the next row is (-y, x).
};

PatchFrame FrameOf(const SiftExtremum& extremum, float angle_rad) {
  const double step = kCellSigmas * extremum.sigma_px / kSamplesPerCell;
  const double along_x = step * std::cos(angle_rad), along_y = step * std::sin(angle_rad);
  constexpr double kToCenter = 0.5 * (kPatchSide - 1);
  return {.origin_x = static_cast<float>(extremum.x_px - kToCenter * (along_x - along_y)),
          .origin_y = static_cast<float>(extremum.y_px - kToCenter * (along_y + along_x)),
          .along_x = static_cast<float>(along_x),
          .along_y = static_cast<float>(along_y)};
}

// Samples gray levels by bilinear interpolation. Beyond the border, the levels of the border
// continue.
CAIRN_VECTOR_CLONES
void SamplePatch(const float* __restrict pixels, int stride, float last_x, float last_y,
                 const PatchFrame& frame, float* __restrict patch) {
  for (int row = 0; row < kPatchSide; ++row) {
    const float row_x = frame.origin_x - static_cast<float>(row) * frame.along_y;
    const float row_y = frame.origin_y + static_cast<float>(row) * frame.along_x;
    int first[kRowFloats];
    float share_x[kRowFloats], share_y[kRowFloats];
    for (int i = 0; i < kRowFloats; ++i) {
      float x = row_x + static_cast<float>(i) * frame.along_x;
      float y = row_y + static_cast<float>(i) * frame.along_y;
      x = x > 0.0f ? x : 0.0f;
      y = y > 0.0f ? y : 0.0f;
      x = x < last_x ? x : last_x;
      y = y < last_y ? y : last_y;
      const int whole_x = static_cast<int>(x), whole_y = static_cast<int>(y);
      share_x[i] = x - static_cast<float>(whole_x);
      share_y[i] = y - static_cast<float>(whole_y);
      first[i] = whole_y * stride + whole_x;
    }
    for (int i = 0; i < kRowFloats; ++i) {
      const float* at = pixels + first[i];
      const float top = at[0] + share_x[i] * (at[1] - at[0]);
      const float bottom = at[stride] + share_x[i] * (at[stride + 1] - at[stride]);
      patch[row * kRowFloats + i] = top + share_y[i] * (bottom - top);
    }
  }
}

// Adds the gradients of a row of samples to two rows of cells, weighted by the row's share of each.
[[gnu::always_inline]] inline void AddRow(const float* lengths, const float* directions,
                                          float share_a, float share_b,
                                          std::array<float, kRowFloats>* __restrict cells_a,
                                          std::array<float, kRowFloats>* __restrict cells_b) {
  for (int direction = 0; direction < kNumDirections; ++direction) {
    float* const a = cells_a[direction].data();
    float* const b = cells_b[direction].data();
    for (int i = 0; i < kRowFloats; ++i) {
      float distance = std::fabs(directions[i] - static_cast<float>(direction));
      if (direction == 0) {
        distance = distance < kNumDirections - distance ? distance : kNumDirections - distance;
      }
      const float nearness = 1.0f - distance;
      const float value = nearness > 0.0f ? nearness * lengths[i] : 0.0f;
      a[i] += share_a * value;
      b[i] += share_b * value;
    }
  }
}

// Sums the gradients of all samples over the rows.
CAIRN_VECTOR_CLONES
void SumRows(const float* __restrict patch, const SampleShares& shares,
             Columns* __restrict columns) {
  float lengths[kRowFloats], directions[kRowFloats];
  for (int row = 0; row < kNumSamples; ++row) {
    const float* const center = patch + (row + 1) * kRowFloats + 1;
    for (int i = 0; i < kRowFloats; ++i) {
      const float dx = center[i + 1] - center[i - 1];
      const float dy = center[i + kRowFloats] - center[i - kRowFloats];
      lengths[i] = std::sqrt(dx * dx + dy * dy);
      directions[i] = static_cast<float>(kNumDirections) - DirectionInEighths(dy, dx);
    }
    // The row lies between two rows of cells; the outermost samples have only one neighbor.
    const int cell = std::clamp(row / kSamplesPerCell - 1, 0, kNumCells - 2);
    AddRow(lengths, directions, shares.share[cell][row], shares.share[cell + 1][row],
           (*columns)[cell].data(), (*columns)[cell + 1].data());
  }
}

// Sums the columns into cells.
CAIRN_VECTOR_CLONES
void SumColumns(const Columns& columns, const SampleShares& shares, float* __restrict descriptor) {
  for (int cell_y = 0; cell_y < kNumCells; ++cell_y) {
    for (int cell_x = 0; cell_x < kNumCells; ++cell_x) {
      for (int direction = 0; direction < kNumDirections; ++direction) {
        const float* const values = columns[cell_y][direction].data();
        constexpr int kLanes = 8;
        float sums[kLanes] = {};
        for (int i = 0; i < kRowFloats; i += kLanes) {
          for (int lane = 0; lane < kLanes; ++lane) {
            sums[lane] += shares.share[cell_x][i + lane] * values[i + lane];
          }
        }
        for (int half = kLanes / 2; half > 0; half /= 2) {
          for (int lane = 0; lane < half; ++lane) {
            sums[lane] += sums[lane + half];
          }
        }
        *descriptor++ = sums[0];
      }
    }
  }
}

float Norm(std::span<const float, kSiftDim> values) {
  float sum = 0.0f;
  for (const float value : values) {
    sum += value * value;
  }
  return std::sqrt(sum);
}

void Normalize(std::span<float, kSiftDim> descriptor) {
  const float norm = Norm(descriptor);
  if (!(norm > 0.0f)) {
    return;
  }
  for (float& value : descriptor) {
    value = std::min(value, kLargestShare * norm);
  }
  const float scale = kLength / Norm(descriptor);
  for (float& value : descriptor) {
    value = std::min(std::round(scale * value), kLargestValue);
  }
}

}  // namespace

void DescribeSift(const ScaleSpaceOctave& octave, const SiftExtremum& extremum, float angle_rad,
                  std::span<float, kSiftDim> descriptor) {
  const FloatImage& gaussian = octave.Level(extremum.level);
  // Interpolation also reads the pixel to the right and the pixel below.
  const float last_x = std::nextafter(static_cast<float>(gaussian.width_px() - 1), 0.0f);
  const float last_y = std::nextafter(static_cast<float>(gaussian.height_px() - 1), 0.0f);
  Patch patch;
  SamplePatch(gaussian.Row(0), static_cast<int>(gaussian.stride()), last_x, last_y,
              FrameOf(extremum, angle_rad), patch.data());
  std::fill(patch.begin() + kPatchSide * kRowFloats, patch.end(), 0.0f);
  Columns columns = {};
  SumRows(patch.data(), Shares(), &columns);
  SumColumns(columns, Shares(), descriptor.data());
  Normalize(descriptor);
}

}  // namespace cairn
