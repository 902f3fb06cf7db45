#include "cli/ingest_summary.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/angles.h"
#include "core/printable.h"

namespace cairn {
namespace {

nlohmann::ordered_json ChangesJson(const TileChanges& changes) {
  return {{"merged", changes.num_merged},
          {"new", changes.num_new},
          {"notNeeded", changes.num_not_needed},
          {"faded", changes.num_faded},
          {"evicted", changes.num_evicted},
          {"keyframesReplaced", changes.num_keyframes_replaced},
          {"bytesBefore", changes.num_bytes_before},
          {"bytesAfter", changes.num_bytes_after}};
}

}  // namespace

nlohmann::ordered_json GeoregistrationJson(const Georegistration& georegistration) {
  if (georegistration.num_positions == 0) {
    return {{"medianResidualM", georegistration.median_residual_m}};
  }
  return {{"positions", georegistration.num_positions},
          {"inliers", georegistration.num_inliers},
          {"medianResidualM", georegistration.median_residual_m},
          {"maxResidualM", georegistration.max_residual_m}};
}

nlohmann::ordered_json ComparisonJson(const MapComparison& comparison) {
  return {{"photosExpected", comparison.num_expected},
          {"photosRecognised", comparison.num_localized},
          {"photosAgreeing", comparison.fit.num_agreeing},
          {"movedM", comparison.fit.moved_m},
          {"turnedDeg", comparison.fit.turned_rad * kDegPerRad},
          {"scale", comparison.fit.scale},
          {"medianResidualM", comparison.fit.median_residual_m}};
}

void PrintJson(const nlohmann::ordered_json& json) {
  fmt::print("{}\n", json.dump(2, ' ', true, nlohmann::ordered_json::error_handler_t::replace));
}

void PrintIngestJson(const std::string& session_name, const Georegistration& georegistration,
                     const IngestReport& report) {
  PrintJson({{"session", session_name},
             {"replacedSession", report.replaced_session},
             {"unchanged", report.is_unchanged},
             {"georegistration", GeoregistrationJson(georegistration)},
             {"comparison", ComparisonJson(report.comparison)},
             {"images", report.num_images},
             {"landmarksRead", report.num_landmarks_read},
             {"landmarksDropped", report.num_landmarks_dropped},
             {"changes", ChangesJson(report.changes)},
             {"tiles", report.num_tiles_written},
             {"landmarks", report.num_landmarks_written},
             {"descriptors", report.num_descriptors_written},
             {"payloadBytes", report.num_payload_bytes},
             {"mapVersion", Value(report.map_version)}});
}

void PrintGeoregistration(const Georegistration& georegistration) {
  if (georegistration.num_positions == 0) {
    fmt::print("georegistration  residual {:.3f} m median\n", georegistration.median_residual_m);
    return;
  }
  fmt::print(
      "georegistration  {} of {} positions agree; residual {:.3f} m median, {:.3f} m largest\n",
      georegistration.num_inliers, georegistration.num_positions, georegistration.median_residual_m,
      georegistration.max_residual_m);
}

void PrintComparison(const MapComparison& comparison) {
  if (comparison.num_expected == 0) {
    return;
  }
  fmt::print(
      "comparison       the map recognizes {} of {} photos; {} agree on a move of {:.2f} m and "
      "{:.2f} degrees, residual {:.3f} m median\n",
      comparison.num_localized, comparison.num_expected, comparison.fit.num_agreeing,
      comparison.fit.moved_m, comparison.fit.turned_rad * kDegPerRad,
      comparison.fit.median_residual_m);
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
  PrintComparison(report.comparison);
  fmt::print("landmarks        {} read, {} dropped as uncertain\n", report.num_landmarks_read,
             report.num_landmarks_dropped);
  const TileChanges& changes = report.changes;
  fmt::print(
      "                 {} merged, {} new, {} not needed, {} faded, {} evicted (one count for each "
      "tile)\n",
      changes.num_merged, changes.num_new, changes.num_not_needed, changes.num_faded,
      changes.num_evicted);
  fmt::print("keyframes        {} replaced\n", changes.num_keyframes_replaced);
  fmt::print(
      "tiles            {} with {} landmarks and {} descriptors; {:.1f} kB before, {:.1f} kB "
      "now\n",
      report.num_tiles_written, report.num_landmarks_written, report.num_descriptors_written,
      1e-3 * static_cast<double>(changes.num_bytes_before),
      1e-3 * static_cast<double>(changes.num_bytes_after));
  fmt::print("map version      {}\n", Value(report.map_version));
}

}  // namespace cairn
