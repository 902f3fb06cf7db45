// Descriptors with the statistics of SIFT, made from numbers: for worlds that nobody photographed.
// docs/math/descriptor_model.md derives the model and shows it beside real descriptors.
#ifndef CAIRN_EVAL_CITY_DESCRIPTORS_DESCRIPTOR_MODEL_H_
#define CAIRN_EVAL_CITY_DESCRIPTORS_DESCRIPTOR_MODEL_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace cairn {

// Standard deviations of RootSIFT along one principal axis.
struct DescriptorAxis {
  int rank = 0;           // 0 has the largest variance.
  float landmark = 0.0f;  // Between landmarks.
  float instance = 0.0f;  // Between landmarks of one ornament.
  float view = 0.0f;      // Of one landmark, over all viewing directions and scales.
  float mode = 0.0f;      // Of one landmark, between appearance modes.
  float noise = 0.0f;     // Of one landmark, between looks that share all of the above.
};

struct DescriptorModelOptions {
  uint64_t seed = 1;
  // Some axes by ascending rank, from 0 to 127; those between are interpolated.
  std::vector<DescriptorAxis> axes = FittedAxes();
  // The logarithm of a look's noise has this standard deviation.
  double log_noise_sigma = 0.49;
  // Looks that differ by this much share about 1 / e of the view's effect.
  double view_azimuth_scale_rad = 0.5;
  double view_elevation_scale_rad = 0.5;
  double view_log2_scale = 0.7;

  static std::vector<DescriptorAxis> FittedAxes();
  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// One look at one landmark.
struct DescriptorLook {
  // Landmarks of one ornament look nearly the same (windows of a facade); a landmark without
  // likeness has its own.
  uint64_t ornament = 0;
  uint64_t landmark = 0;
  uint32_t appearance_mode = 0;     // Light and season of the pass; 0 is the reference.
  double view_azimuth_rad = 0.0;    // From the surface's normal to the camera, ccw about up.
  double view_elevation_rad = 0.0;  // Likewise, upwards.
  // log2 of (apparent size / the size the landmark is seen at from its reference distance).
  double log2_scale = 0.0;
  uint64_t observation = 0;  // Numbers the look; independent noise.
};

// Landmarks, ornaments and looks are numbered, so that any of them can be made again. Immutable;
// safe to use from any thread.
class DescriptorModel {
 public:
  static constexpr int kDim = 128;
  using Descriptor = Eigen::Matrix<float, 1, kDim>;

  // Throws as Validate.
  explicit DescriptorModel(const DescriptorModelOptions& options);

  // Raw, as ExtractSift makes them: not negative, of L2 norm 512.
  Descriptor Describe(const DescriptorLook& look) const;
  // From the same distribution, but belongs to nothing.
  Descriptor DescribeClutter(uint64_t number) const;

 private:
  using Axes = Eigen::Array<float, 1, kDim>;

  // Adds `weight` times `sigmas` times standard normal values, the same for the same seed.
  void AddNormal(uint64_t seed, const Axes& sigmas, float weight, Axes* axes) const;
  // The smooth effect of the viewing direction and scale.
  void AddView(uint64_t seed, const DescriptorLook& look, Axes* axes) const;
  // A standard normal value, by 16 random bits.
  float Normal(uint64_t bits) const;
  // From principal axes to a raw descriptor.
  Descriptor ToRaw(Axes axes) const;

  uint64_t seed_;
  float log_noise_sigma_;
  Eigen::Vector3f view_frequency_;  // Per radian, radian and octave.
  Axes mean_;                       // Of RootSIFT.
  Axes signs_;                      // Make the principal axes random; +-1 / sqrt(kDim).
  // In the order of the Hadamard transform's rows.
  Axes landmark_sigmas_, instance_sigmas_, view_sigmas_, mode_sigmas_, noise_sigmas_;
  std::vector<float> normal_table_;
};

}  // namespace cairn

#endif  // CAIRN_EVAL_CITY_DESCRIPTORS_DESCRIPTOR_MODEL_H_
