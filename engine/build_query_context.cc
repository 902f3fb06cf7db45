#include "engine/build_query_context.h"

#include <fmt/format.h>

#include "core/error.h"
#include "engine/pose/level_frame.h"

namespace cairn {

QueryContext BuildQueryContext(const LocalizeQuery& query, const DescriptorCodec& codec,
                               const SearchRegion& region) {
  const std::string map_codec = codec.codebook().CodecName();
  if (query.features.space == DescriptorSpace::kProjected && query.codec != map_codec) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("features.codec: '{}' is not this map's; it uses '{}'", query.codec,
                            map_codec));
  }
  QueryContext context;
  context.camera = query.camera;
  context.keypoints = query.features.keypoints;
  context.descriptors = codec.ProjectFeatures(query.features);
  context.region = region;
  context.rays_in_cam.reserve(context.keypoints.size());
  context.gravity_orientations_rad.resize(context.keypoints.size());
  if (query.down_in_cam) {
    context.down_in_cam = query.down_in_cam->normalized();
    context.level_from_cam = LevelFromCam(*context.down_in_cam);
  }
  for (size_t i = 0; i < context.keypoints.size(); ++i) {
    const Keypoint& keypoint = context.keypoints[i];
    context.rays_in_cam.push_back(
        query.camera.Unproject({keypoint.x_px, keypoint.y_px}).value_or(Eigen::Vector3d::Zero()));
    if (context.down_in_cam) {
      const auto orientation_rad =
          GravityRectifiedOrientationRad(query.camera, keypoint, *context.down_in_cam);
      if (orientation_rad) {
        context.gravity_orientations_rad[i] = static_cast<float>(*orientation_rad);
      }
    }
  }
  return context;
}

}  // namespace cairn
