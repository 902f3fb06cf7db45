#include "lab/rivals/fusion/marginalize_camera.h"

#include <cmath>
#include <vector>

#include "fusion/filter/measurement.h"
#include "lab/rivals/fusion/factors.h"
#include "lab/rivals/fusion/window_problem.h"

namespace cairn::fusion {
namespace {

using RowMajorXd = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Residual and Jacobians of a cost function at the present values of its variables.
struct Linearization {
  bool is_valid = false;
  Eigen::VectorXd residual;
  std::vector<Eigen::MatrixXd> jacobians;

  Linearization(const ceres::CostFunction& factor, const std::vector<const double*>& variables) {
    residual.resize(factor.num_residuals());
    std::vector<RowMajorXd> blocks;
    std::vector<double*> pointers;
    for (const int32_t size : factor.parameter_block_sizes()) {
      blocks.emplace_back(factor.num_residuals(), size);
    }
    for (RowMajorXd& block : blocks) {
      pointers.push_back(block.data());
    }
    is_valid = factor.Evaluate(variables.data(), residual.data(), pointers.data());
    jacobians.assign(blocks.begin(), blocks.end());
  }

  // Applies Huber's loss: a residual beyond `sigmas` gets the weight sigmas / |r|.
  void Robustify(double sigmas) {
    const double norm = residual.norm();
    if (norm > sigmas) {
      const double root_weight = std::sqrt(sigmas / norm);
      residual *= root_weight;
      for (Eigen::MatrixXd& jacobian : jacobians) {
        jacobian *= root_weight;
      }
    }
  }
};

class Marginalizer {
 public:
  Marginalizer(const BundleAdjusterOptions& options, std::span<WindowCamera* const> cameras,
               WindowAlignment* alignment)
      : options_(options),
        cameras_(cameras),
        alignment_(alignment),
        equations_(Blocks(cameras, alignment), /*num_eliminated=*/2) {}

  void AddPrior(const MarginalPrior& prior) {
    const MarginalPriorFactor factor(prior);
    std::vector<const double*> variables;
    std::vector<int> offsets;
    for (const PriorBlock& block : prior.blocks) {
      variables.push_back(block.variables());
      offsets.push_back(equations_.Offset(block.kind, block.camera));
    }
    const Linearization linear(factor, variables);
    equations_.Add(offsets, linear.jacobians, linear.residual);
  }

  void AddInertial() {
    WindowCamera* from = cameras_[0];
    WindowCamera* to = cameras_[1];
    ImuFactor factor;
    factor.Set(from, to, options_.gravity_m_s2);
    const Linearization linear(
        factor, {from->pose.data(), from->motion.data(), to->pose.data(), to->motion.data()});
    equations_.Add({equations_.Offset(PriorBlockKind::kPose, from),
                    equations_.Offset(PriorBlockKind::kMotion, from),
                    equations_.Offset(PriorBlockKind::kPose, to),
                    equations_.Offset(PriorBlockKind::kMotion, to)},
                   linear.jacobians, linear.residual);
  }

  void AddGlobal(const WindowTrack& track, const WindowObservation& observation) {
    const WindowCamera& camera = *observation.camera;
    const Eigen::Vector3d x_in_local = alignment_->ToLocal(track.map_landmark->x_in_global);
    const double depth_m = camera.ToCam(x_in_local).z();
    if (depth_m < options_.triangulate.min_depth_m) {
      return;
    }
    GlobalFactor factor;
    factor.Set(
        &camera, alignment_, observation.normalized,
        GlobalObservationSigma(options_, *track.map_landmark, track.observations.size(), depth_m),
        track.map_landmark->x_in_global);
    Linearization linear(factor, {camera.pose.data(), alignment_->block.data()});
    linear.Robustify(options_.huber_sigmas);
    equations_.Add({equations_.Offset(PriorBlockKind::kPose, &camera),
                    equations_.Offset(PriorBlockKind::kAlignment, nullptr)},
                   linear.jacobians, linear.residual);
  }

