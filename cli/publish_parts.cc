#include "cli/publish_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/geodesy.h"
#include "core/scene/reconstruction.h"
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
  AddSegment(segment.segment, *placement.ecef_from_world, segment.number, &result->mapped,
             &result->session.reconstruction);
}

// Returns the numbers of the segments that the map places.
std::set<int> PlaceUnplaced(const MapSnapshot& map, MapSessionResult* result) {
  std::set<int> placed;
  if (result->mapped.unplaced.empty()) {
    return placed;
  }
  const std::optional<SessionRecord> replaced =
      map.FindSession(result->session.options.session_name);
  const KnownTiles known(map, replaced ? replaced->id : SessionId{});
  for (const UnplacedSegment& segment : result->mapped.unplaced) {
    const PlacementByMap placement = PlaceByMap(segment.segment.model, segment.positions, known,
                                                result->session.options.num_threads);
    if (placement.ecef_from_world) {
      placed.insert(segment.number);
      AddPlaced(segment, placement, result);
      continue;
    }
    result->mapped.segments[static_cast<size_t>(segment.number)].problem = fmt::format(
        "{}. The map does not place it, either: it recognizes {} of {} photos, and {} agree",
        segment.problem, placement.num_recognized, placement.num_asked, placement.num_agreeing);
  }
  return placed;
}

bool IsLeftOut(const MapSessionResult& result, int number) {
  return !result.mapped.segments[static_cast<size_t>(number)].problem.empty();
}

// Reports the cameras of the segments that the map placed, and why it had to.
void ReportPlacedByMap(const std::set<int>& placed_by_map, MapSessionResult* result) {
  MappedPhotos& mapped = result->mapped;
  for (const UnplacedSegment& segment : mapped.unplaced) {
    if (!placed_by_map.contains(segment.number) || IsLeftOut(*result, segment.number)) {
      continue;
    }
    mapped.cameras.insert(mapped.cameras.end(), segment.cameras.begin(), segment.cameras.end());
    const size_t num_photos = segment.segment.model.images.size();
    mapped.notes.push_back(
        segment.has_place
            ? fmt::format("the whole map anchors {} photos that it did not before", num_photos)
            : fmt::format("the map places {} photos whose positions do not: {}", num_photos,
                          segment.problem));
  }
}

// Moves the segments of the model to where the map sees them; those that FitParts refuses leave it.
// `placed_by_map` is of PlaceUnplaced.
void FitAll(const MapSnapshot& map, const std::set<int>& placed_by_map, MapSessionResult* result) {
  PlacedReconstruction& session = result->session;
  std::vector<std::string> names;
  for (const ReconImage& image : session.reconstruction.images) {
    names.push_back(image.name);
  }
  const Parts parts =
      FitParts(map, result->mapped.segment_of_image, placed_by_map,
               session.georegistration.ecef_from_world, session.options, &session.reconstruction);
  ReportSegments(parts, &result->mapped.segments);
  ReportPhotos(parts, names, session.reconstruction.images, &result->mapped);
  ReportPlacedByMap(placed_by_map, result);
}

// A segment of the model by itself.
UnplacedSegment SegmentOfModel(const MapSessionResult& result, int number) {
  const Reconstruction& model = result.session.reconstruction;
  UnplacedSegment segment;
  segment.number = number;
  segment.has_place = true;
  std::vector<int> images;
  for (size_t i = 0; i < model.images.size(); ++i) {
    if (result.mapped.segment_of_image[i] == number) {
      images.push_back(static_cast<int>(i));
      segment.segment.photo_of_image.push_back(result.mapped.photo_of_image[i]);
      segment.positions.push_back(
          GeodeticFromEcef(result.session.georegistration.ecef_from_world *
                           model.images[i].cam_from_world.Inverse().translation));
    }
  }
  segment.segment.model = SelectImages(model, images);
  return segment;
}

