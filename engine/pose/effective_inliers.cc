#include "engine/pose/effective_inliers.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <cstdint>

namespace cairn {

double EffectiveInliers(const std::vector<Eigen::Vector2d>& pixels, int width_px, int height_px) {
  constexpr int kGridSide = 128;
  constexpr double kRadiusByDiagonal = 1.0 / 32.0;
  const double radius_px = kRadiusByDiagonal * std::hypot(width_px, height_px);
  const double cell_width_px = static_cast<double>(width_px) / kGridSide;
  const double cell_height_px = static_cast<double>(height_px) / kGridSide;

  std::bitset<kGridSide * kGridSide> covered;
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
      const double half_chord_px = std::sqrt(sq_half_chord);
      // Columns whose centre lies on the chord.
      const int first =
          std::max(0, static_cast<int>(std::ceil((x_px - half_chord_px) / cell_width_px - 0.5)));
      const int last =
          std::min(kGridSide - 1,
                   static_cast<int>(std::floor((x_px + half_chord_px) / cell_width_px - 0.5)));
      for (int column = first; column <= last; ++column) {
        covered.set(row * kGridSide + column);
      }
      summed_area += std::max(0, last - first + 1);
    }
  }
  if (summed_area == 0) {
    return 0.0;
  }
  return static_cast<double>(pixels.size()) * static_cast<double>(covered.count()) /
         static_cast<double>(summed_area);
}

}  // namespace cairn
