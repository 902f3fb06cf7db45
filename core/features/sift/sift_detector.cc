#include "core/features/sift/sift_detector.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>

#include "core/simd.h"

namespace cairn {
namespace {

constexpr double kGrayLevels = 255.0;
// Refinement may raise the contrast, so pixels slightly below the threshold are also tried.
constexpr double kTriedShare = 0.8;
constexpr int kMaxSteps = 5;
// For a larger offset, expanding about the neighboring pixel is more accurate.
constexpr double kStepAtPx = 0.6;
constexpr double kMaxOffsetPx = 1.5;

CAIRN_VECTOR_CLONES
void SubtractRow(const float* a, const float* b, int width, float* __restrict difference) {
  for (int x = 0; x < width; ++x) {
    difference[x] = a[x] - b[x];
  }
}

// Marks the pixels of a row, except the first and last, that are above or below all eight neighbors
// of their level and beyond the threshold. `marks` has `width` bytes.
CAIRN_VECTOR_CLONES
void MarkExtremaOfRow(const float* above, const float* center, const float* below, int width,
                      float threshold, uint8_t* __restrict marks) {
  const auto larger = [](float a, float b) { return a > b ? a : b; };
  const auto smaller = [](float a, float b) { return a < b ? a : b; };
  for (int x = 1; x < width - 1; ++x) {
    float highest = threshold, lowest = -threshold;
    for (int step = -1; step <= 1; ++step) {
      highest = larger(highest, larger(above[x + step], below[x + step]));
      lowest = smaller(lowest, smaller(above[x + step], below[x + step]));
    }
    highest = larger(highest, larger(center[x - 1], center[x + 1]));
    lowest = smaller(lowest, smaller(center[x - 1], center[x + 1]));
    marks[x] = static_cast<uint8_t>((center[x] > highest) | (center[x] < lowest));
  }
}

// The differences around a pixel of a level. The pixel is not on the border.
class Neighborhood {
 public:
  Neighborhood(const ScaleSpaceOctave& octave, int x, int y, int level)
      : stride_(static_cast<ptrdiff_t>(octave.gaussians[0].stride())) {
    for (int i = 0; i < 4; ++i) {
      gaussians_[i] = octave.Level(level - 1 + i).Row(y) + x;
    }
  }

  float At(int dx, int dy, int ds) const {
    const ptrdiff_t offset = dy * stride_ + dx;
    return gaussians_[ds + 2][offset] - gaussians_[ds + 1][offset];
  }

  // True if the pixel is above, or below, all nine pixels of the level at distance `ds`.
  bool IsBeyondLevel(int ds) const {
    const float sign = At(0, 0, 0) > 0.0f ? 1.0f : -1.0f;
    const float value = sign * At(0, 0, 0);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (sign * At(dx, dy, ds) >= value) {
          return false;
        }
      }
    }
    return true;
  }

  // The gradient in x, y and level, by central differences.
  Eigen::Vector3d Gradient() const {
    return 0.5 * Eigen::Vector3d(At(1, 0, 0) - At(-1, 0, 0), At(0, 1, 0) - At(0, -1, 0),
                                 At(0, 0, 1) - At(0, 0, -1));
  }
  Eigen::Matrix3d Hessian() const {
    const double twice = 2.0 * At(0, 0, 0);
    const double xx = At(1, 0, 0) + At(-1, 0, 0) - twice;
    const double yy = At(0, 1, 0) + At(0, -1, 0) - twice;
    const double ss = At(0, 0, 1) + At(0, 0, -1) - twice;
    const double xy = 0.25 * (At(1, 1, 0) + At(-1, -1, 0) - At(-1, 1, 0) - At(1, -1, 0));
    const double xs = 0.25 * (At(1, 0, 1) + At(-1, 0, -1) - At(-1, 0, 1) - At(1, 0, -1));
    const double ys = 0.25 * (At(0, 1, 1) + At(0, -1, -1) - At(0, -1, 1) - At(0, 1, -1));
    Eigen::Matrix3d hessian;
    hessian << xx, xy, xs, xy, yy, ys, xs, ys, ss;
    return hessian;
  }

 private:
  const ptrdiff_t stride_;
  const float* gaussians_[4];  // From the level below to two levels above.
};

// A step of -1, 0 or 1 that does not reach the border.
int StepTowards(double offset, int at, int size) {
  return (offset > kStepAtPx && at < size - 2 ? 1 : 0) - (offset < -kStepAtPx && at > 1 ? 1 : 0);
}

