// Trees with fine foliage. The leaves give more and stronger keypoints than the houses behind them.
#ifndef CAIRN_CLI_DEMO_STREET_TREES_H_
#define CAIRN_CLI_DEMO_STREET_TREES_H_

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "cli/demo/street/renderer.h"

namespace cairn {

// Plants trees. A tree is a trunk and a crown of twigs. Twigs are upright plates of leaves in
// random directions, visible from both sides, with gaps that show the houses behind. The trees are
// upright along z. Equal seeds give equal trees.
class TreePlanter {
 public:
  explicit TreePlanter(uint64_t seed);

  void Plant(const Eigen::Vector3d& foot, std::vector<TexturedRect>* rects);

 private:
  static constexpr int kNumLooks = 6;

  cv::RNG rng_;
  std::vector<std::shared_ptr<const Texture>> foliage_;  // kNumLooks textures.
  std::shared_ptr<const Texture> bark_;
};

}  // namespace cairn

#endif  // CAIRN_CLI_DEMO_STREET_TREES_H_
