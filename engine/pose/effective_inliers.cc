#include "engine/pose/effective_inliers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace cairn {
namespace {

// Returns a number whose lowest `count` bits are set; `count` may lie outside [0, 64].
uint64_t BitsBelow(int count) {
  return count <= 0 ? 0 : count >= 64 ? ~uint64_t{0} : (uint64_t{1} << count) - 1;
}

// Returns the smallest integer >= max(value, 0). Avoids std::ceil, which is a function call.
int CeilOrZero(double value) {
  const int truncated = static_cast<int>(value);
  return std::max(0, truncated + (truncated < value ? 1 : 0));
}

}  // namespace

double EffectiveInliers(const std::vector<Eigen::Vector2d>& pixels, int width_px, int height_px) {
  constexpr int kGridSide = 128;
  constexpr double kRadiusByDiagonal = 1.0 / 32.0;
  const double radius_px = kRadiusByDiagonal * std::hypot(width_px, height_px);
  const double cell_width_px = static_cast<double>(width_px) / kGridSide;
  const double cells_per_px = 1.0 / cell_width_px;
  const double cell_height_px = static_cast<double>(height_px) / kGridSide;

  std::array<std::array<uint64_t, 2>, kGridSide> covered{};  // One bit per cell.
  int64_t summed_area = 0;
  for (const Eigen::Vector2d& pixel : pixels) {
    const double x_px = std::clamp(pixel.x(), 0.0, static_cast<double>(width_px));
    const double y_px = std::clamp(pixel.y(), 0.0, static_cast<double>(height_px));
    const int first_row = std::max(0, static_cast<int>((y_px - radius_px) / cell_height_px));
    const int last_row =
        std::min(kGridSide - 1, static_cast<int>((y_px + radius_px) / cell_height_px));
    for (int row = first_row; row <= last_row; ++row) {
      const double dy_px = (row + 0.5) * cell_height_px - y_px;
      const double sq_half_chord = radius_px * radius_px - dy_px * dy_px;
      if (sq_half_chord <= 0.0) {
        continue;
      }
      // The columns whose center lies on the chord are [begin, end).
      const double half_chord_px = std::sqrt(sq_half_chord);
      const int begin = CeilOrZero((x_px - half_chord_px) * cells_per_px - 0.5);
      const int end =
          std::min(kGridSide, static_cast<int>((x_px + half_chord_px) * cells_per_px + 0.5));
      covered[row][0] |= BitsBelow(end) & ~BitsBelow(begin);
      covered[row][1] |= BitsBelow(end - 64) & ~BitsBelow(begin - 64);
      summed_area += std::max(0, end - begin);
    }
  }
  if (summed_area == 0) {
    return 0.0;
  }
  int64_t union_area = 0;
  for (const auto& row : covered) {
    union_area += std::popcount(row[0]) + std::popcount(row[1]);
  }
  return static_cast<double>(pixels.size()) * static_cast<double>(union_area) /
         static_cast<double>(summed_area);
}

}  // namespace cairn
