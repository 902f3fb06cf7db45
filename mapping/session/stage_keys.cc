#include "mapping/session/stage_keys.h"

#include <fmt/format.h>

#include "storage/tile/content_digest.h"

namespace cairn {
namespace {

// The work folder keeps each key with its file, so a long text becomes its digest.
std::string DigestOf(const std::string& text) {
  return ContentDigest({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

}  // namespace

std::string ViewsKeyOf(const PhotoFolder& folder, const PhotoPlaces& places,
                       const MappingOptions& options) {
  std::string key = fmt::format("mapping 13 {}", folder.digest);
  const PairOptions& p = options.pairs;
  key += fmt::format(" pairs {} {} {} {} {} {} {}", p.max_partners, p.max_exhaustive, p.max_voters,
                     p.max_panel, p.neighbors_per_voter, p.max_distance_m, p.default_accuracy_m);
  const TwoViewOptions& t = options.two_views;
  key += fmt::format(" views {} {} {} {} {}", t.descriptors.max_ratio, t.descriptors.max_distance,
                     t.min_inliers, t.max_iterations, t.seed);
  for (size_t i = 0; i < places.positions.size(); ++i) {
    const auto& position = places.positions[i];
    key += position ? fmt::format(" {} {} {} {} {} {}", position->position.lat_rad,
                                  position->position.lon_rad, position->position.h_m,
                                  position->accuracy_m, position->has_height,
                                  folder.set.photos[i].gps_accuracy_m.value_or(0.0))
                    : " -";
  }
  return DigestOf(key);
}

std::string SegmentsKeyOf(const std::string& views_key, const GrowthOptions& g) {
  return DigestOf(fmt::format("{} growth 9 {} {} {} {} {} {} {} {} {}", views_key, g.min_inliers,
                              g.min_link_share, g.min_witnesses, g.max_rotation_error_rad,
                              g.max_direction_error_rad, g.default_gps_accuracy_m,
                              g.adjust_after_growth, g.min_photos, g.seed));
}

std::string PlacementKeyOf(const std::string& segments_key, const AdjustOptions& a,
                           const GeoregisterOptions& r) {
  return DigestOf(fmt::format(
      "{} placement 1 {} {} {} {} {} {} {} {} {} {} {} {} {} {} {}", segments_key,
      a.loss_scale_sigmas, a.position_loss_scale_sigmas, a.distortion_sigma,
      a.principal_point_loss_scale, a.max_iterations, a.min_relative_change, a.max_error_sigmas,
      a.max_rounds, a.max_observations_of_all, a.min_ray_angle_rad, static_cast<int>(r.up),
      r.least_up_odds, r.upright_sigma_rad, r.max_median_residual_sigmas, r.max_median_residual_m));
}

}  // namespace cairn
