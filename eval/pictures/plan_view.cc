#include "eval/pictures/plan_view.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/angles.h"
#include "core/check.h"
#include "eval/pictures/label.h"

namespace cairn {
namespace {

constexpr int kShift = 4;
constexpr double kMaxOblongness = 2.5;
constexpr double kDashPx = 9.0;
constexpr double kGapPx = 6.0;

int LineWidth(double width_px) { return std::max(1, static_cast<int>(std::lround(width_px))); }

}  // namespace

PlanArea AreaAround(const std::vector<Eigen::Vector2d>& points, double margin_m) {
  CAIRN_CHECK(!points.empty(), "an area needs points");
  PlanArea area = {points.front(), points.front()};
  for (const Eigen::Vector2d& point : points) {
    area = Union(area, {point, point});
  }
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(margin_m);
  return {area.low - margin, area.high + margin};
}

PlanArea Union(const PlanArea& a, const PlanArea& b) {
  return {a.low.cwiseMin(b.low), a.high.cwiseMax(b.high)};
}

PlanView::PlanView(PlanArea area, int width_px) : area_(std::move(area)) {
  const Eigen::Vector2d center = 0.5 * (area_.low + area_.high);
  Eigen::Vector2d half = (0.5 * (area_.high - area_.low)).cwiseMax(1.0);
  half.x() = std::max(half.x(), half.y() / kMaxOblongness);
  half.y() = std::max(half.y(), half.x() / kMaxOblongness);
  area_ = {center - half, center + half};
  px_per_m_ = width_px / (2.0 * half.x());
  const int height_px = static_cast<int>(std::lround(2.0 * half.y() * px_per_m_));
  image_ = cv::Mat(height_px, width_px, CV_8UC3, kPaper);
}

bool PlanView::Contains(const Eigen::Vector2d& at) const {
  return (at.array() >= area_.low.array()).all() && (at.array() <= area_.high.array()).all();
}

Eigen::Vector2d PlanView::PixelOf(const Eigen::Vector2d& at) const {
  return px_per_m_ * Eigen::Vector2d(at.x() - area_.low.x(), area_.high.y() - at.y());
}

cv::Point PlanView::FixedPoint(const Eigen::Vector2d& at) const {
  // OpenCV's fixed-point coordinates overflow, so coordinates are clamped far outside the picture.
  constexpr double kMaxPx = 30000.0;
  const Eigen::Vector2d pixel = PixelOf(at).cwiseMax(-kMaxPx).cwiseMin(kMaxPx) * (1 << kShift);
  return {static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y()))};
}

void PlanView::Dot(const Eigen::Vector2d& at, double radius_px, const cv::Scalar& color) {
  cv::circle(image_, FixedPoint(at), static_cast<int>(std::lround(radius_px * (1 << kShift))),
             color, cv::FILLED, cv::LINE_AA, kShift);
}

void PlanView::Speck(const Eigen::Vector2d& at, int size_px, const cv::Scalar& color) {
  const Eigen::Vector2d pixel = PixelOf(at);
  const cv::Rect square(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()), size_px, size_px);
  image_(square & cv::Rect({0, 0}, image_.size())).setTo(color);
}

void PlanView::Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width_px,
                    const cv::Scalar& color) {
  cv::line(image_, FixedPoint(from), FixedPoint(to), color, LineWidth(width_px), cv::LINE_AA,
           kShift);
}

void PlanView::DashedLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width_px,
                          const cv::Scalar& color) {
  const double length_m = (to - from).norm();
  const double dash_m = kDashPx / px_per_m_, period_m = (kDashPx + kGapPx) / px_per_m_;
  for (double along_m = 0.0; along_m < length_m; along_m += period_m) {
    const double end_m = std::min(along_m + dash_m, length_m);
    Line(from + (to - from) * (along_m / length_m), from + (to - from) * (end_m / length_m),
         width_px, color);
  }
}

void PlanView::DashedCircle(const Eigen::Vector2d& center, double radius_m, double width_px,
                            const cv::Scalar& color) {
  const double circumference_px = 2.0 * kPi * radius_m * px_per_m_;
  const int num_dashes =
      std::clamp(static_cast<int>(circumference_px / (kDashPx + kGapPx)), 8, 720);
  const double period_rad = 2.0 * kPi / num_dashes;
  const auto at = [&](double angle_rad) {
    return Eigen::Vector2d(center +
                           radius_m * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad)));
  };
  for (int i = 0; i < num_dashes; ++i) {
    constexpr double kDashShare = kDashPx / (kDashPx + kGapPx);
    Line(at(i * period_rad), at((i + 0.5 * kDashShare) * period_rad), width_px, color);
    Line(at((i + 0.5 * kDashShare) * period_rad), at((i + kDashShare) * period_rad), width_px,
         color);
  }
}

void PlanView::Polygon(const std::vector<Eigen::Vector2d>& corners, const cv::Scalar& color,
                       double opacity) {
  std::vector<cv::Point> points;
  for (const Eigen::Vector2d& corner : corners) {
    points.push_back(FixedPoint(corner));
  }
  if (opacity >= 1.0) {
    cv::fillConvexPoly(image_, points, color, cv::LINE_AA, kShift);
    return;
  }
  cv::Mat overlay = image_.clone();
  cv::fillConvexPoly(overlay, points, color, cv::LINE_AA, kShift);
  cv::addWeighted(overlay, opacity, image_, 1.0 - opacity, 0.0, image_);
}

}  // namespace cairn
