#include "lab/city/city_sessions.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <utility>

#include "core/parallel_for.h"
#include "lab/city/city_region.h"
#include "lab/city/hashed_random.h"
#include "lab/city/phone_queries.h"

namespace cairn {
namespace {

constexpr uint64_t kGeoregistrationStream = 0x501;

// "2016-06-01T00:00:00Z" plus the time, to the day.
std::string UtcTime(double time_years) {
  using namespace std::chrono;
  const sys_days first = year(2016) / June / 1;
  const year_month_day date(first + days(std::lround(365.2425 * time_years)));
  return fmt::format("{:04}-{:02}-{:02}T00:00:00Z", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()));
}

// Appends a chunk whose images and landmarks share nothing with the session's.
void Append(MappedChunk chunk, CitySession* session) {
  const auto first_image = static_cast<int>(session->reconstruction.images.size());
  for (ReconImage& image : chunk.reconstruction.images) {
    session->reconstruction.images.push_back(std::move(image));
  }
  for (ReconLandmark& landmark : chunk.reconstruction.landmarks) {
    for (ReconObservation& observation : landmark.observations) {
      observation.image_idx += first_image;
    }
    session->reconstruction.landmarks.push_back(std::move(landmark));
  }
  session->city_landmarks.insert(session->city_landmarks.end(), chunk.city_landmarks.begin(),
                                 chunk.city_landmarks.end());
  session->things.insert(session->things.end(), chunk.things.begin(), chunk.things.end());
  session->views.insert(session->views.end(), chunk.views.begin(), chunk.views.end());
}

}  // namespace

CitySessions::CitySessions(const CityWorldOptions& options, double georegistration_sigma_m)
    : options_(options),
      georegistration_sigma_m_(georegistration_sigma_m),
      city_(options.city),
      model_(options.descriptors),
      mapping_(city_, model_, options.mapping),
      tiles_(mapping_.Tiles()) {}

CitySession CitySessions::Record(int session_idx) const {
  CitySession session;
  session.time_years = options_.mapping.TimeYears(session_idx);
  session.recorded_at = UtcTime(session.time_years);
  session.reconstruction.cameras = {options_.mapping.rig.MakeCamera()};
  for (const TileId tile_id : tiles_) {
    Append(mapping_.MapTileInPass(tile_id, session_idx, options_.num_threads), &session);
  }
  HashedRandom random(HashOf(options_.mapping.seed, kGeoregistrationStream, session_idx));
  const Eigen::Vector3d shift_in_site(georegistration_sigma_m_ * random.Normal(),
                                      georegistration_sigma_m_ * random.Normal(), 0.0);
  session.ecef_from_world = mapping_.EcefFromWorld();
  session.ecef_from_world.translation += session.ecef_from_world.rotation * shift_in_site;
  return session;
}

std::unordered_set<uint64_t> CitySessions::Lasting(double from_years, double to_years) const {
  const CityBox box = BoxAroundPoint(
      {0.0, 0.0}, 0.5 * options_.city.SideM() + options_.queries.detector.max_range_m);
  const auto ids_at = [&](double time_years) {
    std::unordered_set<uint64_t> ids;
    const CityRegion region(city_, box, time_years);
    for (const RegionSurface& surface : region.surfaces()) {
      for (const CityLandmark& landmark : surface.landmarks) {
        ids.insert(landmark.id);
      }
    }
    return ids;
  };
  const std::unordered_set<uint64_t> at_the_end = ids_at(to_years);
  std::unordered_set<uint64_t> lasting = ids_at(from_years);
  std::erase_if(lasting, [&](uint64_t id) { return !at_the_end.contains(id); });
  return lasting;
}

std::vector<EvalQuery> CitySessions::Ask(double time_years,
                                         const std::unordered_set<uint64_t>& mapped,
                                         uint64_t seed) const {
  PhoneQueryOptions options = options_.queries;
  options.time_years = time_years;
  options.seed = seed;
  const PhoneQueries queries(city_, model_, options);
  std::vector<EvalQuery> made(static_cast<size_t>(queries.size()));
  ParallelFor(queries.size(), options_.num_threads,
              [&](int i) { made[static_cast<size_t>(i)] = queries.Make(i, mapped); });
  return made;
}

}  // namespace cairn
