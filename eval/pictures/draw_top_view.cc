#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

#include "eval/pictures/label.h"
#include "eval/pictures/pictures.h"
#include "eval/pictures/plan_content.h"
#include "eval/pictures/plan_symbols.h"
#include "eval/pictures/plan_view.h"
#include "eval/pictures/round_down_125.h"

namespace cairn {
namespace {

constexpr int kPlanWidthPx = 1500;
constexpr int kLegendWidthPx = 300;
constexpr int kLegendHeightPx = 560;
constexpr double kTextPx = 12.0;
constexpr double kPoseTextPx = 14.0;
constexpr double kLabelDistancePx = 17.0;
const cv::Scalar kGridColor(238, 236, 234);

void DrawGrid(PlanView* view) {
  const PlanArea& area = view->area();
  const double step_m = RoundDown125(120.0 / view->px_per_m());
  for (double x = std::ceil(area.low.x() / step_m) * step_m; x < area.high.x(); x += step_m) {
    view->Line({x, area.low.y()}, {x, area.high.y()}, 1.0, kGridColor);
  }
  for (double y = std::ceil(area.low.y() / step_m) * step_m; y < area.high.y(); y += step_m) {
    view->Line({area.low.x(), y}, {area.high.x(), y}, 1.0, kGridColor);
  }
}

void DrawTiles(const PlanContent& content, PlanView* view) {
  for (const PlanTile& tile : content.tiles) {
    const std::vector<Eigen::Vector2d>& corners = tile.corners;
    for (size_t i = 0; i < corners.size(); ++i) {
      view->Line(corners[i], corners[(i + 1) % corners.size()], 2.0, kTileColor);
    }
  }
}

// Draws the name of each tile in the upper left corner of its visible part.
void DrawTileNames(const PlanContent& content, PlanView* view) {
  for (const PlanTile& tile : content.tiles) {
    const PlanArea square = AreaAround(tile.corners, 0.0);
    const Eigen::Vector2d low = square.low.cwiseMax(view->area().low);
    const Eigen::Vector2d high = square.high.cwiseMin(view->area().high);
    const std::string text = "tile " + tile.name;
    if ((high.x() - low.x()) * view->px_per_m() < LabelWidthPx(text, kTextPx) + 24 ||
        (high.y() - low.y()) * view->px_per_m() < 40.0) {
      continue;
    }
    const Eigen::Vector2d at = view->PixelOf({low.x(), high.y()});
    DrawLabel(text, cv::Point(static_cast<int>(at.x()) + 14, static_cast<int>(at.y()) + 26),
              kTextPx, kTileColor, LabelAnchor::kLeft, true, &view->image());
  }
}

void DrawLandmarks(const PlanContent& content, PlanView* view) {
  const int size_px = content.landmarks.size() > 50'000 ? 2 : 3;
  for (const Eigen::Vector3d& landmark : content.landmarks) {
    if (view->Contains(landmark.head<2>())) {
      const double share = (landmark.z() - content.low_m) / (content.high_m - content.low_m);
      view->Speck(landmark.head<2>(), size_px, ColorOf(share));
    }
  }
}

std::optional<PlanPose> OnPlan(const std::optional<Rigid3d>& cam_from_ecef,
                               const Rigid3d& ecef_from_plan) {
  return cam_from_ecef ? std::optional(OnPlan(*cam_from_ecef * ecef_from_plan)) : std::nullopt;
}

void DrawPose(const TopViewPose& pose, const Rigid3d& plan_from_ecef, PlanView* view) {
  const Rigid3d ecef_from_plan = plan_from_ecef.Inverse();
  const auto reference = OnPlan(pose.reference_cam_from_ecef, ecef_from_plan);
  const auto estimate = OnPlan(pose.estimated_cam_from_ecef, ecef_from_plan);
  std::optional<Eigen::Vector2d> label_at;
  Eigen::Vector2d forward = -Eigen::Vector2d::UnitY();
  if (pose.prior) {
    label_at = (plan_from_ecef * EcefFromGeodetic(*pose.prior)).head<2>();
    if (const auto answer = estimate ? estimate : reference) {
      DrawCorrection(*label_at, answer->center, view);
    }
  }
  if (reference) {
    DrawTruth(*reference, view);
    label_at = reference->center;
    forward = reference->forward;
  }
  if (estimate) {
    DrawEstimate(*estimate, view);
    label_at = estimate->center;
    forward = estimate->forward;
  }
  if (label_at) {  // Behind the camera, where no symbol is.
    const Eigen::Vector2d pixel =
        view->PixelOf(*label_at - forward * (kLabelDistancePx / view->px_per_m()));
    DrawLabel(
        pose.label,
        cv::Point(static_cast<int>(pixel.x()), static_cast<int>(pixel.y() + 0.5 * kPoseTextPx)),
        kPoseTextPx, kInk, LabelAnchor::kCenter, true, &view->image());
  }
}

void DrawScaleBar(PlanView* view) {
  const double length_m = RoundDown125(260.0 / view->px_per_m());
  const int length_px = static_cast<int>(std::lround(length_m * view->px_per_m()));
  cv::Mat& image = view->image();
  const cv::Point left(28, image.rows - 28), right(28 + length_px, image.rows - 28);
  cv::rectangle(image, cv::Point(14, image.rows - 62), cv::Point(right.x + 14, image.rows - 14),
                kPaper, cv::FILLED);
  cv::line(image, left, right, kInk, 3);
  for (const cv::Point& end : {left, right}) {
    cv::line(image, end - cv::Point(0, 7), end, kInk, 3);
  }
  DrawLabel(fmt::format("{:g} m", length_m), {(left.x + right.x) / 2, left.y - 12}, kTextPx, kInk,
            LabelAnchor::kCenter, false, &image);
}

void DrawNorthArrow(PlanView* view) {
  cv::Mat& image = view->image();
  const cv::Point foot(image.cols - 36, image.rows - 24), tip = foot - cv::Point(0, 48);
  cv::arrowedLine(image, foot, tip, kInk, 2, cv::LINE_AA, 0, 0.3);
  DrawLabel("N", tip - cv::Point(0, 9), kPoseTextPx, kInk, LabelAnchor::kCenter, true, &image);
}

// One legend line: the meaning of a symbol, and a function that draws the symbol at a plan
// position.
struct LegendEntry {
  std::string meaning;
  std::function<void(const Eigen::Vector2d& at, PlanView* view)> draw;
};

std::vector<LegendEntry> LegendEntries(const PlanContent& content) {
  const Eigen::Vector2d east = Eigen::Vector2d::UnitX();
  return {
      {"estimated pose",
       [=](const Eigen::Vector2d& at, PlanView* view) {
         DrawEstimate({at - 12.0 * east, east}, view);
       }},
      {"true pose",
       [=](const Eigen::Vector2d& at, PlanView* view) {
         DrawTruth({at - 16.0 * east, east}, view);
       }},
      {"prior and 68 % circle",
       [](const Eigen::Vector2d& at, PlanView* view) { DrawPrior(at, 18.0, view); }},
      {fmt::format("keyframe ({})", content.keyframes.size()),
       [=](const Eigen::Vector2d& at, PlanView* view) {
         DrawKeyframe({at - 5.0 * east, east}, view);
       }},
      {fmt::format("tile border ({})", content.tiles.size()),
       [=](const Eigen::Vector2d& at, PlanView* view) {
         view->Line(at - 18.0 * east, at + 18.0 * east, 2.0, kTileColor);
       }},
      {fmt::format("landmark ({})", content.landmarks.size()),
       [](const Eigen::Vector2d& at, PlanView* view) {
         for (int i = -4; i <= 4; ++i) {
           view->Speck(at + Eigen::Vector2d(4.0 * i, 4.0 * ((i + 5) * 5 % 3 - 1)), 2,
                       ColorOf(0.5 + i / 8.0));
         }
       }},
  };
}

cv::Mat DrawLegend(const PlanContent& content) {
  constexpr double kRowPx = 48.0;
  // The legend is a plan of its own with one pixel per meter.
  PlanView legend({{0.0, -kLegendHeightPx}, {kLegendWidthPx, 0.0}}, kLegendWidthPx);
  Eigen::Vector2d at(44.0, -40.0);
  for (const LegendEntry& entry : LegendEntries(content)) {
    entry.draw(at, &legend);
    DrawLabel(entry.meaning, {80, static_cast<int>(-at.y()) + 5}, kTextPx, kInk, LabelAnchor::kLeft,
              false, &legend.image());
    at.y() -= kRowPx;
  }
  const int top = static_cast<int>(-at.y());
  DrawLabel("height of landmarks, m", {26, top + 10}, kTextPx, kInk, LabelAnchor::kLeft, false,
            &legend.image());
  std::vector<std::string> labels;
  for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    labels.push_back(fmt::format("{:.0f}", share * (content.high_m - content.low_m)));
  }
  DrawColorBar({30, top + 30, 22, 150}, labels, kTextPx, &legend.image());
  return legend.image();
}

}  // namespace

