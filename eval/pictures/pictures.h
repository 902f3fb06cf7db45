// Pictures of an answer: matched keypoints on the photo, and a top view of map, prior and pose.
#ifndef CAIRN_EVAL_PICTURES_PICTURES_H_
#define CAIRN_EVAL_PICTURES_PICTURES_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/geodesy.h"
#include "core/images/gray_image.h"
#include "core/rigid3.h"
#include "engine/query/localize_query.h"
#include "engine/query/localize_result.h"
#include "storage/map/map_store.h"

namespace cairn {

// Draws the photo with all keypoints (small, gray), the inliers (colored by landmark distance) and
// a caption with the result. The extension selects the format. Throws Error(kIo).
void DrawMatches(const std::string& path, const GrayImage& photo, const LocalizeQuery& query,
                 const LocalizeResult& result);

// The same picture as the bytes of a JPEG file.
std::vector<uint8_t> MatchesAsJpeg(const GrayImage& photo, const LocalizeQuery& query,
                                   const LocalizeResult& result);

// One pose on the top view.
struct TopViewPose {
  std::string label;
  std::optional<Geodetic> prior;
  double prior_accuracy_m = 0.0;
  std::optional<Rigid3d> estimated_cam_from_ecef;
  std::optional<Rigid3d> reference_cam_from_ecef;
};

// Draws a north-up plan in meters with a scale bar and a legend. It shows tiles, landmarks,
// keyframes, priors with their accuracy circles, and estimated and true poses with their viewing
// directions.
void DrawTopView(const std::string& path, const MapStore& store,
                 const std::vector<TopViewPose>& poses);

}  // namespace cairn

#endif  // CAIRN_EVAL_PICTURES_PICTURES_H_
