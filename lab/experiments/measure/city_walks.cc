#include "lab/experiments/measure/city_walks.h"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <random>
#include <utility>

#include "core/geodesy.h"
#include "core/parallel_for.h"
#include "engine/localizer.h"
#include "eval/recordings/simulate_recording.h"
#include "lab/city/hashed_random.h"
#include "lab/city/phone_sequence.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

constexpr uint64_t kWalkStream = 0x701;
constexpr size_t kWalkCacheBytes = size_t{1} << 30;

PhoneSequenceOptions SequenceOptions(const CityWalksOptions& options, const CityWorldOptions& world,
                                     int walk) {
  PhoneSequenceOptions sequence;
  sequence.duration_s = options.duration_s;
  sequence.time_years = world.queries.time_years;
  sequence.height_m = world.queries.height_m;
  sequence.seed = HashOf(options.seed, kWalkStream, walk);
  return sequence;
}

bool IsQueried(const CityWalksOptions& options, size_t frame) {
  return frame > 0 && frame % static_cast<size_t>(options.frames_per_query) == 0;
}

// Returns the places of the queried frames, in order.
std::vector<PhonePlace> PlacesOf(const PhoneSequence& walk, const City& city,
                                 const CityWalksOptions& options) {
  const Rigid3d local_from_site = walk.ecef_from_local.Inverse() * city.ecef_from_site();
  std::vector<PhonePlace> places;
  for (size_t i = 0; i < walk.frames.size(); ++i) {
    if (IsQueried(options, i)) {
      places.push_back(
          PlaceBeside(city, walk.street, walk.frames[i].cam_from_local * local_from_site));
    }
  }
  return places;
}

std::vector<LocalizeResult> LocalizeWalk(const std::string& map_path,
                                         const std::vector<EvalQuery>& queries, int num_threads) {
  const Localizer localizer = Localizer::Open(map_path, {}, kWalkCacheBytes);
  std::vector<LocalizeResult> results(queries.size());
  ParallelFor(static_cast<int>(queries.size()), num_threads, [&](int i) {
    const auto at = static_cast<size_t>(i);
    results[at] = localizer.Localize(queries[at].query);
  });
  return results;
}

fusion::Answer AnswerOf(const LocalizeResult& result, const Rigid3d& global_from_ecef) {
  fusion::Answer answer;
  answer.localized = result.localized;
  if (!result.localized) {
    return answer;
  }
  answer.global_from_cam = global_from_ecef * result.cam_from_ecef.Inverse();
  const Rigid3d global_from_anchor = global_from_ecef * EcefFromEnu(result.anchor);
  for (const LocalizeMatch& match : result.matches) {
    answer.matches.push_back(
        {.pixel = match.pixel,
         .track_id = std::nullopt,
         .x_in_global = global_from_anchor * match.x_in_anchor,
         .sigma_m = match.sigma_m,
         .landmark_id = static_cast<uint64_t>(match.landmark_id),
         .tile_id = result.tiles[static_cast<size_t>(match.tile_idx)].value()});
  }
  return answer;
}

fusion::StartState DrawStartOf(const PhoneSequence& walk, uint64_t seed) {
  std::mt19937_64 random(seed);
  return fusion::DrawStart(walk.truth.front(), {}, &random);
}

fusion::FusionOptions OptionsFor(const PhoneSequence& walk, const PhoneSequenceOptions& options) {
  fusion::FusionOptions fused;
  fused.camera = walk.camera;
  fused.rig = {walk.cam_from_imu, 0.0};
  fused.imu_noise = options.imu_noise;
  fused.gravity_m_s2 = kGravityMS2;
  fused.tracks.sigma_px = options.pixel_sigma;
  return fused;
}

// Returns a recording without answers.
fusion::Recording RecordingOf(const PhoneSequence& walk, const PhoneSequenceOptions& sequence,
                              const CityWalksOptions& options) {
  fusion::Recording recording;
  recording.options = OptionsFor(walk, sequence);
  recording.imu = walk.imu;
  for (const SequenceFrame& frame : walk.frames) {
    fusion::RecordedFrame& recorded = recording.frames.emplace_back();
    recorded.timestamp_ns = frame.timestamp_ns;
    recorded.global_from_imu = frame.cam_from_local.Inverse() * walk.cam_from_imu;
    recorded.features = frame.features;
  }
  recording.frames_per_query = options.frames_per_query;
  recording.first_counted_frame =
      static_cast<size_t>(options.first_counted_s * sequence.frame_rate_hz);
  recording.start = DrawStartOf(walk, sequence.seed);
  return recording;
}

}  // namespace

std::vector<fusion::Recording> RecordCityWalks(
    const CityWalksOptions& options, const std::string& map_path,
    const std::function<void(int done, int total)>& progress) {
  CityWorldOptions world = CityWorldPreset(options.character, options.size);
  world.city.seed = world.mapping.seed = world.queries.seed = world.descriptors.seed = options.seed;
  world.num_threads = options.num_threads;
  const City city(world.city);
  std::vector<fusion::Recording> recordings;
  std::vector<Rigid3d> ecef_from_global;
  std::vector<PhonePlace> places;
  for (int i = 0; i < options.num_walks; ++i) {
    const PhoneSequenceOptions sequence = SequenceOptions(options, world, i);
    const PhoneSequence walk = SimulatePhoneSequence(city, sequence);
    recordings.push_back(RecordingOf(walk, sequence, options));
    recordings.back().name = fmt::format("{}, walk {}", CityCharacterName(options.character), i);
    ecef_from_global.push_back(walk.ecef_from_local);
    const std::vector<PhonePlace> its_places = PlacesOf(walk, city, options);
    places.insert(places.end(), its_places.begin(), its_places.end());
  }
  const std::vector<EvalQuery> queries = BuildCityWorld(world, places, map_path, progress);
  const std::vector<LocalizeResult> results = LocalizeWalk(map_path, queries, options.num_threads);
  size_t next = 0;
  for (size_t walk = 0; walk < recordings.size(); ++walk) {
    std::vector<fusion::RecordedFrame>& frames = recordings[walk].frames;
    for (size_t i = 0; i < frames.size(); ++i) {
      if (IsQueried(options, i)) {
        frames[i].answer = AnswerOf(results[next++], ecef_from_global[walk].Inverse());
      }
    }
  }
  return recordings;
}

}  // namespace cairn
