#include "ingest/place/hemispheres.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/printable.h"
#include "ingest/place/position_columns.h"

namespace cairn {
namespace {

struct HemisphereWord {
  char letter;
  std::array<std::string_view, 4> words;
};

constexpr HemisphereWord kWords[] = {{'N', {"n", "north", "nord"}},
                                     {'S', {"s", "south", "sud"}},
                                     {'E', {"e", "east", "est", "ost"}},
                                     {'W', {"w", "west", "ouest", "oeste"}}};

// What the cells of one column are so far.
struct CellsOfColumn {
  bool are_hemispheres = true;  // Those that are not empty.
  bool has_negative = false;
};

std::vector<CellsOfColumn> CellsOfColumns(CsvReader rows, std::string_view hemispheres) {
  std::vector<CellsOfColumn> columns(rows.cells().size());
  while (rows.Next()) {
    const size_t num_cells = std::min(columns.size(), rows.cells().size());
    for (size_t i = 0; i < num_cells; ++i) {
      const std::string& cell = rows.cells()[i];
      const std::optional<char> letter = HemisphereOf(cell, hemispheres);
      const bool may_be_west = cell == "O" && hemispheres == "EW";
      columns[i].are_hemispheres =
          columns[i].are_hemispheres && (letter || may_be_west || cell.empty());
      columns[i].has_negative = columns[i].has_negative || may_be_west || letter == hemispheres[1];
    }
  }
  return columns;
}

}  // namespace

std::optional<char> HemisphereOf(std::string_view word, std::string_view hemispheres) {
  if (word.empty()) {
    return std::nullopt;
  }
  std::string small(word.substr(0, 10));
  std::transform(small.begin(), small.end(), small.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const HemisphereWord& hemisphere : kWords) {
    const bool is_word = std::find(hemisphere.words.begin(), hemisphere.words.end(), small) !=
                         hemisphere.words.end();
    if (is_word && hemispheres.find(hemisphere.letter) != hemispheres.npos) {
      return hemisphere.letter;
    }
  }
  return std::nullopt;
}

void RequireKnownHemispheres(CsvReader rows) {
  const std::vector<std::string> header = rows.cells();
  for (const HemisphereColumn& known : kHemisphereColumns) {
    if (FindColumn(header, known.name)) {
      continue;
    }
    const std::vector<CellsOfColumn> columns = CellsOfColumns(rows, known.hemispheres);
    for (size_t i = 0; i < columns.size(); ++i) {
      if (columns[i].are_hemispheres && columns[i].has_negative) {
        throw Error(ErrorCode::kBadInput,
                    fmt::format("the cells of the column '{}' are hemispheres ({} and {}), but its "
                                "name does not say so: call it {}, or leave it out if the signs of "
                                "the angles are right without it",
                                Excerpt(header[i]), known.hemispheres[0], known.hemispheres[1],
                                known.name));
      }
    }
  }
}

std::optional<char> MeaningOfO(CsvReader rows) {
  const std::vector<std::string> header = rows.cells();
  bool has_east = false, has_west = false;
  for (const char* name : {"lon_deg", "lon_ref"}) {
    const std::optional<size_t> column = FindColumn(header, name);
    for (CsvReader row = rows; column && row.Next();) {
      const std::string cell = *column < row.cells().size() ? row.cells()[*column] : "";
      const std::string ends = cell.empty() ? "" : std::string{cell.front(), cell.back()};
      has_east = has_east || ends.find('E') != ends.npos;
      has_west = has_west || ends.find('W') != ends.npos;
    }
  }
  if (has_east == has_west) {
    return std::nullopt;
  }
  return has_east ? 'W' : 'E';
}

}  // namespace cairn
