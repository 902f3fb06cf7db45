#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "core/angles.h"
#include "core/check.h"
#include "eval/pictures/label.h"
#include "eval/pictures/pictures.h"

namespace cairn {
namespace {

constexpr double kHeadlinePx = 15.0;
constexpr double kSmallTextPx = 11.0;
constexpr int kCaptionPx = 76;
constexpr int kBarColumnPx = 130;  // Beside the photo, for the color bar.
constexpr double kMinPictureWidthPx = 1200.0;
constexpr double kKeypointRadiusPx = 2.6;
const cv::Scalar kKeypointColor(225, 225, 225);

// For subpixel drawing, OpenCV takes fixed-point coordinates.
constexpr int kFractionBits = 4;

cv::Point FixedPoint(double x_px, double y_px) {
  constexpr double kOne = 1 << kFractionBits;
  return {static_cast<int>(std::lround(x_px * kOne)), static_cast<int>(std::lround(y_px * kOne))};
}

void DrawDot(double x_px, double y_px, double radius_px, const cv::Scalar& color, int thickness,
             cv::Mat* image) {
  // Keypoints are measured from pixel corners, OpenCV coordinates from pixel centers.
  cv::circle(*image, FixedPoint(x_px - 0.5, y_px - 0.5),
             static_cast<int>(std::lround(radius_px * (1 << kFractionBits))), color, thickness,
             cv::LINE_AA, kFractionBits);
}

double DistanceM(const LocalizeResult& result, const LocalizeMatch& match) {
  return (result.cam_from_anchor * match.x_in_anchor).norm();
}

// The smallest and largest distance with a color of their own. They span the bulk of the matches,
// on a log scale.
struct DistanceScale {
  double near_m = 1.0, far_m = 100.0;

