#include "cli/batch/world_frame.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "core/error.h"
#include "core/printable.h"
#include "eval/reference_alignment.h"
#include "ingest/colmap/colmap_model.h"

namespace cairn {
namespace {

double Rounded(double value, double steps_per_unit) {
  return std::round(value * steps_per_unit) / steps_per_unit;
}

}  // namespace

std::string WorldFrame::Text() const {
  if (name == "enu") {
    return fmt::format(
        "east-north-up at {:.8g},{:.9g},{:g} (latitude, longitude, ellipsoidal "
        "height)",
        origin->lat_deg(), origin->lon_deg(), origin->h_m);
  }
  return name == "model" ? "the frame of the COLMAP model" : "ECEF (WGS84)";
}

Rigid3d WorldFrame::CamFromWorld(const Rigid3d& cam_from_ecef) const {
  return CamFromTarget(cam_from_ecef, ecef_from_world.Inverse());
}

WorldFrame EnuFrame(const Geodetic& origin) {
  const Rigid3d ecef_from_enu = EcefFromEnu(origin);
  return {.name = "enu",
          .origin = origin,
          .ecef_from_world = {1.0, ecef_from_enu.rotation, ecef_from_enu.translation}};
}

Geodetic MapOrigin(const MapSnapshot& map) {
  std::optional<KeyframeRecord> first;
  for (const SessionRecord& session : map.Sessions()) {
    for (const KeyframeRecord& keyframe : map.KeyframesOfSession(session.id)) {
      if (!first || keyframe.id < first->id) {
        first = keyframe;
      }
    }
  }
  if (!first) {
    throw Error(ErrorCode::kBadInput,
                "the map is empty, so it has no frame of its own; give --origin LAT,LON,H");
  }
  const Geodetic position = GeodeticFromEcef(first->cam_from_ecef.Inverse().translation);
  return Geodetic::FromDegrees(Rounded(position.lat_deg(), 1e6), Rounded(position.lon_deg(), 1e6),
                               Rounded(position.h_m, 1.0));
}

WorldFrame ModelFrame(const std::string& model_dir, const MapSnapshot& map) {
  Reconstruction reconstruction;
  for (const ColmapImage& image : ReadColmapModel(FindColmapModel(model_dir)).images) {
    ReconImage& posed = reconstruction.images.emplace_back();
    posed.name = image.name;
    posed.cam_from_world = image.cam_from_world;
  }
  std::vector<KeyframeRecord> keyframes;
  for (const SessionRecord& session : map.Sessions()) {
    const std::vector<KeyframeRecord> of_session = map.KeyframesOfSession(session.id);
    keyframes.insert(keyframes.end(), of_session.begin(), of_session.end());
  }
  const auto alignment = AlignToKeyframes(reconstruction, keyframes);
  if (!alignment) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: the map holds fewer than three images of this model, so the place "
                            "of its frame is unknown",
                            Printable(model_dir)));
  }
  // Beyond it, the images merely have the same names; as in `cairn eval`.
  constexpr double kMaxResidualM = 0.5;
  if (alignment->median_residual_m > kMaxResidualM) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: the {} images that map and model share by name are {:.2f} m apart",
                            Printable(model_dir), alignment->num_shared_images,
                            alignment->median_residual_m));
  }
  return {.name = "model", .origin = {}, .ecef_from_world = alignment->ecef_from_world};
}

}  // namespace cairn
