// Finds looks at landmarks in images with known poses; private to this folder.
#ifndef CAIRN_LAB_DESCRIPTORS_LOOK_COLLECTOR_H_
#define CAIRN_LAB_DESCRIPTORS_LOOK_COLLECTOR_H_

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "core/camera.h"
#include "core/features.h"
#include "core/rigid3.h"
#include "lab/descriptors/real_looks.h"

namespace cairn {

struct PosedImage {
  const Camera* camera = nullptr;
  Rigid3d cam_from_world;
  Eigen::Vector3d center_in_world;
  FeatureSet features;
};

// A landmark with the axes for its view angles, and the properties of its first look.
struct Anchor {
  Eigen::Vector3d x_in_world;
  Eigen::Matrix3d axes_from_world;  // Rows: right, up, and out of the surface.
  Eigen::Vector3d along_in_world;   // A short step along the keypoint's orientation; zero: unknown.
  double size = 0.0;                // Physical size of the keypoint.
  double depth = 0.0;               // In the first look.
  double orientation_rad = 0.0;     // In the first look.
};

double DepthOf(const PosedImage& image, const Eigen::Vector3d& x_in_world);

// Returns rows right, up and out for a surface that faces along `out`, which is not vertical.
Eigen::Matrix3d AxesAbout(const Eigen::Vector3d& out, const Eigen::Vector3d& up);

// Returns the step with which every step-th of `count` items gives at most `max_count` items.
size_t StepFor(size_t count, int max_count);

// Keeps references to its arguments.
class LookCollector {
 public:
  LookCollector(const std::vector<PosedImage>& images, const RealLooksOptions& options)
      : images_(images), options_(options) {}

  // Adds a new landmark with the look of its anchor and the looks in all other images for which
  // `is_visible` returns true.
  void Add(const Anchor& anchor, int first_image, int first_keypoint,
           const std::function<bool(int image)>& is_visible);
  // Appends one look at one landmark.
  void Append(const Anchor& anchor, int ornament, int landmark, int image, int keypoint);

  RealLooks Finish();

 private:
  const std::vector<PosedImage>& images_;
  const RealLooksOptions& options_;
  std::vector<RealLook> looks_;
  std::vector<int> keypoints_;
  int num_landmarks_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_LAB_DESCRIPTORS_LOOK_COLLECTOR_H_
