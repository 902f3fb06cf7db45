// How right matches differ from those that agree with a pose by chance.
#ifndef CAIRN_ENGINE_POSE_EVIDENCE_EVIDENCE_MODEL_H_
#define CAIRN_ENGINE_POSE_EVIDENCE_EVIDENCE_MODEL_H_

namespace cairn {

// What a deviation z >= 0 from the ideal adds to the logarithm of the likelihood ratio of "right"
// against "by chance": -weight * log(1 + (z / scale)^2), which falls with z. A Student distribution
// against a flat one has this form.
struct TraitModel {
  double weight = 1.0;  // Not negative.
  double scale = 1.0;   // Positive, in the unit of z.

  double LogRatio(double deviation) const;
};

// Fitted by lab/peers/fit_evidence.py to the inliers of right poses of photos and simulated cities,
// against those of poses found for queries from elsewhere; docs/math/localization.md, "Evidence".
struct EvidenceModel {
  // The reprojection error of a right match has a bivariate Student distribution with this scale,
  //   sqrt(error_px^2 + (error_per_scale * s)^2 + (landmark_share * l)^2),
  // pixels, s being the keypoint's scale and l the projected standard deviation of the landmark;
  double error_px = 0.34;
  double error_per_scale = 0.10;
  double landmark_share = 0.052;
  // and so many degrees of freedom.
  double error_degrees_of_freedom = 1.63;
  // What a right match without a deviation adds beside its place in the image.
  double offset = 6.18;
  // The logarithm falls by this for each unit of the squared descriptor distance. The unit is the
  // squared distance of a median pair of one landmark.
  double distance_weight = 2.8;
  // Logarithm of the keypoint's scale over the one that the landmark's size predicts.
  TraitModel size = {4.4, 0.49};
  // Difference of the gravity-rectified orientations, radians, gravity being that of the pose;
  TraitModel orientation = {1.35, 0.162};
  // where there are such, this is added.
  double orientation_offset = 2.86;
  // Difference of the azimuths from which the landmark is seen and was mapped, radians.
  TraitModel azimuth = {2.37, 3.46};

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_EVIDENCE_EVIDENCE_MODEL_H_
