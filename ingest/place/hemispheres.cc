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
  std::array<std::string_view, 3> words;
};

constexpr HemisphereWord kWords[] = {{'N', {"n", "north", "nord"}},
                                     {'S', {"s", "south", "sud"}},
                                     {'E', {"e", "east", "est"}},
                                     {'W', {"w", "west", "ouest"}}};

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
      columns[i].are_hemispheres = columns[i].are_hemispheres && (letter || cell.empty());
      columns[i].has_negative = columns[i].has_negative || letter == hemispheres[1];
    }
  }
  return columns;
}

}  // namespace

std::optional<char> HemisphereOf(std::string_view word, std::string_view hemispheres) {
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

}  // namespace cairn