// The segments of `before` that `fitted` leaves out.
std::vector<UnplacedSegment> LeftOutOf(const MapSessionResult& before,
                                       const MapSessionResult& fitted) {
  std::vector<UnplacedSegment> left_out;
  for (const UnplacedSegment& segment : before.mapped.unplaced) {
    if (IsLeftOut(fitted, segment.number)) {
      left_out.push_back(segment);
    }
  }
  const std::vector<int>& of_image = before.mapped.segment_of_image;
  for (const int number : std::set<int>(of_image.begin(), of_image.end())) {
    if (IsLeftOut(fitted, number)) {
      left_out.push_back(SegmentOfModel(before, number));
      left_out.back().problem = fitted.mapped.segments[static_cast<size_t>(number)].problem;
    }
  }
  return left_out;
}

// The session with none of its segments.
MapSessionResult WithoutModel(const MapSessionResult& result) {
  MapSessionResult empty = result;
  empty.session.reconstruction = {};
  empty.session.reconstruction.descriptor_type = result.session.reconstruction.descriptor_type;
  empty.mapped.segment_of_image.clear();
  empty.mapped.photo_of_image.clear();
  return empty;
}

// Whether the map anchors any segment that was published.
bool IsAnchored(const MapSnapshot& map, const MapSessionResult& published) {
  Reconstruction model = published.session.reconstruction;
  const Parts parts = FitParts(map, published.mapped.segment_of_image, {},
                               published.session.georegistration.ecef_from_world,
                               published.session.options, &model);
  return std::ranges::any_of(parts, [](const auto& part) { return part.second.is_anchored; });
}

// Adds to what the reports of these segments say.
void AddToProblems(const std::set<int>& numbers, const std::string& why, MappedPhotos* mapped) {
  for (const int number : numbers) {
    std::string& problem = mapped->segments[static_cast<size_t>(number)].problem;
    problem += problem.empty() ? why : ". " + why;
  }
}

// Puts the model of `published` before that of `added`, which becomes the whole session.
void PutBefore(const MapSessionResult& published, MapSessionResult* added) {
  Reconstruction model = published.session.reconstruction;
  AppendModel(std::move(added->session.reconstruction), &model);
  added->session.reconstruction = std::move(model);
  MappedPhotos& mapped = added->mapped;
  const auto put_before = [](const std::vector<int>& first, std::vector<int>* all) {
    all->insert(all->begin(), first.begin(), first.end());
  };
  put_before(published.mapped.segment_of_image, &mapped.segment_of_image);
  put_before(published.mapped.photo_of_image, &mapped.photo_of_image);
  mapped.num_mapped = static_cast<int>(mapped.photo_of_image.size());
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
  const std::set<int> placed_by_map = PlaceUnplaced(map, &fitted);
  if (!placed_by_map.empty() || !IsOnePart(fitted.mapped.segment_of_image)) {
    FitAll(map, placed_by_map, &fitted);
  }
  fitted.mapped.unplaced = LeftOutOf(*result, fitted);
  IngestReport report = PublishAsPlaced(publish, fitted);
  *result = std::move(fitted);
  return report;
}

void PublishLeftOut(const MapSnapshot& map, const PublishPlaced& publish,
                    MapSessionResult* result) {
  if (result->mapped.unplaced.empty()) {
    return;
  }
  MapSessionResult added = WithoutModel(*result);
  const std::set<int> placed_by_map = PlaceUnplaced(map, &added);
  if (!placed_by_map.empty()) {
    FitAll(map, placed_by_map, &added);
  }
  if (added.session.reconstruction.images.empty()) {
    result->mapped.segments = added.mapped.segments;  // With what the map says of them.
    return;
  }
  const std::set<int> found(added.mapped.segment_of_image.begin(),
                            added.mapped.segment_of_image.end());
  if (!IsAnchored(map, *result)) {
    AddToProblems(found, "The whole map sees it, but no part that is published", &result->mapped);
    return;
  }
  PutBefore(*result, &added);
  std::erase_if(added.mapped.unplaced,
                [&](const UnplacedSegment& segment) { return !IsLeftOut(added, segment.number); });
  try {
    added.report = publish(added.session);
  } catch (const SessionRefused& refusal) {
    AddToProblems(found, fmt::format("With it, the session is refused: {}", refusal.what()),
                  &result->mapped);
    return;
  }
  added.report.replaced_session = result->report.replaced_session;
  *result = std::move(added);
}

}  // namespace cairn
