// One least-squares problem over a reconstruction, solved by Ceres. Private to core/adjust.
#ifndef CAIRN_CORE_ADJUST_ADJUST_PROBLEM_H_
#define CAIRN_CORE_ADJUST_ADJUST_PROBLEM_H_

#include <ceres/problem.h>
#include <ceres/solver.h>

#include <functional>
#include <span>
#include <vector>

#include "core/adjust/adjust.h"
#include "core/adjust/adjustable_camera.h"
#include "core/adjust/landmark_roles.h"
#include "core/scene/reconstruction.h"

namespace cairn {

// All arguments must outlive the problem. Every observation of the model projects.
class AdjustProblem {
 public:
  AdjustProblem(std::span<const CameraFreedom> freedom_of_camera,
                std::span<const AdjustableCamera> cameras, const AdjustPriors& priors,
                const AdjustOptions& options, const Reconstruction& model);

  // `progress` receives the number of each iteration. Throws Error(kInternal) if the solver fails,
  // and what `progress` throws.
  ceres::Solver::Summary Solve(const std::function<void(int iteration)>& progress);

  // Writes what was solved, which leaves out landmarks that follow, and CameraUnknowns for each
  // camera.
  void Store(std::span<CameraUnknowns> unknowns, Reconstruction* model) const;

  const std::vector<LandmarkRole>& roles() const { return roles_; }

  // The unknowns of the cameras to start from; AdjustableCamera::start() unless set.
  void StartFrom(std::span<const CameraUnknowns> unknowns);

 private:
  double* PointAt(size_t landmark) { return values_.data() + kPointStride * landmark; }
  double* PoseAt(size_t image) { return values_.data() + poses_at_ + kPoseStride * image; }
  double* CameraAt(size_t camera) { return values_.data() + cameras_at_ + kCameraStride * camera; }
  const double* PointAt(size_t i) const { return values_.data() + kPointStride * i; }
  const double* PoseAt(size_t i) const { return values_.data() + poses_at_ + kPoseStride * i; }
  const double* CameraAt(size_t i) const {
    return values_.data() + cameras_at_ + kCameraStride * i;
  }

  void AddObservations();
  void AddCameras();
  void AddPrincipalPoint(size_t camera);
  CameraUnknowns CameraMean(size_t camera) const;  // See AdjustPriors::camera_means.
  void AddPositions();
  void FixGauge();
  void HoldScale(size_t anchor);

  static constexpr size_t kPointStride = 3, kPoseStride = 7, kCameraStride = kCameraSize;

  std::span<const CameraFreedom> freedom_of_camera_;
  std::span<const AdjustableCamera> cameras_;
  const AdjustPriors& priors_;
  const AdjustOptions& options_;
  const Reconstruction& model_;
  // All unknowns: points, poses, cameras. Ceres orders blocks by their addresses, so that the order
  // of the model decides the order of elimination.
  std::vector<double> values_;
  size_t poses_at_ = 0, cameras_at_ = 0;
  std::vector<int> num_observations_;  // Of each image.
  std::vector<LandmarkRole> roles_;    // Of the landmarks.
  int num_fixed_landmarks_ = 0;        // Of those that decide.
  ceres::Problem problem_;
};

}  // namespace cairn

#endif  // CAIRN_CORE_ADJUST_ADJUST_PROBLEM_H_