bool IsOnEdge(const Eigen::Matrix3d& hessian) {
  constexpr double kEdgeThreshold = 10.0;  // Ratio of the principal curvatures; COLMAP's.
  const double trace = hessian(0, 0) + hessian(1, 1);
  const double determinant = hessian(0, 0) * hessian(1, 1) - hessian(0, 1) * hessian(0, 1);
  const double limit = (kEdgeThreshold + 1.0) * (kEdgeThreshold + 1.0) / kEdgeThreshold;
  return !(determinant > 0.0 && trace * trace < limit * determinant);
}

// Returns nothing unless there is a stable extremum of enough contrast.
std::optional<SiftExtremum> Refine(const ScaleSpaceOctave& octave,
                                   const SiftDetectorOptions& options, int x, int y, int level) {
  const int width = octave.gaussians[0].width_px(), height = octave.gaussians[0].height_px();
  Eigen::Vector3d gradient, offset;
  Eigen::Matrix3d hessian;
  double value = 0.0;
  for (int i = 0, step_x = 0, step_y = 0; i < kMaxSteps; ++i) {
    x += step_x, y += step_y;
    const Neighborhood around(octave, x, y, level);
    value = around.At(0, 0, 0);
    gradient = around.Gradient();
    hessian = around.Hessian();
    bool is_invertible = false;
    Eigen::Matrix3d inverse;
    hessian.computeInverseWithCheck(inverse, is_invertible);
    if (!is_invertible) {
      return std::nullopt;
    }
    offset = -inverse * gradient;
    step_x = StepTowards(offset.x(), x, width), step_y = StepTowards(offset.y(), y, height);
    if (step_x == 0 && step_y == 0) {
      break;
    }
  }
  const double contrast = std::abs(value + 0.5 * gradient.dot(offset));
  const double refined_level = level + offset.z();
  const bool is_inside = x + offset.x() >= 0.0 && x + offset.x() <= width - 1 &&
                         y + offset.y() >= 0.0 && y + offset.y() <= height - 1 &&
                         refined_level >= octave.levels.first - 1 &&
                         refined_level <= octave.levels.last + 1;
  const bool is_near = offset.cwiseAbs().maxCoeff() < kMaxOffsetPx;  // False for NaN.
  if (!is_near || !is_inside || contrast <= options.contrast_threshold * kGrayLevels ||
      IsOnEdge(hessian)) {
    return std::nullopt;
  }
  return SiftExtremum{.x_px = static_cast<float>(x + offset.x()),
                      .y_px = static_cast<float>(y + offset.y()),
                      .sigma_px = static_cast<float>(SiftSigmaPx(refined_level)),
                      .level = level,
                      .contrast = static_cast<float>(contrast)};
}

// Calls use(x) for each marked pixel.
template <typename Use>
void ForEachMark(const std::vector<uint8_t>& marks, const Use& use) {
  constexpr size_t kWordBytes = sizeof(uint64_t);
  for (size_t first = 0; first < marks.size(); first += kWordBytes) {
    uint64_t word;
    std::memcpy(&word, marks.data() + first, kWordBytes);
    if (word == 0) {
      continue;
    }
    for (size_t x = first; x < first + kWordBytes; ++x) {
      if (marks[x] != 0) {
        use(static_cast<int>(x));
      }
    }
  }
}

}  // namespace

std::vector<SiftExtremum> DetectSiftExtrema(const ScaleSpaceOctave& octave,
                                            const SiftDetectorOptions& options) {
  const int width = octave.gaussians[0].width_px(), height = octave.gaussians[0].height_px();
  std::vector<SiftExtremum> extrema;
  if (width < 3 || height < 3) {
    return extrema;
  }
  const auto threshold = static_cast<float>(kTriedShare * options.contrast_threshold * kGrayLevels);
  std::vector<uint8_t> marks((static_cast<size_t>(width) + 7) / 8 * 8);
  FloatImage differences(width, 3);  // The row being searched and its two neighbors.
  for (int level = octave.levels.first; level <= octave.levels.last; ++level) {
    for (int y = 0; y < height; ++y) {
      SubtractRow(octave.Level(level + 1).Row(y), octave.Level(level).Row(y), width,
                  differences.Row(y % 3));
      if (y < 2) {
        continue;
      }
      MarkExtremaOfRow(differences.Row((y - 2) % 3), differences.Row((y - 1) % 3),
                       differences.Row(y % 3), width, threshold, marks.data());
      ForEachMark(marks, [&](int x) {
        const Neighborhood around(octave, x, y - 1, level);
        if (!around.IsBeyondLevel(-1) || !around.IsBeyondLevel(1)) {
          return;
        }
        if (const auto extremum = Refine(octave, options, x, y - 1, level)) {
          extrema.push_back(*extremum);
        }
      });
    }
  }
  return extrema;
}

}  // namespace cairn
