// Photographs textured rectangles: z-buffer, 2 x 2 supersampling, ripmap-filtered textures.
#ifndef CAIRN_LAB_STREET_RENDERER_H_
#define CAIRN_LAB_STREET_RENDERER_H_

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/camera.h"
#include "core/rigid3.h"
#include "ingest/images/gray_image.h"
#include "lab/street/texture.h"

namespace cairn {

// A rectangle in the enu frame, seen from one side only: the side from which the texture's u axis
// runs to the right and its v axis down.
struct TexturedRect {
  Eigen::Vector3d corner_in_enu;  // Where u = v = 0.
  Eigen::Vector3d u_in_enu;       // Along the whole width, metres.
  Eigen::Vector3d v_in_enu;       // Along the whole height, metres; perpendicular to u.
  std::shared_ptr<const Texture> texture;
};

// What a photo has that the scene has not.
struct PhotoEffects {
  double gain = 1.0;         // Exposure.
  double vignetting = 0.25;  // Loss of light at the corners.
  double noise_sigma = 1.0;  // Grey levels.
  uint64_t noise_seed = 0;
};

// Exact geometry: a pixel shows what the ray through it hits, so projections of scene points by
// `Camera` and rendered pixels agree to a small fraction of a pixel. Immutable; safe to use from
// any thread.
class Renderer {
 public:
  explicit Renderer(std::vector<TexturedRect> rects) : rects_(std::move(rects)) {}

  const std::vector<TexturedRect>& rects() const { return rects_; }

  // `camera` must be a PINHOLE. Time is linear in pixels, rectangles and their covered area.
  GrayImage Render(const Camera& camera, const Rigid3d& cam_from_enu,
                   const PhotoEffects& effects) const;

  // How far a ray from `origin_in_enu` along the unit vector `direction_in_enu` gets before it hits
  // the front of a rectangle; infinite if it hits none. Linear in rectangles.
  double FreeSightM(const Eigen::Vector3d& origin_in_enu,
                    const Eigen::Vector3d& direction_in_enu) const;

 private:
  std::vector<TexturedRect> rects_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_STREET_RENDERER_H_
