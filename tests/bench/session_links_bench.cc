// Measures the links between sessions of the simulated city that drift, stand beside the map, and
// see it in another light.
//
//   cairn_session_links [first seed] [num seeds] [appearance factor] [num sessions] [fitting]
//
// Each session but the first is misplaced as phones misplace one: shifted by 3 m to the east, half
// of that to the south, raised by 2 m, and turned by a degree about its middle. Passes drift by 0.3
// m over about 100 m. The appearance factor multiplies the change of descriptors between kinds of
// light and season. `fitting` is "bend" as in `cairn ingest` or "adjust" as in `cairn map`. Prints,
// for each seed, how many sessions the map takes, the share of their possible links that are found,
// and the share of links that are false (LinkJudge).
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "core/angles.h"
#include "core/geodesy.h"
#include "ingest/ingest_session.h"
#include "ingest/session_refused.h"
#include "lab/city/city_sessions.h"
#include "lab/experiments/measure/link_judge.h"
#include "storage/tile/tile_codec.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

struct Trial {
  uint64_t seed = 71;
  double appearance_factor = 1.0;
  int num_sessions = 3;
  SessionFitting fitting = SessionFitting::kBend;
};

CityWorldOptions WorldOf(const Trial& trial) {
  CityWorldOptions options = CityWorldPreset(CityCharacter::kGrid, CityWorldSize::kQuick);
  options.city.area_km2 = 0.01;
  options.city.seed = options.mapping.seed = options.descriptors.seed = trial.seed;
  options.mapping.num_passes = trial.num_sessions;
  options.mapping.years = 0.5 * trial.num_sessions;
  options.mapping.rig.image_width_px = options.mapping.rig.image_height_px = 560;
  options.mapping.detector.max_keypoints = 350;
  options.mapping.keyframe_spacing_m = 4.0;
  options.mapping.noise.pass_drift_m = 0.3;
  options.descriptors.mode_length *= trial.appearance_factor;
  return options;
}

// The place of a session after the errors of its positions.
Sim3d Misplaced(const Sim3d& ecef_from_world, int session_idx) {
  const Rigid3d ecef_from_enu = EcefFromEnu(GeodeticFromEcef(ecef_from_world.translation));
  const double sign = session_idx % 2 == 0 ? 1.0 : -1.0;
  const Rigid3d error(
      Eigen::Quaterniond(Eigen::AngleAxisd(sign * 1.0 / kDegPerRad, Eigen::Vector3d::UnitZ())),
      sign * Eigen::Vector3d(3.0, -1.5, 2.0));
  return ecef_from_enu * (error * (ecef_from_enu.Inverse() * ecef_from_world));
}

std::unordered_set<uint64_t> LandmarksOf(const MapStore& map) {
  const MapSnapshot snapshot = map.Snapshot();
  std::unordered_set<uint64_t> ids;
  for (const TileRecord& record : snapshot.AllTiles(1000)) {
    for (const LandmarkId id : DecodeTile(snapshot.LoadPayload(record.payload_id)).landmark_ids) {
      ids.insert(Value(id));
    }
  }
  return ids;
}

// Returns whether the map takes the session: as `cairn map`, it refuses one that it does not
// anchor.
bool Join(const CitySession& session, int session_idx, SessionFitting fitting, MapStore* map,
          LinkJudge* judge) {
  IngestOptions options;
  options.session_name = "session " + std::to_string(session_idx);
  options.source = "simulated city";
  options.recorded_at = session.recorded_at;
  options.fitting = fitting;
  options.agreement.position_accuracy_m = 4.5;
  options.agreement.unanchored = Unanchored::kRefuse;
  options.gate.max_lost_share = 1.0;
  options.num_threads = 2;
  const Sim3d& ecef_from_world = session.ecef_from_world;
  try {
    const IngestReport report =
        IngestSession(session.reconstruction,
                      session_idx == 0 ? ecef_from_world : Misplaced(ecef_from_world, session_idx),
                      options, map, {});
    judge->Add(session, report, LandmarksOf(*map));
    return true;
  } catch (const SessionRefused&) {
    return false;
  }
}

// A session that the map refuses is tried again when the others are in the map.
void Run(const Trial& trial) {
  const CitySessions sessions(WorldOf(trial), /*georegistration_sigma_m=*/0.3);
  const testing::TempDir dir;
  MapStore map = MapStore::Create(dir.File("map.gpkg"));
  LinkJudge judge;
  std::vector<int> waiting;
  for (int i = 0; i < sessions.size(); ++i) {
    if (!Join(sessions.Record(i), i, trial.fitting, &map, &judge)) {
      waiting.push_back(i);
    }
  }
  std::erase_if(waiting,
                [&](int i) { return Join(sessions.Record(i), i, trial.fitting, &map, &judge); });
  std::printf("%4d  %10.1f  %7d of %d  %5.1f %%  %5.2f %%\n", static_cast<int>(trial.seed),
              trial.appearance_factor, sessions.size() - static_cast<int>(waiting.size()),
              sessions.size(), 100.0 * judge.FoundShare(), 100.0 * judge.FalseShare());
  std::fflush(stdout);
}

}  // namespace
}  // namespace cairn

int main(int argc, char** argv) {
  cairn::Trial trial;
  trial.seed = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : trial.seed;
  const int num_seeds = argc > 2 ? std::atoi(argv[2]) : 2;
  trial.appearance_factor = argc > 3 ? std::atof(argv[3]) : 1.0;
  trial.num_sessions = argc > 4 ? std::atoi(argv[4]) : trial.num_sessions;
  if (argc > 5 && std::string_view(argv[5]) == "adjust") {
    trial.fitting = cairn::SessionFitting::kAdjust;
  }
  std::printf("seed  appearance     joined   found    false\n");
  for (int i = 0; i < num_seeds; ++i, ++trial.seed) {
    Run(trial);
  }
  return 0;
}
