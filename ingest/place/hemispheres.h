// What the cells of a table of positions say about hemispheres. Private to ingest/place.
#ifndef CAIRN_INGEST_PLACE_HEMISPHERES_H_
#define CAIRN_INGEST_PLACE_HEMISPHERES_H_

#include <optional>
#include <string_view>

#include "core/csv.h"

namespace cairn {

// Hemispheres of latitudes or of longitudes.
struct HemisphereColumn {
  std::string_view name;         // Cairn's name of the column.
  std::string_view hemispheres;  // "NS" or "EW", the positive one first.
};
inline constexpr HemisphereColumn kHemisphereColumns[] = {{"lat_ref", "NS"}, {"lon_ref", "EW"}};

// The hemisphere that a word such as "S", "south" or "West" means, as a letter of `hemispheres`.
// Nothing for other words.
std::optional<char> HemisphereOf(std::string_view word, std::string_view hemispheres);

// `rows` stands at the header of a table. Throws Error(kBadInput), with the column and what to call
// it, if FindColumn finds no column for hemispheres, and if all cells of another column are words
// for them, at least one of them S or W. Taken as no hemispheres, they would put a map of Chile in
// Kazakhstan.
void RequireKnownHemispheres(CsvReader rows);

// `rows` stands at the header of a table. What the letter O means in its longitudes, by the other
// letters there: 'E' for Ost if there is West, 'W' for Ouest and Oeste if there is Est. Nothing if
// there is neither or both.
std::optional<char> MeaningOfO(CsvReader rows);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_HEMISPHERES_H_
