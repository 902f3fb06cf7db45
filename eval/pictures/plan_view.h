// A north-up plan in meters, as a drawing surface.
#ifndef CAIRN_EVAL_PICTURES_PLAN_VIEW_H_
#define CAIRN_EVAL_PICTURES_PLAN_VIEW_H_

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace cairn {

// An area of the plan in meters east and north of the plan's origin.
struct PlanArea {
  Eigen::Vector2d low = Eigen::Vector2d::Zero();
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
};

// The smallest area that contains the points, extended by `margin_m`. `points` must not be empty.
PlanArea AreaAround(const std::vector<Eigen::Vector2d>& points, double margin_m);

// The smallest area that contains both areas.
PlanArea Union(const PlanArea& a, const PlanArea& b);

// Draws in meters with subpixel accuracy. Line widths are in pixels.
class PlanView {
 public:
  // `area` fills `width_px`. An area more oblong than 5 : 2 is widened first.
  PlanView(PlanArea area, int width_px);

  cv::Mat& image() { return image_; }
  const PlanArea& area() const { return area_; }
  double px_per_m() const { return px_per_m_; }
  bool Contains(const Eigen::Vector2d& at) const;
  Eigen::Vector2d PixelOf(const Eigen::Vector2d& at) const;

  void Dot(const Eigen::Vector2d& at, double radius_px, const cv::Scalar& color);
  // Draws a square of whole pixels; fast enough for very many points.
  void Speck(const Eigen::Vector2d& at, int size_px, const cv::Scalar& color);
  void Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width_px,
            const cv::Scalar& color);
  void DashedLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width_px,
                  const cv::Scalar& color);
  void DashedCircle(const Eigen::Vector2d& center, double radius_m, double width_px,
                    const cv::Scalar& color);
  // Blends a filled polygon over the picture. `opacity` is in [0, 1].
  void Polygon(const std::vector<Eigen::Vector2d>& corners, const cv::Scalar& color,
               double opacity);

 private:
  cv::Point FixedPoint(const Eigen::Vector2d& at) const;

  PlanArea area_;
  double px_per_m_;
  cv::Mat image_;  // CV_8UC3.
};

}  // namespace cairn

#endif  // CAIRN_EVAL_PICTURES_PLAN_VIEW_H_
