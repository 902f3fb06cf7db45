#include "cli/demo/street/trees.h"

#include <cmath>

#include "cli/demo/street/canvas.h"
#include "cli/demo/street/paint.h"
#include "core/angles.h"

namespace cairn {
namespace {

constexpr double kTrunkM = 0.25;
constexpr double kTrunkHeightM = 4.0;
constexpr double kTwigM = 0.6;
constexpr double kCrownSigmaM = 0.8;
constexpr int kNumTwigs = 80;

// Leaves of a few centimeters, in the sun and in the shade.
Canvas PaintFoliage(cv::RNG* rng) {
  Canvas canvas(kTwigM, kTwigM, kFacadeTexelsPerM, 45.0);
  for (int i = 0; i < 700; ++i) {
    canvas.FillEllipse(rng->uniform(0.0, kTwigM), rng->uniform(0.0, kTwigM),
                       rng->uniform(0.01, 0.025), rng->uniform(0.01, 0.025),
                       rng->uniform(25.0, 235.0));
  }
  return canvas;
}

Canvas PaintBark(cv::RNG* rng) {
  Canvas canvas(kTrunkM, kTrunkHeightM, kFacadeTexelsPerM, 70.0);
  canvas.AddStreaks(rng, 0.03, 0.4, 40.0);
  return canvas;
}

// Adds a plate that is visible from both sides. `foot` is the middle of its lower edge.
void AddPlate(const Eigen::Vector3d& foot, const Eigen::Vector3d& along, double height_m,
              const std::shared_ptr<const Texture>& texture, std::vector<TexturedRect>* rects) {
  const Eigen::Vector3d up = height_m * Eigen::Vector3d::UnitZ();
  rects->push_back({foot - 0.5 * along + up, along, -up, texture});
  rects->push_back({foot + 0.5 * along + up, -along, -up, texture});
}

}  // namespace

TreePlanter::TreePlanter(uint64_t seed) : rng_(seed * 0x9E3779B97F4A7C15ull + 2) {
  for (int i = 0; i < kNumLooks; ++i) {
    foliage_.push_back(PaintFoliage(&rng_).ToTexture());
  }
  bark_ = PaintBark(&rng_).ToTexture();
}

void TreePlanter::Plant(const Eigen::Vector3d& foot, std::vector<TexturedRect>* rects) {
  AddPlate(foot, kTrunkM * Eigen::Vector3d::UnitX(), kTrunkHeightM, bark_, rects);
  AddPlate(foot, kTrunkM * Eigen::Vector3d::UnitY(), kTrunkHeightM, bark_, rects);
  for (int i = 0; i < kNumTwigs; ++i) {
    Eigen::Vector3d place = foot + kTrunkHeightM * Eigen::Vector3d::UnitZ();
    for (double& coordinate : place) {
      coordinate += rng_.gaussian(kCrownSigmaM);
    }
    const double yaw_rad = rng_.uniform(0.0, 2.0 * kPi);
    const Eigen::Vector3d along(std::cos(yaw_rad), std::sin(yaw_rad), 0.0);
    AddPlate(place, kTwigM * along, kTwigM, foliage_[rng_.uniform(0, kNumLooks)], rects);
  }
}

}  // namespace cairn
