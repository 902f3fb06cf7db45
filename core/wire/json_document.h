// Parses untrusted JSON into a tree of bounded size.
#ifndef CAIRN_CORE_WIRE_JSON_DOCUMENT_H_
#define CAIRN_CORE_WIRE_JSON_DOCUMENT_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cairn {

// Limits of a document. The parser refuses a document before it stores the value that exceeds a
// limit. The defaults suit requests, which normally have fewer than 200 values.
struct JsonLimits {
  size_t max_values = 50'000;    // In the whole document: numbers, strings, objects, ...
  size_t max_elements = 10'000;  // In one array.
  size_t max_members = 256;      // In one object.
  size_t max_depth = 16;         // Arrays and objects nested in each other.
  size_t max_name_bytes = 100;   // Of a member's name; error messages quote names.
};

// Limits of a server's response: 100,000 matches of 13 values, and many tiles.
inline constexpr JsonLimits kAnswerLimits{.max_values = 4'000'000, .max_elements = 1 << 20};

// One value. The children of an array or object form a linked list: the first child directly
// follows its parent, and each child has the index of the next one.
struct JsonValue {
  enum class Kind : uint8_t { kNull, kBool, kNumber, kString, kArray, kObject };

  Kind kind = Kind::kNull;
  uint32_t num_children = 0;
  uint32_t next = 0;    // Index of the next sibling; 0 for the last one.
  double number = 0.0;  // Value of kNumber; 0 or 1 for kBool.
  std::string name;     // Name, for a member of an object.
  std::string text;     // Value of kString.
};

// The values in the order of the text, beginning with the top level. Destroying a document
// allocates nothing, so a document can be dropped when memory has run out.
using JsonDocument = std::vector<JsonValue>;

// Parses one JSON value in time and memory linear in the text. Throws JsonError without a pointer,
// with the byte offset in its message, if the text does not parse, is not UTF-8 or exceeds
// `limits`, or if an object has two members with the same name. Numbers outside the range of a
// double, NaN and Infinity do not parse.
JsonDocument ParseJson(std::string_view text, const JsonLimits& limits = {});

}  // namespace cairn

#endif  // CAIRN_CORE_WIRE_JSON_DOCUMENT_H_
