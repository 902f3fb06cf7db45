// A place in a picture where a feature is expected.
#ifndef CAIRN_CORE_EXPECTED_FEATURE_H_
#define CAIRN_CORE_EXPECTED_FEATURE_H_

namespace cairn {

// In pixels of the picture; (0.5, 0.5) is the center of the upper left pixel.
struct ExpectedFeature {
  float x_px = 0.0f;
  float y_px = 0.0f;
  float radius_px = 0.0f;  // The keypoint lies within this distance.
  // The range of Keypoint::scale_px.
  float min_scale_px = 0.0f;
  float max_scale_px = 0.0f;
};

}  // namespace cairn

#endif  // CAIRN_CORE_EXPECTED_FEATURE_H_
