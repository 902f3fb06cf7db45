#include "mapping/photos/group_cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "core/images/photo_camera.h"

namespace cairn {
namespace {

// Sides of pictures are rounded when a picture is reduced.
constexpr double kMaxRatioError = 0.01;

using Size = std::pair<int, int>;

double Ratio(double width, double height) {
  return std::max(width, height) / std::max(1.0, std::min(width, height));
}

bool SameRatio(double a, double b) { return std::abs(a / b - 1.0) <= kMaxRatioError; }

// EXIF's focal length is that of the whole picture.
bool IsCropped(const PhotoLens& photo) {
  const ExifInfo& exif = photo.exif;
  return exif.original_width_px > 0 && exif.original_height_px > 0 &&
         !SameRatio(Ratio(exif.original_width_px, exif.original_height_px),
                    Ratio(photo.width_px, photo.height_px));
}

// Nothing if the camera has other proportions.
std::optional<Camera> ScaledTo(const Camera& camera, int width_px, int height_px) {
  const double across = static_cast<double>(width_px) / camera.width_px();
  const double along = static_cast<double>(height_px) / camera.height_px();
  if (!SameRatio(across, along)) {
    return std::nullopt;
  }
  std::vector<double> params = camera.params();
  const int num_focal = NumFocalLengths(camera.model());
  params[0] *= across;
  params[num_focal - 1] *= num_focal == 2 ? along : 1.0;
  params[num_focal] *= across;
  params[num_focal + 1] *= along;
  return Camera(camera.model(), width_px, height_px, std::move(params));
}

std::optional<Camera> Calibrated(const PhotoLens& photo, const std::vector<Camera>& known) {
  std::optional<Camera> scaled;
  for (const Camera& camera : known) {
    if (camera.width_px() == photo.width_px && camera.height_px() == photo.height_px) {
      return camera;
    }
    if (!scaled) {
      scaled = ScaledTo(camera, photo.width_px, photo.height_px);
    }
  }
  return scaled;
}

MappingCamera CameraOf(const PhotoLens& photo, const std::vector<Camera>& known) {
  if (const std::optional<Camera> camera = Calibrated(photo, known)) {
    return {*camera, {}, FocalSource::kCalibration};
  }
  ExifInfo exif = photo.exif;
  if (IsCropped(photo)) {
    exif.focal_35mm.reset();
  }
  const PhotoCamera camera = CameraOfPhoto(exif, photo.width_px, photo.height_px);
  return {camera.camera, camera.focal,
          camera.focal.with_distortion ? FocalSource::kGuess : FocalSource::kExif};
}

}  // namespace

CameraGroups GroupCameras(const std::vector<PhotoLens>& photos,
                          const std::vector<Camera>& calibrated) {
  CameraGroups groups;
  std::map<Size, size_t> num_of_size;
  for (const PhotoLens& photo : photos) {
    ++num_of_size[{photo.width_px, photo.height_px}];
  }
  // Size, kind, focal length, whether it was cropped, and the photo itself if it shares nothing.
  using Key = std::tuple<int, int, uint64_t, double, bool, size_t>;
  std::map<Key, int> group_of;
  int num_cropped = 0, num_other_size = 0;
  for (size_t i = 0; i < photos.size(); ++i) {
    const PhotoLens& photo = photos[i];
    MappingCamera camera = CameraOf(photo, calibrated);
    const bool is_known = camera.source == FocalSource::kCalibration;
    const bool is_cropped = !is_known && IsCropped(photo) && photo.exif.focal_35mm;
    num_cropped += is_cropped ? 1 : 0;
    num_other_size += !calibrated.empty() && !is_known ? 1 : 0;
    const bool is_anonymous = photo.exif.camera_kind == 0 && !photo.exif.focal_35mm;
    const bool is_alone =
        !is_known &&
        ((is_anonymous && 2 * num_of_size[{photo.width_px, photo.height_px}] < photos.size()) ||
         is_cropped);
    const Key key = {photo.width_px,
                     photo.height_px,
                     is_known ? 0 : photo.exif.camera_kind,
                     is_known ? 0.0 : photo.exif.focal_35mm.value_or(0.0),
                     is_cropped,
                     is_alone ? i + 1 : 0};
    const auto [group, is_new] = group_of.try_emplace(key, static_cast<int>(groups.cameras.size()));
    if (is_new) {
      groups.cameras.push_back(std::move(camera));
    }
    groups.camera_of_photo.push_back(group->second);
  }
  if (num_cropped > 0) {
    groups.notes.push_back(fmt::format(
        "{} photos were cropped after they were taken; their EXIF focal length is not used",
        num_cropped));
  }
  if (num_other_size > 0) {
    groups.notes.push_back(fmt::format(
        "{} photos have other proportions than the given camera, which does not count for them",
        num_other_size));
  }
  return groups;
}

}  // namespace cairn
