#include "cli/publish_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "ingest/fit_parts.h"

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

// `images` are those that were mapped, `published` those of the parts that stay.
void ReportPhotos(const Parts& parts, const std::vector<ReconImage>& images,
                  const std::vector<ReconImage>& published, MappedPhotos* mapped) {
  std::vector<int> segment_of_image, photo_of_image;
  for (size_t i = 0; i < images.size(); ++i) {
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
        {images[i].name, fmt::format("is in a part of {} photos that is not connected to the "
                                     "others, and the map does not anchor it",
                                     part.images.size())});
  }
  mapped->segment_of_image = std::move(segment_of_image);
  mapped->photo_of_image = std::move(photo_of_image);
  mapped->num_mapped = static_cast<int>(published.size());
  std::ranges::sort(mapped->left_out, {}, &LeftOutPhoto::name);
}

}  // namespace

IngestReport PublishParts(const MapSnapshot& map, const PublishPlaced& publish,
                          MapSessionResult* result) {
  PlacedReconstruction& session = result->session;
  if (IsOnePart(result->mapped.segment_of_image)) {
    return publish(session);
  }
  PlacedReconstruction fitted = session;
  const Parts parts =
      FitParts(map, result->mapped.segment_of_image, session.georegistration.ecef_from_world,
               session.options, &fitted.reconstruction);
  IngestReport report = publish(fitted);
  ReportSegments(parts, &result->mapped.segments);
  ReportPhotos(parts, session.reconstruction.images, fitted.reconstruction.images, &result->mapped);
  session = std::move(fitted);
  return report;
}

}  // namespace cairn
