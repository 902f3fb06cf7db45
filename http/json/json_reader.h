// Reads untrusted JSON; every failure names the member by its JSON pointer (RFC 6901).
#ifndef CAIRN_HTTP_JSON_JSON_READER_H_
#define CAIRN_HTTP_JSON_JSON_READER_H_

#include <cstdint>
#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cairn {

// Parses one JSON value. Throws HttpError kInvalidJson, with the byte offset, if it does not parse,
// is nested deeper than 16, or is not UTF-8. Numbers outside the range of a double do not parse;
// NaN and Infinity are no JSON.
nlohmann::json ParseJson(std::string_view text);

// A value and where it stands. Refers to the document, which must outlive it. All functions throw
// HttpError kInvalidField with the pointer of the value at fault.
class JsonReader {
 public:
  explicit JsonReader(const nlohmann::json& value) : JsonReader(value, "") {}

  const std::string& pointer() const { return pointer_; }

  // Throws unless the value is an object with no member but these.
  void RequireOnly(std::initializer_list<std::string_view> members) const;

  // Members. A member that is null counts as absent.
  bool Has(std::string_view member) const;
  JsonReader At(std::string_view member) const;  // Throws if absent.
  std::optional<JsonReader> Find(std::string_view member) const;

  // Elements of an array of [min_size, max_size] elements.
  std::vector<JsonReader> Elements(size_t min_size, size_t max_size) const;
  std::vector<double> Numbers(size_t min_size, size_t max_size) const;

  bool IsArray() const;
  bool Bool() const;
  double Number(double min, double max) const;
  int64_t Integer(int64_t min, int64_t max) const;
  const std::string& String() const;
  const std::string& String(size_t max_length) const;

  [[noreturn]] void Fail(const std::string& detail, const std::string& hint = "") const;

 private:
  JsonReader(const nlohmann::json& value, std::string pointer)
      : value_(&value), pointer_(std::move(pointer)) {}
  void RequireObject() const;

  const nlohmann::json* value_;
  std::string pointer_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_JSON_READER_H_
