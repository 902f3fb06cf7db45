// Untrusted JSON as a tree of bounded size.
#ifndef CAIRN_HTTP_JSON_JSON_DOCUMENT_H_
#define CAIRN_HTTP_JSON_JSON_DOCUMENT_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cairn {

// A document that exceeds one of these is refused before the value that is too much is stored. The
// defaults are for requests, of which an honest one has fewer than 200 values.
struct JsonLimits {
  size_t max_values = 50'000;    // Of the whole document: numbers, strings, objects, ...
  size_t max_elements = 10'000;  // Of one array.
  size_t max_members = 256;      // Of one object.
  size_t max_depth = 16;         // Arrays and objects inside each other.
  size_t max_name_bytes = 100;   // Of the name of a member, which errors quote.
};

// One value. Children of arrays and objects are linked: the first one stands right behind its
// parent, and each has the index of the next.
struct JsonValue {
  enum class Kind : uint8_t { kNull, kBool, kNumber, kString, kArray, kObject };

  Kind kind = Kind::kNull;
  uint32_t num_children = 0;
  uint32_t next = 0;    // Index of the next sibling; 0 of the last one.
  double number = 0.0;  // Of kNumber; 0 or 1 of kBool.
  std::string name;     // Of a member of an object.
  std::string text;     // Of kString.
};

// The values in the order of the text; the first is the top level. Destroying a document allocates
// nothing, so that one can be given up when memory has run out.
using JsonDocument = std::vector<JsonValue>;

// Parses one JSON value, in time and memory linear in the text. Throws HttpError kInvalidJson, with
// the byte offset, if the text does not parse, is not UTF-8 or exceeds `limits`, and if an object
// has two members of one name. Numbers outside the range of a double do not parse; NaN and Infinity
// are no JSON.
JsonDocument ParseJson(std::string_view text, const JsonLimits& limits = {});

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_JSON_DOCUMENT_H_
