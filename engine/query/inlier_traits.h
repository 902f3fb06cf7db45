// How a match deviates from what its landmark predicts.
#ifndef CAIRN_ENGINE_QUERY_INLIER_TRAITS_H_
#define CAIRN_ENGINE_QUERY_INLIER_TRAITS_H_

namespace cairn {

// Of one match under one pose.
struct InlierTraits {
  double error_px = 0.0;  // Reprojection error.
  double keypoint_scale_px = 0.0;
  double landmark_sigma_px = 0.0;  // Standard deviation of the landmark, projected.
  // Squared distance of the descriptors over that of a median pair of one landmark.
  double sq_distance = 0.0;
  double log_size = 0.0;  // Logarithm of the keypoint's scale over the one that is predicted.
  // Difference of the gravity-rectified orientations, gravity being that of the pose; negative if
  // one of the two is not known.
  double orientation_rad = 0.0;
  double azimuth_rad =
      0.0;  // Between where the landmark is seen from and where it was mapped from.
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_QUERY_INLIER_TRAITS_H_
