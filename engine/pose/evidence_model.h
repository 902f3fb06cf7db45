// A model of how right matches differ from matches that agree with a pose by chance.
#ifndef CAIRN_ENGINE_POSE_EVIDENCE_MODEL_H_
#define CAIRN_ENGINE_POSE_EVIDENCE_MODEL_H_

namespace cairn {

// The contribution of a trait's deviation z >= 0 to the logarithm of the likelihood ratio of
// "right" against "by chance": -weight * log(1 + (z / scale)^2), which falls as z grows. A Student
// distribution against a uniform one has this form.
struct TraitModel {
  double weight = 1.0;  // Not negative.
  double scale = 1.0;   // Positive, in the unit of z.

  double LogRatio(double deviation) const;
};

// Fitted by lab/peers/fit_evidence.py to the inliers of right poses of photos and simulated cities,
// against the inliers of poses found for queries from elsewhere; see docs/math/localization.md,
// "Evidence".
struct EvidenceModel {
  // The reprojection error of a right match has a bivariate Student distribution with
  // error_degrees_of_freedom degrees of freedom and this scale in pixels:
  //   sqrt(error_px^2 + (error_per_scale * s)^2 + (landmark_share * l)^2),
  // where s is the keypoint's scale and l the projected standard deviation of the landmark.
  double error_px = 0.34;
  double error_per_scale = 0.10;
  double landmark_share = 0.052;
  double error_degrees_of_freedom = 1.63;
  // Constant contribution of a right match without deviations, apart from its place in the image.
  double offset = 6.18;
  // The logarithm falls by distance_weight per unit of the squared descriptor distance. The unit is
  // the squared distance of a median pair of descriptors of one landmark.
  double distance_weight = 2.8;
  // Deviation: logarithm of the keypoint's scale over the scale predicted by the landmark's size.
  TraitModel size = {4.4, 0.49};
  // Part of `offset`, left out if one of the sizes is unknown. exp(size_offset) times the size's
  // likelihood ratio is 1 on average over pairs of keypoints that have nothing to do with each
  // other: 1.08 to 1.19 for SIFT of four sets of photos.
  double size_offset = 1.1;
  // Deviation: difference of the gravity-rectified orientations, radians, with the gravity of the
  // pose.
  TraitModel orientation = {1.35, 0.162};
  // Added if both orientations are known.
  double orientation_offset = 2.86;
  // Deviation: difference between the azimuths from which the landmark is seen and was mapped,
  // radians.
  TraitModel azimuth = {2.37, 3.46};
};

inline constexpr EvidenceModel kEvidenceModel;

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_EVIDENCE_MODEL_H_
