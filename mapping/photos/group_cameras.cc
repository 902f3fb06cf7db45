#include "mapping/photos/group_cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "core/camera_of_this_size.h"
#include "core/error.h"
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

// The size of the whole picture, which EXIF's focal length is about, has other proportions.
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
          camera.focal.with_distortion ? FocalSource::kGuess : FocalSource::kExif,
          /*may_be_cropped=*/IsCropped(photo)};
}

// A phone takes its photos in one size. A smaller one was reduced, or cut out of a larger one.
class WholeSizes {
 public:
  explicit WholeSizes(const std::vector<PhotoLens>& photos) {
    for (const PhotoLens& photo : photos) {
      if (HasLens(photo)) {
        int& longest = longest_px_of_lens_[LensOf(photo)];
        longest = std::max(longest, LongerSidePx(photo));
      }
    }
  }

  // How many times longer the largest photos of the same kind of camera and focal length are.
  double EnlargementOf(const PhotoLens& photo) const {
    return HasLens(photo) ? static_cast<double>(longest_px_of_lens_.at(LensOf(photo))) /
                                std::max(1, LongerSidePx(photo))
                          : 1.0;
  }

 private:
  using Lens = std::pair<uint64_t, double>;  // The kind of camera, 0: unknown; the focal length.

  static bool HasLens(const PhotoLens& photo) { return photo.exif.focal_35mm.has_value(); }
  static Lens LensOf(const PhotoLens& photo) {
    return {photo.exif.camera_kind, *photo.exif.focal_35mm};
  }
  static int LongerSidePx(const PhotoLens& photo) {
    return std::max(photo.width_px, photo.height_px);
  }

  std::map<Lens, int> longest_px_of_lens_;
};

// If the photo was cut out, its focal length is `enlargement` times that of its EXIF.
void DoubtSize(double enlargement, MappingCamera* camera) {
  camera->may_be_cropped = true;
  camera->focal.log_sigma =
      std::min(FocalPrior::kUnknownLogSigma, camera->focal.log_sigma + 0.5 * std::log(enlargement));
}

// Known cameras whose focal length is not that of the EXIF of their photos.
class Contradictions {
 public:
  // Throws Error(kBadInput) if the parameters are those of another size of the picture.
  void Add(const PhotoLens& photo, const Camera& known) {
    constexpr double kFactor = 1.3;
    if (!photo.exif.focal_35mm || IsCropped(photo)) {
      return;
    }
    const double exif_px =
        CameraOfPhoto(photo.exif, photo.width_px, photo.height_px).camera.focal_px();
    const double factor = known.focal_px() / exif_px;
    if (std::max(factor, 1.0 / factor) < kFactor) {
      return;
    }
    if (const auto scaled = CameraOfThisSize(known);
        scaled && std::abs(std::log(scaled->focal_px() / exif_px)) < std::log(kFactor)) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("the parameters of the known camera of {0} x {1} pixels look like "
                              "those of a picture {2:.2f} times as large, by the principal point "
                              "and the EXIF (focal length {3:.0f} px, not {4:.0f}): state the size "
                              "that the parameters are for; smaller copies are served, too",
                              photo.width_px, photo.height_px,
                              known.focal_px() / scaled->focal_px(), exif_px, known.focal_px()));
    }
    ++num_photos_;
    factor_ = factor;
  }

  std::optional<std::string> Note() const {
    if (num_photos_ == 0) {
      return std::nullopt;
    }
    return fmt::format(
        "the focal length of the known camera is {:.2f} times that of the EXIF of {} photos; the "
        "known camera counts",
        factor_, num_photos_);
  }

 private:
  int num_photos_ = 0;
  double factor_ = 1.0;
};

}  // namespace

CameraGroups GroupCameras(const std::vector<PhotoLens>& photos,
                          const std::vector<Camera>& calibrated) {
  CameraGroups groups;
  std::map<Size, size_t> num_of_size;
  for (const PhotoLens& photo : photos) {
    ++num_of_size[{photo.width_px, photo.height_px}];
  }
  // Size, kind, focal length, and the photo itself if it shares nothing.
  using Key = std::tuple<int, int, uint64_t, double, size_t>;
  std::map<Key, int> group_of;
  int num_cropped = 0, num_other_size = 0;
  Contradictions contradictions;
  const WholeSizes whole_sizes(photos);
  for (size_t i = 0; i < photos.size(); ++i) {
    const PhotoLens& photo = photos[i];
    MappingCamera camera = CameraOf(photo, calibrated);
    const double enlargement = whole_sizes.EnlargementOf(photo);
    if (camera.source == FocalSource::kExif && enlargement > 1.0) {
      DoubtSize(enlargement, &camera);
    }
    const bool is_known = camera.source == FocalSource::kCalibration;
    num_cropped += !is_known && IsCropped(photo) && photo.exif.focal_35mm ? 1 : 0;
    num_other_size += !calibrated.empty() && !is_known ? 1 : 0;
    if (is_known) {
      contradictions.Add(photo, camera.camera);
    }
    const bool is_anonymous = photo.exif.camera_kind == 0 && !photo.exif.focal_35mm;
    if (!is_known && is_anonymous &&
        2 * num_of_size[{photo.width_px, photo.height_px}] < photos.size()) {
      camera.may_be_cropped = true;
    }
    const Key key = {photo.width_px, photo.height_px, is_known ? 0 : photo.exif.camera_kind,
                     is_known ? 0.0 : photo.exif.focal_35mm.value_or(0.0),
                     camera.may_be_cropped ? i + 1 : 0};
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
  if (auto note = contradictions.Note()) {
    groups.notes.push_back(*std::move(note));
  }
  return groups;
}

}  // namespace cairn
