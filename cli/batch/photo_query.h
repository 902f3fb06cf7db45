// Makes a query of a photo and of what a command line says about it.
#ifndef CAIRN_CLI_BATCH_PHOTO_QUERY_H_
#define CAIRN_CLI_BATCH_PHOTO_QUERY_H_

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/camera.h"
#include "core/images/gray_image.h"
#include "engine/query/localize_query.h"
#include "http/json/image_orientation.h"

namespace cairn {

struct PhotoQueryOptions {
  // For the picture as stored or as turned by its EXIF, whichever has the camera's size. Without a
  // camera, the EXIF states it, or else it is unknown (CameraOfPhoto).
  std::optional<Camera> camera = {};
  std::optional<double> focal_log_sigma = {};  // Replaces that of the EXIF or the camera.
  std::optional<PositionPrior> prior = {};
  bool exif_prior = true;  // Without `prior`, the position in the EXIF is the prior.
  std::optional<Eigen::Vector3d> down_in_cam = {};
  bool with_pixels = true;  // Without, only the header of the photo is read.
};

struct PhotoQuery {
  Photo photo;  // The image is turned as the query means it; empty without pixels.
  ImageOrientation orientation = ImageOrientation::kStored;  // Of the picture that is meant.
  LocalizeQuery query;  // Without features. The id is the path of the photo.
};

// Throws Error(kBadInput) that names the photo unless its picture has the size of the camera's.
void RequireSizeOf(const Camera& camera, int width_px, int height_px, const std::string& photo);

// Throws as ReadPhoto and ReadExif, and Error(kBadInput) if the picture has another size than the
// camera. Messages name the path.
PhotoQuery ReadPhotoQuery(const std::string& path, const PhotoQueryOptions& options);

}  // namespace cairn

#endif  // CAIRN_CLI_BATCH_PHOTO_QUERY_H_
