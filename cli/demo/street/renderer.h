// Renders photos of textured rectangles with a z-buffer, 2 x 2 supersampling and ripmap-filtered
// textures.
#ifndef CAIRN_CLI_DEMO_STREET_RENDERER_H_
#define CAIRN_CLI_DEMO_STREET_RENDERER_H_

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "cli/demo/street/texture.h"
#include "core/camera.h"
#include "core/images/gray_image.h"
#include "core/rigid3.h"

namespace cairn {

// A rectangle in the enu frame. Only one side is visible: the side from which the texture's u axis
// runs to the right and its v axis down.
struct TexturedRect {
  Eigen::Vector3d corner_in_enu;  // The corner with u = v = 0.
  Eigen::Vector3d u_in_enu;       // Along the whole width, meters.
  Eigen::Vector3d v_in_enu;       // Along the whole height, meters; perpendicular to u.
  std::shared_ptr<const Texture> texture;
};

// Effects of the camera on a photo.
struct PhotoEffects {
  double gain = 1.0;         // Exposure.
  double vignetting = 0.25;  // Loss of light at the corners.
  double noise_sigma = 1.0;  // Gray levels.
  uint64_t noise_seed = 0;
};

// The geometry is exact: a pixel shows the surface that its ray hits. Projections of scene points
// by `Camera` therefore agree with the rendered pixels to a small fraction of a pixel. Immutable;
// safe to use from any thread.
class Renderer {
 public:
  explicit Renderer(std::vector<TexturedRect> rects) : rects_(std::move(rects)) {}

  const std::vector<TexturedRect>& rects() const { return rects_; }

  // `camera` must be a PINHOLE. Time is linear in the pixels, the rectangles and the area that they
  // cover.
  GrayImage Render(const Camera& camera, const Rigid3d& cam_from_enu,
                   const PhotoEffects& effects) const;

  // Returns the distance from `origin_in_enu` along the unit vector `direction_in_enu` to the first
  // front of a rectangle; infinite if the ray hits none. Time is linear in the rectangles.
  double FreeSightM(const Eigen::Vector3d& origin_in_enu,
                    const Eigen::Vector3d& direction_in_enu) const;

 private:
  std::vector<TexturedRect> rects_;
};

}  // namespace cairn

#endif  // CAIRN_CLI_DEMO_STREET_RENDERER_H_
