// The attributes of a tile's descriptors that matching reads, in the order of an index.
#ifndef CAIRN_ENGINE_TILES_DESCRIPTOR_PLACES_H_
#define CAIRN_ENGINE_TILES_DESCRIPTOR_PLACES_H_

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/large_vector.h"
#include "storage/tile/tile_views.h"

namespace cairn {

// A grid of 4096 x 4096 points around the landmarks of a tile. A grid point takes 24 bits.
class CoarseGrid {
 public:
  explicit CoarseGrid(const TileLandmarks& tile);

  const Eigen::Vector2f& corner() const { return corner_; }  // In the tile frame, meters.
  float step_m() const { return step_m_; }
  // The largest height of a landmark above or below the tile's origin, meters.
  float max_height_m() const { return max_height_m_; }

  // Returns the grid point nearest to a landmark, in the upper 24 bits.
  uint32_t PackXy(const Eigen::Vector3f& x_in_tile) const {
    // Rounds to the nearest step.
    const Eigen::Vector2f steps =
        (x_in_tile.head<2>() - corner_) * steps_per_m_ + Eigen::Vector2f(0.5f, 0.5f);
    return std::min(static_cast<uint32_t>(steps.x()), kMaxCoordinate) << kXShift |
           std::min(static_cast<uint32_t>(steps.y()), kMaxCoordinate) << kYShift;
  }
  // Returns the offset of that grid point from the corner, in steps.
  static Eigen::Vector2f UnpackXy(uint32_t packed) {
    return {static_cast<float>(packed >> kXShift & kMaxCoordinate),
            static_cast<float>(packed >> kYShift)};
  }

 private:
  static constexpr int kXShift = 8, kYShift = 20;
  static constexpr uint32_t kMaxCoordinate = (uint32_t{1} << (kYShift - kXShift)) - 1;

  Eigen::Vector2f corner_ = Eigen::Vector2f::Zero();
  float step_m_ = 0.0f;
  float steps_per_m_ = 0.0f;
  float max_height_m_ = 0.0f;
};

// In these arrays, the hits of a list are close together, even if they are far apart in the tile.
// Most hits can be rejected by one 32-bit number per descriptor: its exact orientation and its
// landmark's approximate position. Immutable; safe to use from any thread.
class DescriptorPlaces {
 public:
  // `order` is the index's (MatchingIndex::order) and must outlive the object.
  DescriptorPlaces(const TileLandmarks& tile, std::span<const uint32_t> order);
  // For some descriptors of a tile; `landmarks` holds the landmark of each and `grid` is the
  // tile's. `descriptors` must outlive the object. Linear in the number of descriptors.
  DescriptorPlaces(const TileLandmarks& tile, const CoarseGrid& grid,
                   std::span<const uint32_t> descriptors, LargeVector<uint32_t> landmarks);

  size_t size() const { return landmarks_.size(); }
  uint32_t landmark(size_t place) const { return landmarks_[place]; }
  uint32_t descriptor(size_t place) const {
    return order_.empty() ? static_cast<uint32_t>(place) : order_[place];
  }
  uint8_t orientation_code(size_t place) const { return static_cast<uint8_t>(packed_[place]); }
  // Returns the landmark's grid point, in steps from the corner.
  Eigen::Vector2f CoarseXy(size_t place) const { return CoarseGrid::UnpackXy(packed_[place]); }
  const CoarseGrid& grid() const { return grid_; }

  // Prefetch prefetches the memory that orientation_code and CoarseXy read; PrefetchLandmark, the
  // memory that landmark and descriptor read.
  void Prefetch(size_t place) const { __builtin_prefetch(&packed_[place]); }
  void PrefetchLandmark(size_t place) const {
    __builtin_prefetch(&landmarks_[place]);
    if (!order_.empty()) {
      __builtin_prefetch(&order_[place]);
    }
  }

  size_t MemoryBytes() const {
    return (packed_.capacity() + landmarks_.capacity()) * sizeof(uint32_t);
  }
  static constexpr size_t kBytesPerDescriptor = 2 * sizeof(uint32_t);

 private:
  CoarseGrid grid_;
  std::span<const uint32_t> order_;
  LargeVector<uint32_t> packed_;  // Orientation code (8 bits) and grid point (24 bits).
  LargeVector<uint32_t> landmarks_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_DESCRIPTOR_PLACES_H_
