#include "http/json/request_photos.h"

#include <utility>

#include "core/error.h"
#include "core/geoid.h"
#include "core/images/photo_camera.h"
#include "http/json/image_orientation.h"

namespace cairn {
namespace {

// Returns nothing if the bytes are not JPEG, PNG or PNM.
std::optional<ExifInfo> TryReadExif(const RequestImage& image) {
  try {
    return ReadExif(image.bytes);
  } catch (const Error&) {
    return std::nullopt;
  }
}

// Without the grid of the geoid, the height is unknown.
Geodetic WithHeight(const ExifInfo& exif) {
  Geodetic position = *exif.gps;
  try {
    return WithEllipsoidalHeight(position, exif.height_reference);
  } catch (const Error&) {
    position.h_m = 0.0;
    return position;
  }
}

// Returns whether the request states nothing of the camera but its size.
bool KnowsOnlyTheSize(const LocalizeQuery& query) {
  return query.focal && query.focal->with_distortion;
}

}  // namespace

std::optional<PositionPrior> PriorOfPhoto(const ExifInfo& exif) {
  const double accuracy_m = exif.gps_error_m.value_or(kUnknownAccuracyM);
  if (!exif.gps || accuracy_m > PositionPrior::kMaxAccuracyM) {
    return std::nullopt;
  }
  PositionPrior prior;
  prior.position = exif.has_altitude ? WithHeight(exif) : *exif.gps;
  prior.accuracy_m = accuracy_m;
  prior.source = PriorSource::kPhoto;
  return prior;
}

void ReadPhotos(bool takes_exif_prior, LocalizeRequest* request) {
  LocalizeQuery& query = request->query;
  const bool wants_prior = takes_exif_prior && request->exif_prior && !query.prior;
  for (size_t i = 0; i < request->images.size(); ++i) {
    const bool wants_camera = i == 0 && KnowsOnlyTheSize(query);
    if (!request->picture && !(wants_prior && i == 0) && !wants_camera) {
      continue;
    }
    const std::optional<ExifInfo> exif = TryReadExif(request->images[i]);
    if (!exif) {
      continue;
    }
    if (request->picture) {
      const Camera& camera = i == 0 ? query.camera : query.other_cameras[i - 1].camera;
      request->images[i].orientation =
          OrientationToApply({exif->width_px, exif->height_px, exif->orientation},
                             *request->picture, camera.width_px(), camera.height_px());
    }
    if (wants_prior && i == 0) {
      query.prior = PriorOfPhoto(*exif);
    }
    if (wants_camera) {
      PhotoCamera of_photo =
          CameraOfPhoto(*exif, query.camera.width_px(), query.camera.height_px());
      query.camera = std::move(of_photo.camera);
      query.focal = of_photo.focal;
    }
  }
  request->picture.reset();
}

}  // namespace cairn
