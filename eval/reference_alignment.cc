#include "eval/reference_alignment.h"

#include <Eigen/SVD>
#include <algorithm>
#include <string>
#include <unordered_map>
#include <utility>

#include "eval/evaluation_bootstrap.h"

namespace cairn {
namespace {

constexpr double kShareOfRadius68 = 0.68;

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

}  // namespace

std::optional<ReferenceAlignment> AlignToKeyframes(const Reconstruction& reconstruction,
                                                   const std::vector<KeyframeRecord>& keyframes) {
  const std::vector<SharedImage> shared = FindSharedImages(reconstruction, keyframes);
  if (shared.size() < 3) {
    return std::nullopt;
  }
  const std::optional<Sim3d> ecef_from_world = FitScaleAndTranslation(shared, MeanRotation(shared));
  if (!ecef_from_world) {
    return std::nullopt;
  }
  ReferenceAlignment alignment;
  alignment.ecef_from_world = *ecef_from_world;
  alignment.num_shared_images = static_cast<int>(shared.size());
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
