// The two views of a street as matching would find them without errors.
#ifndef CAIRN_TESTS_MAPPING_STREET_VIEWS_H_
#define CAIRN_TESTS_MAPPING_STREET_VIEWS_H_

#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "core/scene/reconstruction.h"
#include "mapping/matching/two_view.h"

namespace cairn::testing {

// Says whether the keypoints of two photos that show a landmark are matched.
using IsMatched = std::function<bool(int photo_a, int photo_b, int landmark)>;

// The relative poses of photos that are at most six apart, with `min_inliers` matches and more.
inline std::vector<TwoView> TrueViews(
    const Reconstruction& street, int min_inliers,
    const IsMatched& is_matched = [](int, int, int) { return true; }) {
  constexpr int kFarthest = 6;
  std::map<std::pair<int, int>, std::vector<FeatureMatch>> matches;
  for (int i = 0; i < static_cast<int>(street.landmarks.size()); ++i) {
    for (const ReconObservation& p : street.landmarks[i].observations) {
      for (const ReconObservation& q : street.landmarks[i].observations) {
        if (p.image_idx < q.image_idx && q.image_idx <= p.image_idx + kFarthest &&
            is_matched(p.image_idx, q.image_idx, i)) {
          matches[{p.image_idx, q.image_idx}].push_back({p.keypoint_idx, q.keypoint_idx, 0.1f});
        }
      }
    }
  }
  std::vector<TwoView> views;
  for (auto& [pair, inliers] : matches) {
    if (static_cast<int>(inliers.size()) < min_inliers) {
      continue;
    }
    TwoView view;
    view.a = pair.first;
    view.b = pair.second;
    view.b_from_a =
        street.images[view.b].cam_from_world * street.images[view.a].cam_from_world.Inverse();
    view.b_from_a.translation.normalize();
    view.inliers = std::move(inliers);
    view.parallax_rad = 0.05;
    view.rotation_sigma_rad = 0.002;
    view.direction_sigma_rad = 0.01;
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_MAPPING_STREET_VIEWS_H_
