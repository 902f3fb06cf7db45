#include "cli/batch/result_row.h"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>

#include "core/csv.h"
#include "http/json/localize_response.h"

namespace cairn {
namespace {

using RowJson = nlohmann::ordered_json;

constexpr auto kReplaceBadUtf8 = RowJson::error_handler_t::replace;

RowJson CamFromWorldJson(const Rigid3d& cam_from_world, const WorldFrame& frame) {
  const Eigen::Quaterniond& q = cam_from_world.rotation;
  const Eigen::Vector3d& t = cam_from_world.translation;
  RowJson json = {{"frame", frame.name}};
  if (frame.origin) {
    json["origin"] = {{"lat", frame.origin->lat_deg()},
                      {"lon", frame.origin->lon_deg()},
                      {"h", frame.origin->h_m}};
  }
  json["quaternion"] = {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}};
  json["translation"] = {t.x(), t.y(), t.z()};
  return json;
}

// The value at a path of members as a CSV cell; empty if there is none.
std::string CellAt(const RowJson& row, const char* pointer) {
  const RowJson::json_pointer path(pointer);
  if (!row.contains(path)) {
    return "";
  }
  const RowJson& value = row.at(path);
  if (value.is_number()) {
    return fmt::format("{}", value.get<double>());
  }
  return value.is_string() ? CsvText(value.get<std::string>()) : "";
}

struct CsvColumn {
  const char* name;
  const char* pointer;
};

constexpr std::array kCsvColumns = {
    CsvColumn{"image", "/image"},
    CsvColumn{"status", "/status"},
    CsvColumn{"reason", "/reason"},
    CsvColumn{"reason_text", "/reasonText"},
    CsvColumn{"lat_deg", "/geopose/position/lat"},
    CsvColumn{"lon_deg", "/geopose/position/lon"},
    CsvColumn{"h_m", "/geopose/position/h"},
    CsvColumn{"accuracy_m", "/accuracy/position"},
    CsvColumn{"accuracy_deg", "/accuracy/orientation"},
    CsvColumn{"earth_accuracy_m", "/accuracyOnEarth/position"},
    CsvColumn{"earth_accuracy_deg", "/accuracyOnEarth/orientation"},
    CsvColumn{"confidence", "/confidence"},
    CsvColumn{"score", "/score"},
    CsvColumn{"inliers", "/inlierCount"},
    CsvColumn{"focal_px", "/camera/focalLength"},
    CsvColumn{"prior", "/prior/source"},
    CsvColumn{"frame", "/camFromWorld/frame"},
    CsvColumn{"qw", "/camFromWorld/quaternion/w"},
    CsvColumn{"qx", "/camFromWorld/quaternion/x"},
    CsvColumn{"qy", "/camFromWorld/quaternion/y"},
    CsvColumn{"qz", "/camFromWorld/quaternion/z"},
    CsvColumn{"tx", "/camFromWorld/translation/0"},
    CsvColumn{"ty", "/camFromWorld/translation/1"},
    CsvColumn{"tz", "/camFromWorld/translation/2"},
};

}  // namespace

std::string AnswerRow(const std::string& name, const LocalizeQuery& query,
                      const LocalizeResult& result, const WorldFrame& frame) {
  LocalizeRequest request;
  // Of the query, the answer repeats only these.
  request.query.id = query.id;
  request.query.prior = query.prior;
  request.answer.with_timings = false;
  RowJson row = {{"image", name}};
  row.update(RowJson::parse(LocalizeResponseJson(result, request, ServerTimes())));
  row.erase("id");
  row["stages"][StageName(Stage::kTiles)].erase("loaded");  // Depends on the photos before.
  if (result.localized) {
    row["camFromWorld"] = CamFromWorldJson(frame.CamFromWorld(result.cam_from_ecef), frame);
  }
  return row.dump(-1, ' ', false, kReplaceBadUtf8);
}

std::string FailureRow(const std::string& name, const std::string& why) {
  const RowJson row = {
      {"image", name}, {"status", "FAILED"}, {"reason", "BAD_PHOTO"}, {"reasonText", why}};
  return row.dump(-1, ' ', false, kReplaceBadUtf8);
}

std::optional<RowSummary> ReadRow(std::string_view text) {
  const RowJson row = RowJson::parse(text, nullptr, false);
  if (!row.is_object() || !row.contains("image") || !row.contains("status")) {
    return std::nullopt;
  }
  const bool localized = row["status"] == "LOCALIZED";
  return RowSummary{.localized = localized,
                    .reason = localized ? "" : row.value("reason", std::string())};
}

std::string CsvHeader() {
  std::string text;
  for (const CsvColumn& column : kCsvColumns) {
    text += fmt::format("{}{}", text.empty() ? "" : ",", column.name);
  }
  return text + "\r\n";
}

std::string CsvOfRow(std::string_view text) {
  const RowJson row = RowJson::parse(text);
  std::string record;
  for (const CsvColumn& column : kCsvColumns) {
    record += (&column == kCsvColumns.data() ? "" : ",") + CellAt(row, column.pointer);
  }
  return record + "\r\n";
}

std::string HlocOfRow(const std::string& name, std::string_view text) {
  const RowJson row = RowJson::parse(text);
  if (!row.contains("camFromWorld")) {
    return "";
  }
  std::string line = name;
  for (const char* pointer : {"/quaternion/w", "/quaternion/x", "/quaternion/y", "/quaternion/z",
                              "/translation/0", "/translation/1", "/translation/2"}) {
    line += " " + CellAt(row["camFromWorld"], pointer);
  }
  return line + "\n";
}

}  // namespace cairn
