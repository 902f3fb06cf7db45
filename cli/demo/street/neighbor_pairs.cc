#include "cli/demo/street/neighbor_pairs.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

namespace cairn {
namespace {

constexpr double kMinBaselineM = 0.5;  // A shorter baseline cannot triangulate.
constexpr double kMaxBaselineM = 30.0;
constexpr double kMaxTurnRad = 1.05;  // Between viewing directions; SIFT tolerates no more.
constexpr double kMinOverlap =
    0.1;  // Share of one image's view, 4 to 32 m ahead, that the other sees.

// Groups images by the ground square they are in. The squares are kMaxBaselineM wide, so the
// neighbors of an image are in its own square or in the eight around it.
class ImageGrid {
 public:
  ImageGrid(const std::vector<PosedFeatures>& images, double cell_m) : cell_m_(cell_m) {
    for (size_t i = 0; i < images.size(); ++i) {
      cells_[CellOf(images[i].center_in_world)].push_back(static_cast<int>(i));
    }
  }

  template <typename Visit>
  void ForEachAround(const Eigen::Vector3d& x_in_world, const Visit& visit) const {
    const auto [cell_x, cell_y] = CellOf(x_in_world);
    for (int64_t x = cell_x - 1; x <= cell_x + 1; ++x) {
      for (int64_t y = cell_y - 1; y <= cell_y + 1; ++y) {
        if (const auto cell = cells_.find({x, y}); cell != cells_.end()) {
          std::for_each(cell->second.begin(), cell->second.end(), visit);
        }
      }
    }
  }

 private:
  using Cell = std::pair<int64_t, int64_t>;

  Cell CellOf(const Eigen::Vector3d& x_in_world) const {
    return {static_cast<int64_t>(std::floor(x_in_world.x() / cell_m_)),
            static_cast<int64_t>(std::floor(x_in_world.y() / cell_m_))};
  }

  double cell_m_;
  std::map<Cell, std::vector<int>> cells_;
};

// Returns the share of the view of `a`, sampled by points, that `b` sees.
double ViewOverlap(const PosedFeatures& a, const PosedFeatures& b) {
  constexpr int kColumns = 5, kRows = 4;
  constexpr double kDepthsM[] = {4.0, 8.0, 16.0, 32.0};
  const Rigid3d b_from_a = b.cam_from_world * a.cam_from_world.Inverse();
  int num_points = 0, num_seen = 0;
  for (int i = 0; i < kColumns * kRows; ++i) {
    const auto ray = a.camera->Unproject({(i % kColumns + 0.5) / kColumns * a.camera->width_px(),
                                          (i / kColumns + 0.5) / kRows * a.camera->height_px()});
    for (const double depth_m : kDepthsM) {
      ++num_points;
      if (ray) {
        const auto pixel = b.camera->Project(b_from_a * Eigen::Vector3d(depth_m * *ray));
        num_seen += pixel && b.camera->Contains(*pixel) ? 1 : 0;
      }
    }
  }
  return static_cast<double>(num_seen) / num_points;
}

}  // namespace

std::vector<std::pair<int, int>> FindNeighborPairs(const std::vector<PosedFeatures>& images,
                                                   int max_neighbors) {
  const ImageGrid grid(images, kMaxBaselineM);
  const double min_cos_turn = std::cos(kMaxTurnRad);
  std::vector<std::pair<int, int>> pairs;
  for (int a = 0; a < static_cast<int>(images.size()); ++a) {
    const Eigen::Vector3d forward_in_world =
        images[a].cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    // Overlaps are negated, so that the largest sorts first.
    std::vector<std::pair<double, int>> by_overlap;
    grid.ForEachAround(images[a].center_in_world, [&](int b) {
      const double baseline_m = (images[b].center_in_world - images[a].center_in_world).norm();
      if (baseline_m < kMinBaselineM || baseline_m > kMaxBaselineM ||
          (images[b].cam_from_world.rotation * forward_in_world).z() < min_cos_turn) {
        return;
      }
      const double overlap =
          std::min(ViewOverlap(images[a], images[b]), ViewOverlap(images[b], images[a]));
      if (overlap >= kMinOverlap) {
        by_overlap.emplace_back(-overlap, b);
      }
    });
    std::sort(by_overlap.begin(), by_overlap.end());
    by_overlap.resize(std::min(by_overlap.size(), static_cast<size_t>(max_neighbors)));
    for (const auto& [negated_overlap, b] : by_overlap) {
      pairs.emplace_back(std::minmax(a, b));
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace cairn
