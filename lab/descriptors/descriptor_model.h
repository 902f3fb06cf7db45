// Descriptors with the statistics of SIFT, made from numbers: for worlds that nobody photographed.
// docs/math/descriptor_model.md derives the model and shows it beside real descriptors.
#ifndef CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_MODEL_H_
#define CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_MODEL_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace cairn {

// How descriptors spread along one principal axis of RootSIFT.
struct DescriptorAxis {
  int rank = 0;          // 0 has the largest variance.
  float between = 0.0f;  // Standard deviation between landmarks.
  float within = 0.0f;   // Between looks at one landmark; relative, see DescriptorModelOptions.
};

// All spreads are those before elements are kept from being negative and descriptors are
// normalised, which takes a tenth to a fifth of them; the defaults make up for it. Fitted on two
// photographed streets, a facade in tourists' photos and the rendered street by FitDescriptorModel.
struct DescriptorModelOptions {
  uint64_t seed = 1;
  // Some axes by ascending rank, from 0 to 127; those between are interpolated.
  std::vector<DescriptorAxis> axes = FittedAxes();

  // Real descriptors huddle. Landmarks are leaves of a tree with 16, 64 and 256 inner nodes; each
  // of these levels has this share of the variance between landmarks, at most 1 / 3, and the leaves
  // have the rest.
  double cluster_share = 0.300;
  // The logarithm of a leaf's spread has these standard deviations: one draw for each node of 64,
  // one for each landmark.
  double log_cluster_spread = 0.070;
  double log_landmark_spread = 0.121;

  // Root mean square lengths of what tells looks at one landmark apart; directions follow
  // `DescriptorAxis::within`.
  double noise_length = 0.164;     // Independent in each look.
  double view_length = 0.330;      // By direction and scale; what looks far apart do not share.
  double mode_length = 0.094;      // By appearance mode.
  double instance_length = 0.233;  // Between landmarks of one ornament.
  // Of the view's effect, two looks share exp(-d), where d is the length of (difference of azimuth
  // and elevation / view_angle_scale_rad, difference of log2 scale / view_log2_scale).
  double view_angle_scale_rad = 1.101;
  double view_log2_scale = 0.617;
  // Standard deviations of the logarithm of the noise over looks, and of all within-landmark
  // lengths over landmarks.
  double log_look_spread = 0.884;
  double log_stability_spread = 0.131;

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
  uint32_t appearance_mode = 0;     // Light and season of the pass; 0 is as good as any.
  double view_azimuth_rad = 0.0;    // From the surface's normal to the camera, ccw about up.
  double view_elevation_rad = 0.0;  // Likewise, upwards.
  // log2 of (apparent size / the size the landmark is seen at from its reference distance).
  double log2_scale = 0.0;
  uint64_t observation = 0;  // Numbers the look; independent noise.
};

// Landmarks, ornaments and looks are numbered, so that any of them can be made again. A descriptor
// takes 1.4 us (cairn_descriptors_bench). Immutable; safe to use from any thread.
class DescriptorModel {
 public:
  static constexpr int kDim = 128;
  using Descriptor = Eigen::Matrix<float, 1, kDim>;

  // Throws as Validate.
  explicit DescriptorModel(const DescriptorModelOptions& options);

  // Raw, as ExtractSift makes them: whole numbers from 0 to 255, of L2 norm 512 or a little less.
  Descriptor Describe(const DescriptorLook& look) const;
  // From the same distribution, but belongs to nothing.
  Descriptor DescribeClutter(uint64_t number) const;

 private:
  using Axes = Eigen::Array<float, 1, kDim>;

  // Adds `weight` times `sigmas` times standard normal values, the same for the same seed.
  void AddNormal(uint64_t seed, const Axes& sigmas, float weight, Axes* axes) const;
  void AddOrnament(uint64_t seed, Axes* axes) const;
  // The smooth effect of the viewing direction and scale.
  void AddView(uint64_t seed, const DescriptorLook& look, float length, Axes* axes) const;
  // A standard normal value, by 16 random bits.
  float Normal(uint64_t bits) const;
  // From principal axes to a raw descriptor.
  Descriptor ToRaw(Axes axes) const;

  DescriptorModelOptions options_;
  uint64_t seed_;
  Axes mean_;                            // Of RootSIFT.
  Axes signs_;                           // Make the principal axes random; +-1 / sqrt(kDim).
  Axes between_sigmas_, within_sigmas_;  // In the order of the Hadamard transform's rows.
  float node_weight_, leaf_weight_;
  std::vector<float> normal_table_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_MODEL_H_
