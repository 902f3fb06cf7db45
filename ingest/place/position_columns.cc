#include "ingest/place/position_columns.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <span>
#include <utility>

#include "ingest/place/height_name.h"

namespace cairn {
namespace {

struct ColumnNames {
  std::string_view name;
  // As Simplified writes them, likely ones first; names that state the reference before vague ones.
  std::array<std::string_view, 17> others;
};

constexpr ColumnNames kColumnNames[] = {
    {"image",
     {"image", "imagename", "sourcefile", "filename", "file", "photo", "photoname", "label",
      "picture", "imagefile", "photofile", "imagefilename", "imagepath", "filepath", "path",
      "name"}},
    {"lat_deg",
     {"latdeg", "latitude", "gpslatitude", "lat", "ylatitude", "latitudedeg", "latitudedd",
      "latdd"}},
    {"lon_deg",
     {"londeg", "longitude", "gpslongitude", "lon", "lng", "long", "xlongitude", "longitudedeg",
      "longitudedd", "londd"}},
    {"h_m",
     {"hm", "altitude", "gpsaltitude", "alt", "elevation", "zaltitude", "altitudem", "altm",
      "heightm", "ele", "height", "h"}},
    {"accuracy_m",
     {"accuracym", "accuracy", "gpshpositioningerror", "horizontalaccuracy", "accuracyhorizontal"}},
    {"lat_ref",
     {"latref", "gpslatituderef", "latituderef", "gpslatref", "refgpslatitude", "reflatitude",
      "reflat", "ns", "northsouth", "nors", "nsindicator", "latns", "latitudens", "latdir",
      "latitudedirection", "lathemisphere"}},
    {"lon_ref",
     {"lonref", "gpslongituderef", "longituderef", "gpslonref", "refgpslongitude", "reflongitude",
      "reflon", "ew", "eastwest", "eorw", "ewindicator", "lonew", "longitudeew", "londir",
      "longitudedirection", "lonhemisphere"}},
    {"h_ref", {"gpsaltituderef"}},
};

// In brackets behind a name: what the column has anyway.
constexpr std::string_view kUnits[] = {
    "",  "m",           "meter",     "meters", "deg", "degree",         "degrees",      "n",
    "e", "ellipsoidal", "ellipsoid", "wgs84",  "dd",  "decimaldegrees", "decimaldegree"};

char Lower(char letter) {
  return static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
}

// The letters and digits of a header's cell, in lower case, without group and units. Empty if the
// units are others, such as feet.
std::string Simplified(std::string_view cell) {
  cell.remove_prefix(cell.rfind(':') + 1);  // Nothing if there is none: npos + 1 is 0.
  const size_t bracket = std::min(cell.find_first_of("([{"), cell.size());
  const std::string unit = LettersAndDigits(cell.substr(bracket));
  const bool is_known = std::find(std::begin(kUnits), std::end(kUnits), unit) != std::end(kUnits);
  return is_known ? LettersAndDigits(cell.substr(0, bracket)) : std::string();
}

// Of exiftool's groups, Composite has the signs of south and west.
bool IsComposite(std::string_view cell) {
  return LettersAndDigits(cell.substr(0, cell.rfind(':') + 1)) == "composite";
}

// A table of pictures' widths and heights in pixels.
bool HasWidths(const std::vector<std::string>& header) {
  return std::any_of(header.begin(), header.end(), [](const std::string& cell) {
    return LettersAndDigits(cell).find("width") != std::string::npos;
  });
}

std::span<const std::string_view> OtherNamesOf(std::string_view name) {
  for (const ColumnNames& column : kColumnNames) {
    if (column.name == name) {
      return column.others;
    }
  }
  return {};
}

bool StatesReference(std::string_view cell, HeightReference reference) {
  const std::optional<HeightName> name = ReadHeightName(cell);
  return name && name->in_meters && name->reference == reference;
}

// Takes a letter of `hemispheres` off either end of the text; 1 or -1, or 0 without one.
double TakeHemisphere(std::string_view hemispheres, std::string* text) {
  for (const double sign : {1.0, -1.0}) {
    const char letter = hemispheres[sign > 0.0 ? 0 : 1];
    if (text->empty()) {
      return 0.0;
    }
    // A small s at the end is the sign of seconds.
    if (text->back() != 's' && std::toupper(static_cast<unsigned char>(text->back())) == letter) {
      text->pop_back();
      return sign;
    }
    if (std::toupper(static_cast<unsigned char>(text->front())) == letter) {
      text->erase(0, 1);
      return sign;
    }
  }
  return 0.0;
}

// Makes blanks of the signs between degrees, minutes and seconds.
std::string WithoutAngleSigns(std::string text) {
  for (const std::string_view sign : {"deg", "\u00b0", "\u00ba", "\u2032", "\u2033", "\u2019",
                                      "\u201d", "d", "m", "s", "'", "\"", ":"}) {
    for (size_t at = text.find(sign); at != text.npos; at = text.find(sign, at)) {
      text.replace(at, sign.size(), " ");
    }
  }
  return text;
}

// The numbers of a text, separated by blanks; empty if the text has anything else.
std::vector<double> NumbersOf(std::string_view text) {
  std::vector<double> numbers;
  while (true) {
    text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
    if (text.empty()) {
      return numbers;
    }
    double number = 0.0;
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || !std::isfinite(number)) {
      return {};
    }
    text.remove_prefix(static_cast<size_t>(rest - text.data()));
    if (!text.empty() && text.front() != ' ' && text.front() != '\t') {
      return {};  // Two decimal marks are those of another language.
    }
    numbers.push_back(number);
  }
}

}  // namespace

