#include "mapping/session/report_svg.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace cairn {
namespace {

constexpr double kSidePx = 900.0, kMarginPx = 40.0;
constexpr const char* kBefore = "#999999";
constexpr const char* kAfter = "#1565c0";
constexpr const char* kLeftOut = "#c62828";

using Places = std::vector<std::optional<Eigen::Vector3d>>;

// Maps east and north to pixels.
class View {
 public:
  View(const Places& a, const Places& b) {
    Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300), high = -low;
    for (const Places* places : {&a, &b}) {
      for (const auto& place : *places) {
        if (place) {
          low = low.cwiseMin(place->head<2>());
          high = high.cwiseMax(place->head<2>());
        }
      }
    }
    low_ = low;
    const Eigen::Vector2d extent = (high - low).cwiseMax(1e-3);
    px_per_m_ = (kSidePx - 2.0 * kMarginPx) / extent.maxCoeff();
    size_ = px_per_m_ * extent + Eigen::Vector2d::Constant(2.0 * kMarginPx);
  }

  Eigen::Vector2d Pixel(const Eigen::Vector3d& x_in_enu) const {
    const Eigen::Vector2d from_low = px_per_m_ * (x_in_enu.head<2>() - low_);
    return {kMarginPx + from_low.x(), size_.y() - kMarginPx - from_low.y()};
  }
  double px_per_m() const { return px_per_m_; }
  double width_px() const { return std::max(size_.x(), 400.0); }
  double height_px() const { return size_.y() + 60.0; }  // With the legend.

 private:
  Eigen::Vector2d low_, size_;
  double px_per_m_ = 1.0;
};

void AddWay(const Places& places, const View& view, const char* color, std::string* svg) {
  std::string points;
  for (const auto& place : places) {
    if (place) {
      const Eigen::Vector2d pixel = view.Pixel(*place);
      points += fmt::format("{:.1f},{:.1f} ", pixel.x(), pixel.y());
      *svg += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='3' fill='{}'/>\n", pixel.x(),
                          pixel.y(), color);
    }
  }
  *svg += fmt::format("<polyline points='{}' fill='none' stroke='{}' stroke-width='1'/>\n", points,
                      color);
}

void AddResiduals(const MappedPhotos& mapped, const View& view, std::string* svg) {
  for (size_t i = 0; i < mapped.position_of_photo.size(); ++i) {
    const auto& before = mapped.position_of_photo[i];
    const auto& after = mapped.center_of_photo[i];
    if (!before) {
      continue;
    }
    const Eigen::Vector2d from = view.Pixel(*before);
    if (after) {
      const Eigen::Vector2d to = view.Pixel(*after);
      *svg += fmt::format(
          "<line x1='{:.1f}' y1='{:.1f}' x2='{:.1f}' y2='{:.1f}' stroke='{}' "
          "stroke-dasharray='2 3'/>\n",
          from.x(), from.y(), to.x(), to.y(), kBefore);
    } else {
      *svg += fmt::format(
          "<circle cx='{:.1f}' cy='{:.1f}' r='6' fill='none' stroke='{}' stroke-width='2'/>\n",
          from.x(), from.y(), kLeftOut);
    }
  }
}

// The longest of 1, 2, 5, 10, ... meters that is at most a third of the picture.
double BarM(const View& view) {
  const double most_m = view.width_px() / 3.0 / view.px_per_m();
  const double power = std::pow(10.0, std::floor(std::log10(most_m)));
  return most_m >= 5.0 * power ? 5.0 * power : most_m >= 2.0 * power ? 2.0 * power : power;
}

void AddLegend(const MappedPhotos& mapped, const View& view, std::string* svg) {
  const double y = view.height_px() - 50.0;
  const double bar_m = BarM(view);
  *svg += fmt::format(
      "<line x1='{0}' y1='{1:.1f}' x2='{2:.1f}' y2='{1:.1f}' stroke='black' stroke-width='2'/>\n"
      "<text x='{0}' y='{3:.1f}'>{4} m</text>\n",
      kMarginPx, y, kMarginPx + bar_m * view.px_per_m(), y + 16.0, bar_m);
  *svg += fmt::format(
      "<text x='{}' y='{:.1f}'><tspan fill='{}'>positions</tspan> <tspan fill='{}'>cameras: {} of "
      "{}</tspan> <tspan fill='{}'>left out</tspan></text>\n",
      kMarginPx, y + 36.0, kBefore, kAfter, mapped.num_mapped, mapped.num_photos, kLeftOut);
}

}  // namespace

std::string ReportSvg(const MappedPhotos& mapped) {
  const View view(mapped.position_of_photo, mapped.center_of_photo);
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='{:.0f}' height='{:.0f}' "
      "font-family='sans-serif' font-size='14'>\n<rect width='100%' height='100%' "
      "fill='white'/>\n",
      view.width_px(), view.height_px());
  AddResiduals(mapped, view, &svg);
  AddWay(mapped.position_of_photo, view, kBefore, &svg);
  AddWay(mapped.center_of_photo, view, kAfter, &svg);
  AddLegend(mapped, view, &svg);
  return svg + "</svg>\n";
}

}  // namespace cairn