  double Share(double distance_m) const {
    return std::log(std::max(distance_m, 1e-3) / near_m) / std::log(far_m / near_m);
  }
  double AtShare(double share) const { return near_m * std::pow(far_m / near_m, share); }
};

DistanceScale ScaleOf(const LocalizeResult& result) {
  std::vector<double> distances_m;
  for (const LocalizeMatch& match : result.matches) {
    distances_m.push_back(DistanceM(result, match));
  }
  if (distances_m.empty()) {
    return {};
  }
  std::sort(distances_m.begin(), distances_m.end());
  DistanceScale scale;
  scale.near_m = std::max(0.1, distances_m[distances_m.size() / 50]);
  scale.far_m = std::max(1.5 * scale.near_m, distances_m[(distances_m.size() - 1) * 49 / 50]);
  return scale;
}

std::string Headline(const LocalizeQuery& query, const LocalizeResult& result) {
  const std::string name = query.id.empty() ? "query" : query.id;
  if (!result.localized) {
    return fmt::format("{}: not localized, {}", name, NotLocalizedReasonName(result.reason));
  }
  return fmt::format("{}: {} inliers of {} keypoints", name, result.matches.size(),
                     std::max<int64_t>(result.counters.num_keypoints, query.features.size()));
}

std::string Details(const LocalizeResult& result) {
  const std::string time = fmt::format("{:.0f} ms", 1e3 * result.times.total_seconds);
  if (!result.localized) {
    return fmt::format("{} matches   {} tiles   {}", result.counters.num_matches,
                       result.tiles.size(), time);
  }
  return fmt::format(
      "lat {:.6f}  lon {:.6f}  h {:.1f} m   +- {:.2f} m, {:.2f} deg   score {:.0f}   {}",
      result.position.lat_deg(), result.position.lon_deg(), result.position.h_m,
      result.position_accuracy_m, kDegPerRad * result.rotation_accuracy_rad, result.score, time);
}

// Pales the photo a little so that dots stand out.
cv::Mat PalePhoto(const GrayImage& photo, double zoom) {
  const cv::Mat gray(photo.height_px, photo.width_px, CV_8UC1,
                     const_cast<uint8_t*>(photo.pixels.data()));
  cv::Mat pale, scaled, picture;
  gray.convertTo(pale, CV_8UC1, 0.85, 30.0);
  cv::resize(pale, scaled, cv::Size(), zoom, zoom, zoom > 1.0 ? cv::INTER_CUBIC : cv::INTER_AREA);
  cv::cvtColor(scaled, picture, cv::COLOR_GRAY2BGR);
  return picture;
}

void DrawKeypoints(const LocalizeQuery& query, double zoom, cv::Mat* picture) {
  for (const Keypoint& keypoint : query.features.keypoints) {
    DrawDot(zoom * keypoint.x_px, zoom * keypoint.y_px, kKeypointRadiusPx, kKeypointColor, 1,
            picture);
  }
}

void DrawInliers(const LocalizeQuery& query, const LocalizeResult& result,
                 const DistanceScale& scale, double zoom, cv::Mat* picture) {
  for (const LocalizeMatch& match : result.matches) {
    double radius_px = 4.0;
    if (match.keypoint_idx >= 0 && match.keypoint_idx < query.features.size()) {
      const double scale_px = query.features.keypoints[match.keypoint_idx].scale_px;
      radius_px = std::clamp(1.5 * zoom * scale_px, 3.5, 30.0);
    }
    const double x_px = zoom * match.pixel.x(), y_px = zoom * match.pixel.y();
    const cv::Scalar color = ColorOf(1.0 - scale.Share(DistanceM(result, match)));
    DrawDot(x_px, y_px, radius_px, kInk, 3, picture);
    DrawDot(x_px, y_px, radius_px, color, 2, picture);
    DrawDot(x_px, y_px, 1.5, color, cv::FILLED, picture);
  }
}

void DrawDistanceBar(const DistanceScale& scale, const cv::Rect& area, cv::Mat* picture) {
  std::vector<std::string> labels;
  for (const double share : {1.0, 0.75, 0.5, 0.25, 0.0}) {  // Near is red and at the top.
    const double distance_m = scale.AtShare(share);
    labels.push_back(fmt::format("{:.{}f} m", distance_m, distance_m < 10.0 ? 1 : 0));
  }
  DrawLabel("distance", {area.x + 20, area.y + 30}, kSmallTextPx, kInk, LabelAnchor::kLeft, false,
            picture);
  DrawColorBar({area.x + 20, area.y + 46, 22, std::max(60, area.height / 2)}, labels, kSmallTextPx,
               picture);
}

void DrawMatchLegend(bool localized, const cv::Rect& area, cv::Mat* picture) {
  const int y = area.y + area.height - 60;
  cv::rectangle(*picture, cv::Rect(area.x + 20, y - 10, 20, 20), cv::Scalar(120, 120, 120),
                cv::FILLED);
  DrawDot(area.x + 30, y, kKeypointRadiusPx, kKeypointColor, 1, picture);
  DrawLabel("keypoint", {area.x + 46, y + 5}, kSmallTextPx, kInk, LabelAnchor::kLeft, false,
            picture);
  if (localized) {
    DrawDot(area.x + 30, y + 28, 6.0, ColorOf(0.5), 2, picture);
    DrawLabel("inlier", {area.x + 46, y + 33}, kSmallTextPx, kInk, LabelAnchor::kLeft, false,
              picture);
  }
}

cv::Mat PictureOfMatches(const GrayImage& photo, const LocalizeQuery& query,
                         const LocalizeResult& result) {
  CAIRN_CHECK(photo.width_px > 0 && photo.height_px > 0, "an empty photo");
  const double zoom = std::min(3.0, std::max(1.0, kMinPictureWidthPx / photo.width_px));
  cv::Mat on_photo = PalePhoto(photo, zoom);
  const DistanceScale scale = ScaleOf(result);
  // Keypoints are in pixels of the picture. A corner of less than a pixel would not be seen.
  const double picture_zoom = photo.full ? zoom / photo.full->pixel_px : zoom;
  DrawKeypoints(query, picture_zoom, &on_photo);
  if (result.localized) {
    DrawInliers(query, result, scale, picture_zoom, &on_photo);
  }

  cv::Mat picture(on_photo.rows + kCaptionPx, on_photo.cols + kBarColumnPx, CV_8UC3, kPaper);
  on_photo.copyTo(picture(cv::Rect(0, kCaptionPx, on_photo.cols, on_photo.rows)));
  DrawLabel(Headline(query, result), {16, 30}, kHeadlinePx, kInk, LabelAnchor::kLeft, false,
            &picture);
  DrawLabel(Details(result), {16, 60}, kSmallTextPx, kInk, LabelAnchor::kLeft, false, &picture);
  const cv::Rect side(on_photo.cols, kCaptionPx, kBarColumnPx, on_photo.rows);
  if (result.localized) {
    DrawDistanceBar(scale, side, &picture);
  }
  DrawMatchLegend(result.localized, side, &picture);
  return picture;
}

}  // namespace

void DrawMatches(const std::string& path, const GrayImage& photo, const LocalizeQuery& query,
                 const LocalizeResult& result) {
  WritePicture(path, PictureOfMatches(photo, query, result));
}

std::vector<uint8_t> MatchesAsJpeg(const GrayImage& photo, const LocalizeQuery& query,
                                   const LocalizeResult& result) {
  return EncodePicture(".jpg", PictureOfMatches(photo, query, result));
}

}  // namespace cairn