std::vector<size_t> FindColumns(const std::vector<std::string>& header, std::string_view name) {
  std::vector<size_t> columns;
  std::vector<bool> is_taken(header.size(), false);
  const auto add_if = [&](const auto& holds) {
    for (size_t i = 0; i < header.size(); ++i) {
      if (!is_taken[i] && holds(header[i])) {
        is_taken[i] = true;
        columns.push_back(i);
      }
    }
  };
  add_if([&](const std::string& cell) { return cell == name; });
  if (name == "h_m") {
    for (const HeightReference reference :
         {HeightReference::kEllipsoid, HeightReference::kMeanSeaLevel}) {
      add_if([&](const std::string& cell) { return StatesReference(cell, reference); });
    }
  }
  const bool has_widths = name == "h_m" && HasWidths(header);
  for (const std::string_view other : OtherNamesOf(name)) {
    if (other.empty() || (has_widths && other == "height")) {
      continue;
    }
    const auto is_other = [&](const std::string& cell) { return Simplified(cell) == other; };
    add_if([&](const std::string& cell) { return is_other(cell) && IsComposite(cell); });
    add_if(is_other);
  }
  return columns;
}

std::optional<size_t> FindColumn(const std::vector<std::string>& header, std::string_view name) {
  const std::vector<size_t> columns = FindColumns(header, name);
  return columns.empty() ? std::nullopt : std::optional(columns.front());
}

bool IsAltitudeOfExif(std::string_view column_name) {
  return Simplified(column_name) == "gpsaltitude";
}

std::string LettersAndDigits(std::string_view text) {
  std::string kept;
  for (const char letter : text) {
    if (std::isalnum(static_cast<unsigned char>(letter))) {
      kept += Lower(letter);
    }
  }
  return kept;
}

std::optional<double> AngleDeg(std::string_view text, std::string_view hemispheres) {
  constexpr size_t kMaxAngleBytes = 100;
  if (text.size() > kMaxAngleBytes) {
    return std::nullopt;
  }
  std::string rest(text);
  const double hemisphere = TakeHemisphere(hemispheres, &rest);
  const std::vector<double> numbers = NumbersOf(WithoutAngleSigns(std::move(rest)));
  if (numbers.empty() || numbers.size() > 3) {
    return std::nullopt;
  }
  if (hemisphere == 0.0 && hemispheres[1] == 'S' && text.ends_with('s') && numbers.size() != 3) {
    return std::nullopt;  // South, or seconds.
  }
  double angle_deg = std::abs(numbers[0]);
  double unit_deg = 1.0;
  for (size_t i = 1; i < numbers.size(); ++i) {
    unit_deg /= 60.0;
    if (numbers[i - 1] != std::trunc(numbers[i - 1]) || std::signbit(numbers[i]) ||
        numbers[i] >= 60.0) {
      return std::nullopt;
    }
    angle_deg += numbers[i] * unit_deg;
  }
  const bool is_negative = std::signbit(numbers[0]);
  if (is_negative && hemisphere != 0.0) {
    return std::nullopt;
  }
  return is_negative || hemisphere < 0.0 ? -angle_deg : angle_deg;
}

std::optional<double> HeightM(std::string_view text) {
  const char* const end = text.data() + text.size();
  double height_m = 0.0, divisor = 1.0;
  std::from_chars_result read = std::from_chars(text.data(), end, height_m);
  const bool is_ratio = read.ec == std::errc() && read.ptr != end && *read.ptr == '/';
  if (is_ratio) {
    read = std::from_chars(read.ptr + 1, end, divisor);
  }
  if (read.ec != std::errc() || !(divisor > 0.0)) {
    return std::nullopt;
  }
  height_m /= divisor;
  std::string unit(read.ptr, end);
  std::transform(unit.begin(), unit.end(), unit.begin(), Lower);
  unit.erase(std::remove(unit.begin(), unit.end(), ' '), unit.end());
  if (unit == "mbelowsealevel") {
    return -height_m;
  }
  const bool has_unit = unit == "m" || unit == "mabovesealevel";
  return has_unit || (is_ratio && unit.empty()) ? std::optional(height_m) : std::nullopt;
}

std::string PlainText(std::string text) {
  constexpr std::pair<std::string_view, std::string_view> kPlain[] = {
      {"\u2212", "-"}, {"\u00a0", " "}, {"\u202f", " "}, {"\u2009", " "}};
  for (const auto& [special, plain] : kPlain) {
    for (size_t at = text.find(special); at != text.npos; at = text.find(special, at)) {
      text.replace(at, special.size(), plain);
    }
  }
  return text;
}

std::string WithoutBlanksAround(const std::string& text) {
  constexpr std::string_view kBlanks[] = {" ", "\t", "\u00a0", "\u202f"};
  std::string_view rest = text;
  for (bool has_changed = true; has_changed;) {
    has_changed = false;
    for (const std::string_view blank : kBlanks) {
      if (rest.starts_with(blank)) {
        rest.remove_prefix(blank.size());
        has_changed = true;
      }
      if (rest.ends_with(blank)) {
        rest.remove_suffix(blank.size());
        has_changed = true;
      }
    }
  }
  return std::string(rest);
}

bool StandsForNothing(std::string_view text) {
  constexpr std::string_view kNothing[] = {"",    "-",   "undef", "inf",  "na",
                                           "n/a", "nan", "none",  "null", "#n/a"};
  std::string small(text.substr(0, 10));
  std::transform(small.begin(), small.end(), small.begin(), Lower);
  return std::find(std::begin(kNothing), std::end(kNothing), small) != std::end(kNothing);
}

}  // namespace cairn
