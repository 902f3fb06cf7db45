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

// For each column, the largest and the smallest difference of a level in three rows.
struct ColumnExtremes {
  const float* highest;
  const float* lowest;
};

CAIRN_VECTOR_CLONES
void FindColumnExtremes(const float* above, const float* center, const float* below, int width,
                        float* __restrict highest, float* __restrict lowest) {
  for (int x = 0; x < width; ++x) {
    const float high = above[x] > center[x] ? above[x] : center[x];
    const float low = above[x] < center[x] ? above[x] : center[x];
    highest[x] = high > below[x] ? high : below[x];
    lowest[x] = low < below[x] ? low : below[x];
  }
}

// Marks the pixels of a row, except the first and last, that are above or below all 26 neighbors in
// their level and the two levels next to it, and beyond the threshold. `marks` has `width` bytes.
CAIRN_VECTOR_CLONES
void MarkExtremaOfRow(const float* above, const float* center, const float* below,
                      const ColumnExtremes& own, const ColumnExtremes& finer,
                      const ColumnExtremes& coarser, int width, float threshold,
                      uint8_t* __restrict marks) {
  const auto larger = [](float a, float b) { return a > b ? a : b; };
  const auto smaller = [](float a, float b) { return a < b ? a : b; };
  for (int x = 1; x < width - 1; ++x) {
    float highest = larger(threshold, larger(above[x], below[x]));
    float lowest = smaller(-threshold, smaller(above[x], below[x]));
    highest = larger(highest, larger(own.highest[x - 1], own.highest[x + 1]));
    lowest = smaller(lowest, smaller(own.lowest[x - 1], own.lowest[x + 1]));
    for (int step = -1; step <= 1; ++step) {
      highest = larger(highest, larger(finer.highest[x + step], coarser.highest[x + step]));
      lowest = smaller(lowest, smaller(finer.lowest[x + step], coarser.lowest[x + step]));
    }
    marks[x] = static_cast<uint8_t>((center[x] > highest) | (center[x] < lowest));
  }
}

// The differences of one level in the three rows around the row that is searched.
class DifferenceRows {
 public:
  explicit DifferenceRows(int width) : rows_(width, 3), extremes_(width, 2) {}

  // Moves on to the next row, whose Gaussians are given, beginning with row 0.
  void Advance(const float* coarser_gaussian, const float* gaussian) {
    SubtractRow(coarser_gaussian, gaussian, rows_.width_px(), rows_.Row(num_rows_ % 3));
    ++num_rows_;
    if (num_rows_ >= 3) {
      FindColumnExtremes(Above(), Center(), Below(), rows_.width_px(), extremes_.Row(0),
                         extremes_.Row(1));
    }
  }

  // After three rows.
  const float* Above() const { return rows_.Row(num_rows_ % 3); }
  const float* Center() const { return rows_.Row((num_rows_ + 1) % 3); }
  const float* Below() const { return rows_.Row((num_rows_ + 2) % 3); }
  ColumnExtremes Extremes() const { return {extremes_.Row(0), extremes_.Row(1)}; }

 private:
  int num_rows_ = 0;
  FloatImage rows_;      // Row y is in row y % 3.
  FloatImage extremes_;  // The highest, the lowest.
};

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
  const auto num_levels = static_cast<size_t>(octave.levels.last - octave.levels.first + 1);
  // Those of the levels that are searched, and of one level to either side.
  std::vector<DifferenceRows> differences;
  for (size_t i = 0; i < num_levels + 2; ++i) {
    differences.emplace_back(width);
  }
  std::vector<std::vector<SiftExtremum>> of_level(num_levels);
  for (int y = 0; y < height; ++y) {
    for (size_t i = 0; i < differences.size(); ++i) {
      differences[i].Advance(octave.gaussians[i + 1].Row(y), octave.gaussians[i].Row(y));
    }
    for (size_t i = 0; y >= 2 && i < num_levels; ++i) {
      const DifferenceRows& own = differences[i + 1];
      MarkExtremaOfRow(own.Above(), own.Center(), own.Below(), own.Extremes(),
                       differences[i].Extremes(), differences[i + 2].Extremes(), width, threshold,
                       marks.data());
      ForEachMark(marks, [&](int x) {
        const int level = octave.levels.first + static_cast<int>(i);
        if (const auto extremum = Refine(octave, options, x, y - 1, level)) {
          of_level[i].push_back(*extremum);
        }
      });
    }
  }
  for (const std::vector<SiftExtremum>& of_one : of_level) {
    extrema.insert(extrema.end(), of_one.begin(), of_one.end());
  }
  return extrema;
}

}  // namespace cairn
