#include "engine/tiles/search_region.h"

#include <algorithm>
#include <cmath>

#include "core/radius68.h"
#include "core/require.h"
#include "core/tile_id.h"

namespace cairn {
namespace {

// Lower bound on the reported accuracy, meters.
constexpr double kMinAccuracyM = 3.0;

}  // namespace

void PriorOptions::Validate() const {
  RequireOption(search_sigmas > 0.0, "prior.search_sigmas must be positive");
  RequireOption(min_radius_m > 0.0 && max_radius_m >= min_radius_m,
                "prior: need 0 < min_radius_m <= max_radius_m");
}

SearchRegion RegionOfPrior(const PositionPrior& prior, const PriorOptions& options) {
  SearchRegion region;
  region.origin = {prior.position.lat_rad, prior.position.lon_rad, 0.0};
  region.ecef_from_anchor = EcefFromEnu(region.origin);
  region.has_prior = true;
  region.prior_sigma_m = std::max(prior.accuracy_m, kMinAccuracyM) / kRadius68PerSigma2d;
  region.radius_m = std::clamp(options.search_sigmas * region.prior_sigma_m, options.min_radius_m,
                               options.max_radius_m);
  if (prior.height_sigma_m) {
    const double reach_m = options.search_sigmas * *prior.height_sigma_m;
    region.min_z_m = prior.position.h_m - reach_m;
    region.max_z_m = prior.position.h_m + reach_m;
  }
  return region;
}

SearchRegion RegionOfPlace(const Geodetic& center, double radius_m, int64_t num_tiles) {
  SearchRegion region;
  region.origin = {center.lat_rad, center.lon_rad, 0.0};
  region.ecef_from_anchor = EcefFromEnu(region.origin);
  region.radius_m = radius_m;
  region.area_m2 = static_cast<double>(num_tiles) * TileId::kSideM * TileId::kSideM;
  return region;
}

GeoBox RegionBounds(const SearchRegion& region) {
  const Eigen::Vector3d center_in_anchor(region.prior_xy_in_anchor.x(),
                                         region.prior_xy_in_anchor.y(), 0.0);
  return BoxAround(GeodeticFromEcef(region.ecef_from_anchor * center_in_anchor), region.radius_m);
}

}  // namespace cairn