void DrawTopView(const std::string& path, const MapStore& store,
                 const std::vector<TopViewPose>& poses) {
  const PlanContent content = LoadPlanContent(store.Snapshot(), poses);
  PlanView view(content.area, kPlanWidthPx);
  DrawGrid(&view);
  DrawLandmarks(content, &view);
  DrawTiles(content, &view);
  DrawTileNames(content, &view);
  for (const PlanPose& keyframe : content.keyframes) {
    DrawKeyframe(keyframe, &view);
  }
  for (const TopViewPose& pose : poses) {
    if (pose.prior) {
      DrawPrior((content.plan_from_ecef * EcefFromGeodetic(*pose.prior)).head<2>(),
                pose.prior_accuracy_m, &view);
    }
  }
  for (const TopViewPose& pose : poses) {
    DrawPose(pose, content.plan_from_ecef, &view);
  }
  DrawScaleBar(&view);
  DrawNorthArrow(&view);
  cv::rectangle(view.image(), cv::Rect({0, 0}, view.image().size()), kTileColor, 1);

  const cv::Mat legend = DrawLegend(content);
  cv::Mat picture(std::max(view.image().rows, legend.rows), view.image().cols + legend.cols,
                  CV_8UC3, kPaper);
  view.image().copyTo(picture(cv::Rect(0, 0, view.image().cols, view.image().rows)));
  legend.copyTo(picture(cv::Rect(view.image().cols, 0, legend.cols, legend.rows)));
  WritePicture(path, picture);
}

}  // namespace cairn
