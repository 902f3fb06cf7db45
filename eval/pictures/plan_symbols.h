// The symbols of a top view. Plan and legend share them.
#ifndef CAIRN_EVAL_PICTURES_PLAN_SYMBOLS_H_
#define CAIRN_EVAL_PICTURES_PLAN_SYMBOLS_H_

#include <Eigen/Core>
#include <opencv2/core/types.hpp>

#include "core/rigid3.h"
#include "eval/pictures/plan_view.h"

namespace cairn {

inline const cv::Scalar kTileColor(150, 130, 120);

// A camera on the plan.
struct PlanPose {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  Eigen::Vector2d forward =
      Eigen::Vector2d::Zero();  // Unit vector; zero if the camera looks straight up or down.
};

PlanPose OnPlan(const Rigid3d& cam_from_plan);

void DrawKeyframe(const PlanPose& keyframe, PlanView* view);
// Draws a cross and the circle of the prior's accuracy.
void DrawPrior(const Eigen::Vector2d& prior, double accuracy_m, PlanView* view);
// Draws a hollow symbol, larger than that of an estimate, so that both stay visible where they
// agree.
void DrawTruth(const PlanPose& pose, PlanView* view);
void DrawEstimate(const PlanPose& pose, PlanView* view);
// Draws the line from the prior to the answer.
void DrawCorrection(const Eigen::Vector2d& prior, const Eigen::Vector2d& answer, PlanView* view);

}  // namespace cairn

#endif  // CAIRN_EVAL_PICTURES_PLAN_SYMBOLS_H_
