// A grey picture painted in metres.
#ifndef CAIRN_LAB_STREET_CANVAS_H_
#define CAIRN_LAB_STREET_CANVAS_H_

#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

#include "lab/street/texture.h"

namespace cairn {

// x runs right and z up from the lower left corner, like on a facade; greys are 0 to 255 and are
// clamped. Painting outside is cut off. Small details are cheap: everything is whole texels, except
// text and lines, which are anti-aliased.
class Canvas {
 public:
  // The texture gets at least `texels_per_m` texels a metre along both axes.
  Canvas(double width_m, double height_m, double texels_per_m, double grey);

  double width_m() const { return width_m_; }
  double height_m() const { return height_m_; }

  void FillRect(double x_m, double z_m, double width_m, double height_m, double grey);
  // Axis-aligned ellipse about (x, z).
  void FillEllipse(double x_m, double z_m, double x_radius_m, double z_radius_m, double grey);
  void Line(double x0_m, double z0_m, double x1_m, double z1_m, double thickness_m, double grey);
  // Capitals of the given height with their base line from (x, z); squeezed to `max_width_m`.
  void Text(double x_m, double z_m, double height_m, double max_width_m, const std::string& text,
            double grey);

  // Dirt: smooth random patches of about `patch_m`, with amplitudes up to `amplitude` grey levels.
  void AddPatches(cv::RNG* rng, double patch_m, double amplitude);
  // As AddPatches but drawn out along z, like what rain leaves below sills.
  void AddStreaks(cv::RNG* rng, double width_m, double height_m, double amplitude);

  std::shared_ptr<const Texture> ToTexture() const;

 private:
  int Column(double x_m) const;
  int Row(double z_m) const;
  void AddNoise(cv::RNG* rng, double x_patch_m, double z_patch_m, double amplitude);

  double width_m_;
  double height_m_;
  double x_texels_per_m_;
  double z_texels_per_m_;
  cv::Mat pixels_;  // CV_8UC1.
};

}  // namespace cairn

#endif  // CAIRN_LAB_STREET_CANVAS_H_
