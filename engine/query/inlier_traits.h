// How a match deviates from the prediction of its landmark.
#ifndef CAIRN_ENGINE_QUERY_INLIER_TRAITS_H_
#define CAIRN_ENGINE_QUERY_INLIER_TRAITS_H_

namespace cairn {

// The deviations of one match under one pose.
struct InlierTraits {
  double error_px = 0.0;  // Reprojection error.
  double keypoint_scale_px = 0.0;
  double landmark_sigma_px = 0.0;  // Standard deviation of the landmark, projected.
  // Squared distance of the descriptors relative to that of a median pair of one landmark.
  double sq_distance = 0.0;
  double log_size = 0.0;  // Logarithm of the keypoint's scale over the predicted one; NaN: unknown.
  // Difference of the gravity-rectified orientations, with the gravity of the pose; negative if one
  // of them is unknown.
  double orientation_rad = 0.0;
  // Difference between the azimuths from which the landmark is seen and was mapped.
  double azimuth_rad = 0.0;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_QUERY_INLIER_TRAITS_H_
