#include "lab/city/draw_city.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core.hpp>

#include "core/require.h"
#include "eval/pictures/label.h"
#include "eval/pictures/plan_symbols.h"
#include "eval/pictures/plan_view.h"
#include "lab/city/city_region.h"

namespace cairn {
namespace {

constexpr int kWidthPx = 1400;
constexpr double kMarginM = 12.0;
constexpr double kMaxPictureKm2 = 1.0;
constexpr double kTextPx = 12.0;
constexpr double kBarM = 50.0;
constexpr float kMinDotM = 0.06f;  // Smaller landmarks would fill the picture.
const cv::Scalar kRoad(226, 226, 224);
const cv::Scalar kSidewalk(240, 240, 238);
const cv::Scalar kTreeColor(120, 170, 110);
const cv::Scalar kLandmarkColor(60, 60, 90);

void FillStreet(const CityStreet& street, double half_m, const cv::Scalar& color, PlanView* view) {
  const double length_m = street.LengthM();
  view->Polygon({street.At(-half_m, half_m), street.At(-half_m, -half_m),
                 street.At(length_m + half_m, -half_m), street.At(length_m + half_m, half_m)},
                color, 1.0);
}

void DrawGround(const City& city, const CityBox& box, PlanView* view) {
  const std::vector<CityStreet> streets = city.StreetsIn(box);
  for (const CityStreet& street : streets) {
    FillStreet(street, 0.5 * street.width_m, kSidewalk, view);
  }
  for (const CityStreet& street : streets) {
    FillStreet(street, 0.5 * street.width_m - street.sidewalk_m, kRoad, view);
  }
}

void DrawHouses(const City& city, const CityBox& box, PlanView* view) {
  const CityShape& shape = city.shape();
  for (const CityBuilding& building : city.BuildingsIn(box)) {
    const double height_m = building.top_m - building.ground_m;
    const double share =
        (height_m - shape.min_height_m) / (shape.max_height_m - shape.min_height_m);
    const cv::Scalar color = 0.45 * ColorOf(0.15 + 0.7 * share) + 0.55 * kPaper;
    view->Polygon({building.corners.begin(), building.corners.end()}, color, 1.0);
    for (int k = 0; k < 4; ++k) {
      view->Line(building.corners[k], building.corners[(k + 1) % 4], 1.0, 0.7 * color);
    }
  }
}

void DrawThings(const City& city, const CityBox& box, PlanView* view) {
  const CityRegion region(city, box, 0.0);
  for (const RegionSurface& surface : region.surfaces()) {
    if (surface.surface.kind == SurfaceKind::kTree) {
      view->Dot(surface.middle, surface.radius_m * view->px_per_m(), kTreeColor);
    }
    for (const CityLandmark& landmark : surface.landmarks) {
      if (surface.surface.kind == SurfaceKind::kFacade && landmark.size_m > kMinDotM) {
        view->Speck(landmark.x_in_site.head<2>(), 1, kLandmarkColor);
      }
    }
  }
}

void DrawScale(const CityOptions& options, PlanView* view) {
  cv::Mat& image = view->image();
  const int length_px = static_cast<int>(kBarM * view->px_per_m());
  const Eigen::Vector2d left = view->area().low + Eigen::Vector2d(8.0, 8.0);
  const Eigen::Vector2d right = left + Eigen::Vector2d(kBarM, 0.0);
  view->Line(left, right, 4.0, kInk);
  const Eigen::Vector2d at = view->PixelOf(left);
  DrawLabel(fmt::format("{:g} m    {}, seed {}", kBarM, CityCharacterName(options.character),
                        options.seed),
            {static_cast<int>(at.x()) + length_px + 12, static_cast<int>(at.y()) + 5}, kTextPx,
            kInk, LabelAnchor::kLeft, true, &image);
}

}  // namespace

void DrawCity(const std::string& path, const SimulatedMapping& mapping,
              const PhoneQueries& queries) {
  const City& city = mapping.city();
  RequireWithin("city.area_km2 of a picture", city.options().area_km2, 0.0, kMaxPictureKm2);
  const CityBox box =
      BoxAroundPoint(Eigen::Vector2d::Zero(), 0.5 * city.options().SideM() + kMarginM);
  PlanView view({box.min(), box.max()}, kWidthPx);
  DrawGround(city, box, &view);
  DrawHouses(city, box, &view);
  DrawThings(city, box, &view);
  for (int pass = 0; pass < mapping.options().num_passes; ++pass) {
    const cv::Scalar color = ColorOf(pass / std::max(1.0, mapping.options().num_passes - 1.0));
    for (const RigKeyframe& keyframe : mapping.KeyframesIn(box, pass)) {
      view.Dot(keyframe.center_in_site.head<2>(), 2.0, color);
    }
  }
  for (int i = 0; i < queries.size(); ++i) {
    DrawTruth(OnPlan(queries.Place(i).cam_from_site), &view);
  }
  DrawScale(city.options(), &view);
  WritePicture(path, view.image());
}

}  // namespace cairn
