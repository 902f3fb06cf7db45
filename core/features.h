// Local image features, the format that all rooms exchange.
#ifndef CAIRN_CORE_FEATURES_H_
#define CAIRN_CORE_FEATURES_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/camera.h"

namespace cairn {

// num_features x descriptor_dim, row-major.
using DescriptorMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A keypoint in pixels; (0.5, 0.5) is the center of the upper left pixel.
struct Keypoint {
  float x_px = 0.0f;
  float y_px = 0.0f;
  float scale_px = 1.0f;  // Standard deviation of the detector's Gaussian; 0 if unknown.
  // Direction of the dominant gradient; 0 is the x axis, pi/2 the y axis; NaN if it is unknown.
  float orientation_rad = 0.0f;
};

// The space of a set of descriptors.
enum class DescriptorSpace {
  kRaw,        // As the extractor outputs them, e.g. 128-D SIFT.
  kProjected,  // Normalized and projected by a map's codebook, e.g. 16-D.
};

// The features of one image: keypoints[i] belongs to descriptors.row(i).
struct FeatureSet {
  std::vector<Keypoint> keypoints;
  DescriptorMatrix descriptors;
  DescriptorSpace space = DescriptorSpace::kRaw;

  int size() const { return static_cast<int>(keypoints.size()); }
};

// Throws Error(kBadInput), naming `what`, if the counts differ, a number is not finite, or a scale
// is negative. A scale may be 0 and an orientation NaN; see core/keypoint_shape.h.
void ValidateFeatures(const FeatureSet& features, const char* what);

// Returns the gravity-rectified orientation (Kurz and Benhimane 2011): the keypoint's direction
// relative to the image of the gravity direction at the keypoint, in (-pi, pi]. Returns nothing if
// the viewing ray is within 3 degrees of the vertical, where the direction is meaningless, or if
// the keypoint has no orientation. `down_in_cam` is a unit vector.
std::optional<double> GravityRectifiedOrientationRad(const Camera& camera, const Keypoint& keypoint,
                                                     const Eigen::Vector3d& down_in_cam);

// Wraps an angle to (-pi, pi].
double WrapAngleRad(double angle_rad);

}  // namespace cairn

#endif  // CAIRN_CORE_FEATURES_H_
