// Generates descriptors with the statistics of SIFT from numbers, for worlds without photos.
// docs/math/descriptor_model.md derives the model and compares it with real descriptors.
#ifndef CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_MODEL_H_
#define CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_MODEL_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace cairn {

// The spread of descriptors along one principal axis of RootSIFT.
struct DescriptorAxis {
  int rank = 0;          // Rank 0 has the largest variance.
  float between = 0.0f;  // Standard deviation between landmarks.
  float within = 0.0f;   // Between looks at one landmark; relative, see DescriptorModelOptions.
};

// The model finally removes negative elements and normalizes the descriptors. This takes a tenth to
// a fifth of the spreads. The options state the spreads before this step; the defaults compensate
// for the loss. FitDescriptorModel fitted the defaults to two photographed streets, a facade in
// tourists' photos and the rendered street.
struct DescriptorModelOptions {
  uint64_t seed = 1;
  // Some axes in ascending order of rank, from 0 to 127. The axes between them are interpolated.
  std::vector<DescriptorAxis> axes = FittedAxes();

  // Real descriptors form clusters. Landmarks are the leaves of a tree whose levels have 16, 64 and
  // 256 nodes. Each of these levels has this share of the variance between landmarks, at most 1 /
  // 3; the leaves have the rest.
  double cluster_share = 0.300;
  // Standard deviations of the logarithm of a leaf's spread: one draw for each node of the level of
  // 64, and one draw for each landmark.
  double log_cluster_spread = 0.070;
  double log_landmark_spread = 0.121;

  // Root mean square lengths of the differences between looks at one landmark. Their directions
  // follow `DescriptorAxis::within`.
  double noise_length = 0.164;     // Independent in each look.
  double view_length = 0.330;      // Differs by direction and scale; distant views share little.
  double mode_length = 0.094;      // Differs by appearance mode.
  double instance_length = 0.233;  // Between landmarks of one ornament.
  // Two looks share exp(-d) of the view's effect. d is the length of (difference of azimuth and
  // elevation / view_angle_scale_rad, difference of log2 scale / view_log2_scale).
  double view_angle_scale_rad = 1.101;
  double view_log2_scale = 0.617;
  // Standard deviations of logarithms: of the noise over the looks, and of all within-landmark
  // lengths over the landmarks.
  double log_look_spread = 0.884;
  double log_stability_spread = 0.131;

  static std::vector<DescriptorAxis> FittedAxes();
  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

// One look at one landmark.
struct DescriptorLook {
  // Landmarks of one ornament look almost the same (windows of a facade). A landmark that resembles
  // no other has an ornament of its own.
  uint64_t ornament = 0;
  uint64_t landmark = 0;
  uint32_t appearance_mode = 0;     // Light and season of the pass; all numbers are equivalent.
  double view_azimuth_rad = 0.0;    // From the surface's normal to the camera, ccw about up.
  double view_elevation_rad = 0.0;  // From the normal to the camera, upward.
  // log2 of (apparent size / size at the landmark's reference distance).
  double log2_scale = 0.0;
  uint64_t observation = 0;  // Number of the look; selects its independent noise.
};

// Landmarks, ornaments and looks have numbers, so that each can be generated again. A descriptor
// takes 1.4 us (cairn_descriptors_bench). Immutable; safe to use from any thread.
class DescriptorModel {
 public:
  static constexpr int kDim = 128;
  using Descriptor = Eigen::Matrix<float, 1, kDim>;

  // Throws the errors of Validate.
  explicit DescriptorModel(const DescriptorModelOptions& options);

  // Returns a raw descriptor like those of ExtractSift: whole numbers from 0 to 255, with an L2
  // norm of 512 or slightly less.
  Descriptor Describe(const DescriptorLook& look) const;
  // Returns a descriptor from the same distribution that belongs to no landmark.
  Descriptor DescribeClutter(uint64_t number) const;

 private:
  using Axes = Eigen::Array<float, 1, kDim>;

  // Adds standard normal values times `sigmas` times `weight`. The same seed gives the same values.
  void AddNormal(uint64_t seed, const Axes& sigmas, float weight, Axes* axes) const;
  void AddOrnament(uint64_t seed, Axes* axes) const;
  // Adds the smooth effect of the viewing direction and scale.
  void AddView(uint64_t seed, const DescriptorLook& look, float length, Axes* axes) const;
  // Returns a standard normal value that 16 random bits select.
  float Normal(uint64_t bits) const;
  // Converts from principal axes to a raw descriptor.
  Descriptor ToRaw(Axes axes) const;

  DescriptorModelOptions options_;
  uint64_t seed_;
  Axes mean_;                            // Mean of RootSIFT.
  Axes signs_;                           // Randomize the principal axes; +-1 / sqrt(kDim).
  Axes between_sigmas_, within_sigmas_;  // In the order of the Hadamard transform's rows.
  float node_weight_, leaf_weight_;
  std::vector<float> normal_table_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_DESCRIPTORS_DESCRIPTOR_MODEL_H_
