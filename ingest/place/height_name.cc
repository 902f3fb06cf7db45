#include "ingest/place/height_name.h"

#include <string>

#include "ingest/place/position_columns.h"

namespace cairn {
namespace {

struct HeightWord {
  std::string_view text;
  bool is_height = false;
  std::optional<HeightReference> reference = {};
  bool in_meters = true;
};

constexpr HeightReference kEllipsoid = HeightReference::kEllipsoid;
constexpr HeightReference kSeaLevel = HeightReference::kMeanSeaLevel;

constexpr HeightWord kHeightWords[] = {
    {.text = "altitude", .is_height = true},
    {.text = "alt", .is_height = true},
    {.text = "elevation", .is_height = true},
    {.text = "elev", .is_height = true},
    {.text = "ele", .is_height = true},
    {.text = "height", .is_height = true},
    {.text = "hgt", .is_height = true},
    {.text = "ht", .is_height = true},
    {.text = "h", .is_height = true},
    {.text = "hae", .is_height = true, .reference = kEllipsoid},
    {.text = "ellipsoidal", .reference = kEllipsoid},
    {.text = "ellipsoid", .reference = kEllipsoid},
    {.text = "ell", .reference = kEllipsoid},
    {.text = "wgs84", .reference = kEllipsoid},
    {.text = "amsl", .is_height = true, .reference = kSeaLevel},
    {.text = "msl", .is_height = true, .reference = kSeaLevel},
    {.text = "asl", .is_height = true, .reference = kSeaLevel},
    {.text = "sealevel", .reference = kSeaLevel},
    {.text = "orthometric", .reference = kSeaLevel},
    {.text = "ortho", .reference = kSeaLevel},
    {.text = "abovegeoid", .reference = kSeaLevel},
    {.text = "m"},
    {.text = "meter"},
    {.text = "meters"},
    {.text = "etre"},  // Behind an m, in British spelling.
    {.text = "etres"},
    {.text = "ft", .in_meters = false},
    {.text = "feet", .in_meters = false},
    {.text = "foot", .in_meters = false},
    {.text = "km", .in_meters = false},
    {.text = "us"},
    {.text = "survey"},
    {.text = "gps"},
    {.text = "above"},
    {.text = "the"},
    {.text = "mean"},
};

// The longest word with which the text begins; nullptr if there is none.
const HeightWord* FirstWord(std::string_view text) {
  const HeightWord* longest = nullptr;
  for (const HeightWord& word : kHeightWords) {
    if (text.starts_with(word.text) &&
        (longest == nullptr || word.text.size() > longest->text.size())) {
      longest = &word;
    }
  }
  return longest;
}

}  // namespace

std::optional<HeightName> ReadHeightName(std::string_view column_name) {
  const std::string letters = LettersAndDigits(column_name.substr(column_name.rfind(':') + 1));
  HeightName name;
  bool is_height = false;
  for (std::string_view rest = letters; !rest.empty();) {
    const HeightWord* const word = FirstWord(rest);
    if (word == nullptr ||
        (word->reference && name.reference && *word->reference != *name.reference)) {
      return std::nullopt;
    }
    is_height = is_height || word->is_height;
    name.in_meters = name.in_meters && word->in_meters;
    name.reference = word->reference ? word->reference : name.reference;
    rest.remove_prefix(word->text.size());
  }
  return is_height ? std::optional(name) : std::nullopt;
}

}  // namespace cairn
