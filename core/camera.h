// Pinhole and fisheye camera models with COLMAP's names, parameter order and pixel convention. The
// center of the upper left pixel is (0.5, 0.5).
#ifndef CAIRN_CORE_CAMERA_H_
#define CAIRN_CORE_CAMERA_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/lens.h"

namespace cairn {

// Values are COLMAP's model ids. Parameters, in order:
//   SIMPLE_PINHOLE  f, cx, cy                    PINHOLE  fx, fy, cx, cy
//   SIMPLE_RADIAL   f, cx, cy, k                 RADIAL   f, cx, cy, k1, k2
//   OPENCV          fx, fy, cx, cy, k1, k2, p1, p2
//   OPENCV_FISHEYE  fx, fy, cx, cy, k1, k2, k3, k4
//   FULL_OPENCV     fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6
//   FOV             fx, fy, cx, cy, omega
//   SIMPLE_RADIAL_FISHEYE  f, cx, cy, k
//   RADIAL_FISHEYE         f, cx, cy, k1, k2
//   THIN_PRISM_FISHEYE     fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, sx1, sy1
//   RAD_TAN_THIN_PRISM_FISHEYE  fx, fy, cx, cy, k0, ..., k5, p0, p1, s0, s1, s2, s3
enum class CameraModel {
  kSimplePinhole = 0,
  kPinhole = 1,
  kSimpleRadial = 2,
  kRadial = 3,
  kOpenCv = 4,
  kOpenCvFisheye = 5,
  kFullOpenCv = 6,
  kFov = 7,
  kSimpleRadialFisheye = 8,
  kRadialFisheye = 9,
  kThinPrismFisheye = 10,
  kRadTanThinPrismFisheye = 11,  // Project Aria's Fisheye624.
};

// Returns COLMAP's name of a model, e.g. "SIMPLE_RADIAL".
const char* CameraModelName(CameraModel model);

// Throw Error(kBadInput) for an unsupported model. The message names the model, if COLMAP knows it,
// and the supported models.
CameraModel CameraModelFromName(std::string_view name);
CameraModel CameraModelFromColmapId(int colmap_id);

// Returns the number of parameters of a model.
int NumCameraParams(CameraModel model);

// Returns how many of the first parameters are focal lengths: 1 (f) or 2 (fx, fy).
int NumFocalLengths(CameraModel model);

// Returns true for fisheye models. Their images may show a wider view than a perspective image can,
// so no perspective model can replace them.
bool IsFisheye(CameraModel model);

// The intrinsics of one camera. Immutable after construction; safe to use from any thread.
class Camera {
 public:
  static constexpr int kMaxSidePx = 100'000;  // Of an image.

  // A 640 x 480 pinhole camera. The default constructor lets Camera be a member of plain structs.
  Camera();

  // Throws Error(kBadInput) if the number of parameters is wrong, a side of the image is outside
  // [1, 100000] px, a focal length is not positive, any parameter is not finite, or FOV's omega is
  // outside (-pi, pi).
  Camera(CameraModel model, int width_px, int height_px, std::vector<double> params);

  CameraModel model() const { return model_; }
  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }
  const std::vector<double>& params() const { return params_; }

  // The mean of fx and fy.
  double focal_px() const { return 0.5 * (fx_ + fy_); }

  // Projects a point to a pixel. Returns nothing if the point is not in front of the camera or lies
  // outside the field of view in which the distortion is invertible.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& x_in_cam) const;

  // Like Project; also computes the 2x3 Jacobian of the pixel with respect to the point.
  std::optional<Eigen::Vector2d> ProjectWithJacobian(const Eigen::Vector3d& x_in_cam,
                                                     Eigen::Matrix<double, 2, 3>* jacobian) const;

  // Returns the unit ray through a pixel, in the camera frame; nothing if the distortion cannot be
  // inverted there. The inverse of Project to 1e-8 px.
  std::optional<Eigen::Vector3d> Unproject(const Eigen::Vector2d& pixel) const;

  // Returns true if the pixel lies in [0, width] x [0, height].
  bool Contains(const Eigen::Vector2d& pixel) const;

 private:
  CameraModel model_;
  int width_px_;
  int height_px_;
  std::vector<double> params_;
  double fx_, fy_, cx_, cy_;
  Lens lens_;
};

}  // namespace cairn

#endif  // CAIRN_CORE_CAMERA_H_
