#include "engine/query/build_query_context.h"

#include <fmt/format.h>

#include <optional>
#include <string>

#include "core/check.h"
#include "core/error.h"
#include "engine/query/level_frame.h"
#include "storage/codebook/distance_statistics.h"

namespace cairn {

namespace {

void CheckCodec(const LocalizeQuery& query, const DescriptorCodec& codec) {
  const std::string map_codec = codec.codebook().CodecName();
  if (query.features.space == DescriptorSpace::kProjected && query.codec != map_codec) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("features.codec: '{}' does not match this map's codec '{}'",
                            query.codec, map_codec));
  }
}

std::optional<float> GravityOrientationRad(const Camera& camera, const Keypoint& keypoint,
                                           const std::optional<Eigen::Vector3d>& down_in_own) {
  if (down_in_own) {
    if (const auto angle_rad = GravityRectifiedOrientationRad(camera, keypoint, *down_in_own)) {
      return static_cast<float>(*angle_rad);
    }
  }
  return std::nullopt;
}

Eigen::Vector3d RayOf(const Camera& camera, const Keypoint& keypoint) {
  return camera.Unproject({keypoint.x_px, keypoint.y_px}).value_or(Eigen::Vector3d::Zero());
}

// Appends the keypoints of one camera, without descriptors. `rotation` is that of cam_from_first.
void AddKeypoints(const Camera& camera, const FeatureSet& features,
                  const Eigen::Quaterniond& rotation, QueryContext* context) {
  std::optional<Eigen::Vector3d> down_in_own;
  if (context->down_in_cam) {
    down_in_own = rotation * *context->down_in_cam;
  }
  for (const Keypoint& keypoint : features.keypoints) {
    context->keypoints.push_back(keypoint);
    context->rays_in_cam.push_back(rotation.conjugate() * RayOf(camera, keypoint));
    context->gravity_orientations_rad.push_back(
        GravityOrientationRad(camera, keypoint, down_in_own));
  }
}

// Extends the context of a query's own camera to its whole rig.
void AddOtherCameras(const LocalizeQuery& query, const DescriptorCodec& codec,
                     QueryContext* context) {
  context->camera_of_keypoint.assign(context->keypoints.size(), 0);
  context->origins_in_cam.assign(context->keypoints.size(), Eigen::Vector3d::Zero());
  for (const RigCamera& other : query.other_cameras) {
    context->other_cameras.push_back({other.camera, other.cam_from_first});
    AddKeypoints(other.camera, other.features, other.cam_from_first.rotation, context);
    context->camera_of_keypoint.resize(context->keypoints.size(),
                                       static_cast<uint8_t>(context->other_cameras.size()));
    context->origins_in_cam.resize(context->keypoints.size(),
                                   other.cam_from_first.Inverse().translation);
    if (other.features.size() > 0) {
      const DescriptorMatrix projected = codec.ProjectFeatures(other.features);
      const Eigen::Index num_before = context->descriptors.rows();
      context->descriptors.conservativeResize(num_before + projected.rows(), projected.cols());
      context->descriptors.bottomRows(projected.rows()) = projected;
    }
  }
}

}  // namespace

QueryContext BuildQueryContext(const LocalizeQuery& query, const DescriptorCodec& codec,
                               const SearchRegion& region) {
  CheckCodec(query, codec);
  QueryContext context;
  context.camera = query.camera;
  context.descriptors = query.features.size() == 0 && !query.other_cameras.empty()
                            ? DescriptorMatrix(0, codec.codebook().projected_dim())
                            : codec.ProjectFeatures(query.features);
  context.same_landmark_distance = SameLandmarkDistance(codec.codebook(), 0.5);
  context.region = region;
  if (query.down_in_cam) {
    context.down_in_cam = query.down_in_cam->normalized();
    context.level_from_cam = LevelFromCam(*context.down_in_cam);
  }
  AddKeypoints(query.camera, query.features, Eigen::Quaterniond::Identity(), &context);
  if (!query.other_cameras.empty()) {
    AddOtherCameras(query, codec, &context);
  }
  return context;
}

QueryContext WithRegion(QueryContext context, const SearchRegion& region) {
  context.region = region;
  return context;
}

QueryContext WithCamera(QueryContext context, const Camera& camera) {
  CAIRN_CHECK(!context.is_rig(), "the camera of a rig cannot be replaced");
  context.camera = camera;
  for (int i = 0; i < context.num_keypoints(); ++i) {
    context.rays_in_cam[i] = RayOf(camera, context.keypoints[i]);
    context.gravity_orientations_rad[i] =
        GravityOrientationRad(camera, context.keypoints[i], context.down_in_cam);
  }
  return context;
}

QueryContext WithoutGravity(QueryContext context) {
  context.down_in_cam.reset();
  context.level_from_cam.reset();
  context.gravity_orientations_rad.assign(context.keypoints.size(), std::nullopt);
  return context;
}

}  // namespace cairn
