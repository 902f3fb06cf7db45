#include "engine/places/tile_signature.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace cairn {
namespace {

// The middle of the cameras that saw a landmark.
struct CameraMean {
  Eigen::Vector2d sum_in_tile = Eigen::Vector2d::Zero();
  int num_cameras = 0;
};

std::vector<CameraMean> CameraMeans(const Tile& tile) {
  std::vector<CameraMean> means(tile.num_landmarks());
  for (size_t k = 0; k < tile.num_keyframes(); ++k) {
    const Eigen::Vector2d center_in_tile =
        tile.keyframes[k].cam_from_tile.Inverse().translation.head<2>();
    for (const uint32_t landmark : tile.LandmarksOfKeyframe(k)) {
      means[landmark].sum_in_tile += center_in_tile;
      ++means[landmark].num_cameras;
    }
  }
  return means;
}

uint8_t CellOf(const Tile& tile, const CameraMean& mean, size_t landmark) {
  if (mean.num_cameras == 0) {
    return PlaceCells::Containing(tile.x_in_tile[landmark].head<2>().cast<double>());
  }
  return PlaceCells::Containing(mean.sum_in_tile / mean.num_cameras);
}

// Every second landmark comes first, of the others every second follows, and so on, in reverse: any
// prefix is spread evenly over the tile.
std::vector<uint32_t> EvenOrder(size_t num_landmarks) {
  std::vector<uint32_t> order;
  order.reserve(num_landmarks);
  const size_t first_step = std::bit_ceil(std::max<size_t>(1, num_landmarks));
  for (size_t step = first_step; step >= 1; step /= 2) {
    // Multiples of twice the step are taken already.
    const size_t between = step == first_step ? step : 2 * step;
    for (size_t i = step == first_step ? 0 : step; i < num_landmarks; i += between) {
      order.push_back(static_cast<uint32_t>(i));
    }
  }
  return order;
}

}  // namespace

uint8_t PlaceCells::Containing(const Eigen::Vector2d& xy_in_tile) {
  const auto place = [](double coordinate_m) {
    const double cell = std::floor((coordinate_m + 0.5 * TileId::kSideM) / kSideM);
    return static_cast<int>(std::clamp(cell, 0.0, kPerSide - 1.0));
  };
  return static_cast<uint8_t>(place(xy_in_tile.y()) * kPerSide + place(xy_in_tile.x()));
}

TileSignature MakeTileSignature(const Tile& tile, size_t max_descriptors) {
  TileSignature signature;
  signature.id = tile.id;
  const size_t size = std::min(max_descriptors, tile.num_descriptors());
  const auto code_size = static_cast<size_t>(tile.code_size);
  signature.codes.reserve(size * code_size);
  signature.traits.reserve(size);
  const std::vector<CameraMean> means = CameraMeans(tile);
  for (const uint32_t landmark : EvenOrder(tile.num_landmarks())) {
    const uint8_t cell = CellOf(tile, means[landmark], landmark);
    for (uint32_t i = tile.descriptor_begin[landmark];
         i < tile.descriptor_begin[landmark + 1] && signature.size() < size; ++i) {
      const auto code = tile.codes.begin() + static_cast<ptrdiff_t>(i * code_size);
      signature.codes.insert(signature.codes.end(), code, code + tile.code_size);
      signature.traits.push_back({cell, tile.orientation_codes[i], tile.azimuth_codes[i]});
    }
  }
  return signature;
}

}  // namespace cairn
