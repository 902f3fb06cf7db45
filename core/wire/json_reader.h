// Reads untrusted JSON. Every error names the member by its JSON pointer (RFC 6901).
#ifndef CAIRN_CORE_WIRE_JSON_READER_H_
#define CAIRN_CORE_WIRE_JSON_READER_H_

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/wire/json_document.h"

namespace cairn {

// The largest integer below which every integer has a double of its own.
inline constexpr int64_t kMaxExactInteger = int64_t{1} << 53;

// A value and its position in the document. The document must outlive the reader. All functions
// throw JsonError with the pointer of the value at fault.
class JsonReader {
 public:
  // The top level.
  explicit JsonReader(const JsonDocument& document) : JsonReader(document, 0, "") {}

  const std::string& pointer() const { return pointer_; }

  // Throws unless the value is an object without other members than these.
  void RequireOnly(std::initializer_list<std::string_view> members) const;

  // Access to members. A null member counts as absent.
  bool Has(std::string_view member) const;
  JsonReader At(std::string_view member) const;  // Throws if absent.
  std::optional<JsonReader> Find(std::string_view member) const;

  // Returns the elements of an array. Throws unless their number is in [min_size, max_size].
  std::vector<JsonReader> Elements(size_t min_size, size_t max_size) const;
  std::vector<double> Numbers(size_t min_size, size_t max_size) const;

  bool IsArray() const;
  bool IsObject() const;
  bool IsString() const;
  bool Bool() const;
  double Number() const;  // Finite, as every number of a document is.
  double Number(double min, double max) const;
  int64_t Integer(int64_t min, int64_t max) const;
  const std::string& String() const;
  const std::string& String(size_t max_length) const;

  [[noreturn]] void Fail(const std::string& detail, const std::string& hint = "") const;

 private:
  JsonReader(const JsonDocument& document, size_t index, std::string pointer)
      : document_(&document), index_(index), pointer_(std::move(pointer)) {}
  const JsonValue& value() const { return (*document_)[index_]; }
  // The value at `index`, which is the member `name` of this value.
  JsonReader Member(size_t index, std::string_view name) const;
  void RequireObject() const;
  // Calls visit(index) for each element or member, in order.
  template <typename Visit>
  void ForEachChild(const Visit& visit) const;

  const JsonDocument* document_;
  size_t index_;
  std::string pointer_;
};

}  // namespace cairn

#endif  // CAIRN_CORE_WIRE_JSON_READER_H_
