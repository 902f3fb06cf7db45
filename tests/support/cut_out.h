// A query of a part of a picture.
#ifndef CAIRN_TESTS_SUPPORT_CUT_OUT_H_
#define CAIRN_TESTS_SUPPORT_CUT_OUT_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "core/focal_length.h"
#include "engine/query/localize_query.h"

namespace cairn::testing {

// A rectangle, in shares of the width and the height.
struct Part {
  double left = 0.0, top = 0.0, right = 1.0, bottom = 1.0;
};

// The query of this part of the picture, whose camera nobody states.
inline LocalizeQuery CutOut(const LocalizeQuery& whole, const Part& part) {
  const auto width_px = static_cast<double>(whole.camera.width_px());
  const auto height_px = static_cast<double>(whole.camera.height_px());
  const Eigen::AlignedBox2d window(Eigen::Vector2d(part.left * width_px, part.top * height_px),
                                   Eigen::Vector2d(part.right * width_px, part.bottom * height_px));
  LocalizeQuery query = whole;
  query.features.keypoints.clear();
  std::vector<int> kept;
  for (int i = 0; i < whole.features.size(); ++i) {
    Keypoint keypoint = whole.features.keypoints[i];
    if (window.contains(Eigen::Vector2d(keypoint.x_px, keypoint.y_px))) {
      keypoint.x_px -= static_cast<float>(window.min().x());
      keypoint.y_px -= static_cast<float>(window.min().y());
      query.features.keypoints.push_back(keypoint);
      kept.push_back(i);
    }
  }
  query.features.descriptors = whole.features.descriptors(kept, Eigen::all);
  query.camera = CameraOfUnknownFocal(static_cast<int>(window.sizes().x()),
                                      static_cast<int>(window.sizes().y()));
  query.focal = FocalPrior{.with_distortion = true};
  return query;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_CUT_OUT_H_
