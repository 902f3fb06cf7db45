// The relative pose of two cameras from matched rays, some of them wrong.
#ifndef CAIRN_MAPPING_MATCHING_RELATIVE_POSE_H_
#define CAIRN_MAPPING_MATCHING_RELATIVE_POSE_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/random.h"
#include "core/rigid3.h"
#include "mapping/matching/five_point.h"

namespace cairn {

// How the error of a keypoint moves its unit ray: the columns are the shifts, in radians and across
// the ray, by one standard deviation along x and y of the picture. Toward the edge of a perspective
// picture a pixel is a smaller angle, and more so along the radius than across it.
using RaySpread = Eigen::Matrix<double, 3, 2>;

// The same standard deviation in all directions.
RaySpread EvenSpread(const Eigen::Vector3d& ray, double sigma_rad);

// Two unit rays that may show one point, each in the frame of its camera.
struct RayMatch {
  Eigen::Vector3d a, b;
  RaySpread spread_a, spread_b;

  // Variance of the angle between the rays, of the mean direction.
  double SqSigmaRad() const { return 0.5 * (spread_a.squaredNorm() + spread_b.squaredNorm()); }
};

// A match whose epipolar error is larger, in standard deviations, is not an inlier. As
// AdjustOptions::max_error_sigmas.
inline constexpr double kMaxEpipolarSigmas = 4.0;

// The Sampson error of a match under an essential matrix b_from_a, squared, in its variances: the
// squared distance of the keypoints from the nearest pair whose rays meet. Valid for any field of
// view because both rays are unit vectors.
double SqEpipolarError(const Eigen::Matrix3d& essential, const RayMatch& match);

// The essential matrix of a relative pose: [t]x R for a unit translation.
Eigen::Matrix3d EssentialOf(const Rigid3d& b_from_a);

// Depths of the point nearest to both rays, in units of the baseline; the translation of
// `b_from_a` has unit length. Nothing for parallel rays.
std::optional<std::pair<double, double>> DepthsOf(const Rigid3d& b_from_a, const RayMatch& match);

// The errors of the matches `inliers` under a pose, relative to those that the matches state: in
// [kLeastNoise, 1]. Keypoints of a sharp picture are often several times as exact as stated.
double NoiseOf(std::span<const RayMatch> matches, std::span<const int> inliers,
               const Rigid3d& b_from_a);
inline constexpr double kLeastNoise = 0.25;

// The matches with standard deviations `noise` times as large.
std::vector<RayMatch> WithNoise(std::span<const RayMatch> matches, double noise);

struct RefinedRelativePose {
  Rigid3d b_from_a;
  // Standard deviations of the least certain direction: of the rotation, and of the direction of
  // the translation.
  double rotation_sigma_rad = 0.0;
  double direction_sigma_rad = 0.0;
  double cost = 0.0;  // Half the sum of the robust squared errors.
};

// Minimizes the robust Sampson errors (Cauchy, at two standard deviations) of the matches `inliers`
// over rotation and direction of the translation by damped Gauss-Newton. Nothing if there are fewer
// than five.
std::optional<RefinedRelativePose> RefineRelativePose(std::span<const RayMatch> matches,
                                                      std::span<const int> inliers,
                                                      const Rigid3d& b_from_a);

// The rotation that maps rays of a to rays of b best, and how many of the matches `inliers` it
// explains: all of them if the camera only turned.
struct RotationFit {
  Eigen::Quaterniond b_from_a;
  int num_explained = 0;
};
RotationFit FitRotation(std::span<const RayMatch> matches, std::span<const int> inliers,
                        const Eigen::Quaterniond& b_from_a);

// See LoRansac for the contract of the methods. Samples prefer the first matches: those whose
// descriptors are nearest should come first. Keeps a reference to the matches. Not thread-safe.
class RelativePoseProblem {
 public:
  struct Model {
    Eigen::Matrix3d essential = Eigen::Matrix3d::Zero();
    Rigid3d b_from_a;  // Only of optimized models.
  };
  static constexpr int kMaxModels = kMaxEssentials;

  // `seed` determines the order of scoring. There must be at least five matches.
  RelativePoseProblem(std::span<const RayMatch> matches, uint64_t seed);

  int SampleModels(Random* random, std::array<Model, kMaxModels>* models);
  double ScoreMinimal(const Model& model, double score_to_beat) const;
  std::optional<std::pair<Model, double>> Optimize(const Model& model) const;
  double InlierSampleProbability(const Model& model) const;
  double SampleProbabilityOfScore(double score) const;

  // Matches that agree with a pose and lie in front of both cameras, ascending.
  std::vector<int> InliersOf(const Rigid3d& b_from_a) const;

 private:
  std::vector<int> EpipolarInliers(const Eigen::Matrix3d& essential) const;
  // Of the four poses of an essential matrix, the one with the most points in front of both.
  Rigid3d PoseOf(const Eigen::Matrix3d& essential, std::span<const int> inliers) const;

  std::span<const RayMatch> matches_;
  std::vector<int> order_;  // A random order of the matches.
};

}  // namespace cairn

#endif  // CAIRN_MAPPING_MATCHING_RELATIVE_POSE_H_