  // Adds all observations of a triangulated track except those of cameras that may be replaced.
  void AddLocal(const WindowTrack& track) {
    const double sigma = options_.track_sigma_px / options_.camera.focal_px();
    const auto num_rows = 2 * static_cast<Eigen::Index>(track.observations.size());
    const auto width =
        static_cast<Eigen::Index>(kLandmarkBlock + kPoseBlock * track.observations.size());
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(num_rows, width + 1);
    std::vector<int> offsets;
    for (size_t i = 0; i < track.observations.size(); ++i) {
      const WindowObservation& observation = track.observations[i];
      LocalFactor factor;
      factor.Set(observation.camera, observation.normalized, sigma);
      Linearization linear(factor, {observation.camera->pose.data(), track.x_in_local.data()});
      if (!linear.is_valid) {
        return;
      }
      linear.Robustify(options_.huber_sigmas);
      auto target = rows.middleRows<2>(2 * static_cast<Eigen::Index>(i));
      target.leftCols<kLandmarkBlock>() = linear.jacobians[1];
      target.middleCols<kPoseBlock>(static_cast<Eigen::Index>(kLandmarkBlock + kPoseBlock * i)) =
          linear.jacobians[0];
      target.col(width) = linear.residual;
      offsets.push_back(equations_.Offset(PriorBlockKind::kPose, observation.camera));
    }
    // The rows below the landmark's triangle do not depend on it.
    Triangularize(kLandmarkBlock, rows);
    const auto kept = rows.bottomRows(num_rows - kLandmarkBlock);
    std::vector<Eigen::MatrixXd> jacobians;
    for (size_t i = 0; i < track.observations.size(); ++i) {
      jacobians.emplace_back(
          kept.middleCols<kPoseBlock>(static_cast<Eigen::Index>(kLandmarkBlock + kPoseBlock * i)));
    }
    equations_.Add(offsets, jacobians, kept.col(width));
  }

  MarginalPrior Finish() const { return equations_.Marginalize(); }

 private:
  static std::vector<PriorBlock> Blocks(std::span<WindowCamera* const> cameras,
                                        WindowAlignment* alignment) {
    std::vector<PriorBlock> blocks = {PriorBlock::Pose(cameras[0]), PriorBlock::Motion(cameras[0]),
                                      PriorBlock::Motion(cameras[1])};
    // The newest camera may still be replaced, so nothing that is marginalized may touch it.
    for (WindowCamera* camera : cameras.subspan(1, cameras.size() - 2)) {
      blocks.push_back(PriorBlock::Pose(camera));
    }
    if (alignment != nullptr) {
      blocks.push_back(PriorBlock::Alignment(alignment));
    }
    return blocks;
  }

  const BundleAdjusterOptions& options_;
  std::span<WindowCamera* const> cameras_;
  WindowAlignment* alignment_;
  NormalEquations equations_;
};

}  // namespace

MarginalPrior MarginalizeCamera(const BundleAdjusterOptions& options,
                                std::span<WindowCamera* const> cameras, WindowAlignment* alignment,
                                const std::optional<MarginalPrior>& prior, WindowTracks* tracks) {
  PrepareVariables prepare(options.rig);
  prepare.Watch({cameras.begin(), cameras.end()}, alignment);
  prepare.Prepare();
  Marginalizer marginalizer(options, cameras, alignment);
  if (prior) {
    marginalizer.AddPrior(*prior);
  }
  marginalizer.AddInertial();
  const WindowCamera* newest = cameras.back();
  std::vector<WindowTrack*> used_up;
  tracks->ForEach([&](WindowTrack* track) {
    if (track->observations.front().camera != cameras[0]) {
      return;
    }
    const bool has_ended = track->observations.back().camera != newest;
    const bool spans_window = track->observations.size() >= cameras.size();
    if (track->map_landmark && alignment != nullptr) {
      marginalizer.AddGlobal(*track, track->observations.front());
    } else if (!track->map_landmark && track->is_triangulated && (has_ended || spans_window) &&
               static_cast<int>(track->observations.size()) >= options.min_views) {
      used_up.push_back(track);
    }
  });
  for (WindowTrack* track : used_up) {
    // The newest camera may still be replaced. Its observation starts a new track.
    std::optional<WindowObservation> last;
    if (track->observations.back().camera == newest) {
      last = track->observations.back();
      track->observations.pop_back();
    }
    marginalizer.AddLocal(*track);
    track->observations.clear();
    track->is_triangulated = false;
    if (last) {
      track->observations.push_back(*last);
    } else {
      tracks->Forget(track);
    }
  }
  return marginalizer.Finish();
}

}  // namespace cairn::fusion
