// A north-up plan in metres to draw on.
#ifndef CAIRN_EVAL_PICTURES_PLAN_VIEW_H_
#define CAIRN_EVAL_PICTURES_PLAN_VIEW_H_

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace cairn {

// An area of the plan, metres east and north of its origin.
struct PlanArea {
  Eigen::Vector2d low = Eigen::Vector2d::Zero();
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
};

// The smallest area that holds the points, grown by `margin_m`. `points` must not be empty.
PlanArea AreaAround(const std::vector<Eigen::Vector2d>& points, double margin_m);

// The smallest area that holds both.
PlanArea Union(const PlanArea& a, const PlanArea& b);

// Draws by metres with subpixel accuracy; widths are in pixels.
class PlanView {
 public:
  // The area, widened if it is more oblong than 5 : 2, fills `width_px`.
  PlanView(PlanArea area, int width_px);

  cv::Mat& image() { return image_; }
  const PlanArea& area() const { return area_; }
  double px_per_m() const { return px_per_m_; }
  bool Contains(const Eigen::Vector2d& at) const;
  Eigen::Vector2d PixelOf(const Eigen::Vector2d& at) const;

  void Dot(const Eigen::Vector2d& at, double radius_px, const cv::Scalar& color);
  // A square of whole pixels; for very many of them.
  void Speck(const Eigen::Vector2d& at, int size_px, const cv::Scalar& color);
  void Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width_px,
            const cv::Scalar& color);
  void DashedLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width_px,
                  const cv::Scalar& color);
  void DashedCircle(const Eigen::Vector2d& center, double radius_m, double width_px,
                    const cv::Scalar& color);
  // Blends a filled polygon over the picture; `opacity` in [0, 1].
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
