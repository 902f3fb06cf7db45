// Trees with fine foliage, whose leaves outnumber and outshine what stands behind them.
#ifndef CAIRN_LAB_STREET_TREES_H_
#define CAIRN_LAB_STREET_TREES_H_

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "lab/street/renderer.h"

namespace cairn {

// Plants trees: a trunk, and a crown of twigs, which are upright plates of leaves that face any
// way, seen from both sides, with gaps through which the houses appear. Upright along z. Equal
// seeds make equal trees.
class TreePlanter {
 public:
  explicit TreePlanter(uint64_t seed);

  void Plant(const Eigen::Vector3d& foot, std::vector<TexturedRect>* rects);

 private:
  static constexpr int kNumLooks = 6;

  cv::RNG rng_;
  std::vector<std::shared_ptr<const Texture>> foliage_;  // kNumLooks of it.
  std::shared_ptr<const Texture> bark_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_STREET_TREES_H_
