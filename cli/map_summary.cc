#include "cli/map_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/ingest_summary.h"
#include "core/printable.h"

namespace cairn {
namespace {

constexpr size_t kMaxNamesShown = 5;  // Of photos with one reason; JSON has all.
// A reason says at its end what to do.
constexpr size_t kMaxReasonBytes = 400;

const char* SourceName(FocalSource source) {
  switch (source) {
    case FocalSource::kCalibration:
      return "given";
    case FocalSource::kExif:
      return "EXIF";
    case FocalSource::kGuess:
    case FocalSource::kPhotos:
    case FocalSource::kGrowth:
      break;
  }
  return "guess";
}

void PrintLeftOut(const std::vector<LeftOutPhoto>& left_out) {
  std::map<std::string, std::vector<std::string>> names_of_reason;
  for (const LeftOutPhoto& photo : left_out) {
    names_of_reason[photo.reason].push_back(photo.name);
  }
  for (const auto& [reason, names] : names_of_reason) {
    const size_t num_shown = std::min(names.size(), kMaxNamesShown);
    std::string shown;
    for (size_t i = 0; i < num_shown; ++i) {
      shown += (i == 0 ? "" : ", ") + Excerpt(names[i]);
    }
    if (names.size() > num_shown) {
      shown += fmt::format(" and {} others", names.size() - num_shown);
    }
    fmt::print("left out         {}: {}\n", shown, Excerpt(reason, kMaxReasonBytes));
  }
}

// Nothing for a segment that only the map adjusts.
std::string AdjustedText(const SegmentReport& segment) {
  return segment.is_placed_by_map
             ? ""
             : fmt::format("; {} observations of landmarks, {:.2f} px rms",
                           segment.adjustment.num_observations, segment.adjustment.rms_px);
}

void PrintSegments(const MappedPhotos& mapped) {
  for (const SegmentReport& segment : mapped.segments) {
    if (!segment.problem.empty()) {
      fmt::print("not in the map   {} photos: {}\n", segment.num_photos,
                 Excerpt(segment.problem, kMaxReasonBytes));
      continue;
    }
    fmt::print("segment          {} photos{}; placed by {} {}, {:.2f} m median{}\n",
               segment.num_photos, AdjustedText(segment), segment.georegistration.num_positions,
               segment.is_placed_by_map ? "answers of the map" : "positions",
               segment.georegistration.median_residual_m,
               segment.moved_by_map_m > 0.0
                   ? fmt::format("; moved by the map, by {:.2f} m", segment.moved_by_map_m)
                   : "");
  }
}

void PrintCameras(const std::vector<CameraReport>& cameras) {
  constexpr size_t kMaxCameras = 10;
  for (size_t i = 0; i < std::min(cameras.size(), kMaxCameras); ++i) {
    const CameraReport& camera = cameras[i];
    fmt::print("camera           {} x {}, {} photos: focal length {:.1f} px ({}: {:.1f} px)\n",
               camera.camera.width_px(), camera.camera.height_px(), camera.num_photos,
               camera.camera.focal_px(), SourceName(camera.source), camera.focal_before_px);
  }
  if (cameras.size() > kMaxCameras) {
    fmt::print("                 and {} other cameras\n", cameras.size() - kMaxCameras);
  }
}

// True for a session that the map moved, which then has the size of the map.
bool FollowsMap(const MapSessionResult& result) {
  return result.is_in_map && !result.report.is_unchanged && IsJudged(result.report.comparison);
}

const char* ScaleSource(const MapSessionResult& result) {
  if (FollowsMap(result)) {
    return "map";
  }
  return result.mapped.num_mapped > 0 ? "positions" : "unknown";
}

void PrintScale(const MapSessionResult& result) {
  const auto& segments = result.mapped.segments;
  const bool moved_apart = std::ranges::any_of(
      segments, [](const SegmentReport& segment) { return segment.moved_by_map_m > 0.0; });
  if (result.mapped.num_mapped == 0) {
    fmt::print("scale            unknown\n");
  } else if (!FollowsMap(result)) {
    fmt::print("scale            from the positions\n");
  } else if (moved_apart) {
    fmt::print("scale            from the map\n");
  } else {
    fmt::print("scale            from the map, {:.3f} times that of the positions\n",
               result.report.comparison.fit.scale);
  }
}

nlohmann::ordered_json MappedPhotosJson(const MapSessionResult& result) {
  const MappedPhotos& mapped = result.mapped;
  nlohmann::ordered_json json = {{"found", mapped.num_photos},
                                 {"mapped", mapped.num_mapped},
                                 {"scale", ScaleSource(result)},
                                 {"notes", mapped.notes}};
  json["leftOut"] = nlohmann::ordered_json::array();
  for (const LeftOutPhoto& photo : mapped.left_out) {
    json["leftOut"].push_back({{"name", photo.name}, {"reason", photo.reason}});
  }
  json["segments"] = nlohmann::ordered_json::array();
  for (const SegmentReport& segment : mapped.segments) {
    nlohmann::ordered_json entry = {{"photos", segment.num_photos}};
    if (segment.problem.empty()) {
      entry["placedBy"] = segment.is_placed_by_map ? "map" : "positions";
      if (segment.is_placed_by_map) {
        entry["answers"] = segment.georegistration.num_positions;
        entry["medianResidualM"] = segment.georegistration.median_residual_m;
      } else {
        entry["observations"] = segment.adjustment.num_observations;
        entry["rmsPx"] = segment.adjustment.rms_px;
        entry["georegistration"] = GeoregistrationJson(segment.georegistration);
      }
      entry["movedByMapM"] = segment.moved_by_map_m;
    } else {
      entry["problem"] = segment.problem;
    }
    json["segments"].push_back(entry);
  }
  json["cameras"] = nlohmann::ordered_json::array();
  for (const CameraReport& camera : mapped.cameras) {
    json["cameras"].push_back({{"model", CameraModelName(camera.camera.model())},
                               {"widthPx", camera.camera.width_px()},
                               {"heightPx", camera.camera.height_px()},
                               {"params", camera.camera.params()},
                               {"focalBeforePx", camera.focal_before_px},
                               {"focalSource", SourceName(camera.source)},
                               {"photos", camera.num_photos}});
  }
  json["stages"] = nlohmann::ordered_json::array();
  for (const StageCost& stage : mapped.stages) {
    json["stages"].push_back({{"name", stage.name},
                              {"seconds", stage.seconds},
                              {"processorSeconds", stage.processor_seconds},
                              {"peakMegabytes", stage.peak_megabytes},
                              {"fromWork", stage.from_work}});
  }
  return json;
}

}  // namespace

void PrintMappedPhotos(const MapSessionResult& result) {
  const MappedPhotos& mapped = result.mapped;
  fmt::print("photos           {} of {} in the map\n", mapped.num_mapped, mapped.num_photos);
  PrintLeftOut(mapped.left_out);
  PrintSegments(mapped);
  PrintCameras(mapped.cameras);
  PrintScale(result);
  for (const std::string& note : mapped.notes) {
    fmt::print("note             {}\n", note);
  }
  for (const StageCost& stage : mapped.stages) {
    fmt::print("stage            {:<14} {:>5.1f} s, at most {:.0f} MB so far{}\n", stage.name,
               stage.seconds, stage.peak_megabytes,
               stage.from_work ? ", from the work folder" : "");
  }
}

nlohmann::ordered_json MapSessionJson(const MapSessionResult& result) {
  nlohmann::ordered_json json;
  if (result.is_mapped) {
    json["photos"] = MappedPhotosJson(result);
  }
  if (result.is_in_map) {
    json["ingest"] = IngestJson(result.name, result.session.georegistration, result.report);
  } else {
    json["notInMap"] = {{"session", result.name}, {"problem", result.problem}};
  }
  return json;
}

nlohmann::ordered_json MapSessionsJson(const std::vector<MapSessionResult>& results) {
  if (results.size() == 1) {
    return MapSessionJson(results.front());
  }
  nlohmann::ordered_json json;
  for (const MapSessionResult& result : results) {
    json["sessions"].push_back(MapSessionJson(result));
  }
  return json;
}

}  // namespace cairn
