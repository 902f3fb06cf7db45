#include "ingest/place/position_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/file_bytes.h"
#include "core/logging.h"
#include "core/printable.h"
#include "ingest/place/height_name.h"
#include "ingest/place/hemispheres.h"
#include "ingest/place/position_columns.h"

namespace cairn {
namespace {

constexpr uint64_t kMaxTableBytes = uint64_t{256} << 20;
constexpr size_t kMaxHeaderBytes = 200;  // In a message.
constexpr std::string_view kCoordinates[] = {"lat_deg", "lon_deg", "h_m"};

bool IsHeightInOtherUnit(const std::string& column_name) {
  const std::optional<HeightName> name = ReadHeightName(column_name);
  return name && !name->in_meters;
}

// Runs `read` and prefixes the path to the message of an error.
template <typename Read>
auto WithTablePath(const std::string& path, const Read& read) {
  try {
    return read();
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("{}: {}", path, error.what()));
  }
}

// Empties the lines before the header that begin with "# ": Metashape states its coordinate system
// there. Lines keep their numbers.
std::string WithoutComments(std::string text) {
  for (size_t begin = 0; text.compare(begin, 2, "# ") == 0; ++begin) {
    text.erase(begin, std::min(text.find('\n', begin), text.size()) - begin);
    if (begin == text.size()) {
      break;
    }
  }
  return text;
}

}  // namespace

PositionTable::PositionTable(const std::string& path, std::initializer_list<const char*> required)
    : path_(path),
      text_(WithoutComments(ReadTextFile(path, kMaxTableBytes))),
      rows_(WithTablePath(path, [&] { return CsvReader(text_); })) {
  if (!NextRow()) {
    Throw("the header is missing");
  }
  const std::vector<std::string> header = rows_.cells();
  for (const char* name : required) {
    if (!TakeColumn(name, header)) {
      ThrowNoColumn(name, required, header);
    }
  }
  for (const char* name : {"accuracy_m", "lat_ref", "lon_ref", "h_ref"}) {
    TakeColumn(name, header);
  }
  WithTablePath(path_, [&] { RequireKnownHemispheres(rows_); });
  TakeHeightsFrom(header[ColumnOf("h_m")]);
  meaning_of_o_ = MeaningOfO(rows_);
  num_columns_ = header.size();
  while (num_columns_ > 0 && header[num_columns_ - 1].empty()) {
    --num_columns_;
  }
}

bool PositionTable::TakeColumn(const char* name, const std::vector<std::string>& header) {
  const std::vector<size_t> columns = FindColumns(header, name);
  if (columns.empty()) {
    return false;
  }
  const std::string& counts = header[columns.front()];
  if (std::count(header.begin(), header.end(), counts) > 1) {
    Throw(fmt::format("the header has several columns '{}'; leave one", Excerpt(counts)));
  }
  column_of_name_.emplace(name, columns.front());
  const bool is_coordinate =
      std::find(std::begin(kCoordinates), std::end(kCoordinates), name) != std::end(kCoordinates);
  if (is_coordinate && columns.size() > 1) {
    LogInfo("{}: of the columns that may be {}, '{}' counts, and '{}' does not", Printable(path_),
            name, Excerpt(counts), Excerpt(header[columns[1]]));
  }
  return true;
}

void PositionTable::TakeHeightsFrom(const std::string& column_name) {
  has_altitudes_of_exif_ = IsAltitudeOfExif(column_name);
  const std::optional<HeightName> stated = ReadHeightName(column_name);
  height_reference_ = stated ? stated->reference : std::nullopt;
  if (height_reference_ == HeightReference::kMeanSeaLevel) {
    LogInfo(
        "{}: by its name, the column '{}' has heights above mean sea level; --height ellipsoid "
        "says that they are above the ellipsoid",
        Printable(path_), Excerpt(column_name));
  }
}

void PositionTable::ThrowNoColumn(const char* name, std::initializer_list<const char*> required,
                                  const std::vector<std::string>& header) const {
  const bool is_height = std::string_view(name) == "h_m";
  if (const auto foreign = std::find_if(header.begin(), header.end(), IsHeightInOtherUnit);
      is_height && foreign != header.end()) {
    Throw(
        fmt::format("the heights of the column '{}' are not in meters; convert them, and call "
                    "the column h_m if they are above the ellipsoid, and h_msl if they are above "
                    "mean sea level",
                    Excerpt(*foreign)));
  }
  std::string hint = rows_.Number(header.size() - 1) ? "; this line looks like a position" : "";
  // Control points need their heights.
  if (is_height && std::string_view(*required.begin()) == "image") {
    hint +=
        ". If no height is known, leave the cells of that column empty; cairn map and cairn "
        "ingest then take --camera-height M";
  }
  Throw(
      fmt::format("the header has no column '{}'; expected {} and optionally accuracy_m, got {}{}",
                  name, fmt::join(required, ", "),
                  Excerpt(fmt::format("{}", fmt::join(header, ", ")), kMaxHeaderBytes), hint));
}

bool PositionTable::NextRow() {
  const auto next = [&] { return WithTablePath(path_, [&] { return rows_.Next(); }); };
  if (num_columns_ == 0) {
    return next();  // The header.
  }
  while (next()) {
    TakeCells();
    if (!IsComment()) {
      RequireColumns();
      return true;
    }
  }
  return false;
}

