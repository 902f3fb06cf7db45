#include "ingest/fit_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "core/check.h"
#include "core/error.h"
#include "core/printable.h"
#include "ingest/place/known_tiles.h"
#include "ingest/session_placement.h"
#include "ingest/session_refused.h"
#include "ingest/tiles/placed_session.h"

namespace cairn {
namespace {

using Parts = std::map<int, SessionPart>;

Parts PartsOf(const std::vector<int>& part_of_image, const std::set<int>& placed_by_map) {
  Parts parts;
  for (size_t i = 0; i < part_of_image.size(); ++i) {
    SessionPart& part = parts[part_of_image[i]];
    part.images.push_back(static_cast<int>(i));
    part.needs_map = placed_by_map.contains(part_of_image[i]);
  }
  return parts;
}

void Compare(const Reconstruction& part, const Sim3d& ecef_from_world, const KnownTiles& known,
             const std::vector<SessionRecord>& others, IngestOptions options, SessionPart* result) {
  options.agreement.unanchored = Unanchored::kRefuseAlways;
  const double accuracy_m = options.agreement.position_accuracy_m;
  try {
    result->comparison =
        CompareWithMap(part, PlaceSession(part, ecef_from_world, PlacementOf(options)), known,
                       {.position_accuracy_m = accuracy_m, .num_threads = options.num_threads});
    RequireAgreement(
        result->comparison, options.agreement,
        AccuracyOf(result->comparison, accuracy_m, options.georef_median_residual_m, others),
        fmt::format("a part of {} photos", result->images.size()));
    result->is_anchored = true;
    result->moved_m = result->comparison.fit.moved_m;
  } catch (const SessionRefused& refusal) {
    result->problem = refusal.what();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kBadInput) {
      throw;
    }
    result->problem = error.what();  // None of its landmarks is good enough.
  }
}

// Whether the anchored parts decide who stays. Those that only the map placed decide if they have
// more images than the parts that their positions place: a few photos of a corner shall not keep a
// walk over new ground out.
bool AnchoredDecide(const Parts& parts) {
  size_t num_placed = 0, num_anchored_by_map = 0;
  for (const auto& [number, part] : parts) {
    if (!part.needs_map && part.problem.empty()) {
      return true;
    }
    size_t& count = part.needs_map ? num_anchored_by_map : num_placed;
    count += !part.needs_map || part.problem.empty() ? part.images.size() : 0;
  }
  return num_anchored_by_map > num_placed;
}

// Otherwise the ingest decides: on the placed part with the most images if the map was asked about
// any of them.
void KeepSome(Parts* parts) {
  const auto placed = [](const auto& part) { return !part.second.needs_map; };
  const bool were_asked = std::ranges::any_of(*parts, [&](const auto& part) {
    return placed(part) && part.second.comparison.num_asked() > 0;
  });
  const auto largest = std::ranges::max_element(
      *parts, {}, [&](const auto& part) { return placed(part) ? part.second.images.size() : 0; });
  for (auto part = parts->begin(); part != parts->end(); ++part) {
    std::string& problem = part->second.problem;
    if (placed(*part) && (!were_asked || part == largest)) {
      problem.clear();
    } else if (problem.empty()) {
      problem = "the map sees it, but not the parts that stand by their positions";
    }
  }
}

// Moves the images and landmarks of the parts that are not refused to where the map sees them.
void MoveParts(const Parts& parts, const std::vector<int>& part_of_image,
               const Sim3d& ecef_from_world, Reconstruction* reconstruction) {
  std::map<int, Sim3d> world_from_part;
  for (const auto& [number, part] : parts) {
    world_from_part[number] =
        part.problem.empty()
            ? ecef_from_world.Inverse() * part.comparison.fit.map_from_session * ecef_from_world
            : Sim3d();
  }
  for (size_t i = 0; i < reconstruction->images.size(); ++i) {
    Rigid3d& cam_from_world = reconstruction->images[i].cam_from_world;
    cam_from_world = CamFromTarget(cam_from_world, world_from_part.at(part_of_image[i]));
  }
  for (ReconLandmark& landmark : reconstruction->landmarks) {
    if (!landmark.observations.empty()) {
      const int part = part_of_image[landmark.observations.front().image_idx];
      landmark.x_in_world = world_from_part.at(part) * landmark.x_in_world;
    }
  }
}

}  // namespace

std::map<int, SessionPart> FitParts(const MapSnapshot& map, const std::vector<int>& part_of_image,
                                    const std::set<int>& placed_by_map,
                                    const Sim3d& ecef_from_world, const IngestOptions& options,
                                    Reconstruction* reconstruction) {
  CAIRN_CHECK(part_of_image.size() == reconstruction->images.size(), "each image needs a part");
  const std::optional<SessionRecord> same = map.FindSession(options.session_name);
  const SessionId replaced = same ? same->id : SessionId{};
  std::vector<SessionRecord> others = map.Sessions();
  std::erase_if(others, [&](const SessionRecord& session) { return session.id == replaced; });
  const KnownTiles known(map, replaced);

  Parts parts = PartsOf(part_of_image, placed_by_map);
  for (auto& [number, part] : parts) {
    Compare(SelectImages(*reconstruction, part.images), ecef_from_world, known, others, options,
            &part);
  }
  if (AnchoredDecide(parts)) {
    MoveParts(parts, part_of_image, ecef_from_world, reconstruction);
  } else {
    KeepSome(&parts);
  }
  std::vector<int> kept;
  for (size_t i = 0; i < part_of_image.size(); ++i) {
    if (parts[part_of_image[i]].problem.empty()) {
      kept.push_back(static_cast<int>(i));
    }
  }
  if (kept.size() < part_of_image.size()) {
    *reconstruction = SelectImages(*reconstruction, kept);
  }
  return parts;
}

}  // namespace cairn
