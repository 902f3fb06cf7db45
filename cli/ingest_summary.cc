#include "cli/ingest_summary.h"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/join_summary.h"
#include "cli/json_output.h"
#include "core/printable.h"

namespace cairn {
namespace {

// Odds beyond this are no more than certain.
constexpr double kManyTimes = 1000.0;

const char* CodebookName(CodebookOrigin origin) {
  switch (origin) {
    case CodebookOrigin::kMap:
      return "of the map";
    case CodebookOrigin::kShipped:
      return "shipped";
    case CodebookOrigin::kTrained:
      break;
  }
  return "trained";
}

constexpr std::array<const char*, kPictureUps.size()> kHoldNames = {"top", "left", "right",
                                                                    "bottom", "back"};

nlohmann::ordered_json UpJson(const UpReport& up) {
  nlohmann::ordered_json json = {{"source", up.source}};
  if (up.odds > 0.0) {
    json["odds"] = up.odds;
    for (size_t i = 0; i < kHoldNames.size(); ++i) {
      json["photosWithUpAt"][kHoldNames[i]] = up.num_images[i];
    }
  }
  return json;
}

// E.g. "from the bends of the walk, 52 times as likely as the next; at the left of 12 photos".
void PrintUp(const UpReport& up) {
  std::string line = "from " + up.source;
  if (up.odds > 0.0) {
    line += up.odds < kManyTimes
                ? fmt::format(", {:.0f} times as likely as the next", up.odds)
                : fmt::format(", over {:.0f} times as likely as the next", kManyTimes);
    const char* separator = "; at the ";
    for (size_t i = 0; i < kHoldNames.size(); ++i) {
      if (up.num_images[i] > 0) {
        line += fmt::format("{}{} of {} photos", separator, kHoldNames[i], up.num_images[i]);
        separator = ", the ";
      }
    }
  }
  fmt::print("up               {}\n", line);
}

}  // namespace

nlohmann::ordered_json GeoregistrationJson(const Georegistration& georegistration) {
  if (georegistration.num_positions == 0) {
    return {{"medianResidualM", georegistration.median_residual_m}};
  }
  return {{"positions", georegistration.num_positions},
          {"inliers", georegistration.num_inliers},
          {"medianResidualM", georegistration.median_residual_m},
          {"maxResidualM", georegistration.max_residual_m},
          {"notes", georegistration.notes},
          {"up", UpJson(georegistration.up)}};
}

nlohmann::ordered_json IngestJson(const std::string& session_name,
                                  const Georegistration& georegistration,
                                  const IngestReport& report) {
  return {{"session", session_name},
          {"replacedSession", report.replaced_session},
          {"unchanged", report.is_unchanged},
          {"georegistration", GeoregistrationJson(georegistration)},
          {"codebook", CodebookName(report.codebook_origin)},
          {"comparison", ComparisonJson(report.comparison)},
          {"adjustment", AdjustmentJson(report.adjustment)},
          {"images", report.num_images},
          {"landmarksRead", report.num_landmarks_read},
          {"landmarksDropped", report.num_landmarks_dropped},
          {"changes", ChangesJson(report.changes)},
          {"keyframeAnswers", AnswersJson(report.keyframe_answers)},
          {"tiles", report.num_tiles_written},
          {"landmarks", report.num_landmarks_written},
          {"descriptors", report.num_descriptors_written},
          {"payloadBytes", report.num_payload_bytes},
          {"mapVersion", Value(report.map_version)}};
}

void PrintIngestJson(const std::string& session_name, const Georegistration& georegistration,
                     const IngestReport& report) {
  PrintJson(IngestJson(session_name, georegistration, report));
}

void PrintGeoregistration(const Georegistration& georegistration) {
  if (georegistration.is_by_map) {
    return;
  }
  if (georegistration.num_positions == 0) {
    fmt::print("georegistration  residual {:.3f} m median\n", georegistration.median_residual_m);
    return;
  }
  fmt::print(
      "georegistration  {} of {} positions agree; residual {:.3f} m median, {:.3f} m largest\n",
      georegistration.num_inliers, georegistration.num_positions, georegistration.median_residual_m,
      georegistration.max_residual_m);
  for (const std::string& note : georegistration.notes) {
    fmt::print("                 {}\n", note);
  }
  PrintUp(georegistration.up);
}

void PrintIngestText(const std::string& session_name, const Georegistration& georegistration,
                     const IngestReport& report) {
  fmt::print("session          {}{}\n", Excerpt(session_name),
             report.replaced_session ? " (replaced)" : "");
  fmt::print("images           {}\n", report.num_images);
  PrintGeoregistration(georegistration);
  if (report.is_unchanged) {
    fmt::print("The map already holds exactly this session. Nothing was changed.\n");
    return;
  }
  fmt::print("codebook         {}\n", CodebookName(report.codebook_origin));
  PrintComparison(report.comparison, "photos");
  PrintAdjustment(report.adjustment);
  fmt::print("landmarks        {} read, {} dropped as uncertain\n", report.num_landmarks_read,
             report.num_landmarks_dropped);
  const TileChanges& changes = report.changes;
  PrintChanges(changes);
  PrintAnswers(report.keyframe_answers);
  fmt::print(
      "tiles            {} with {} landmarks and {} descriptors; {:.1f} kB before, {:.1f} kB "
      "now\n",
      report.num_tiles_written, report.num_landmarks_written, report.num_descriptors_written,
      1e-3 * static_cast<double>(changes.num_bytes_before),
      1e-3 * static_cast<double>(changes.num_bytes_after));
  fmt::print("map version      {}\n", Value(report.map_version));
}

}  // namespace cairn
