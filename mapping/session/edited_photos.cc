#include "mapping/session/edited_photos.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/focal_length.h"

namespace cairn {
namespace {

// Beyond these, a photo was edited: EXIF and the calibration of whole pictures err by less. The
// distance of the principal point from the middle is in lengths of the longer side.
const double kMaxLogFocalError = std::log(1.15);
constexpr double kMaxOffCenter = 0.08;

}  // namespace

std::vector<std::string> NotesOnEditedPhotos(const Reconstruction& model,
                                             std::span<const MappingCamera> cameras_as_read) {
  int num_corrected = 0, num_off_center = 0;
  for (const ReconImage& image : model.images) {
    const Camera& found = model.cameras[image.camera_idx];
    const MappingCamera& before = cameras_as_read[image.camera_idx % cameras_as_read.size()];
    const double change = std::abs(std::log(found.focal_px() / before.camera.focal_px()));
    num_corrected += before.source == FocalSource::kExif && change > kMaxLogFocalError ? 1 : 0;
    const double off_px = (PrincipalPointPx(found) - PrincipalPointPx(before.camera)).norm();
    const int longer_px = std::max(found.width_px(), found.height_px());
    num_off_center += off_px > kMaxOffCenter * longer_px ? 1 : 0;
  }
  std::vector<std::string> notes;
  if (num_corrected > 0) {
    notes.push_back(fmt::format(
        "the focal length in the EXIF of {} photos contradicts what they show and does not count; "
        "perhaps they were cropped or enlarged after they were taken",
        num_corrected));
  }
  if (num_off_center > 0) {
    notes.push_back(fmt::format(
        "{} photos are parts that were cut out of larger ones, by what they show; their optical "
        "axis is not in their middle",
        num_off_center));
  }
  return notes;
}

}  // namespace cairn
