#include "engine/pose/landmark_density.h"

#include <algorithm>
#include <cstddef>

namespace cairn {

LandmarkDensity::LandmarkDensity(const QueryContext& query,
                                 const std::vector<Correspondence>& correspondences,
                                 const Rigid3d& cam_from_anchor, int camera_idx) {
  constexpr size_t kMaxSamples = 1000;
  const Camera& camera = query.CameraAt(camera_idx);
  cell_size_px_ = Eigen::Array2d(camera.width_px(), camera.height_px()) / kSide;
  const Rigid3d own_from_anchor = query.OwnFromFirst(camera_idx) * cam_from_anchor;
  const size_t stride = (correspondences.size() + kMaxSamples - 1) / kMaxSamples;
  std::array<double, kSide * kSide> counts{};
  double num_samples = 0.0;
  for (size_t i = 0; i < correspondences.size(); i += stride) {
    if (correspondences[i].search_area_sq_px > 0.0f) {
      continue;
    }
    num_samples += 1.0;
    const auto pixel = camera.Project(own_from_anchor * correspondences[i].x_in_anchor);
    if (pixel && camera.Contains(*pixel)) {
      counts[CellOf(*pixel)] += 1.0;
    }
  }
  // One extra landmark is spread over the image, so that no cell is empty.
  const double per_count = 1.0 / ((num_samples + 1.0) * cell_size_px_.prod());
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      double sum = 0.0;
      int num_cells = 0;
      for (int v = std::max(0, y - 1); v <= std::min(kSide - 1, y + 1); ++v) {
        for (int u = std::max(0, x - 1); u <= std::min(kSide - 1, x + 1); ++u, ++num_cells) {
          sum += counts[kSide * v + u];
        }
      }
      per_sq_px_[kSide * y + x] = per_count * (sum / num_cells + 1.0 / (kSide * kSide));
    }
  }
}

int LandmarkDensity::CellOf(const Eigen::Vector2d& pixel) const {
  const Eigen::Array2i cell = (pixel.array() / cell_size_px_).cast<int>().max(0).min(kSide - 1);
  return kSide * cell.y() + cell.x();
}

double LandmarkDensity::At(const Eigen::Vector2d& pixel) const { return per_sq_px_[CellOf(pixel)]; }

}  // namespace cairn
