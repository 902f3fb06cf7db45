#include "core/wire/accept.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>

#include "core/wire/multipart.h"

namespace cairn {
namespace {

struct Named {
  int position;  // In the list.
  double quality;
};

std::optional<Named> Find(std::string_view accept, std::string_view media_range) {
  for (int position = 0; !accept.empty(); ++position) {
    const std::string_view element = TakeElement(&accept);
    if (MediaType(element) == media_range) {
      return Named{position, Quality(element)};
    }
  }
  return std::nullopt;
}

// The weight of a type that the list does not name.
double QualityByRange(std::string_view accept, std::string_view media_type) {
  const std::string all_subtypes = std::string(media_type.substr(0, media_type.find('/'))) + "/*";
  for (const std::string_view range : {std::string_view(all_subtypes), std::string_view("*/*")}) {
    if (const auto named = Find(accept, range)) {
      return named->quality;
    }
  }
  return 0.0;
}

}  // namespace

std::string_view TakeElement(std::string_view* list) {
  const size_t comma = std::min(list->find(','), list->size());
  const std::string_view element = list->substr(0, comma);
  list->remove_prefix(std::min(comma + 1, list->size()));
  return element;
}

double Quality(std::string_view element) {
  const std::string_view text = HeaderParameter(element, "q");
  double quality = 1.0;
  std::from_chars(text.data(), text.data() + text.size(), quality);
  return quality;
}

bool Prefers(std::string_view accept, std::string_view media_type, std::string_view usual) {
  const std::optional<Named> wanted = Find(accept, media_type);
  if (!wanted || !(wanted->quality > 0.0)) {
    return false;
  }
  const std::optional<Named> other = Find(accept, usual);
  const double other_quality = other ? other->quality : QualityByRange(accept, usual);
  if (wanted->quality != other_quality) {
    return wanted->quality > other_quality;
  }
  return !other || wanted->position < other->position;
}

}  // namespace cairn