void PositionTable::TakeCells() {
  cells_ = rows_.cells();
  for (std::string& cell : cells_) {
    cell = WithoutBlanksAround(cell);
  }
  for (const auto& [name, column] : column_of_name_) {
    if (name != "image" && name != "point" && column < cells_.size()) {
      cells_[column] = WithoutBlanksAround(PlainText(cells_[column]));
    }
  }
}

// A photo's name may begin with '#', too; then the latitude has digits.
bool PositionTable::IsComment() const {
  return cells_.front().starts_with('#') &&
         (cells_.size() < num_columns_ ||
          Text("lat_deg").find_first_of("0123456789") == std::string::npos);
}

void PositionTable::RequireColumns() const {
  const auto extra_begin =
      cells_.begin() + static_cast<int64_t>(std::min(num_columns_, cells_.size()));
  const bool has_more =
      std::any_of(extra_begin, cells_.end(), [](const std::string& cell) { return !cell.empty(); });
  if (cells_.size() < num_columns_ || has_more) {
    Throw(fmt::format("{} columns, but the header has {}; put a name with a '{}' in quotes",
                      cells_.size(), num_columns_, rows_.separator()));
  }
}

bool PositionTable::Has(const char* name) const {
  return column_of_name_.contains(name) && !StandsForNothing(Text(name));
}

double PositionTable::Number(const char* name) const {
  const std::optional<double> value = rows_.NumberOf(Text(name));
  if (!value || !std::isfinite(*value)) {
    Throw(fmt::format("column {}: '{}' is not a number", name, Excerpt(Text(name))));
  }
  return *value;
}

std::string PositionTable::AngleText(const char* name, std::string_view hemispheres) const {
  std::string text = Text(name);
  if (rows_.separator() != ',') {
    std::replace(text.begin(), text.end(), ',', '.');
  }
  const size_t at = text.starts_with('O') ? 0 : text.size() - 1;
  if (hemispheres == "EW" && !text.empty() && text[at] == 'O') {
    if (!meaning_of_o_) {
      Throw(fmt::format("column {}: 'O' may be east (Ost) or west (Ouest, Oeste); write E or W",
                        name));
    }
    text[at] = *meaning_of_o_;
  }
  return text;
}

double PositionTable::Angle(const char* name, const char* ref_name, const char* hemispheres) const {
  std::optional<double> angle_deg = rows_.NumberOf(Text(name));
  if (!angle_deg) {
    angle_deg = AngleDeg(AngleText(name, hemispheres), hemispheres);
  }
  if (!angle_deg || !std::isfinite(*angle_deg)) {
    return Number(name);  // Throws.
  }
  return IsNegative(ref_name, hemispheres) ? -std::abs(*angle_deg) : *angle_deg;
}

bool PositionTable::IsNegative(const char* ref_name, const char* hemispheres) const {
  if (!Has(ref_name)) {
    return false;
  }
  // The rest of the word depends on the language: South, Sud, Sur.
  const auto first = static_cast<char>(std::toupper(static_cast<unsigned char>(Text(ref_name)[0])));
  char letter = HemisphereOf(Text(ref_name), hemispheres).value_or(first);
  if (letter == 'O' && hemispheres[1] == 'W' && meaning_of_o_) {
    letter = *meaning_of_o_;
  }
  if (letter != hemispheres[0] && letter != hemispheres[1]) {
    Throw(fmt::format("column {}: '{}' is neither {} nor {}", ref_name, Excerpt(Text(ref_name)),
                      hemispheres[0], hemispheres[1]));
  }
  return letter == hemispheres[1];
}

double PositionTable::Height() const {
  if (!Has("h_m")) {
    return 0.0;
  }
  const double height_m = Meters("h_m");
  const std::string below = Has("h_ref") ? Text("h_ref") : "";
  return below == "1" || below.starts_with("Below") ? -std::abs(height_m) : height_m;
}

double PositionTable::Meters(const char* name) const {
  std::string text = Text(name);
  if (rows_.separator() != ',') {
    std::replace(text.begin(), text.end(), ',', '.');
  }
  const std::optional<double> with_unit = HeightM(text);
  return with_unit ? *with_unit : Number(name);
}

Geodetic PositionTable::Position(const std::string& what) const {
  // Heights such as -32768 and 1e6 stand for none. They stay so low or high that no place has them.
  const double height_m = std::clamp(Height(), Geodetic::kMinHeightM, Geodetic::kMaxHeightM);
  const Geodetic position = Geodetic::FromDegrees(Angle("lat_deg", "lat_ref", "NS"),
                                                  Angle("lon_deg", "lon_ref", "EW"), height_m);
  try {
    ValidateGeodetic(position, Excerpt(what).c_str());
  } catch (const Error& e) {
    Throw(e.what());
  }
  return position;
}

double PositionTable::AccuracyOr(double default_m) const {
  const double accuracy_m = Has("accuracy_m") ? Meters("accuracy_m") : default_m;
  if (!(accuracy_m > 0.0)) {
    Throw("column accuracy_m: must be positive");
  }
  return accuracy_m;
}

void PositionTable::Throw(const std::string& what) const {
  throw Error(ErrorCode::kBadInput, fmt::format("{}: line {}: {}", path_, rows_.line(), what));
}

}  // namespace cairn
