#include "cli/publish_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "ingest/fit_parts.h"
#include "ingest/place/known_tiles.h"
#include "ingest/place/place_by_map.h"
#include "ingest/session_refused.h"
#include "mapping/session/add_segment.h"

namespace cairn {
namespace {

using Parts = std::map<int, SessionPart>;

bool IsOnePart(const std::vector<int>& part_of_image) {
  return std::ranges::adjacent_find(part_of_image, std::ranges::not_equal_to{}) ==
         part_of_image.end();
}

void ReportSegments(const Parts& parts, std::vector<SegmentReport>* segments) {
  for (const auto& [number, part] : parts) {
    SegmentReport& segment = (*segments)[static_cast<size_t>(number)];
    segment.problem = part.problem;
    segment.moved_by_map_m = part.moved_m;
  }
}

// `names` are of the images that were mapped, `published` those of the parts that stay.
void ReportPhotos(const Parts& parts, const std::vector<std::string>& names,
                  const std::vector<ReconImage>& published, MappedPhotos* mapped) {
  std::vector<int> segment_of_image, photo_of_image;
  for (size_t i = 0; i < names.size(); ++i) {
    const int number = mapped->segment_of_image[i], photo = mapped->photo_of_image[i];
    const SessionPart& part = parts.at(number);
    if (part.problem.empty()) {
      const Rigid3d& cam_from_world = published[photo_of_image.size()].cam_from_world;
      mapped->center_of_photo[photo] = cam_from_world.Inverse().translation;
      segment_of_image.push_back(number);
      photo_of_image.push_back(photo);
      continue;
    }
    mapped->center_of_photo[photo].reset();
    mapped->left_out.push_back(
        {names[i], fmt::format("is in a part of {} photos that is not connected to the "
                               "others, and the map does not anchor it",
                               part.images.size())});
  }
  mapped->segment_of_image = std::move(segment_of_image);
  mapped->photo_of_image = std::move(photo_of_image);
  mapped->num_mapped = static_cast<int>(published.size());
  std::ranges::sort(mapped->left_out, {}, &LeftOutPhoto::name);
}

// Makes a segment part of the model where the map sees it.
void AddPlaced(const UnplacedSegment& segment, const PlacementByMap& placement,
               MapSessionResult* result) {
  SegmentReport& report = result->mapped.segments[static_cast<size_t>(segment.number)];
  report.problem.clear();
  report.is_placed_by_map = true;
  report.georegistration.num_positions = placement.num_agreeing;
  report.georegistration.num_inliers = placement.num_agreeing;
  report.georegistration.median_residual_m = placement.median_residual_m;
  std::set<std::string> names;
  for (const ReconImage& image : segment.segment.model.images) {
    names.insert(image.name);
  }
  std::erase_if(result->mapped.left_out,
                [&](const LeftOutPhoto& photo) { return names.contains(photo.name); });
  AddSegment(segment.segment, *placement.ecef_from_world, segment.number, segment.cameras,
             &result->mapped, &result->session.reconstruction);
}

// Returns the numbers of the segments that the map places, and why their positions do not.
std::map<int, std::string> PlaceUnplaced(const MapSnapshot& map, MapSessionResult* result) {
  const std::optional<SessionRecord> replaced =
      map.FindSession(result->session.options.session_name);
  const KnownTiles known(map, replaced ? replaced->id : SessionId{});
  std::map<int, std::string> placed;
  for (const UnplacedSegment& segment : result->mapped.unplaced) {
    std::string& problem = result->mapped.segments[static_cast<size_t>(segment.number)].problem;
    const PlacementByMap placement = PlaceByMap(segment.segment.model, segment.positions, known,
                                                result->session.options.num_threads);
    if (placement.ecef_from_world) {
      placed[segment.number] = problem;
      AddPlaced(segment, placement, result);
      continue;
    }
    problem += fmt::format(
        ". The map does not place it, either: it recognizes {} of {} photos, and {} agree",
        placement.num_recognized, placement.num_asked, placement.num_agreeing);
  }
  return placed;
}

// Moves the segments of the model to where the map sees them; those that FitParts refuses leave it.
// `why_by_map` is of PlaceUnplaced.
void FitAll(const MapSnapshot& map, const std::map<int, std::string>& why_by_map,
            MapSessionResult* result) {
  PlacedReconstruction& session = result->session;
  std::set<int> placed_by_map;
  for (const auto& [number, why] : why_by_map) {
    placed_by_map.insert(number);
  }
  std::vector<std::string> names;
  for (const ReconImage& image : session.reconstruction.images) {
    names.push_back(image.name);
  }
  const Parts parts =
      FitParts(map, result->mapped.segment_of_image, placed_by_map,
               session.georegistration.ecef_from_world, session.options, &session.reconstruction);
  ReportSegments(parts, &result->mapped.segments);
  ReportPhotos(parts, names, session.reconstruction.images, &result->mapped);
  for (const auto& [number, why] : why_by_map) {
    const SegmentReport& segment = result->mapped.segments[static_cast<size_t>(number)];
    if (segment.problem.empty()) {
      result->mapped.notes.push_back(fmt::format(
          "the map places {} photos whose positions do not: {}", segment.num_photos, why));
    }
  }
}

}  // namespace

IngestReport PublishAsPlaced(const PublishPlaced& publish, const MapSessionResult& result) {
  if (result.session.reconstruction.images.empty()) {
    throw SessionRefused(result.mapped.segments.front().problem);
  }
  return publish(result.session);
}

IngestReport PublishParts(const MapSnapshot& map, const PublishPlaced& publish,
                          MapSessionResult* result) {
  if (result->mapped.unplaced.empty() && IsOnePart(result->mapped.segment_of_image)) {
    return PublishAsPlaced(publish, *result);
  }
  MapSessionResult fitted = *result;
  const std::map<int, std::string> why_by_map = PlaceUnplaced(map, &fitted);
  if (!why_by_map.empty() || !IsOnePart(fitted.mapped.segment_of_image)) {
    FitAll(map, why_by_map, &fitted);
  }
  fitted.mapped.unplaced.clear();
  IngestReport report = PublishAsPlaced(publish, fitted);
  *result = std::move(fitted);
  return report;
}

}  // namespace cairn
