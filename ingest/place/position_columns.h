// Columns of positions under the names and in the forms that other programs write. Private to
// ingest/place.
#ifndef CAIRN_INGEST_PLACE_POSITION_COLUMNS_H_
#define CAIRN_INGEST_PLACE_POSITION_COLUMNS_H_

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cairn {

// Returns the columns of a header that `name` may mean, the one that counts first: the one of that
// name, then those whose name other programs use for it, as exiftool does (SourceFile,
// GPSLatitude), Metashape (#Label, Y/Latitude) and spreadsheets ("Latitude [deg]", "N/S"). Case,
// blanks, signs, meters and degrees in brackets and exiftool's groups ("EXIF:") do not count; its
// group Composite, which has signs, comes first. Heights that state their reference come before
// vague ones (height_name.h). A column with another unit has none of these names, and heights
// beside widths are those of pictures. Only image, lat_deg, lon_deg, h_m, accuracy_m, lat_ref,
// lon_ref and h_ref have other names.
std::vector<size_t> FindColumns(const std::vector<std::string>& header, std::string_view name);

// The first of these.
std::optional<size_t> FindColumn(const std::vector<std::string>& header, std::string_view name);

// True if a column of this name holds heights above mean sea level if a camera wrote them: EXIF's
// GPSAltitude.
bool IsAltitudeOfExif(std::string_view column_name);

// The letters and digits of a text, in lower case.
std::string LettersAndDigits(std::string_view text);

// The angle of a text that is no plain number: degrees, or degrees and minutes, or degrees, minutes
// and seconds, with a minus or one letter of `hemispheres` before or behind them: "NS" or "EW", the
// positive one first. Between the numbers stand blanks, colons, the signs ° ' " ′ ″ or deg, d, m,
// s; a small s at the end stands for seconds. Nothing for other texts, for minutes and seconds that
// are not in [0, 60), and if a fraction stands before another number.
std::optional<double> AngleDeg(std::string_view text, std::string_view hemispheres);

// The height of a text such as exiftool's "37.2 m Above Sea Level" or EXIF's "3720/100"; meters,
// negative if it says below. Nothing for other texts, such as plain numbers.
std::optional<double> HeightM(std::string_view text);

// The text with plain signs for the minus of typographers and for blanks that do not break.
std::string PlainText(std::string text);

// The text without blanks at its ends, plain ones and those that do not break.
std::string WithoutBlanksAround(const std::string& text);

// True for what programs write if there is no value: nothing, NA, nan, null, None, undef, - and so
// on.
bool StandsForNothing(std::string_view text);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_POSITION_COLUMNS_H_
