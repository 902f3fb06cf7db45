// Localizes a photo in a map, with the library instead of the program: docs/using_the_library.md.
#include <cstdio>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/features/sift/sift_extractor.h"
#include "core/images/exif.h"
#include "core/images/gray_image.h"
#include "core/images/orient_image.h"
#include "core/images/photo_camera.h"
#include "engine/localizer.h"

namespace {

// The rough position in the EXIF; 15 m unless the phone says otherwise.
std::optional<cairn::PositionPrior> PriorOf(const cairn::ExifInfo& exif) {
  if (!exif.gps) {
    return std::nullopt;  // The places of the map that look most like the photo are searched.
  }
  cairn::PositionPrior prior;
  prior.position = *exif.gps;
  prior.accuracy_m = exif.gps_error_m.value_or(15.0);
  return prior;
}

cairn::LocalizeQuery QueryOf(const char* path) {
  cairn::Photo photo = cairn::ReadPhoto(path);
  const cairn::ExifInfo exif = cairn::ReadExif(photo.bytes);
  const cairn::GrayImage upright = cairn::OrientImage(std::move(photo.image), exif.orientation);
  cairn::PhotoCamera camera =
      cairn::CameraOfPhoto(exif, upright.picture_width_px(), upright.picture_height_px());
  cairn::LocalizeQuery query;
  query.id = path;
  query.camera = std::move(camera.camera);
  query.focal = camera.focal;  // How well the focal length is known; refined with the pose.
  query.features = cairn::ExtractSift(upright);
  query.prior = PriorOf(exif);
  return query;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: localize_photo MAP PHOTO\n");
    return 2;
  }
  try {
    // One localizer serves all threads of a program; it keeps tiles in memory.
    const cairn::Localizer localizer = cairn::Localizer::Open(argv[1]);
    const cairn::LocalizeResult result = localizer.Localize(QueryOf(argv[2]));
    if (!result.localized) {
      std::printf("%s: %s\n", cairn::NotLocalizedReasonName(result.reason),
                  result.reason_text.c_str());
      return 3;
    }
    std::printf("%.8f %.8f %.3f  within %.2f m, confidence %.3f\n", result.position.lat_deg(),
                result.position.lon_deg(), result.position.h_m, result.EarthAccuracyM(),
                result.confidence);
    return 0;
  } catch (const cairn::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
