#include "engine/tiles/descriptor_places.h"

#include <algorithm>
#include <utility>

namespace cairn {
namespace {

LargeVector<uint32_t> LandmarkOfDescriptor(const Tile& tile) {
  // Most landmarks have a few descriptors: writing that many numbers and going back is faster than
  // to count.
  constexpr size_t kAhead = 4;
  LargeVector<uint32_t> landmark_of_descriptor(tile.num_descriptors() + kAhead);
  for (uint32_t landmark = 0; landmark < tile.num_landmarks(); ++landmark) {
    const uint32_t begin = tile.descriptor_begin[landmark];
    const size_t count = tile.descriptor_begin[landmark + 1] - begin;
    std::fill_n(landmark_of_descriptor.begin() + begin, kAhead, landmark);
    if (count > kAhead) {
      std::fill_n(landmark_of_descriptor.begin() + begin, count, landmark);
    }
  }
  landmark_of_descriptor.resize(tile.num_descriptors());
  return landmark_of_descriptor;
}

LargeVector<uint32_t> InOrder(LargeVector<uint32_t> values, std::span<const uint32_t> order) {
  if (order.empty()) {
    return values;
  }
  LargeVector<uint32_t> ordered(order.size());
  for (size_t i = 0; i < order.size(); ++i) {
    ordered[i] = values[order[i]];
  }
  return ordered;
}

}  // namespace

CoarseGrid::CoarseGrid(const Tile& tile) {
  if (tile.num_landmarks() == 0) {
    return;
  }
  Eigen::Vector3f low = tile.x_in_tile.front(), high = low;
  for (const Eigen::Vector3f& x_in_tile : tile.x_in_tile) {
    low = low.cwiseMin(x_in_tile);
    high = high.cwiseMax(x_in_tile);
  }
  corner_ = low.head<2>();
  max_height_m_ = std::max(-low.z(), high.z());
  step_m_ = std::max((high - low).head<2>().maxCoeff(), 1.0f) / static_cast<float>(kMaxCoordinate);
}

uint32_t CoarseGrid::WordOf(const Eigen::Vector3f& x_in_tile) const {
  const float steps_per_m = 1.0f / step_m_;
  // Rounds to the nearest.
  const Eigen::Vector2f steps =
      (x_in_tile.head<2>() - corner_) * steps_per_m + Eigen::Vector2f(0.5f, 0.5f);
  return std::min(static_cast<uint32_t>(steps.x()), kMaxCoordinate) << kXShift |
         std::min(static_cast<uint32_t>(steps.y()), kMaxCoordinate) << kYShift;
}

DescriptorPlaces::DescriptorPlaces(const Tile& tile, std::span<const uint32_t> order)
    : grid_(tile),
      order_(order),
      words_(tile.num_descriptors()),
      landmarks_(InOrder(LandmarkOfDescriptor(tile), order)) {
  // A landmark's place once, not for each of its descriptors.
  LargeVector<uint32_t> landmark_words(tile.num_landmarks());
  for (size_t i = 0; i < landmark_words.size(); ++i) {
    landmark_words[i] = grid_.WordOf(tile.x_in_tile[i]);
  }
  for (size_t place = 0; place < words_.size(); ++place) {
    words_[place] = landmark_words[landmarks_[place]] | tile.orientation_codes[descriptor(place)];
  }
}

DescriptorPlaces::DescriptorPlaces(const Tile& tile, const CoarseGrid& grid,
                                   std::span<const uint32_t> descriptors,
                                   LargeVector<uint32_t> landmarks)
    : grid_(grid), order_(descriptors), words_(landmarks.size()), landmarks_(std::move(landmarks)) {
  for (size_t place = 0; place < words_.size(); ++place) {
    words_[place] =
        grid_.WordOf(tile.x_in_tile[landmarks_[place]]) | tile.orientation_codes[descriptor(place)];
  }
}

}  // namespace cairn
