#include "eval/reference_alignment.h"

#include <Eigen/SVD>
#include <algorithm>
#include <iterator>
#include <limits>
#include <string>
#include <unordered_map>
#include <utility>

#include "core/random.h"
#include "core/statistics.h"
#include "eval/evaluation_bootstrap.h"

namespace cairn {
namespace {

constexpr double kShareOfRadius68 = 0.68;
// Pairs of images that are drawn: a quarter are of two images that fit if half of the images do.
constexpr int kNumSamples = 200;
constexpr uint64_t kSeed = 1;
constexpr double kMaxSigmas = 3.0;
constexpr double kSigmaOfMedian = 1.4826;
constexpr double kExactM = 1e-3;  // Images that are nearer than this always fit.

// One image with its poses in the reconstruction and in the map.
struct SharedImage {
  Rigid3d cam_from_world;
  Rigid3d cam_from_ecef;

  Eigen::Vector3d CenterInWorld() const { return cam_from_world.Inverse().translation; }
  Eigen::Vector3d CenterInEcef() const { return cam_from_ecef.Inverse().translation; }
};

std::vector<SharedImage> FindSharedImages(const Reconstruction& reconstruction,
                                          const std::vector<KeyframeRecord>& keyframes) {
  std::unordered_map<std::string, const KeyframeRecord*> keyframe_by_name;
  for (const KeyframeRecord& keyframe : keyframes) {
    const auto [entry, is_new] = keyframe_by_name.emplace(keyframe.image_name, &keyframe);
    if (!is_new) {
      entry->second = nullptr;
    }
  }
  std::vector<SharedImage> shared;
  for (const ReconImage& image : reconstruction.images) {
    const auto found = keyframe_by_name.find(image.name);
    if (found != keyframe_by_name.end() && found->second != nullptr) {
      shared.push_back({image.cam_from_world, found->second->cam_from_ecef});
    }
  }
  return shared;
}

// The chordal mean of the rotations of all ecef_from_cam * cam_from_world.
Eigen::Quaterniond MeanRotation(const std::vector<SharedImage>& shared) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const SharedImage& image : shared) {
    sum += (image.cam_from_ecef.rotation.conjugate() * image.cam_from_world.rotation)
               .toRotationMatrix();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d sign = Eigen::Matrix3d::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return Eigen::Quaterniond(Eigen::Matrix3d(svd.matrixU() * sign * svd.matrixV().transpose()));
}

// Fits scale and translation by least squares, with the rotation given. Returns nothing if the
// centers coincide.
std::optional<Sim3d> FitScaleAndTranslation(const std::vector<SharedImage>& shared,
                                            const Eigen::Quaterniond& ecef_from_world) {
  Eigen::Vector3d mean_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_in_ecef = Eigen::Vector3d::Zero();
  for (const SharedImage& image : shared) {
    mean_in_world += image.CenterInWorld() / static_cast<double>(shared.size());
    mean_in_ecef += image.CenterInEcef() / static_cast<double>(shared.size());
  }
  double cross = 0.0;
  double sq_spread = 0.0;
  for (const SharedImage& image : shared) {
    const Eigen::Vector3d rotated = ecef_from_world * (image.CenterInWorld() - mean_in_world);
    cross += rotated.dot(image.CenterInEcef() - mean_in_ecef);
    sq_spread += rotated.squaredNorm();
  }
  if (!(sq_spread > 0.0) || !(cross > 0.0)) {
    return std::nullopt;
  }
  Sim3d fit{cross / sq_spread, ecef_from_world, Eigen::Vector3d::Zero()};
  fit.translation = mean_in_ecef - fit * mean_in_world;
  return fit;
}

std::optional<Sim3d> FitAll(const std::vector<SharedImage>& images) {
  return FitScaleAndTranslation(images, MeanRotation(images));
}

double DistanceM(const SharedImage& image, const Sim3d& ecef_from_world) {
  return (ecef_from_world * image.CenterInWorld() - image.CenterInEcef()).norm();
}

double MedianDistanceM(const std::vector<SharedImage>& shared, const Sim3d& ecef_from_world) {
  std::vector<double> distances_m;
  for (const SharedImage& image : shared) {
    distances_m.push_back(DistanceM(image, ecef_from_world));
  }
  return Median(std::move(distances_m));
}

// The images near the alignment that has the least median distance, by all images or by two.
std::vector<SharedImage> FindFitting(const std::vector<SharedImage>& shared) {
  Random random(kSeed);
  std::optional<Sim3d> best = FitAll(shared);
  double least_m = best ? MedianDistanceM(shared, *best) : std::numeric_limits<double>::infinity();
  const int count = static_cast<int>(shared.size());
  for (int i = 0; i < kNumSamples; ++i) {
    const int p = random.Index(count), q = random.Index(count);
    const std::optional<Sim3d> fit = p != q ? FitAll({shared[p], shared[q]}) : std::nullopt;
    const double median_m = fit ? MedianDistanceM(shared, *fit) : least_m;
    if (median_m < least_m) {
      least_m = median_m;
      best = fit;
    }
  }
  std::vector<SharedImage> fitting;
  const double max_m = std::max(kExactM, kMaxSigmas * kSigmaOfMedian * least_m);
  std::copy_if(shared.begin(), shared.end(), std::back_inserter(fitting),
               [&](const SharedImage& image) { return best && DistanceM(image, *best) <= max_m; });
  return fitting;
}

}  // namespace

std::optional<ReferenceAlignment> AlignToKeyframes(const Reconstruction& reconstruction,
                                                   const std::vector<KeyframeRecord>& keyframes) {
  const std::vector<SharedImage> shared = FindSharedImages(reconstruction, keyframes);
  if (shared.size() < 3) {
    return std::nullopt;
  }
  const std::vector<SharedImage> fitting = FindFitting(shared);
  const std::optional<Sim3d> ecef_from_world = fitting.empty() ? std::nullopt : FitAll(fitting);
  if (!ecef_from_world) {
    return std::nullopt;
  }
  ReferenceAlignment alignment;
  alignment.ecef_from_world = *ecef_from_world;
  alignment.num_shared_images = static_cast<int>(shared.size());
  alignment.num_fitting_images = static_cast<int>(fitting.size());
  std::vector<double> residuals_m, residuals_rad;
  for (const SharedImage& image : shared) {
    const Rigid3d aligned = CamFromTarget(image.cam_from_world, *ecef_from_world);
    residuals_m.push_back((aligned.Inverse().translation - image.CenterInEcef()).norm());
    residuals_rad.push_back(RotationAngleRad(aligned.rotation, image.cam_from_ecef.rotation));
  }
  std::sort(residuals_m.begin(), residuals_m.end());
  alignment.median_residual_m = residuals_m[residuals_m.size() / 2];
  alignment.max_residual_m = residuals_m.back();
  alignment.radius68_m = Quantile(std::move(residuals_m), kShareOfRadius68);
  alignment.max_residual_rad = *std::max_element(residuals_rad.begin(), residuals_rad.end());
  alignment.radius68_rad = Quantile(std::move(residuals_rad), kShareOfRadius68);
  return alignment;
}

}  // namespace cairn
