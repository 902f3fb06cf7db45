#include "lab/city/whole_city.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "core/error.h"

namespace cairn {
namespace {

// Memory of a descriptor, a keypoint and a share of a landmark.
constexpr double kBytesPerObservation = 600.0;

void RequireFits(const SimulatedMapping& mapping, double max_bytes) {
  const double bytes = kBytesPerObservation * mapping.ExpectedObservations();
  if (bytes > max_bytes) {
    const double area_km2 = mapping.city().options().area_km2;
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("city.area_km2 = {} needs up to {:.1f} GB of memory as one reconstruction, but "
                    "only {:.1f} GB are allowed; the largest possible value is {:.4g}. A map is "
                    "written tile by tile and has no such limit",
                    area_km2, 1e-9 * bytes, 1e-9 * max_bytes, area_km2 * max_bytes / bytes));
  }
}

}  // namespace

Reconstruction MapWholeCity(const SimulatedMapping& mapping, int num_threads, double max_bytes,
                            const std::function<void(int done, int total)>& progress) {
  RequireFits(mapping, max_bytes);
  const std::vector<TileId> tiles = mapping.Tiles();
  Reconstruction whole;
  whole.cameras = {mapping.options().rig.MakeCamera()};
  for (size_t i = 0; i < tiles.size(); ++i) {
    Reconstruction part = mapping.MapTile(tiles[i], num_threads).reconstruction;
    const auto first_image = static_cast<int>(whole.images.size());
    for (ReconImage& image : part.images) {
      whole.images.push_back(std::move(image));
    }
    for (ReconLandmark& landmark : part.landmarks) {
      for (ReconObservation& observation : landmark.observations) {
        observation.image_idx += first_image;
      }
      whole.landmarks.push_back(std::move(landmark));
    }
    if (progress) {
      progress(static_cast<int>(i) + 1, static_cast<int>(tiles.size()));
    }
  }
  return whole;
}

}  // namespace cairn
