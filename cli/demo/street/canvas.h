// A gray picture that is painted in meters.
#ifndef CAIRN_CLI_DEMO_STREET_CANVAS_H_
#define CAIRN_CLI_DEMO_STREET_CANVAS_H_

#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

#include "cli/demo/street/texture.h"

namespace cairn {

// x runs right and z up from the lower left corner, as on a facade. Gray values are 0 to 255 and
// are clamped. Paint outside the canvas is cut off. Text and lines are anti-aliased; everything
// else fills whole texels, which makes small details cheap.
class Canvas {
 public:
  // The texture has at least `texels_per_m` texels per meter along both axes.
  Canvas(double width_m, double height_m, double texels_per_m, double gray);

  double width_m() const { return width_m_; }
  double height_m() const { return height_m_; }

  void FillRect(double x_m, double z_m, double width_m, double height_m, double gray);
  // Axis-aligned ellipse about (x, z).
  void FillEllipse(double x_m, double z_m, double x_radius_m, double z_radius_m, double gray);
  void Line(double x0_m, double z0_m, double x1_m, double z1_m, double thickness_m, double gray);
  // Writes capitals of the given height. The baseline starts at (x, z). Text wider than
  // `max_width_m` is squeezed.
  void Text(double x_m, double z_m, double height_m, double max_width_m, const std::string& text,
            double gray);

  // Adds dirt: smooth random patches of about `patch_m` that change the gray value by up to
  // `amplitude`.
  void AddPatches(cv::RNG* rng, double patch_m, double amplitude);
  // Adds patches that are drawn out along z, like the marks of rain below sills.
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

#endif  // CAIRN_CLI_DEMO_STREET_CANVAS_H_
