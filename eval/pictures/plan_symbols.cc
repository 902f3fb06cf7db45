#include "eval/pictures/plan_symbols.h"

#include <vector>

namespace cairn {
namespace {

const cv::Scalar kKeyframeColor(120, 100, 90);
const cv::Scalar kPriorColor(60, 60, 215);
const cv::Scalar kTrueColor(70, 150, 20);
const cv::Scalar kEstimateColor(200, 80, 20);

// The camera's field of view, as a wedge of about 60 degrees.
std::vector<Eigen::Vector2d> Wedge(const PlanPose& pose, double length_m) {
  const Eigen::Vector2d left(-pose.forward.y(), pose.forward.x());
  return {pose.center, pose.center + length_m * (pose.forward + 0.58 * left),
          pose.center + length_m * (pose.forward - 0.58 * left)};
}

}  // namespace

PlanPose OnPlan(const Rigid3d& cam_from_plan) {
  const Eigen::Vector3d forward = cam_from_plan.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  PlanPose pose;
  pose.center = cam_from_plan.Inverse().translation.head<2>();
  if (const double norm = forward.head<2>().norm(); norm > 1e-6) {
    pose.forward = forward.head<2>() / norm;
  }
  return pose;
}

void DrawKeyframe(const PlanPose& keyframe, PlanView* view) {
  const double length_m = 11.0 / view->px_per_m();
  view->Line(keyframe.center, keyframe.center + length_m * keyframe.forward, 1.0, kKeyframeColor);
  view->Dot(keyframe.center, 2.5, kKeyframeColor);
}

void DrawPrior(const Eigen::Vector2d& prior, double accuracy_m, PlanView* view) {
  view->DashedCircle(prior, accuracy_m, 1.0, kPriorColor);
  const double arm_m = 6.0 / view->px_per_m();
  view->Line(prior - Eigen::Vector2d(arm_m, 0.0), prior + Eigen::Vector2d(arm_m, 0.0), 2.0,
             kPriorColor);
  view->Line(prior - Eigen::Vector2d(0.0, arm_m), prior + Eigen::Vector2d(0.0, arm_m), 2.0,
             kPriorColor);
}

void DrawTruth(const PlanPose& pose, PlanView* view) {
  const std::vector<Eigen::Vector2d> wedge = Wedge(pose, 34.0 / view->px_per_m());
  for (size_t i = 0; i < wedge.size(); ++i) {
    view->Line(wedge[i], wedge[(i + 1) % wedge.size()], 3.0, kTrueColor);
  }
}

void DrawEstimate(const PlanPose& pose, PlanView* view) {
  view->Polygon(Wedge(pose, 26.0 / view->px_per_m()), kEstimateColor, 0.7);
  view->Dot(pose.center, 5.0, kEstimateColor);
}

void DrawCorrection(const Eigen::Vector2d& prior, const Eigen::Vector2d& answer, PlanView* view) {
  view->DashedLine(prior, answer, 1.0, kPriorColor);
}

}  // namespace cairn
