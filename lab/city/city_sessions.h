// A simulated city that is mapped again and again: every pass is a session of its own.
#ifndef CAIRN_LAB_CITY_CITY_SESSIONS_H_
#define CAIRN_LAB_CITY_CITY_SESSIONS_H_

#include <cstdint>
#include <string>
#include <unordered_set>
#include <vector>

#include "core/rigid3.h"
#include "core/scene/reconstruction.h"
#include "eval/eval_query.h"
#include "lab/city/city.h"
#include "lab/city/city_world.h"
#include "lab/city/simulated_mapping.h"
#include "lab/descriptors/descriptor_model.h"

namespace cairn {

// The recording of one pass.
struct CitySession {
  Reconstruction reconstruction;
  // Parallel to reconstruction.landmarks, see MappedChunk.
  std::vector<uint64_t> city_landmarks, things, views;
  Sim3d ecef_from_world;    // With the error of the session's georegistration.
  std::string recorded_at;  // UTC; the first pass is in June 2016.
  double time_years = 0.0;  // After the first pass.
};

// The passes of options.mapping as sessions. Immutable; safe to use from any thread.
class CitySessions {
 public:
  // `georegistration_sigma_m` is the standard deviation, per horizontal axis, of a session's shift.
  CitySessions(const CityWorldOptions& options, double georegistration_sigma_m);

  int size() const { return options_.mapping.num_passes; }
  double TimeYears(int session) const { return options_.mapping.TimeYears(session); }

  // A pure function of the options and the number of the session.
  CitySession Record(int session) const;

  // Ids of the landmarks that exist at both times, in all that queries can see.
  std::unordered_set<uint64_t> Lasting(double from_years, double to_years) const;

  // Queries at a time; `mapped` holds the city landmarks that the maps under test should know. The
  // places depend on `seed` only.
  std::vector<EvalQuery> Ask(double time_years, const std::unordered_set<uint64_t>& mapped,
                             uint64_t seed) const;

 private:
  CityWorldOptions options_;
  double georegistration_sigma_m_;
  City city_;
  DescriptorModel model_;
  SimulatedMapping mapping_;
  std::vector<TileId> tiles_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_CITY_SESSIONS_H_
